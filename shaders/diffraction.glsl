// Stam's wave-optics BRDF [Single 2014, B.12] from the layers: the optics that every stage shades with.
// Directions are unit vectors away from the surface in the tangent frame (x = T, y = B, z = N). The f64 twins are
// src/optics/brdf.rs and src/optics/reference.rs.

const float PI = 3.14159265358979;

// A cosine this small is within the rounding of an interpolated f32 direction: the direction counts as below the horizon,
// where nothing is reflected. It also keeps G/w^2 from overflowing.
const float HORIZON = 1e-6;

// What of a pair of directions does not depend on the wavelength.
struct Pair {
    vec2 toward;      // -(u, v), or (u, v) where the layers hold the other half of the plane
    float conjugate;  // -1 where they have to be conjugated for that
    float w;          // |w|
    float uv;         // |(u, v)|
    float factor;     // 4 pi sigma^2 R G cos(theta_i) / w^2 [um^2/sr]; 0 below the horizon
    float reflectance;
};

Pair pair_of(vec3 light, vec3 view) {
    Pair pair;
    vec3 uvw = -light - view;
    pair.w = -uvw.z;
    pair.uv = length(uvw.xy);
    // w <= 0, and P(f; -z) = conj(P(-f; z)) because heights are real: |P(f)| = |sum c_n(|z|) P_n(-f)|. Where every b_n is
    // real the layers hold f_x >= 0, and the other half is P_n(-f) = conj(P_n(f)).
    pair.conjugate = HALF_PLANE && -uvw.x < 0.0 ? -1.0 : 1.0;
    pair.toward = -uvw.xy * pair.conjugate;
    // 1 + light . view = |(u,v,w)|^2 / 2, which does not cancel near opposite grazing directions.
    float one_plus_dot = 0.5 * dot(uvw, uvw);
    float cos_half = min(0.5 * length(uvw), 1.0);
    float grazing = 1.0 - cos_half;
    float grazing2 = grazing * grazing;
    pair.reflectance =
        optics.normal_reflectance + (1.0 - optics.normal_reflectance) * grazing2 * grazing2 * grazing;
    bool above = light.z > HORIZON && view.z > HORIZON;
    pair.factor = above ? 4.0 * PI * optics.sigma * optics.sigma * pair.reflectance * one_plus_dot * one_plus_dot
                              / (view.z * pair.w * pair.w)
                        : 0.0;
    return pair;
}

// The largest wavenumber at which the layers hold anything [1/um].
float largest_wavenumber(Pair pair) {
    vec2 reach = optics.band / max(abs(pair.toward), vec2(1e-9)); // straight at the mirror direction every wavenumber is in
    return min(reach.x, reach.y);
}

// Where the coefficients come from; the same numbers as in src/precompute/coefficients.rs.
const int INTERPOLATED = 0; // linear between the columns of a table
const int NEAREST = 1;      // the nearest column
const int POWERS = 2;       // c_n = d^n of the place d in the band: computed
const int POLYNOMIALS = 3;  // c_0 = 1, c_n = d T_{n-1}(2d - 1) with Chebyshev's T: computed

const bool COMPUTED = SOURCE == POWERS || SOURCE == POLYNOMIALS;

// The coefficients at one z, pair after pair.
struct Coefficients {
    float place;     // in the band of z, 0 ... 1
    float conjugate; // as in `Pair`
    vec2 own;        // computed: of the pair at hand
    vec2 next;       // and of the next
};

Coefficients coefficients_from(float place, float conjugate) {
    Coefficients c = Coefficients(place, conjugate, vec2(1.0, place), vec2(0.0));
    if (SOURCE == POWERS) {
        c.next = vec2(place * place, place * place * place);
    } else {
        float x = 2.0 * place - 1.0;
        c.next = place * vec2(x, 2.0 * x * x - 1.0);
    }
    return c;
}

// To the next pair.
void advance(inout Coefficients c) {
    c.own = c.next;
    if (SOURCE == POWERS) {
        c.next *= c.place * c.place;
    } else {
        float twice = 4.0 * c.place - 2.0;
        c.next.x = twice * c.own.y - c.own.x;
        c.next.y = twice * c.next.x - c.own.y;
    }
}

