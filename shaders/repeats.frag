#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel through repeats: for each light the diffracted spectrum as colour, and the pigment below what the surface reflects.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "repeats.glsl"
#include "color.glsl"
#include "pixel.glsl"

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 stored = texelFetch(directions, pixel, 0);
    radiance = vec4(0.0, 0.0, 0.0, covered(stored) ? 1.0 : 0.0);
    if (!covered(stored)) {
        return;
    }
    vec3 to_view = unprojected(stored.xy);
    vec3 albedo = albedo_of(pixel);
    for (int i = 0; i < frame.counts.x; ++i) {
        vec3 to_light = light_direction(stored, i, pixel);
        Pair pair = pair_of(to_light, to_view);
        if (pair.factor == 0.0) {
            continue;
        }
        vec3 diffracted = LINEAR_SRGB_FROM_XYZ * repeated_xyz(pair);
        vec3 pigmented = albedo * ((1.0 - pair.reflectance) * to_light.z / PI);
        radiance.rgb += (diffracted + pigmented) * (frame.lights[i].w * PI);
    }
}
