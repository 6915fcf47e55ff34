// A light at a surface point: its direction, brightness and shadow, the footprint of the pixel, and the surroundings in
// the mirrored direction.
#include "surroundings.glsl"

layout(constant_id = 3) const bool MIRRORED = false; // true: light of the surroundings, separate specular order
layout(constant_id = 4) const bool LAMP = false;     // true if the light is a lamp
layout(constant_id = 5) const bool SHADOWS = false;  // true if the light casts shadows
layout(constant_id = 8) const bool CHOSEN = false;   // true if each pixel takes one of the directions of the light

layout(set = 0, binding = 6) uniform sampler2DArray shadow;      // depth from each light
layout(set = 0, binding = 10) uniform sampler2DArray sky_shadow; // from each direction among which pixels choose

// Returns the direction number `number` of the light that the pixel takes: `Choices::slot` of src/render/light_passes.rs.
int slot_of(ivec2 pixel, int number) {
    uint turn = frame.at.turn ^ bitfieldReverse(uint(number));
    uint x = uint(pixel.x), y = uint(pixel.y), checks = x ^ y;
    uint rank = (checks & 1u) << 31 | (y & 1u) << 30 | (checks & 2u) << 28 | (y & 2u) << 27 | (checks & 4u) << 25 | (y & 4u) << 24;
    uint part = frame.at.parts == 0 ? 0 : bitfieldReverse(turn >> (32 - frame.at.parts));
    rank ^= part ^ part << 2;
    return int(((rank >> frame.at.parts) ^ turn) >> (32 - findMSB(LIGHT_SLOTS)));
}

// Returns the share of four texels of depth map number `map` around `place` [texels] that are at least as far from the light
// as `depth`, weighed by the distance from their centres.
float share_lit(sampler2DArray maps, vec2 place, int map, float depth) {
    vec2 size = vec2(textureSize(maps, 0).xy);
    vec2 corner = place - 0.5, share = fract(corner);
    // In the middle of four texels, so that rounding does not move to others.
    vec4 found = textureGather(maps, vec3((floor(corner) + 1.0) / size, map), 0);
    vec4 lit = vec4(greaterThanEqual(found, vec4(depth)));
    return mix(mix(lit.w, lit.z, share.x), mix(lit.x, lit.y, share.x), share.y);
}

// Returns a vector to the light, in the world; for a lamp it is not normalised.
vec3 toward_light(SurfacePoint at, Light light) {
    return LAMP ? light.toward.xyz - at.position : light.toward.xyz;
}

// Returns the unit vector to the light in the frame of the patch.
vec3 direction_of_light(SurfacePoint at, Light light) {
    vec3 direction = rotated(at.rotation, normalize(toward_light(at, light)));
    return vec3(direction.x, at.sense * direction.y, direction.z);
}

// Returns the mean of max(cos, 0) over the directions that the light stands for, by the cosine to its middle:
// `mean_cosine` of src/scene/incident.rs.
float mean_cosine(Light light, float cosine) {
    if (LAMP) {
        return max(cosine, 0.0);
    }
    float mean = light.emitter.x;
    float whole = mean * cosine, along = (1.0 - mean) * (1.0 - mean);
    float across = 1.5 * (1.0 - mean * mean - along / 3.0);
    float width = sqrt(max(along * cosine * cosine + across * (1.0 - cosine * cosine), 0.0)); // half of it
    return abs(whole) >= width ? max(whole, 0.0) : (whole + width) * (whole + width) / (4.0 * width);
}

// Returns the brightness relative to that at distance 1 on the axis of the lamp: `LampPoint::falloff` of
// src/scene/incident.rs.
float falloff(SurfacePoint at, Light light) {
    if (!LAMP) {
        return 1.0;
    }
    vec3 from = -toward_light(at, light), middle = at.position - light.emitter.xyz;
    float around = length(from) * pow(dot(middle, middle), -1.5);
    float aside = max(dot(light.emitter.xyz, from), 0.0) * pow(dot(from, from), -1.5);
    return light.emitter.w == ALL_AROUND ? around : aside;
}

// Returns the share of the light that reaches the point past the surfaces in depth map number `map`, that of the light: 0 or
// 1 but within a texel of the edge of a shadow. The depth bias covers the depth change of the surface within the four
// texels that are compared, and rounding.
float visibility(SurfacePoint at, Light light, int map) {
    const float ROUNDING = 2e-5, STEEPEST = 30.0, TEXEL = 3.0; // TEXEL: the diagonal of the four, with a margin for curved surfaces
    vec3 toward = toward_light(at, light);
    float facing_light = dot(at.face, normalize(toward));
    if (facing_light <= 0.0 && mean_cosine(light, facing_light) > 0.0) {
        return 1.0; // the middle of the light is behind the surface, and the part beside it that shines on it is not
    }
    float cosine = abs(facing_light);
    float slope = min(sqrt(max(1.0 - cosine * cosine, 0.0)) / max(cosine, 1e-6), STEEPEST);
    mat4 clip_from_world = light.shadow_from_world;
    vec4 clip = clip_from_world * vec4(at.position, 1.0);
    vec2 size = vec2(CHOSEN ? textureSize(sky_shadow, 0).xy : textureSize(shadow, 0).xy);
    // For parallel light the clip space is two units wide and one deep.
    float bias = ROUNDING + slope * TEXEL / size.x;
    if (LAMP) {
        if (clip.w <= 0.0 || any(greaterThan(abs(clip.xy), vec2(clip.w)))) {
            return 1.0; // not on the map
        }
        // Relative change of the distance along the axis of the map on the surface, per distance on the map.
        vec3 axis = vec3(clip_from_world[0].w, clip_from_world[1].w, clip_from_world[2].w);
        float along = dot(at.face, axis);
        slope = sqrt(max(1.0 - along * along, 0.0)) * clip.w / (max(cosine, 1e-6) * length(toward));
        slope = min(slope, STEEPEST);
        // Depth is A + B/distance; B is z of the lamp's position before the division.
        float reach = (clip_from_world * vec4(light.toward.xyz, 1.0)).z;
        float texel = 2.0 * clip.w / (size.x * length(vec3(clip_from_world[0].x, clip_from_world[1].x, clip_from_world[2].x)));
        bias = abs(reach) / (clip.w * clip.w) * (ROUNDING * clip.w + slope * TEXEL * texel);
    }
    vec3 place = clip.xyz / clip.w;
    vec2 texel = (place.xy * 0.5 + 0.5) * size;
    // Beyond the far end of the map nothing is in shadow: all casters are nearer.
    float depth = min(place.z - bias, 1.0);
    return CHOSEN ? share_lit(sky_shadow, texel, map, depth) : share_lit(shadow, texel, map, depth);
}

