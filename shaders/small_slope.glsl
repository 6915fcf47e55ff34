// Small-slope approximation of first order [Voronovich 1994]: Rice's kernel B, whose square stands in the factor of a
// pair. The f64 twin is src/optics/small_slope.rs, which has the formulas.
//
// The includer defines POLARISATION: 0 for unpolarised light, 1 for TE, 2 for TM.

// Refractive indices n + ik that stand for X, Y and Z.
struct Medium {
    vec3 n;
    vec3 k;
};

// Directions as the kernel takes them.
struct Slants {
    float light;       // cos(theta_i)
    float view;        // cos(theta_r)
    float sines;       // sin(theta_i) sin(theta_r)
    float cos_azimuth; // between the wave vectors in the plane; 1 in the mirror direction
};

Slants slants_of(vec3 light, vec3 view) {
    float sines = length(light.xy) * length(view.xy);
    // At the normal the azimuth is rounding, and the sum over polarisations does not depend on it.
    float cosine = sines > 1e-6 ? clamp(-dot(light.xy, view.xy) / sines, -1.0, 1.0) : 1.0;
    return Slants(light.z, view.z, sines, cosine);
}

// Returns the sum over polarisations of |ss|^2, |sp|^2, |pp|^2 and |ps|^2, those of the light that comes in.
float sum_of_polarisations(vec4 powers) {
    float te = powers.x + powers.w;
    float tm = powers.y + powers.z;
    return POLARISATION == 1 ? te : POLARISATION == 2 ? tm : 0.5 * (te + tm);
}

// Returns |B|^2 for a refractive index without absorption.
float small_slope_of_dielectric(float n, Slants slants) {
    float squared = n * n;
    float contrast = (n - 1.0) * (n + 1.0);
    float q_light = sqrt(contrast + slants.light * slants.light);
    float q_view = sqrt(contrast + slants.view * slants.view);
    float s_light = contrast / (slants.light + q_light);
    float p_light = contrast / (squared * slants.light + q_light);
    float s_view = 1.0 / (slants.view + q_view);
    float p_view = 1.0 / (squared * slants.view + q_view);
    float cosine = slants.cos_azimuth;
    float sine2 = 1.0 - cosine * cosine;
    float ss = s_light * s_view;
    float sp = p_light * q_light * s_view;
    float pp = p_light * p_view * (q_light * q_view * cosine - squared * slants.sines);
    float ps = s_light * p_view * q_view;
    return sum_of_polarisations(vec4(ss * ss * cosine * cosine, sp * sp * sine2, pp * pp, ps * ps * sine2));
}

vec2 product(vec2 a, vec2 b) {
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// Returns the root in the upper half plane of a number there. The larger part is the root of a sum without cancellation.
vec2 upper_root(vec2 z) {
    float larger = sqrt(0.5 * (length(z) + abs(z.x)));
    float smaller = 0.5 * z.y / max(larger, 1e-12);
    return z.x >= 0.0 ? vec2(larger, smaller) : vec2(smaller, larger);
}

// Returns |B|^2 for a refractive index n + ik.
float small_slope(float n, float k, Slants slants) {
    vec2 squared = vec2((n - k) * (n + k), 2.0 * n * k);
    vec2 contrast = squared - vec2(1.0, 0.0);
    vec2 q_light = upper_root(contrast + vec2(slants.light * slants.light, 0.0));
    vec2 q_view = upper_root(contrast + vec2(slants.view * slants.view, 0.0));
    vec2 s_light = q_light + vec2(slants.light, 0.0);
    vec2 s_view = q_view + vec2(slants.view, 0.0);
    vec2 p_light = squared * slants.light + q_light;
    vec2 p_view = squared * slants.view + q_view;
    float cosine = slants.cos_azimuth;
    float sine2 = 1.0 - cosine * cosine;
    vec2 difference = product(q_light, q_view) * cosine - squared * slants.sines;
    float from_s = dot(contrast, contrast) / dot(s_light, s_light);
    float from_p = dot(contrast, contrast) / dot(p_light, p_light);
    float to_s = 1.0 / dot(s_view, s_view);
    float to_p = 1.0 / dot(p_view, p_view);
    return sum_of_polarisations(vec4(from_s * to_s * cosine * cosine, from_p * to_s * dot(q_light, q_light) * sine2,
                                     from_p * to_p * dot(difference, difference), from_s * to_p * dot(q_view, q_view) * sine2));
}
