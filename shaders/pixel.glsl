// What `geometry.frag` finds at a pixel, for the stages that shade it. Directions are stored by stereographic projection from
// -N, two numbers each: a frame writes and reads them for every pixel. Its twin is `Directions` of src/render/picture.rs.

// Written by the geometry pass: to the viewer (xy) and to the first light (zw).
layout(set = 0, binding = 2) uniform sampler2D directions;
layout(set = 0, binding = 3) uniform sampler2D albedos;      // where there is a pigment texture
layout(set = 0, binding = 4) uniform sampler2D more_lights_0; // to the second and to the third light
layout(set = 0, binding = 5) uniform sampler2D more_lights_1; // to the fourth

// Where footprints are asked for: du/dx, dv/dx, du/dy, dv/dy of each light's (u, v) = -(w_i + w_r).xy, per pixel; x to the right, y downward.
layout(set = 0, binding = 6) uniform sampler2D footprints_0;
layout(set = 0, binding = 7) uniform sampler2D footprints_1;
layout(set = 0, binding = 8) uniform sampler2D footprints_2;
layout(set = 0, binding = 9) uniform sampler2D footprints_3;

layout(set = 0, binding = 15) uniform sampler2D falloffs;    // how bright each light is here, where lamps are among them

// What the pass clears to: farther out than any direction is projected.
const float UNCOVERED = 100.0;
const float NEARLY_UNCOVERED = 50.0;

vec3 unprojected(vec2 s) {
    float k = 2.0 / (1.0 + dot(s, s));
    return vec3(k * s, k - 1.0);
}

bool covered(vec4 stored) {
    return stored.x < NEARLY_UNCOVERED;
}

// To light number `light`, of a pixel whose `directions` are `stored`. An array of samplers would need a feature that not every device
// has.
vec3 light_direction(vec4 stored, int light, ivec2 pixel) {
    switch (light) {
    case 0: return unprojected(stored.zw);
    case 1: return unprojected(texelFetch(more_lights_0, pixel, 0).xy);
    case 2: return unprojected(texelFetch(more_lights_0, pixel, 0).zw);
    default: return unprojected(texelFetch(more_lights_1, pixel, 0).xy);
    }
}

// Radiance of the surroundings from the mirrored direction, where the geometry pass was asked for it, behind the last of `lights` lights.
vec3 mirrored_of(int lights, ivec2 pixel) {
    vec4 pair = texelFetch(more_lights_0, pixel, 0);
    if (lights > 2) {
        pair = texelFetch(more_lights_1, pixel, 0);
    }
    return vec3((lights & 1) == 1 ? pair.xy : pair.zw, texelFetch(albedos, pixel, 0).w);
}

vec3 albedo_of(ivec2 pixel) {
    return frame.base_color.w > 0.0 ? texelFetch(albedos, pixel, 0).rgb : frame.base_color.rgb;
}

// Of light number `light`, where the geometry pass was asked for footprints: what the part of the pixel filter covers that shading averages
// over.
Footprint footprint_of(int light, ivec2 pixel) {
    vec4 change;
    switch (light) {
    case 0: change = texelFetch(footprints_0, pixel, 0); break;
    case 1: change = texelFetch(footprints_1, pixel, 0); break;
    case 2: change = texelFetch(footprints_2, pixel, 0); break;
    default: change = texelFetch(footprints_3, pixel, 0); break;
    }
    change *= frame.at.footprint;
    return Footprint(change.xy, change.zw, frame.at.tap_offset, float(frame.at.count));
}
