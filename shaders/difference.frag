#version 460
#extension GL_GOOGLE_include_directive : require
// How far two radiances are apart, relative to the second, in false colour over four decades.

layout(set = 0, binding = 0) uniform sampler2D judged;
layout(set = 0, binding = 1) uniform sampler2D judge;

layout(push_constant) uniform Difference {
    float floor; // radiance below which errors count against this radiance
} difference;

layout(location = 0) out vec4 code;

// The stops of `render::difference::STOPS`: viridis, sRGB-encoded, from an error of 1e-4 to 1.
const vec3 STOPS[9] = vec3[](
    vec3(0.267, 0.005, 0.329), vec3(0.278, 0.173, 0.478), vec3(0.231, 0.319, 0.545), vec3(0.172, 0.443, 0.557),
    vec3(0.129, 0.565, 0.553), vec3(0.153, 0.678, 0.506), vec3(0.361, 0.784, 0.388), vec3(0.667, 0.863, 0.196),
    vec3(0.993, 0.906, 0.144));

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 a = texelFetch(judged, pixel, 0);
    vec4 b = texelFetch(judge, pixel, 0);
    float error = distance(a.rgb, b.rgb) / max(length(b.rgb), difference.floor);
    float place = clamp(log(max(error, 1e-20)) / log(10.0) + 4.0, 0.0, 4.0) * 2.0;
    int stop = min(int(place), 7);
    code = vec4(mix(STOPS[stop], STOPS[stop + 1], place - float(stop)), 1.0);
}
