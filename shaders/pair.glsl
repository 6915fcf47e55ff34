// What every source of diffracted light is evaluated for: a pair of directions, and the part of the BRDF that does not depend on the
// wavelength [Single 2014, B.12]. Directions are unit vectors away from the surface in the tangent frame (x = T, y = B, z = N).
// The f64 twins are src/optics/geometry.rs and src/optics/brdf.rs. The includer has `dielectric(index, cosine)`, the part of R that the factor of a pair holds.

const float PI = 3.14159265358979;

// A cosine this small is within the rounding of an interpolated f32 direction: the direction counts as below the horizon,
// where nothing is reflected. It also keeps G/w^2 from overflowing.
const float HORIZON = 1e-6;

struct Pair {
    vec2 toward;      // -(u, v)
    float w;          // |w|
    float uv;         // |(u, v)|
    float factor;     // 4 pi R G cos(theta_i) / w^2 [1/sr]; 0 below the horizon
    float cos_half;   // between either direction and the half vector
    float reflectance;
};

// How (u, v) changes over a pixel: a Gaussian in the pixel becomes the Gaussian in (u, v) of covariance J J^T, J = [dx dy], times its variance.
// Zero for a point.
struct Footprint {
    vec2 dx; // of (u, v), from a pixel to the one on its right
    vec2 dy; // to the one below
};

const Footprint POINT = Footprint(vec2(0.0), vec2(0.0));

// Returns true if light arrives at the side that is seen, and leaves it.
bool above_horizon(vec3 light, vec3 view) {
    return light.z > HORIZON && view.z > HORIZON;
}

Pair pair_of(vec3 light, vec3 view, float index) {
    Pair pair;
    vec3 uvw = -light - view;
    pair.toward = -uvw.xy;
    pair.w = -uvw.z;
    pair.uv = length(uvw.xy);
    // 1 + light . view = |(u,v,w)|^2 / 2, which does not cancel near opposite grazing directions.
    float one_plus_dot = 0.5 * dot(uvw, uvw);
    pair.cos_half = min(0.5 * length(uvw), 1.0);
    pair.reflectance = dielectric(index, pair.cos_half);
    pair.factor = above_horizon(light, view) ? 4.0 * PI * pair.reflectance * one_plus_dot * one_plus_dot / (view.z * pair.w * pair.w) : 0.0;
    return pair;
}
