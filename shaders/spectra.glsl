// Spectra of an expansion's terms on the device, and the amplitude that is their sum; shared by the sources of a window
// and of a grating. The f64 twin is src/optics/reference.rs; the Rust side is src/render/source/spectra.rs.

#extension GL_EXT_control_flow_attributes : require
#include "kernel.glsl"

layout(set = 1, binding = 2, std140) uniform Spectra {
    vec2 texture_size;              // texels of a layer along f_x and f_y
    vec2 origin;                    // centre of the texel of f = 0, in texels from the texture's corner
    vec2 texels_per_frequency;      // L_x, L_y [um]
    vec2 band;                      // largest |f_x|, |f_y| in the layers [1/um]
    float sigma;                    // standard deviation of the Gaussian window [um]
    float half_range;               // a: half the range of heights [um]
    vec2 column;                    // texture coordinate of `coefficients` at z = k|w| = 0, and per unit of z [um]
    float pairs_per_z;              // pairs of terms at k|w|: ceil(pairs_per_z k|w| + fewest_pairs)
    float fewest_pairs;
    Medium medium;                  // refractive indices of the surface, unless sums over wavelengths contain all of it
} source;

// Spectra of the basis functions: RGBA = Re, Im of term 2p, Re, Im of term 2p + 1, relative to the peak of a flat
// mirror. Pair p of terms is layer p.
layout(set = 1, binding = 3) uniform sampler2DArray layers;

// c_2p, c_2p+1 as (Re, Im, Re, Im) over z, in the layers of the same numbers. Small tables are textures, because
// software devices read textures eight lanes at a time, and buffers lane by lane.
layout(set = 1, binding = 4) uniform sampler2DArray coefficients;

// XYZ weight and wavenumber 1/lambda [1/um] of quadrature nodes, ascending along a row; or the colour functions as
// densities.
layout(set = 1, binding = 5) uniform sampler2D nodes;

// Compile-time constants. For other conditions software devices run both sides of a branch.
layout(constant_id = 12) const bool HALF_PLANE = true;   // the layers hold f_x >= 0 only
layout(constant_id = 13) const int PAIRS = 1;            // pairs of terms
layout(constant_id = 14) const bool FEWER_PAIRS = false; // small z need fewer pairs
layout(constant_id = 15) const bool TAYLOR = false;      // Taylor coefficients by recurrence, else from the table

// Ray of frequencies, -(u, v)/lambda, in the half plane stored in the spectra.
struct Ray {
    vec2 toward;      // -(u, v), or (u, v) if that is in the stored half plane
    float conjugate;  // -1 if the spectra have to be conjugated for that
    float w;          // |w|
};

Ray ray_of(Pair pair) {
    // w <= 0, and P(f; -z) = conj(P(-f; z)) because heights are real: |P(f)| = |sum c_n(|z|) P_n(-f)|. If every b_n is
    // real, the layers hold f_x >= 0, and the other half is P_n(-f) = conj(P_n(f)).
    float conjugate = HALF_PLANE && pair.toward.x < 0.0 ? -1.0 : 1.0;
    return Ray(pair.toward * conjugate, conjugate, pair.w);
}

// Returns the largest wavenumber within the band [1/um]; 0 below the horizon.
float largest_wavenumber(Pair pair) {
    if (pair.factor.y == 0.0) {
        return 0.0;
    }
    vec2 reach = source.band / max(abs(pair.toward), vec2(1e-9)); // unlimited in the specular direction
    return min(reach.x, reach.y);
}

// Returns c_2p P_2p + c_2p+1 P_2p+1 of a pair of terms.
vec2 sum_of_terms(vec4 c, vec4 s) {
    return vec2(c.x * s.x - c.y * s.y, c.x * s.y + c.y * s.x) + vec2(c.z * s.z - c.w * s.w, c.z * s.w + c.w * s.z);
}

// Returns the pairs of terms needed at k|w| = z.
int pairs_at(float z) {
    return min(int(ceil(z * source.pairs_per_z + source.fewest_pairs)), PAIRS);
}

// Returns |P|^2 relative to the peak of a flat mirror, at a wavenumber 1/lambda [1/um] within the band.
float power(Ray ray, float wavenumber) {
    Read read = read_at(ray.toward * wavenumber * source.texels_per_frequency + source.origin, source.texture_size);
    float z = 2.0 * PI * wavenumber * ray.w;
    float step = z * source.half_range;
    float column = source.column.x + z * source.column.y;
    int count = FEWER_PAIRS ? pairs_at(z) : PAIRS;
    // Taylor series: c_n = (i z a)^n/n! is real for even n and imaginary for odd n, where the conjugate changes the
    // sign.
    vec2 taylor = vec2(1.0, step * ray.conjugate);
    vec2 p = vec2(0.0);
    for (int pair = 0; pair < count; ++pair) {
        vec4 s = read_layer(layers, read, pair, 0.0);
        if (TAYLOR) {
            p += taylor.x * s.xy + taylor.y * vec2(-s.w, s.z);
            float n = float(2 * pair + 2);
            // Next pair: times (i z a)^2 over the next two factors.
            taylor *= -step * step / (n * vec2(n - 1.0, n + 1.0));
        } else {
            vec4 c = textureLod(coefficients, vec3(column, 0.5, pair), 0.0);
            c.yw *= ray.conjugate;
            p += sum_of_terms(c, s);
        }
    }
    return dot(p, p);
}

// Returns f cos(theta_i) of `pair` for q^2 |P|^2 = `power`, summed or not [1/sr]. Sums over wavelengths have one factor for X, Y and Z.
float cosine_weighted(Pair pair, float power) {
    return pair.factor.y * source.sigma * source.sigma * power;
}

vec3 cosine_weighted(Pair pair, vec3 powers) {
    return pair.factor * source.sigma * source.sigma * powers;
}

// Returns f cos(theta_i) at one wavenumber [1/sr].
float cosine_weighted_at(Pair pair, float wavenumber) {
    bool seen = wavenumber <= largest_wavenumber(pair);
    float reflected = reflectance_at(pair, wavenumber);
    return seen ? cosine_weighted(pair, wavenumber * wavenumber * reflected * power(ray_of(pair), wavenumber)) : 0.0;
}
