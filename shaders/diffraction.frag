#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a fragment: for each light the diffracted spectrum as colour, and the pigment below what the surface reflects.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "color.glsl"

layout(location = 0) in vec3 view;
layout(location = 1) in vec2 pigment_uv;
layout(location = 2) in vec3 lights[MAX_LIGHTS];

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

void main() {
    vec3 to_view = normalize(view);
    vec3 albedo = frame.base_color.rgb;
    if (frame.base_color.w > 0.0) {
        albedo *= texture(pigment, pigment_uv).rgb;
    }
    vec3 color = vec3(0.0);
    for (int i = 0; i < frame.counts.x; ++i) {
        vec3 to_light = normalize(lights[i]);
        Pair pair = pair_of(to_light, to_view);
        if (pair.factor == 0.0) {
            continue;
        }
        vec3 diffracted = LINEAR_SRGB_FROM_XYZ * cosine_weighted_xyz(pair);
        vec3 pigmented = albedo * ((1.0 - pair.reflectance) * to_light.z / PI);
        color += (diffracted + pigmented) * (frame.lights[i].w * PI);
    }
    radiance = vec4(color, 1.0);
}
