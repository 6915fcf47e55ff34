// Pair of directions that sources are evaluated for, and the factor of the BRDF around the power |P|^2 [Single 2014, B.12].
// Directions are unit vectors away from the surface in the tangent frame (x = T, y = B, z = N).
// The f64 twins are src/optics/geometry.rs and src/optics/reflectance.rs. The includer defines
//   int FACTOR_LAW                             law of the factor, one of those below
//   bool LIMITED                               true if the surface reflects no more than a flat one
//   float dielectric(float index, float cosine)  R, or 1 if sums over wavelengths contain it
//   vec2 energy_at(vec3 direction)             directional albedo over the reflectance of a flat surface; root of the factor of a pigment

const float PI = 3.14159265358979;

// Laws of the factor. Stam's theory: R G cos(theta_i).
const int SPECTRAL = 0;             // the factor contains no R; sums over wavelengths do
const int FRESNEL = 1;              // Fresnel's equations for a refractive index without dispersion
const int SCHLICK = 2;              // Schlick's approximation of them, as in the thesis
// Small-slope approximation: 4 cos(theta_i)^2 cos(theta_r) |B|^2.
const int SMALL_SLOPE = 3;          // of a refractive index without dispersion and absorption
const int SMALL_SLOPE_INDICES = 4;  // of an index n + ik for each of X, Y and Z; sums over wavelengths contain the ratio to it
const int SMALL_SLOPE_SPECTRAL = 5; // sums over wavelengths contain |B|^2

// Smallest cosine above the horizon: smaller ones are within the rounding of an interpolated f32 direction. Below the
// horizon nothing is reflected. The bound also keeps G/w^2 from overflowing.
const float HORIZON = 1e-6;

struct Pair {
    vec2 toward;      // -(u, v)
    float w;          // |w|
    float uv;         // |(u, v)|
    vec3 factor;      // of X, Y and Z: 4 pi F / w^2 [1/sr], with F the law's factor; 0 below the horizon
    float cos_half;   // between either direction and the half vector
    float reflectance; // R at the half vector
    Slants slants;
    float limit;      // divisor by the limit of energy, which the factor contains
    float pigment;    // factor of a pigment below the surface, if LIMITED
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

// Returns |B|^2 for X, Y and Z, or 1 if sums over wavelengths contain it.
vec3 kernel(Medium medium, Slants slants) {
    if (FACTOR_LAW == SMALL_SLOPE) {
        return vec3(small_slope_of_dielectric(medium.n.y, slants));
    }
    if (FACTOR_LAW == SMALL_SLOPE_INDICES) {
        return vec3(small_slope(medium.n.x, medium.k.x, slants), small_slope(medium.n.y, medium.k.y, slants), small_slope(medium.n.z, medium.k.z, slants));
    }
    return vec3(1.0);
}

Pair pair_of(vec3 light, vec3 view, Medium medium) {
    Pair pair;
    vec3 uvw = -light - view;
    pair.toward = -uvw.xy;
    pair.w = -uvw.z;
    pair.uv = length(uvw.xy);
    // 1 + light . view = |(u,v,w)|^2 / 2, which does not cancel near opposite grazing directions.
    float one_plus_dot = 0.5 * dot(uvw, uvw);
    pair.cos_half = min(0.5 * length(uvw), 1.0);
    pair.reflectance = dielectric(medium.n.y, pair.cos_half);
    pair.slants = slants_of(light, view);
    vec3 factor = FACTOR_LAW <= SCHLICK
        ? vec3(4.0 * PI * pair.reflectance * one_plus_dot * one_plus_dot / (view.z * pair.w * pair.w))
        : kernel(medium, pair.slants) * (16.0 * PI * light.z * light.z * view.z / (pair.w * pair.w));
    pair.limit = 1.0;
    pair.pigment = 1.0;
    if (LIMITED) {
        vec2 energy_of_light = energy_at(light);
        vec2 energy_of_view = energy_at(view);
        pair.limit = max(1.0, max(energy_of_light.x, energy_of_view.x));
        factor /= pair.limit;
        pair.pigment = energy_of_light.y * energy_of_view.y;
    }
    pair.factor = above_horizon(light, view) ? factor : vec3(0.0);
    return pair;
}
