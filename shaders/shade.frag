#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel under one light: the diffracted light of the source, and the pigment below the reflecting surface.
// Blending adds the result to that of other lights.
#include "frame.glsl"
#include "brdf.glsl"
#include "part.glsl"
layout(push_constant) uniform Shade {
    Part part;
    float coverage; // 1, or 0 if this pass does not count the covered pixels
    vec3 white;     // white of the illuminant, linear sRGB
};
#include "reads.glsl"
#include "source.glsl"
#include "color.glsl"
#include "pixel.glsl"

layout(constant_id = 0) const bool MARKED = true;      // true if uncovered pixels have to be skipped
layout(constant_id = 1) const bool OWN_REFLECTANCE = false; // true if the source already contains Fresnel's R
layout(constant_id = 2) const float NORMAL_OF_PIGMENT = 0.0; // R0 that attenuates the pigment if the source contains R

layout(constant_id = 3) const bool MIRRORED = false; // true: light of the surroundings, separate specular order

layout(constant_id = 4) const bool LAMPS = false;    // true if the falloff of lights differs between pixels

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

// Returns the radiance due to the light.
vec3 of_light(ivec2 pixel, vec3 to_light, vec3 to_view) {
    Pair pair = pair_of(to_light, to_view, source.index);
    Footprint footprint = POINT;
    if (SOURCE_READS_FOOTPRINT) {
        footprint = footprint_of(pixel);
    }
    vec3 diffracted = source_xyz(pair, footprint);
    if (!MIRRORED) {
        diffracted += source_specular(pair, footprint);
    }
    diffracted = LINEAR_SRGB_FROM_XYZ * diffracted;
    float kept = OWN_REFLECTANCE ? schlick(NORMAL_OF_PIGMENT, pair.cos_half) : pair.reflectance;
    vec3 pigmented = part.first == 0 ? albedo_of(pixel) * white * ((1.0 - kept) * to_light.z / PI) : vec3(0.0);
    float falloff = LAMPS ? texelFetch(albedos, pixel, 0).a : 1.0;
    return above_horizon(to_light, to_view) ? (diffracted + pigmented) * (frame.irradiance.rgb * (PI * falloff)) : vec3(0.0);
}

// Returns the reflection of the surroundings by the specular order, from their radiance in the mirrored direction.
vec3 of_surroundings(ivec2 pixel, vec3 to_view) {
    if (!MIRRORED || to_view.z <= HORIZON) {
        return vec3(0.0);
    }
    Pair pair = pair_of(vec3(-to_view.xy, to_view.z), to_view, source.index);
    return LINEAR_SRGB_FROM_XYZ * source_mirrored(pair) * texelFetch(mirrored, pixel, 0).rgb / to_view.z;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 stored = texelFetch(directions, pixel, 0);
    radiance = vec4(0.0);
    if (MARKED && !covered(stored)) {
        return;
    }
    vec3 to_view = unprojected(stored.xy);
    radiance = vec4(of_surroundings(pixel, to_view) + of_light(pixel, unprojected(stored.zw), to_view), coverage);
}
