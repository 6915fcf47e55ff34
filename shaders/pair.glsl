// Pair of directions that sources are evaluated for, and the factor of the BRDF that does not depend on the wavelength
// [Single 2014, B.12]. Directions are unit vectors away from the surface in the tangent frame (x = T, y = B, z = N).
// The f64 twins are src/optics/geometry.rs and src/optics/brdf.rs. The includer defines `dielectric(index, cosine)`, the
// part of R in the factor of a pair.

const float PI = 3.14159265358979;

// Smallest cosine above the horizon: smaller ones are within the rounding of an interpolated f32 direction. Below the
// horizon nothing is reflected. The bound also keeps G/w^2 from overflowing.
const float HORIZON = 1e-6;

struct Pair {
    vec2 toward;      // -(u, v)
    float w;          // |w|
    float uv;         // |(u, v)|
    float factor;     // 4 pi R G cos(theta_i) / w^2 [1/sr]; 0 below the horizon
    float cos_half;   // between either direction and the half vector
    float reflectance;
};

// Jacobian of (u, v) over a pixel, J = [dx dy]: a Gaussian over the pixel becomes a Gaussian in (u, v) of covariance J
// J^T times its variance. Zero for a point.
struct Footprint {
    vec2 dx; // change of (u, v) to the pixel on the right
    vec2 dy; // to the pixel below
};

const Footprint POINT = Footprint(vec2(0.0), vec2(0.0));

// Returns true if light and viewer are both above the horizon.
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
