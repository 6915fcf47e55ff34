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
    vec4 falloff = LAMPS ? texelFetch(falloffs, pixel, 0) : vec4(1.0);
    for (int i = 0; i < LIGHTS; ++i) {
        if ((lights & (1u << i)) == 0u) {
            continue;
        }
        vec3 to_light = light_direction(stored, i, pixel);
        Pair pair = pair_of(to_light, to_view, source.normal_reflectance);
        Footprint footprint = POINT;
        if (SOURCE_READS_FOOTPRINT) {
            footprint = footprint_of(i, pixel);
        }
        vec3 diffracted = source_xyz(pair, footprint);
        if (!MIRRORED || i < LIGHTS - 1) {
            diffracted += source_specular(pair, footprint);
        }
        diffracted = LINEAR_SRGB_FROM_XYZ * diffracted;
        float kept = OWN_REFLECTANCE ? schlick(NORMAL_OF_PIGMENT, pair.cos_half) : pair.reflectance;
        vec3 pigmented = part.first == 0 ? albedo * white * ((1.0 - kept) * to_light.z / PI) : vec3(0.0);
        // Below the horizon there is neither.
        sum += pair.factor > 0.0 ? (diffracted + pigmented) * (frame.irradiances[i].rgb * (PI * falloff[i])) : vec3(0.0);
    }
    if (MIRRORED && (lights & (1u << (LIGHTS - 1))) != 0u && to_view.z > HORIZON) {
        // Of the light from all around, the specular order sends on what comes from the mirrored direction.
        Pair pair = pair_of(vec3(-to_view.xy, to_view.z), to_view, source.normal_reflectance);
        sum += LINEAR_SRGB_FROM_XYZ * source_mirrored(pair) * mirrored_of(LIGHTS, pixel) / to_view.z;
    }
    radiance = vec4(sum, coverage);
}
