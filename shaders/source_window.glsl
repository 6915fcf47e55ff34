// Spectra of an expansion's terms through one Gaussian window, summed over wavelengths. Its twin is
// src/render/source/window.rs.
#include "spectra.glsl"

const int UV_BINS = 256; // entries of `bins` over |(u, v)| in 0 ... 2

// Row of `nodes` and number of wavelengths for each bin of |(u, v)|.
layout(set = 1, binding = 6, std430) readonly buffer Bins { ivec2 bins[]; };

const bool SOURCE_READS_FOOTPRINT = false;

// Returns XYZ of f cos(theta_i) [1/sr], over the wavelengths within the band, as many as |(u, v)| needs.
vec3 source_xyz(Pair pair, Footprint footprint) {
    Ray ray = ray_of(pair);
    float largest = largest_wavenumber(pair);
    vec3 xyz = vec3(0.0);
    ivec2 set = bins[min(int(pair.uv * (0.5 * float(UV_BINS))), UV_BINS - 1)];
    for (int node = part.first; node < set.y; node += part.step) {
        vec4 weight_and_wavenumber = texelFetch(nodes, ivec2(node, set.x), 0);
        float wavenumber = weight_and_wavenumber.w;
        if (wavenumber > largest) {
            break; // wavenumbers grow
        }
        float reflected = reflectance_at(pair, wavenumber);
        xyz += weight_and_wavenumber.xyz * (wavenumber * wavenumber * reflected * power(ray, wavenumber));
    }
    return cosine_weighted(pair, xyz);
}

vec3 source_round_xyz(Pair pair, float radius) {
    return source_xyz(pair, POINT);
}

float source_spectral(Pair pair, float wavenumber) {
    return cosine_weighted_at(pair, wavenumber);
}

vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return reads_of(layers, pixel, scattered, samples);
}

// There is no separate specular order.
vec3 source_specular(Pair pair, Footprint footprint) {
    return vec3(0.0);
}

vec3 source_mirrored(Pair pair) {
    return vec3(0.0);
}
