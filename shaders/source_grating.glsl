// Finite grating of n x m copies of the patch. The response of one copy is read from its spectra and multiplied by the
// periodic factors; wavelengths lie at the orders and between them. Its twin is src/render/source/grating.rs.
#include "spectra.glsl"
#include "orders.glsl"

layout(set = 1, binding = 6, std140) uniform Grating {
    Copies copies;
} grating;

const bool SOURCE_READS_FOOTPRINT = false;

// Returns XYZ of f cos(theta_i) [1/sr].
vec3 source_xyz(Pair pair, Footprint footprint) {
    Ray ray = ray_of(pair);
    Sampling s = sampling(grating.copies, ray.toward);
    float largest = largest_wavenumber(pair);
    vec3 xyz = vec3(0.0);
    ivec2 ends = seen_orders(s);
    for (int number = ends.x + part.first; number < ends.y; number += part.step) {
        vec2 order = order_at(s, number);
        float wavenumber = order.x;
        if (wavenumber > largest) {
            break; // wavenumbers grow
        }
        float reflected = reflectance_at(pair, wavenumber);
        xyz += colour_density(wavenumber) * (order.y * wavenumber * wavenumber * reflected * power(ray, wavenumber));
    }
    return cosine_weighted(pair, xyz / s.periods);
}

vec3 source_round_xyz(Pair pair, float radius) {
    return source_xyz(pair, POINT);
}

// Returns the value of one copy; its periodic factor is multiplied in f64, which resolves orders of any sharpness.
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
