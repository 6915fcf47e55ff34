// Sum of the thesis [Single 2014] as a baseline: for each wavelength and each term of the Taylor series, the Fourier
// series of the infinite periodic surface at the 3 x 3 bins nearest to a frequency, weighted by the spectrum of the
// window. Two optimisations leave the sum unchanged: two terms share a texel, and weights are computed once per
// wavelength. Its twin is src/render/source/thesis.rs.

layout(constant_id = 10) const int PAIRS = 1; // pairs of terms

layout(set = 1, binding = 2, std140) uniform Thesis {
    float sigma;               // standard deviation of the Gaussian window [um]
    float half_range;          // a: the heights are in -a ... a [um]
    int wavelengths;           // texels of `nodes`
    vec2 bins_per_frequency;   // T_x, T_y [um]
    vec2 origin;               // bin of f = 0
    vec2 band;                 // largest |f_x|, |f_y| in the series [1/um]
    Medium medium;             // refractive indices of the surface, unless sums over wavelengths contain all of it
} source;

// RGBA = Re, Im of term 2p, Re, Im of term 2p + 1; layer p.
layout(set = 1, binding = 3) uniform sampler2DArray series;

// XYZ weight and wavenumber [1/um], the wavenumber growing.
layout(set = 1, binding = 4) uniform sampler2D nodes;

// Returns c_2p P_2p + c_2p+1 P_2p+1 of a pair of terms.
vec2 sum_of_terms(vec4 c, vec4 s) {
    return vec2(c.x * s.x - c.y * s.y, c.x * s.y + c.y * s.x) + vec2(c.z * s.z - c.w * s.w, c.z * s.w + c.w * s.z);
}

// Returns |P|^2 relative to the peak of a flat mirror.
float power_of_taps(vec2 toward, float conjugate, float w, float wavenumber) {
    vec2 place = toward * wavenumber * source.bins_per_frequency; // bins
    vec2 nearest = floor(place + 0.5);
    ivec2 middle = ivec2(nearest + source.origin);
    // Spectrum of the window, exp(-2 pi^2 sigma^2 f^2), at the middle bin and its neighbours.
    vec2 width = 2.0 * PI * PI * source.sigma * source.sigma / (source.bins_per_frequency * source.bins_per_frequency);
    vec2 weights[3];
    for (int tap = 0; tap < 3; ++tap) {
        vec2 away = place - nearest - float(tap - 1);
        weights[tap] = exp(-width * away * away);
    }
    float step = 2.0 * PI * wavenumber * w * source.half_range;
    vec2 c = vec2(1.0, 0.0); // (i z a)^n / n!
    vec2 p = vec2(0.0);
    for (int layer = 0; layer < PAIRS; ++layer) {
        float n = float(2 * layer + 1);
        vec2 next = vec2(-c.y, c.x) * (step / n);
        vec4 s = vec4(0.0);
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 3; ++x) {
                s += weights[x].x * weights[y].y * texelFetch(series, ivec3(middle + ivec2(x - 1, y - 1), layer), 0);
            }
        }
        p += sum_of_terms(vec4(c.x, c.y * conjugate, next.x, next.y * conjugate), s);
        c = vec2(-next.y, next.x) * (step / (n + 1.0));
    }
    return dot(p, p);
}

const bool SOURCE_READS_FOOTPRINT = false;

// Returns q^2 |P|^2 [1/um^2].
float density_at(Pair pair, float wavenumber) {
    float conjugate = pair.toward.x < 0.0 ? -1.0 : 1.0; // the series holds f_x >= 0
    float reflected = reflectance_at(pair, wavenumber);
    return wavenumber * wavenumber * reflected * power_of_taps(pair.toward * conjugate, conjugate, pair.w, wavenumber);
}

float largest_wavenumber(Pair pair) {
    vec2 reach = source.band / max(abs(pair.toward), vec2(1e-9));
    return pair.factor.y > 0.0 ? min(reach.x, reach.y) : 0.0;
}

vec3 source_xyz(Pair pair, Footprint footprint) {
    float largest = largest_wavenumber(pair);
    vec3 xyz = vec3(0.0);
    for (int node = part.first; node < source.wavelengths; node += part.step) {
        vec4 weight_and_wavenumber = texelFetch(nodes, ivec2(node, 0), 0);
        float wavenumber = weight_and_wavenumber.w;
        if (wavenumber > largest) {
            break; // wavenumbers grow
        }
        xyz += weight_and_wavenumber.xyz * density_at(pair, wavenumber);
    }
    return xyz * (pair.factor * source.sigma * source.sigma);
}

vec3 source_round_xyz(Pair pair, float radius) {
    return source_xyz(pair, POINT);
}

float source_spectral(Pair pair, float wavenumber) {
    bool seen = wavenumber <= largest_wavenumber(pair);
    return seen ? pair.factor.y * source.sigma * source.sigma * density_at(pair, wavenumber) : 0.0;
}

vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return reads_of(series, pixel, scattered, samples);
}

// There is no separate specular order.
vec3 source_specular(Pair pair, Footprint footprint) {
    return vec3(0.0);
}

vec3 source_mirrored(Pair pair) {
    return vec3(0.0);
}
