// Output of `geometry.frag` at a pixel, for shading. Directions are stored by stereographic projection from -N as two
// numbers each, to save bandwidth. The twin is `Directions` of src/render/directions.rs.

// Written by the geometry pass: to the viewer (xy) and to the light (zw).
layout(set = 0, binding = 2) uniform sampler2D directions;
layout(set = 0, binding = 3) uniform sampler2D albedos;    // rgb: textured pigment; a: falloff of lamps

// Jacobian, if requested: du/dx, dv/dx, du/dy, dv/dy of (u, v) = -(w_i + w_r).xy, per pixel; x to the right, y
// downward.
layout(set = 0, binding = 4) uniform sampler2D footprints;

// Radiance of the surroundings in the mirrored direction, if the light is drawn from them.
layout(set = 0, binding = 5) uniform sampler2D mirrored;

// Clear value of directions: outside the range of the projection.
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

// Returns the footprint of the filter that shading averages over, if the geometry pass writes footprints.
Footprint footprint_of(ivec2 pixel) {
    vec4 change = texelFetch(footprints, pixel, 0) * frame.at.footprint;
    return Footprint(change.xy, change.zw);
}
