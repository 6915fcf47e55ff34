// Classical real-time shader of compact discs (Stam, in GPU Gems, chapter 8): the surface is a grating of one period,
// the grating equation u = m lambda/d is solved for the wavelength of each order, and the colours of these wavelengths
// are summed. Baseline without data. Its twin is src/render/source/classical_grating.rs.

layout(set = 1, binding = 2, std140) uniform ClassicalGrating {
    float period;             // [um]
    float strength;           // radiance of the first order under a light of irradiance 1
    vec2 axis;                // direction of the period, in the tangent plane
    Medium medium;            // refractive indices of the surface, unless sums over wavelengths contain all of it
} source;

const int ORDERS = 8;

float lobe(float x, float centre, float below, float above) {
    float t = (x - centre) / (x < centre ? below : above);
    return exp(-0.5 * t * t);
}

// CIE 1931 2 degree observer at a wavelength in nm (Wyman, Sloan, Shirley 2013, multi-lobe fit).
vec3 observer(float x) {
    return vec3(1.056 * lobe(x, 599.8, 37.9, 31.0) + 0.362 * lobe(x, 442.0, 16.0, 26.7) - 0.065 * lobe(x, 501.1, 20.4, 26.2),
                0.821 * lobe(x, 568.8, 46.9, 40.5) + 0.286 * lobe(x, 530.9, 16.3, 31.1),
                1.217 * lobe(x, 437.0, 11.8, 36.0) + 0.681 * lobe(x, 459.0, 26.0, 13.8));
}

const bool SOURCE_READS_FOOTPRINT = false;

vec3 source_xyz(Pair pair, Footprint footprint) {
    float sines = abs(dot(pair.toward, source.axis));
    vec3 xyz = vec3(0.0);
    for (int order = 1; order <= ORDERS; ++order) {
        float wavelength = 1000.0 * source.period * sines / float(order);
        xyz += observer(wavelength) / float(order * order);
    }
    return xyz * source.strength;
}

vec3 source_round_xyz(Pair pair, float radius) {
    return source_xyz(pair, POINT);
}

// Never used: the orders have colours only.
float source_spectral(Pair pair, float wavenumber) {
    return 0.0;
}

// There is no texture.
vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return vec4(0.0);
}

// There is no separate specular order.
vec3 source_specular(Pair pair, Footprint footprint) {
    return vec3(0.0);
}

vec3 source_mirrored(Pair pair) {
    return vec3(0.0);
}
