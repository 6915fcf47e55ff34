#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel from a colour table: for each light one lookup, and the pigment below what the surface reflects.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "color.glsl"
#include "table.glsl"
#include "pixel.glsl"

layout(constant_id = 8) const int LIGHTS = 1; // known beforehand, so that only their directions are read

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

// The step of -(u, v) from a pixel to its neighbours at `next` and opposite: the shorter one, because the other may lead over an
// edge to something else. Nothing where neither is covered.
vec2 shorter_step(int light, vec2 toward, ivec2 pixel, ivec2 next) {
    vec2 step = vec2(1e6);
    for (int side = -1; side <= 1; side += 2) {
        ivec2 other = clamp(pixel + side * next, ivec2(0), textureSize(directions, 0) - 1);
        vec4 stored = texelFetch(directions, other, 0);
        vec2 found = float(side) * (light_direction(stored, light, other).xy + unprojected(stored.xy).xy - toward);
        bool counts = covered(stored) && other != pixel && dot(found, found) < dot(step, step);
        step = counts ? found : step;
    }
    return step.x < 1e6 ? step : vec2(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 stored = texelFetch(directions, pixel, 0);
    vec3 to_view = unprojected(stored.xy);
    vec3 albedo = albedo_of(pixel);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < LIGHTS; ++i) {
        vec3 to_light = light_direction(stored, i, pixel);
        Pair pair = pair_of(to_light, to_view);
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
    radiance = covered(stored) ? vec4(sum, 1.0) : vec4(0.0);
}
