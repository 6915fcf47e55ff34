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
#include "gbuffer.glsl"
#include "light.glsl"

layout(constant_id = 0) const bool MARKED = true;      // true if uncovered pixels have to be skipped
layout(constant_id = 1) const bool OWN_REFLECTANCE = false; // true if the source already contains Fresnel's R
layout(constant_id = 2) const float NORMAL_OF_PIGMENT = 0.0; // R0 that attenuates the pigment if the source contains R

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

// Returns the radiance due to the light.
vec3 of_light(ivec2 pixel, SurfacePoint at, vec3 to_light) {
    Pair pair = pair_of(to_light, at.to_view, source.index);
    Footprint footprint = POINT;
    if (SOURCE_READS_FOOTPRINT) {
        Footprint change = footprint_of(at, to_light);
        footprint = Footprint(frame.at.footprint * change.dx, frame.at.footprint * change.dy);
    }
    vec3 diffracted = source_xyz(pair, footprint);
    if (!MIRRORED) {
        diffracted += source_specular(pair, footprint);
    }
    diffracted = LINEAR_SRGB_FROM_XYZ * diffracted;
    float kept = OWN_REFLECTANCE ? schlick(NORMAL_OF_PIGMENT, pair.cos_half) : pair.reflectance;
    float first = part.first == 0 ? 1.0 : 0.0;
    vec3 pigmented = albedo_of(pixel) * white * (first * (1.0 - kept) * to_light.z / PI);
    return (diffracted + pigmented) * (frame.irradiance.rgb * (PI * falloff(at)));
}

// Returns the reflection of the surroundings by the specular order, from their radiance in the mirrored direction.
vec3 of_surroundings(SurfacePoint at) {
    if (!MIRRORED || at.to_view.z <= HORIZON) {
        return vec3(0.0);
    }
    Pair pair = pair_of(vec3(-at.to_view.xy, at.to_view.z), at.to_view, source.index);
    return LINEAR_SRGB_FROM_XYZ * source_mirrored(pair) * mirrored_radiance(at) / at.to_view.z;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    radiance = vec4(0.0);
    if (MARKED && !covered(texelFetch(facing, pixel, 0))) {
        return;
    }
    SurfacePoint at = surface_at(pixel);
    vec3 to_light = direction_of_light(at);
    bool lit = above_horizon(to_light, at.to_view) && !(SHADOWS && in_shadow(at));
    radiance = vec4(of_surroundings(at) + (lit ? of_light(pixel, at, to_light) : vec3(0.0)), coverage);
}