// Returns the unit vector to the light in the world where the point has moved.
vec3 light_from(SurfacePoint at, Light light, vec3 move) {
    return normalize(LAMP ? toward_light(at, light) - move : toward_light(at, light));
}

// Smallest variance of u: far below that of any pixel, and not 0, which would divide.
const float SMALLEST_VARIANCE = 1e-20;

// Returns the footprint whose covariance is the sum of that of `change` and that of a light with a `variance` of
// directions, in (u, v). Nothing branches on the variance: lavapipe would compile the stage anew for each value.
Footprint widened(Footprint change, float variance, vec2 to_light) {
    vec2 dx = change.dx, dy = change.dy;
    vec2 foreshortened = max(1.0 - to_light * to_light, 0.0); // negative by rounding at grazing angles
    float uu = dx.x * dx.x + dy.x * dy.x + variance * foreshortened.x;
    float uv = dx.x * dx.y + dy.x * dy.y - variance * to_light.x * to_light.y;
    float vv = dx.y * dx.y + dy.y * dy.y + variance * foreshortened.y;
    // Cholesky's root, as the columns of a Jacobian.
    float u = sqrt(max(uu, SMALLEST_VARIANCE)), v = uv / u;
    bvec2 wide = bvec2(variance > 0.0);
    return Footprint(mix(dx, vec2(u, v), wide), mix(dy, vec2(0.0, sqrt(max(vv - v * v, 0.0))), wide));
}

// Returns the Jacobian of (u, v) = -(w_i + w_r).xy per pixel, x to the right, y downward: differences to the neighbours in
// the quad. `views`: differences of the direction to the viewer. `to_light` is in the frame of the patch.
Footprint footprint_of(SurfacePoint at, mat2x3 views, Light light, vec3 to_light) {
    vec3 here = vec3(to_light.x, at.sense * to_light.y, to_light.z);
    mat2x3 moves = LAMP ? moves_on_plane(at, at.face) : mat2x3(0.0);
    vec3 right = light_from(at, light, at.toward.x * moves[0]);
    vec3 down = light_from(at, light, at.toward.y * moves[1]);
    vec2 dx = (views[0] + difference(at, at.curving_right, at.toward.x, here, right)).xy;
    vec2 dy = (views[1] + difference(at, at.curving_down, at.toward.y, here, down)).xy;
    vec2 sense = -vec2(1.0, at.sense);
    Footprint change = Footprint(sense * dx, sense * dy);
    float variance = light.toward.w / (frame.at.footprint * frame.at.footprint);
    if (LAMP) {
        vec3 toward = toward_light(at, light);
        variance /= dot(toward, toward);
    }
    change = widened(change, variance, to_light.xy);
    if (CHOSEN) {
        // A direction stands for a part of the surroundings whose outline is not known: its footprint is round.
        float radius = sqrt(0.5 * (dot(change.dx, change.dx) + dot(change.dy, change.dy)));
        change = Footprint(vec2(radius, 0.0), vec2(0.0, radius));
    }
    return change;
}

// Returns the radiance of the surroundings in the mirrored direction, averaged over the pixel and over the spread of
// the specular order; 0 if the direction points into the surface. `changes`: differences of the direction to the viewer.
vec3 mirrored_radiance(SurfacePoint at, mat2x3 changes, Light light) {
    vec3 to_viewer = normalize(toward_viewer(at.position));
    vec3 normal = rotated(-at.rotation, vec3(0.0, 0.0, 1.0));
    vec3 mirrored = 2.0 * dot(to_viewer, normal) * normal - to_viewer;
    if (dot(mirrored, at.face) <= 0.0) {
        return vec3(0.0);
    }
    // Change of the mirrored direction in the world: that in the frame, less the rotation of the frame.
    vec3 turned = rotated(at.rotation, mirrored);
    vec3 dx = vec3(-changes[0].xy, changes[0].z) - cross(at.curving_right, turned);
    vec3 dy = vec3(-changes[1].xy, changes[1].z) - cross(at.curving_down, turned);
    float spread = frame.at.footprint * frame.at.footprint * 0.5 * (dot(dx, dx) + dot(dy, dy));
    // A Gaussian in (u, v) is one of directions, wider by 1/cosine in the plane of incidence.
    return radiance_toward(mirrored, sqrt(spread + frame.surroundings.w / max(turned.z, 0.1))) * light.irradiance.w;
}
