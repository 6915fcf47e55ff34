#version 460
#extension GL_GOOGLE_include_directive : require
// Shades a pixel under lights of one kind: the diffracted light of the source, and the pigment below the reflecting
// surface. Blending adds the result to that of other lights.
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

layout(constant_id = 1) const bool SOURCE_HAS_REFLECTANCE = false; // true if the source already contains Fresnel's R
layout(constant_id = 2) const float NORMAL_OF_PIGMENT = 0.0; // R0 that attenuates the pigment if the source contains R; 1 hides it

layout(constant_id = 6) const int FIRST_LIGHT = 0; // place of the first light
layout(constant_id = 7) const int LIGHTS = 1;      // number of lights

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

// Returns the radiance due to a light in the direction `to_light`. `views`: differences of the direction to the viewer.
// Only the pigment is lit by a light whose middle is below the horizon.
vec3 of_light(ivec2 pixel, SurfacePoint at, mat2x3 views, Light light, vec3 to_light) {
    bool diffracts = to_light.z > HORIZON;
    Pair pair = pair_of(vec3(to_light.xy, max(to_light.z, 2.0 * HORIZON)), at.to_view, source.medium);
    vec3 diffracted = vec3(0.0);
    if (diffracts) {
        Footprint footprint = POINT;
        if (SOURCE_READS_FOOTPRINT) {
            Footprint change = footprint_of(at, views, light, to_light);
            footprint = Footprint(frame.at.footprint * change.dx, frame.at.footprint * change.dy);
        }
        diffracted = CHOSEN ? source_round_xyz(pair, footprint.dx.x) : source_xyz(pair, footprint);
        if (!MIRRORED) {
            diffracted += source_specular(pair, footprint);
        }
        diffracted = LINEAR_SRGB_FROM_XYZ * diffracted;
    }
    float kept = SOURCE_HAS_REFLECTANCE ? schlick(NORMAL_OF_PIGMENT, pair.cos_half) : pair.reflectance;
    float passed = LIMITED ? (NORMAL_OF_PIGMENT < 1.0 ? pair.pigment : 0.0) : 1.0 - kept;
    float first = part.first == 0 ? 1.0 : 0.0;
    vec3 pigmented = albedo_of(pixel) * white * (first * passed * mean_cosine(light, to_light.z) / PI);
    return (diffracted + pigmented) * (light.irradiance.rgb * (PI * falloff(at, light)));
}

// Returns the reflection of the surroundings by the specular order, from their radiance in the mirrored direction.
vec3 of_surroundings(SurfacePoint at, mat2x3 views, Light light) {
    if (!MIRRORED || at.to_view.z <= HORIZON) {
        return vec3(0.0);
    }
    Pair pair = pair_of(vec3(-at.to_view.xy, at.to_view.z), at.to_view, source.medium);
    return LINEAR_SRGB_FROM_XYZ * source_mirrored(pair) * mirrored_radiance(at, views, light) / at.to_view.z;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    radiance = vec4(0.0);
    if (!covered(texelFetch(facing, pixel, 0))) {
        return;
    }
    SurfacePoint at = surface_at(pixel);
    mat2x3 views = view_differences(at);
    radiance.a = coverage;
    for (int place = FIRST_LIGHT; place < FIRST_LIGHT + LIGHTS; ++place) {
        int number = CHOSEN ? slot_of(pixel, place) : place;
        Light light = frame.lights[number];
        vec3 to_light = direction_of_light(at, light);
        bool shines = to_light.z > HORIZON || mean_cosine(light, to_light.z) > 0.0;
        float share = shines && at.to_view.z > HORIZON ? (SHADOWS ? visibility(at, light, number) : 1.0) : 0.0;
        if (!CHOSEN || place == 0) {
            // The same for all directions that a pixel takes.
            radiance.rgb += of_surroundings(at, views, light) * (CHOSEN ? float(LIGHTS) : 1.0);
        }
        radiance.rgb += share > 0.0 ? share * of_light(pixel, at, views, light, to_light) : vec3(0.0);
    }
}
