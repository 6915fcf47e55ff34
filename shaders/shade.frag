#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel: for each light what the source says that the surface diffracts, and the pigment below what it reflects.
#include "frame.glsl"
#include "brdf.glsl"
#include "reads.glsl"
#include "source.glsl"
#include "color.glsl"
#include "pixel.glsl"

layout(constant_id = 0) const int LIGHTS = MAX_LIGHTS; // known beforehand, so that only their directions are read
layout(constant_id = 1) const bool MARKED = true;      // whether directions tell what is covered

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

// What a pixel covers of (u, v) for a light.
Footprint footprint_of(int light, vec2 toward, ivec2 pixel) {
    return Footprint(shorter_step(light, toward, pixel, ivec2(1, 0)), shorter_step(light, toward, pixel, ivec2(0, 1)));
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 stored = texelFetch(directions, pixel, 0);
    radiance = vec4(0.0);
    if (MARKED && !covered(stored)) {
        return;
    }
    vec3 to_view = unprojected(stored.xy);
    vec3 albedo = albedo_of(pixel);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < LIGHTS; ++i) {
        vec3 to_light = light_direction(stored, i, pixel);
        Pair pair = pair_of(to_light, to_view, source.normal_reflectance);
        Footprint footprint = POINT;
        if (SOURCE_READS_FOOTPRINT) {
            footprint = footprint_of(i, pair.toward, pixel);
        }
        vec3 diffracted = LINEAR_SRGB_FROM_XYZ * source_xyz(pair, footprint);
        vec3 pigmented = albedo * ((1.0 - pair.reflectance) * to_light.z / PI);
        // Below the horizon there is neither.
        sum += pair.factor > 0.0 ? (diffracted + pigmented) * (frame.lights[i].w * PI) : vec3(0.0);
    }
    radiance = vec4(sum, 1.0);
}
