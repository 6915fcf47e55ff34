#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the inputs of shading for a covered pixel: directions in its tangent frame, the pigment, and footprints.
// Shading follows in a separate pass over neighbouring pixels, independent of the size of triangles; a reference can
// shade the very same directions.
#include "frame.glsl"

const float PI = 3.14159265358979;

layout(set = 0, binding = 1) uniform sampler2D pigment;

layout(constant_id = 0) const bool TEXTURED = true;    // true if a texture gives the pigment
layout(constant_id = 1) const bool FOOTPRINTS = true;  // true if footprints are written
layout(constant_id = 2) const bool SHADOWS = false;    // true if the light casts shadows
layout(constant_id = 3) const bool MIRRORED = false;   // true: light of the surroundings, mirrored radiance written
layout(constant_id = 4) const bool LAMPS = false;      // true if lamps are among the lights; their falloff is written
layout(constant_id = 5) const int GROOVES = 0;         // orientation of the patch in the tangent frame

// Values of `GROOVES`; see src/render/grooves.rs.
const int TURNED = 1, RADIAL = 2, MAPPED = 3;

layout(set = 0, binding = 8) uniform sampler2D groove_map; // cosine and sine over (u, v)

layout(set = 0, binding = 6) uniform sampler2D shadow;     // depth from the light

#include "surroundings.glsl"

// Outputs of `surface.vert`; `view` and `light` are not normalised.
layout(location = 0) in vec3 view;
layout(location = 1) in vec2 pigment_uv;
layout(location = 2) in vec3 light;
layout(location = 3) in vec3 world;
layout(location = 4) in vec3 world_normal;
layout(location = 5) in vec3 world_tangent;
layout(location = 6) in vec3 world_bitangent;

// Inputs of `pixel.glsl`. Attachments of a pass must be contiguous; images that a picture does not have are omitted.
layout(location = 0) out vec4 directions;
layout(location = 1) out vec4 image_1; // footprint, or albedo
layout(location = 2) out vec4 image_2; // albedo,    or mirrored radiance
layout(location = 3) out vec4 image_3; // mirrored radiance

// Data of a fragment's triangle. Derivatives are undefined if neighbours take another branch, so that all of them are
// taken before any branch.
struct Face {
    vec3 normal; // of the triangle, toward the viewer
    bool back;   // true if the back of the surface is seen
    vec3 mirrored; // mirrored direction of the viewer, in world space
    float spread;  // its variance over the filter that shading averages over, per axis
    vec2 turn;     // direction of the patch's x in the tangent frame
};

vec2 groove_turn() {
    if (GROOVES == TURNED) {
        return frame.grooves.xy;
    }
    vec2 turn = vec2(1.0, 0.0);
    if (GROOVES == RADIAL) {
        turn = vec2(pigment_uv.x - 0.5, 0.5 - pigment_uv.y);
    } else if (GROOVES == MAPPED) {
        turn = texture(groove_map, pigment_uv).rg;
    }
    return dot(turn, turn) > 0.0 ? normalize(turn) : vec2(1.0, 0.0);
}

Face face_seen() {
    vec3 normal = normalize(cross(dFdx(world), dFdy(world)));
    vec3 to_eye = frame.eye.xyz - world;
    normal = dot(normal, to_eye) < 0.0 ? -normal : normal;
    vec3 mirrored = reflect(-normalize(to_eye), normalize(world_normal));
    vec3 dx = dFdxFine(mirrored), dy = dFdyFine(mirrored);
    float spread = frame.at.footprint * frame.at.footprint * 0.5 * (dot(dx, dx) + dot(dy, dy));
    return Face(normal, dot(world_normal, normal) < 0.0, mirrored, spread, groove_turn());
}

