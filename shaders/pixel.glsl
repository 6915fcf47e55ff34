// What `geometry.frag` finds at a pixel, for the stages that shade it. Directions are stored by stereographic projection from
// -N, two numbers each: a frame writes and reads them for every pixel. Its twin is `Directions` of src/render/directions.rs.

// Written by the geometry pass: to the viewer (xy) and to the light (zw).
layout(set = 0, binding = 2) uniform sampler2D directions;
layout(set = 0, binding = 3) uniform sampler2D albedos;    // rgb: where there is a pigment texture; a: how bright the light is here, where lamps are among them

// Where footprints are asked for: du/dx, dv/dx, du/dy, dv/dy of (u, v) = -(w_i + w_r).xy, per pixel; x to the right, y downward.
layout(set = 0, binding = 4) uniform sampler2D footprints;

// Radiance of the surroundings from the mirrored direction, where the light is drawn from them.
layout(set = 0, binding = 5) uniform sampler2D mirrored;

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

vec3 albedo_of(ivec2 pixel) {
    return frame.base_color.w > 0.0 ? texelFetch(albedos, pixel, 0).rgb : frame.base_color.rgb;
}

// What the part of the pixel filter covers that shading averages over, where the geometry pass was asked for footprints.
Footprint footprint_of(ivec2 pixel) {
    vec4 change = texelFetch(footprints, pixel, 0) * frame.at.footprint;
    return Footprint(change.xy, change.zw);
}
