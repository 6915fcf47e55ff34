#version 460
#extension GL_GOOGLE_include_directive : require
// From linear radiance to a display: background, exposure, gamut, transfer.
#include "color.glsl"

layout(set = 0, binding = 0) uniform sampler2D radiance;

layout(push_constant) uniform Display {
    vec4 background; // linear sRGB as displayed, exposure not applied; w: exposure in stops
} display;

layout(location = 0) out vec4 code;

void main() {
    vec4 linear = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0);
    vec3 exposed = linear.rgb * exp2(display.background.w);
    code = vec4(srgb_transfer(map_to_gamut(mix(display.background.rgb, exposed, linear.a))), 1.0);
}