// Transforms `direction`, its products with the interpolated T, B and N, to the orthonormal frame of N, T orthogonal to
// it, and B. On the snake, whose normals differ by up to 0.4 across a triangle, the median error of the products alone
// is 5e-3.
vec3 orthonormal(vec3 direction) {
    const float DEGENERATE = 1e-3; // opposite tangents cancel
    float along_normal = length(world_normal);
    vec3 normal = world_normal / along_normal;
    float skew = dot(world_tangent, normal);
    vec3 tangent = world_tangent - skew * normal;
    float along_tangent = length(tangent);
    tangent /= along_tangent;
    float along_bitangent = abs(dot(world_bitangent, cross(normal, tangent)));
    if (!(min(along_normal, min(along_tangent, along_bitangent)) > DEGENERATE)) {
        return direction;
    }
    float z = direction.z / along_normal;
    float x = (direction.x - skew * z) / along_tangent;
    float y = (direction.y - dot(world_bitangent, tangent) * x - dot(world_bitangent, normal) * z) / along_bitangent;
    return vec3(x, y, z);
}

// Returns `direction` in the frame of the patch. If the back of a surface is seen, as of a mesh with inward winding,
// the frame is turned about T.
vec3 seen(Face face, vec3 direction) {
    direction = orthonormal(direction);
    if (GROOVES != 0) {
        direction.xy = vec2(dot(face.turn, direction.xy), face.turn.x * direction.y - face.turn.y * direction.x);
    }
    return face.back ? vec3(direction.x, -direction.yz) : direction;
}

// Projects stereographically from -N. Close to -N the direction is far below the horizon and its value does not matter.
vec2 projected(vec3 direction) {
    const float LEAST = 0.1;
    float size = length(direction);
    float depth = size + direction.z;
    return depth > LEAST * size ? direction.xy / depth : vec2(1.0 / LEAST, 0.0);
}

// Returns the unit vector to the viewer. Its cosine is bounded from below by its change over the filter that shading
// averages over: the BRDF divides by the cosine, and a single sample at a silhouette would outshine all others.
vec3 to_viewer(Face face) {
    vec3 direction = normalize(seen(face, view));
    float spread = frame.at.footprint * length(vec2(dFdxFine(direction.z), dFdyFine(direction.z)));
    direction.z = direction.z > 0.0 && spread > direction.z ? min(spread, 1.0) : direction.z;
    return direction;
}

bool is_lamp() {
    return LAMPS && frame.emitter.w != FAR_AWAY;
}

// Returns a vector to the light; for a lamp it is not normalised.
vec3 toward() {
    return is_lamp() ? frame.light.xyz - world : frame.light.xyz;
}

// Returns the brightness relative to that at distance 1 on the axis of the lamp: `LampPoint::falloff` of
// src/scene/incident.rs.
float falloff() {
    vec3 from = -toward();
    vec4 emitter = frame.emitter;
    if (!is_lamp()) {
        return 1.0;
    }
    if (emitter.w == ALL_AROUND) {
        vec3 middle = world - emitter.xyz;
        return length(from) * pow(dot(middle, middle), -1.5);
    }
    return max(dot(emitter.xyz, from), 0.0) * pow(dot(from, from), -1.5);
}

// Returns true if the light's depth map has a surface nearer to the light. The depth bias covers the depth change of
// the surface within a texel of the map, and rounding.
bool in_shadow(Face face) {
    const float ROUNDING = 2e-5, STEEPEST = 30.0, TEXEL = 1.5; // TEXEL: the diagonal, with a margin
    float cosine = abs(dot(face.normal, normalize(toward())));
    float slope = min(sqrt(max(1.0 - cosine * cosine, 0.0)) / max(cosine, 1e-6), STEEPEST);
    mat4 clip_from_world = frame.shadow_from_world;
    vec4 clip = clip_from_world * vec4(world, 1.0);
    vec2 size = vec2(textureSize(shadow, 0));
    // For parallel light the clip space is two units wide and one deep.
    float bias = ROUNDING + slope * TEXEL / size.x;
    if (is_lamp()) {
        if (clip.w <= 0.0 || any(greaterThan(abs(clip.xy), vec2(clip.w)))) {
            return false; // not on the map
        }
        // Relative change of the distance along the axis of the map on the surface, per distance on the map.
        vec3 axis = vec3(clip_from_world[0].w, clip_from_world[1].w, clip_from_world[2].w);
        float along = dot(face.normal, axis);
        slope = sqrt(max(1.0 - along * along, 0.0)) * clip.w / (max(cosine, 1e-6) * length(toward()));
        slope = min(slope, STEEPEST);
        // Depth is A + B/distance; B is z of the lamp's position before the division.
        float reach = (clip_from_world * vec4(frame.light.xyz, 1.0)).z;
        float texel = 2.0 * clip.w / (size.x * length(vec3(clip_from_world[0].x, clip_from_world[1].x, clip_from_world[2].x)));
        bias = abs(reach) / (clip.w * clip.w) * (ROUNDING * clip.w + slope * TEXEL * texel);
    }
    vec3 place = clip.xyz / clip.w;
    vec2 texel = clamp((place.xy * 0.5 + 0.5) * size, vec2(0.0), size - 1.0);
    // Beyond the far end of the map nothing is in shadow: all casters are nearer.
    return texelFetch(shadow, ivec2(texel), 0).r < min(place.z - bias, 1.0);
}

