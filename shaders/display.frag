#version 460
#extension GL_GOOGLE_include_directive : require
// From the linear radiance of covered pixels to a display: exposure, tone or gamut, transfer. The mean of samples stands over the background by the
// part of the samples that the mesh covers; what light does at an edge is linear, so the two are mixed before the transfer. The
// background knows neither exposure nor tone.
#include "displayed.glsl"

layout(constant_id = 0) const bool MEAN = false; // of samples, else one of them, which covers all that is drawn

// Of a sample, or summed over samples; then alpha is the number of samples that cover the pixel.
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
