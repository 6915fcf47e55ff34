#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel through repeats: for each light the diffracted spectrum as colour, and the pigment below what the surface reflects.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "repeats.glsl"
#include "color.glsl"

// What `geometry.frag` wrote.
layout(set = 0, binding = 9) uniform sampler2D view_directions;
layout(set = 0, binding = 10) uniform sampler2D albedos;
layout(set = 0, binding = 11) uniform sampler2D light_directions_0;
layout(set = 0, binding = 12) uniform sampler2D light_directions_1;
layout(set = 0, binding = 13) uniform sampler2D light_directions_2;
layout(set = 0, binding = 14) uniform sampler2D light_directions_3;

// An array of samplers would need a feature that not every device has.
vec3 light_direction(int light, ivec2 pixel) {
    switch (light) {
    case 0: return texelFetch(light_directions_0, pixel, 0).xyz;
    case 1: return texelFetch(light_directions_1, pixel, 0).xyz;
    case 2: return texelFetch(light_directions_2, pixel, 0).xyz;
    default: return texelFetch(light_directions_3, pixel, 0).xyz;
    }
}

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 to_view = texelFetch(view_directions, pixel, 0);
    radiance = vec4(0.0, 0.0, 0.0, to_view.w);
    if (to_view.w == 0.0) {
        return;
    }
    vec3 albedo = texelFetch(albedos, pixel, 0).rgb;
    for (int i = 0; i < frame.counts.x; ++i) {
        vec3 to_light = light_direction(i, pixel);
        Pair pair = pair_of(to_light, to_view.xyz);
        if (pair.factor == 0.0) {
            continue;
        }
        vec3 diffracted = LINEAR_SRGB_FROM_XYZ * repeated_xyz(pair);
        vec3 pigmented = albedo * ((1.0 - pair.reflectance) * to_light.z / PI);
        radiance.rgb += (diffracted + pigmented) * (frame.lights[i].w * PI);
    }
}