// Returns the radiance of the surroundings in the mirrored direction, averaged over the pixel and over the spread of
// the specular order; 0 if the direction points into the surface.
vec3 mirrored_radiance(Face face) {
    if (dot(face.mirrored, face.normal) <= 0.0) {
        return vec3(0.0);
    }
    // A Gaussian in (u, v) is one of directions, wider by 1/cosine in the plane of incidence.
    float cosine = max(dot(face.mirrored, normalize(world_normal)) * (face.back ? -1.0 : 1.0), 0.1);
    return radiance_toward(face.mirrored, sqrt(face.spread + frame.surroundings.w / cosine));
}

// Returns the projected direction to the light; in shadow, a direction from below.
vec2 projected_light(Face face) {
    return SHADOWS && in_shadow(face) ? projected(vec3(0.0, 0.0, -1.0)) : projected(seen(face, light));
}

// Returns the footprint whose covariance is the sum of that of `change` and that of a light with a `variance` of
// directions, in (u, v).
vec4 widened(vec4 change, float variance, vec2 to_light) {
    float uu = change.x * change.x + change.z * change.z + variance * (1.0 - to_light.x * to_light.x);
    float uv = change.x * change.y + change.z * change.w - variance * to_light.x * to_light.y;
    float vv = change.y * change.y + change.w * change.w + variance * (1.0 - to_light.y * to_light.y);
    // Cholesky's root, as the columns of a Jacobian.
    float u = sqrt(uu), v = uv / u;
    return vec4(u, v, 0.0, sqrt(max(vv - v * v, 0.0)));
}

// Returns the Jacobian of (u, v): du/dx, dv/dx, du/dy, dv/dy per pixel. Differences are within the triangle; beyond its
// edges it is extrapolated. u and v of unit vectors are within -2 ... 2, so that no difference exceeds 4. Extrapolation
// behind the viewer may give NaN or infinity, and then the footprint is zero.
vec4 footprint(Face face) {
    vec3 to_light = normalize(seen(face, light));
    vec2 uv = -(to_light.xy + normalize(seen(face, view)).xy);
    vec4 change = vec4(dFdxFine(uv), dFdyFine(uv));
    change = any(isnan(change)) || any(isinf(change)) ? vec4(0.0) : change;
    float variance = frame.light.w / (frame.at.footprint * frame.at.footprint);
    if (is_lamp()) {
        vec3 lamp = toward();
        variance /= dot(lamp, lamp);
    }
    return variance > 0.0 ? widened(change, variance, to_light.xy) : change;
}

void main() {
    Face face = face_seen();
    directions = vec4(projected(to_viewer(face)), projected_light(face));
    vec4 mirrored = vec4(MIRRORED ? frame.irradiance.w * mirrored_radiance(face) : vec3(0.0), 0.0);
    vec4 albedo = vec4(frame.base_color.rgb, LAMPS ? falloff() : 1.0);
    if (TEXTURED && frame.base_color.w > 0.0) {
        albedo.rgb *= texture(pigment, pigment_uv).rgb;
    }
    image_1 = FOOTPRINTS ? footprint(face) : albedo;
    image_2 = FOOTPRINTS ? albedo : mirrored;
    image_3 = mirrored;
}
