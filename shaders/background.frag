#version 460
#extension GL_GOOGLE_include_directive : require
// Displays the surroundings in uncovered pixels, with the exposure and the tone of the mesh.
#include "frame.glsl"

const float PI = 3.14159265358979;

#include "displayed.glsl"
#include "surroundings.glsl"

layout(constant_id = 0) const bool MEAN = false; // true: behind the mean of samples; false: behind a single sample

// Summed over samples; alpha is the number of samples that cover the pixel.
layout(set = 1, binding = 0) uniform sampler2D radiance;

layout(location = 0) in vec3 toward;

layout(location = 0) out vec4 code;

void main() {
    vec3 direction = normalize(toward);
    // The standard deviation of the pixel filter is half a pixel.
    float deviation = 0.5 * max(length(dFdx(direction)), length(dFdy(direction)));
    vec3 shown = displayed(radiance_toward(direction, deviation));
    if (MEAN) {
        vec4 stored = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0);
        if (stored.a > 0.0) {
            shown = mix(shown, displayed(stored.rgb / stored.a), stored.a / display.samples);
        }
    }
    code = vec4(srgb_codes(shown), 1.0);
}
