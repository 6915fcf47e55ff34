// Material of the surface, and the pairs of directions that sources are evaluated for. The f64 twin is
// src/optics/brdf.rs; the Rust side is src/render/source/surface_factor.rs.

layout(constant_id = 31) const int FACTOR_LAW = 1;
layout(constant_id = 32) const int POLARISATION = 0;
layout(constant_id = 33) const bool LIMITED = false;

#include "small_slope.glsl"

// Over the wavenumbers of the visible range, in rows: R over the cosine at the half vector by Stam's theory, or n and k.
layout(set = 1, binding = 0) uniform sampler2D reflectances;

// Limit of energy over a square of directions, ends included (src/optics/energy.rs).
layout(set = 1, binding = 1) uniform sampler2D energy;

// Returns R of a dielectric in air for unpolarised light by Fresnel's equations [Walter et al. 2007, eq. 22], with
// g - c = (n^2 - 1) / (g + c).
float fresnel(float index, float c) {
    float contrast = (index - 1.0) * (index + 1.0);
    float sum = sqrt(contrast + c * c) + c;
    float s = contrast / (sum * sum);
    float p = (c * sum - 1.0) / (c * contrast / sum + 1.0);
    return 0.5 * s * s * (1.0 + p * p);
}

// Returns Schlick's approximation of R from its value at normal incidence.
float schlick(float normal_reflectance, float cosine) {
    float grazing = 1.0 - cosine;
    float grazing2 = grazing * grazing;
    return normal_reflectance + (1.0 - normal_reflectance) * grazing2 * grazing2 * grazing;
}

// Returns R of a dielectric by the selected law, Fresnel's for the small-slope approximation, or 1 if sums over wavelengths contain it.
float dielectric(float index, float cosine) {
    if (FACTOR_LAW == 1 || FACTOR_LAW == 3) {
        return fresnel(index, cosine);
    }
    float root = (index - 1.0) / (index + 1.0);
    return FACTOR_LAW == 2 ? schlick(root * root, cosine) : 1.0;
}

vec2 energy_at(vec3 direction) {
    vec2 size = vec2(textureSize(energy, 0));
    float z = max(direction.z, 0.0);
    vec2 place = 0.5 + 0.5 * direction.xy * inversesqrt((1.0 + sqrt(z)) * (1.0 + z));
    return textureLod(energy, (place * (size - 1.0) + 0.5) / size, 0.0).rg;
}

#include "pair.glsl"

const float SHORTEST = 0.380; // of the visible range [um]
const float LONGEST = 0.780;

// Returns the part of the factor that depends on the wavelength, or 1.
float reflectance_at(Pair pair, float wavenumber) {
    const float FIRST = 1.0 / LONGEST, LAST = 1.0 / SHORTEST;
    if (FACTOR_LAW != SPECTRAL && FACTOR_LAW != SMALL_SLOPE_SPECTRAL) {
        return 1.0;
    }
    vec2 size = vec2(textureSize(reflectances, 0));
    float column = FACTOR_LAW == SPECTRAL ? pair.cos_half : 0.0;
    vec2 place = vec2(column, (wavenumber - FIRST) / (LAST - FIRST));
    vec2 found = textureLod(reflectances, (place * (size - 1.0) + 0.5) / size, 0.0).rg;
    return FACTOR_LAW == SPECTRAL ? found.r : small_slope(found.r, found.g, pair.slants);
}
