#version 460
#extension GL_GOOGLE_include_directive : require
// Displays the linear radiance of covered pixels: exposure, tone mapping or gamut mapping, transfer function. A mean of
// samples is blended with the background by its coverage, before the transfer function, because light mixes linearly at
// an edge. The background is unaffected by exposure and tone.
#include "displayed.glsl"

layout(constant_id = 0) const bool MEAN = false; // true: mean of samples; false: one sample, in covered pixels

// One sample, or a sum of samples whose alpha is the number of samples that cover the pixel.
layout(set = 0, binding = 0) uniform sampler2D radiance;

layout(location = 0) out vec4 code;

void main() {
    vec4 stored = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0);
    if (MEAN) {
        if (stored.a == 0.0) {
            discard;
        }
        stored.rgb /= stored.a;
    }
    vec3 shown = displayed(stored.rgb);
    if (MEAN) {
        shown = mix(display.background, shown, stored.a / display.samples);
    }
    code = vec4(srgb_codes(shown), 1.0);
}