// c_2p, c_2p+1 from a layer of the table.
vec4 coefficients_at(float place, int layer) {
    float column = place * optics.last_column;
    if (SOURCE == NEAREST) {
        return texelFetch(coefficients, ivec3(int(column + 0.5), 0, layer), 0);
    }
    // Interpolating all coefficients alike interpolates e^{izh} itself: an error of (dz a)^2/8 and no cancellation.
    return textureLod(coefficients, vec3((column + 0.5) / (optics.last_column + 1.0), 0.5, layer), 0.0);
}

// c_2p P_2p + c_2p+1 P_2p+1 of a pair of terms.
vec2 sum_of_terms(vec4 c, vec4 s) {
    return vec2(c.x * s.x - c.y * s.y, c.x * s.y + c.y * s.x) + vec2(c.z * s.z - c.w * s.w, c.z * s.w + c.w * s.z);
}

// The same of the pair at hand, whose layer this is; then goes on to the next.
vec2 next_terms(inout Coefficients coefficients, int layer, vec4 s) {
    if (COMPUTED) {
        vec2 sum = coefficients.own.x * s.xy + coefficients.own.y * s.zw;
        advance(coefficients);
        return sum;
    }
    vec4 c = coefficients_at(coefficients.place, layer);
    c.yw *= coefficients.conjugate;
    return sum_of_terms(c, s);
}

// Pairs of terms that k|w| = z needs.
int pairs_at(float z) {
    return min(int(ceil(z * optics.pairs_per_z + optics.fewest_pairs)), PAIRS);
}

// |P|^2 relative to the flat mirror's peak, at a wavenumber 1/lambda [1/um] within the band.
float power(Pair pair, float wavenumber) {
    Read read = read_at(pair.toward * wavenumber);
    float z = 2.0 * PI * wavenumber * pair.w;
    float place = z * optics.bands_per_z;
    int layer = min(int(place), Z_BANDS - 1);
    Coefficients c = coefficients_from(min(place - float(layer), 1.0), pair.conjugate);
    int count = FEWER_PAIRS ? pairs_at(z) : PAIRS;
    vec2 p = vec2(0.0);
    // Tested at its end: software devices run a loop's body until every lane has failed the test, and a test in front would
    // run it once more for nobody. There is always a pair.
    int done = 0;
    do {
        p += next_terms(c, layer, read_layer(read, layer));
        layer += Z_BANDS;
        ++done;
    } while (done < count);
    return dot(p, p);
}

// f cos(theta_i) at one wavenumber [1/sr].
float cosine_weighted(Pair pair, float wavenumber) {
    bool seen = pair.factor != 0.0 && wavenumber <= largest_wavenumber(pair);
    return seen ? pair.factor * wavenumber * wavenumber * power(pair, wavenumber) : 0.0;
}

#include "lines.glsl"

// XYZ of f cos(theta_i) [1/sr], over the wavelengths that are in the band: where the ray crosses lines, or, where there are none, by the
// comb that |(u, v)| needs.
vec3 cosine_weighted_xyz(Pair pair) {
    float largest = pair.factor != 0.0 ? largest_wavenumber(pair) : 0.0;
    if (LINES) {
        return sum_over_lines(pair, largest) * pair.factor;
    }
    vec3 xyz = vec3(0.0);
    ivec2 comb = combs[min(int(pair.uv * (0.5 * float(UV_BINS))), UV_BINS - 1)];
    for (int node = 0; node < comb.y; ++node) {
        vec4 weight_and_wavenumber = texelFetch(nodes, ivec2(node, comb.x), 0);
        float wavenumber = weight_and_wavenumber.w;
        if (wavenumber > largest) {
            break; // wavenumbers grow
        }
        xyz += weight_and_wavenumber.xyz * (wavenumber * wavenumber * power(pair, wavenumber));
    }
    return xyz * pair.factor;
}
