#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel from a colour table: for each light one lookup, and the pigment below what the surface reflects.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "color.glsl"
#include "table.glsl"

// What `geometry.frag` wrote.
layout(set = 0, binding = 9) uniform sampler2D view_directions;
layout(set = 0, binding = 10) uniform sampler2D albedos;
layout(set = 0, binding = 11) uniform sampler2D light_directions_0;
layout(set = 0, binding = 12) uniform sampler2D light_directions_1;
layout(set = 0, binding = 13) uniform sampler2D light_directions_2;
layout(set = 0, binding = 14) uniform sampler2D light_directions_3;

vec3 light_direction(int light, ivec2 pixel) {
    switch (light) {
    case 0: return texelFetch(light_directions_0, pixel, 0).xyz;
    case 1: return texelFetch(light_directions_1, pixel, 0).xyz;
    case 2: return texelFetch(light_directions_2, pixel, 0).xyz;
    default: return texelFetch(light_directions_3, pixel, 0).xyz;
    }
}

layout(constant_id = 8) const int LIGHTS = 1; // known beforehand, so that only their directions are read

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

// The step of -(u, v) from a pixel to its neighbours at `next` and opposite: the shorter one, because the other may lead over an
// edge to something else. Nothing where neither is covered.
vec2 shorter_step(int light, vec2 toward, ivec2 pixel, ivec2 next) {
    vec2 step = vec2(1e6);
    for (int side = -1; side <= 1; side += 2) {
        ivec2 other = clamp(pixel + side * next, ivec2(0), textureSize(view_directions, 0) - 1);
        vec4 to_view = texelFetch(view_directions, other, 0);
        vec2 found = float(side) * (light_direction(light, other).xy + to_view.xy - toward);
        bool counts = to_view.w > 0.0 && other != pixel && dot(found, found) < dot(step, step);
        step = counts ? found : step;
    }
    return step.x < 1e6 ? step : vec2(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 to_view = texelFetch(view_directions, pixel, 0);
    vec3 albedo = texelFetch(albedos, pixel, 0).rgb;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < LIGHTS; ++i) {
        vec3 to_light = light_direction(i, pixel);
        Pair pair = pair_of(to_light, to_view.xyz);
        vec2 toward = to_light.xy + to_view.xy;
        vec3 xyz;
        if (MAX_TAPS == 0) {
            xyz = table_xyz(pair, toward);
        } else {
            vec2 dx = shorter_step(i, toward, pixel, ivec2(1, 0)), dy = shorter_step(i, toward, pixel, ivec2(0, 1));
            xyz = table_xyz(pair, toward, dx, dy);
        }
        // Below the horizon there is neither.
        vec3 diffracted = pair.factor > 0.0 ? LINEAR_SRGB_FROM_XYZ * xyz : vec3(0.0);
        vec3 pigmented = pair.factor > 0.0 ? albedo * ((1.0 - pair.reflectance) * to_light.z / PI) : vec3(0.0);
        sum += (diffracted + pigmented) * (frame.lights[i].w * PI);
    }
    radiance = to_view.w > 0.0 ? vec4(sum, to_view.w) : vec4(0.0);
}
