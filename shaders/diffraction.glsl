// Stam's wave-optics BRDF [Single 2014, B.12] from the layers: the optics that every stage shades with.
// Directions are unit vectors away from the surface in the tangent frame (x = T, y = B, z = N). The f64 twins are
// src/optics/brdf.rs and src/optics/reference.rs.

const float PI = 3.14159265358979;

// A cosine this small is within the rounding of an interpolated f32 direction: the direction counts as below the horizon,
// where nothing is reflected. It also keeps G/w^2 from overflowing.
const float HORIZON = 1e-6;

// What of a pair of directions does not depend on the wavelength.
struct Pair {
    vec2 toward;      // -(u, v) or (u, v), so that toward.x >= 0
    float conjugate;  // -1 where the layers have to be conjugated for that
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
    // w <= 0: with c_n(-z) = conj(c_n(z)), |P(f)| = |sum c_n(|z|) P_n(-f)|. The layers hold f_x >= 0; the other half is
    // P_n(-f) = conj(P_n(f)), because every b_n is real.
    pair.conjugate = -uvw.x < 0.0 ? -1.0 : 1.0;
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

bool in_band(Pair pair, float wavenumber) {
    return all(lessThanEqual(abs(pair.toward * wavenumber), optics.band));
}

// |P|^2 relative to the flat mirror's peak, at a wavenumber 1/lambda [1/um] within the band.
float power(Pair pair, float wavenumber) {
    Read read = read_at(pair.toward * wavenumber);
    float column = 2.0 * PI * wavenumber * pair.w * optics.columns_per_z + optics.first_column;
    // The counts never fall along z: between two columns, rounding up takes the larger. The margin is for hardware whose
    // filter does not return a value that both its neighbours have.
    float needed = textureLod(coefficients, vec3(column, 0.5, optics.pairs), 0.0).x;
    int count = min(int(ceil(needed - 1e-3)), optics.pairs);
    vec2 p = vec2(0.0);
    for (int layer = 0; layer < count; ++layer) {
        // Interpolating all coefficients alike interpolates e^{izh} itself: an error of (dz a)^2/8 and no cancellation.
        vec4 c = textureLod(coefficients, vec3(column, 0.5, layer), 0.0);
        c.yw *= pair.conjugate;
        vec4 s = read_layer(read, layer);
        p += vec2(c.x * s.x - c.y * s.y, c.x * s.y + c.y * s.x);
        p += vec2(c.z * s.z - c.w * s.w, c.z * s.w + c.w * s.z);
    }
    return dot(p, p);
}

// f cos(theta_i) at one wavenumber [1/sr].
float cosine_weighted(Pair pair, float wavenumber) {
    if (pair.factor == 0.0 || !in_band(pair, wavenumber)) {
        return 0.0;
    }
    return pair.factor * wavenumber * wavenumber * power(pair, wavenumber);
}

// XYZ of f cos(theta_i) [1/sr]: the comb that |(u, v)| needs, over the wavelengths that are in the band.
vec3 cosine_weighted_xyz(Pair pair) {
    vec3 xyz = vec3(0.0);
    if (pair.factor == 0.0) {
        return xyz;
    }
    ivec2 comb = combs[min(int(pair.uv * (0.5 * float(UV_BINS))), UV_BINS - 1)];
    for (int node = 0; node < comb.y; ++node) {
        vec4 weight_and_wavenumber = texelFetch(nodes, ivec2(node, comb.x), 0);
        float wavenumber = weight_and_wavenumber.w;
        if (!in_band(pair, wavenumber)) {
            break; // wavenumbers grow
        }
        xyz += weight_and_wavenumber.xyz * (wavenumber * wavenumber * power(pair, wavenumber));
    }
    return xyz * pair.factor;
}
