// Reflectance of the surface, and the pairs of directions that sources are evaluated for. The f64 twin is
// src/optics/brdf.rs.

// Law of R in the factor of a pair. The Rust side is src/render/source/reflectance.rs.
const int SPECTRAL = 0; // the factor contains no R; sums over wavelengths do
const int FRESNEL = 1;  // Fresnel's equations for a refractive index without dispersion
const int SCHLICK = 2;  // Schlick's approximation of them, as in the thesis
layout(constant_id = 31) const int REFLECTANCE_LAW = FRESNEL;

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

// Returns R of a dielectric by the selected law, or 1 for a spectral law.
float dielectric(float index, float cosine) {
    if (REFLECTANCE_LAW == SPECTRAL) {
        return 1.0;
    }
    float root = (index - 1.0) / (index + 1.0);
    return REFLECTANCE_LAW == FRESNEL ? fresnel(index, cosine) : schlick(root * root, cosine);
}

#include "pair.glsl"
