#version 460
#extension GL_GOOGLE_include_directive : require
// From the linear radiance of covered pixels to a display: exposure, gamut, transfer.
#include "color.glsl"

layout(set = 0, binding = 0) uniform sampler2D radiance;

layout(push_constant) uniform Display {
    float exposure; // in stops
} display;

layout(location = 0) out vec4 code;

void main() {
    vec3 exposed = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb * exp2(display.exposure);
    code = vec4(srgb_transfer(map_to_gamut(exposed)), 1.0);
}
