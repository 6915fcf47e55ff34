#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel: for each light what the source says that the surface diffracts, and the pigment below what it reflects.
#include "frame.glsl"
#include "brdf.glsl"
#include "part.glsl"
layout(push_constant) uniform Shade {
    Part part;
    uint lights;    // that have the illuminant of the source, one bit each
    float coverage; // 1, or 0 where the pass adds to what was drawn
    vec3 white;     // of the illuminant, linear sRGB
};
#include "reads.glsl"
#include "source.glsl"
#include "color.glsl"
#include "pixel.glsl"

layout(constant_id = 0) const int LIGHTS = MAX_LIGHTS; // known beforehand, so that only their directions are read
layout(constant_id = 1) const bool MARKED = true;      // whether directions tell what is covered
layout(constant_id = 2) const bool OWN_REFLECTANCE = false; // whether the source holds R or a part of it, so that the pair does not know what the surface keeps from the pigment
layout(constant_id = 3) const float NORMAL_OF_PIGMENT = 0.0; // R0 of what the surface keeps from the pigment, where the source holds R

layout(constant_id = 4) const bool MIRRORED = false; // whether the last light is drawn from surroundings, and their specular order is read apart

layout(constant_id = 5) const bool LAMPS = false;    // whether lights differ in brightness from pixel to pixel

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

// What comes from light number `light`. Calls name it by a constant: devices that run both sides of a branch would read the images of every light for each.
vec3 of_light(int light, ivec2 pixel, vec4 stored, vec3 to_view, vec3 albedo, float falloff) {
    if (light >= LIGHTS || (lights & (1u << light)) == 0u) {
        return vec3(0.0);
    }
    vec3 to_light = light_direction(stored, light, pixel);
    Pair pair = pair_of(to_light, to_view, source.normal_reflectance);
    Footprint footprint = POINT;
    if (SOURCE_READS_FOOTPRINT) {
        footprint = footprint_of(light, pixel);
    }
    vec3 diffracted = source_xyz(pair, footprint);
    if (!MIRRORED || light < LIGHTS - 1) {
        diffracted += source_specular(pair, footprint);
    }
    diffracted = LINEAR_SRGB_FROM_XYZ * diffracted;
    float kept = OWN_REFLECTANCE ? schlick(NORMAL_OF_PIGMENT, pair.cos_half) : pair.reflectance;
    vec3 pigmented = part.first == 0 ? albedo * white * ((1.0 - kept) * to_light.z / PI) : vec3(0.0);
    // Below the horizon there is neither.
    return pair.factor > 0.0 ? (diffracted + pigmented) * (frame.irradiances[light].rgb * (PI * falloff)) : vec3(0.0);
}

// Of the light from all around, the specular order sends on what comes from the mirrored direction.
vec3 of_surroundings(ivec2 pixel, vec3 to_view) {
    if (!MIRRORED || (lights & (1u << (LIGHTS - 1))) == 0u || to_view.z <= HORIZON) {
        return vec3(0.0);
    }
    Pair pair = pair_of(vec3(-to_view.xy, to_view.z), to_view, source.normal_reflectance);
    return LINEAR_SRGB_FROM_XYZ * source_mirrored(pair) * mirrored_of(LIGHTS, pixel) / to_view.z;
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
    vec4 falloff = LAMPS ? texelFetch(falloffs, pixel, 0) : vec4(1.0);
    vec3 sum = of_surroundings(pixel, to_view);
    sum += of_light(0, pixel, stored, to_view, albedo, falloff.x);
    sum += of_light(1, pixel, stored, to_view, albedo, falloff.y);
    sum += of_light(2, pixel, stored, to_view, albedo, falloff.z);
    sum += of_light(3, pixel, stored, to_view, albedo, falloff.w);
    radiance = vec4(sum, coverage);
}
