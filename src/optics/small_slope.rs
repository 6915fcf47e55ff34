//! Small-slope approximation of first order (\[Voronovich 1994\], *Waves in Random Media* 4, 337): Rice's kernel B of
//! the first order in the height (Rice 1951, *Commun. Pure Appl. Math.* 4, 351) in place of Kirchhoff's factor.
//!
//! R G becomes 4 cos θ_i cos θ_r |B|². With q = √(n² − sin² θ), e = n² − 1, c = cos θ and the azimuth φ between the
//! wave vectors in the plane, which is 0 in the mirror direction, the amplitudes from one polarisation (second letter)
//! into another (first letter) are
//!
//! ```text
//! ss  e cos φ / ((c_i + q_i)(c_r + q_r))                            sp  e q_i sin φ / ((c_r + q_r)(n² c_i + q_i))
//! pp  e (q_r q_i cos φ − n² sin θ_r sin θ_i) / ((n² c_r + q_r)(n² c_i + q_i))    ps  e q_r sin φ / ((n² c_r + q_r)(c_i + q_i))
//! ```
//!
//! In the mirror direction |ss|² and |pp|² are Fresnel's reflectances. The twin on the device is `shaders/small_slope.glsl`.

use super::geometry::Pair;
use super::polarisation::Polarisation;
use glam::DVec3;
use rustfft::num_complex::Complex64;

/// Squares of the denominators of the amplitudes at one direction.
struct End {
    // q = √(n² − sin² θ), the root that decays in the material.
    depth: Complex64,
    // 1/|c + q|².
    s: f64,
    // 1/|n² c + q|².
    p: f64,
}

impl End {
    fn new(squared: Complex64, cosine: f64) -> Self {
        let depth = decaying_root(squared - 1.0 + cosine * cosine);
        Self { depth, s: 1.0 / (depth + cosine).norm_sqr(), p: 1.0 / (squared * cosine + depth).norm_sqr() }
    }
}

/// Returns the square root of `z` with an imaginary part of at least 0.
fn decaying_root(z: Complex64) -> Complex64 {
    let length = z.norm_sqr().sqrt();
    // The larger part by a sum of positive numbers, the other one from Im z = 2 Re Im.
    let larger = (0.5 * (length + z.re.abs())).sqrt();
    let other = if larger > 0.0 { 0.5 * z.im / larger } else { 0.0 };
    if z.re < 0.0 {
        Complex64::new(other, larger)
    } else if other < 0.0 {
        Complex64::new(-larger, -other)
    } else {
        Complex64::new(larger, other)
    }
}

/// Returns |B|² of a surface of refractive index `index` = n + ik for light of this polarisation, summed over the
/// polarisations of what leaves. TE and TM are those of the plane of incidence; at normal incidence of the plane
/// through the viewer. Reciprocal for unpolarised light.
pub fn intensity(index: Complex64, pair: &Pair, polarisation: Polarisation) -> f64 {
    Incidence::new(index, pair.light, polarisation).intensity(pair.view)
}

/// Light from one direction on a surface of one refractive index.
pub struct Incidence {
    squared: Complex64,
    light: DVec3,
    end: End,
    polarisation: Polarisation,
}

impl Incidence {
    /// Prepares light of this polarisation from the direction `light` on a surface of refractive index `index` = n + ik.
    pub fn new(index: Complex64, light: DVec3, polarisation: Polarisation) -> Self {
        let squared = index * index;
        Self { squared, light, end: End::new(squared, light.z), polarisation }
    }

    /// Returns 4 cos² θ_i cos θ_r |B|² toward the direction `view`; 0 below the horizon.
    pub fn factor(&self, view: DVec3) -> f64 {
        if self.light.z <= 0.0 || view.z <= 0.0 {
            return 0.0;
        }
        4.0 * self.light.z * self.light.z * view.z * self.intensity(view)
    }

    /// Returns |B|² toward the direction `view`, as [`intensity`].
    pub fn intensity(&self, view: DVec3) -> f64 {
        /// Product of sines below which a direction is the normal: the azimuth is rounding there, and the sum over
        /// polarisations does not depend on it.
        const NORMAL: f64 = 1e-12;
        let (contrast, i, r) = (self.squared - 1.0, &self.end, End::new(self.squared, view.z));
        let (across_i, across_r) = (self.light.truncate(), view.truncate());
        let sines = (across_i.length_squared() * across_r.length_squared()).sqrt();
        // The wave vectors in the plane are −ω_i and ω_r.
        let cos = if sines > NORMAL { (-across_i.dot(across_r) / sines).clamp(-1.0, 1.0) } else { 1.0 };
        let sin2 = 1.0 - cos * cos;
        let difference = r.depth * i.depth * cos - self.squared * sines;
        let te = i.s * (r.s * cos * cos + r.depth.norm_sqr() * r.p * sin2);
        let tm = i.p * (i.depth.norm_sqr() * r.s * sin2 + r.p * difference.norm_sqr());
        contrast.norm_sqr() * self.polarisation.share([te, tm])
    }
}

/// Returns the mean of |B|² over the pairs of directions that have this (u, v, w), by the length |(u, v)| and |w|. The
/// pairs lie on a cone about their half vector; each counts by cos θ_i cos θ_r. A colour table holds the ratio of this
/// mean to that of one index: R at the half vector in its place errs by ten times as much on metals.
pub fn mean_intensity(index: Complex64, uv: f64, w: f64, polarisation: Polarisation) -> f64 {
    /// Positions on the cone, symmetric about the pair of equal polar angles.
    const POSITIONS: usize = 8;
    /// Smallest cosine between half vector and horizon, and smallest half opening: the pair is that of a grazing
    /// mirror, or of one direction.
    const LEAST: f64 = 1e-9;
    let length = uv.hypot(w).clamp(LEAST, 2.0);
    // Half vector (x, 0, z), and the cosine and sine between it and either direction.
    let (x, z) = (uv / uv.hypot(w).max(LEAST), (w / uv.hypot(w).max(LEAST)).max(LEAST));
    let cosine = 0.5 * length;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    // Directions are h cos α ± (t cos ψ + s sin ψ) sin α, with t along y and s = (−z, 0, x): both are above the
    // horizon while |sin ψ| x sin α < z cos α.
    let largest = (z * cosine / (x * sine).max(LEAST)).min(1.0).asin();
    let (mut sum, mut weights) = (0.0, 0.0);
    for position in 0..POSITIONS {
        let psi = largest * ((position as f64 + 0.5) * 2.0 / POSITIONS as f64 - 1.0);
        let half = DVec3::new(x, 0.0, z) * cosine;
        let aside = DVec3::new(-z * psi.sin(), psi.cos(), x * psi.sin()) * sine;
        let pair = Pair::new(half + aside, half - aside);
        let weight = (pair.light.z * pair.view.z).max(LEAST);
        sum += weight * intensity(index, &pair, polarisation);
        weights += weight;
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::geometry::direction;
    use crate::optics::material::Material;
    use crate::random::Random;

    fn indices() -> Vec<Complex64> {
        let gold = Material::from_name_or_file("gold").unwrap();
        vec![
            1.5.into(),
            1.05.into(),
            4.0.into(),
            gold.index(0.45),
            gold.index(0.65),
            Complex64::new(0.05, 3.6),
        ]
    }

    fn pairs(count: usize) -> Vec<Pair> {
        let mut random = Random::new(5);
        let mut any = || direction(89.9 * random.share(), 360.0 * random.share());
        (0..count).map(|_| Pair::new(any(), any())).collect()
    }

    #[test]
    fn squares_of_roots_are_the_numbers_and_roots_decay() {
        let mut random = Random::new(3);
        let mut numbers: Vec<_> =
            (0..1000).map(|_| Complex64::new(9.0 * random.signed(), 9.0 * random.signed())).collect();
        numbers.extend([2.0, -2.0, 0.0, -1e-20].map(Complex64::from));
        numbers.extend([Complex64::new(0.0, 3.0), Complex64::new(0.0, -3.0), Complex64::new(-4.0, 1e-18)]);
        for z in numbers {
            let root = decaying_root(z);
            assert!((root * root - z).norm() <= 1e-15 * z.norm(), "{z}: {root}");
            assert!(root.im >= 0.0, "{z}: {root}");
        }
    }

    #[test]
    fn the_mirror_direction_has_fresnel_s_reflectances() {
        for index in indices() {
            for (theta, phi) in [(0.0, 0.0), (20.0, 130.0), (56.0, 10.0), (75.0, 300.0), (89.0, 45.0)] {
                let pair = Pair::new(direction(theta, phi), direction(theta, phi + 180.0));
                let c = pair.light.z;
                let inside = (index * index - 1.0 + c * c).sqrt();
                let te = ((inside - c) / (inside + c)).norm_sqr();
                let tm = ((index * index * c - inside) / (index * index * c + inside)).norm_sqr();
                for (polarisation, expected) in
                    [(Polarisation::Te, te), (Polarisation::Tm, tm), (Polarisation::None, 0.5 * (te + tm))]
                {
                    let found = intensity(index, &pair, polarisation);
                    assert!(
                        (found - expected).abs() < 1e-12,
                        "{index} {theta} {polarisation:?}: {found} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn exchanging_light_and_viewer_changes_nothing_and_polarisations_add_up() {
        for index in indices() {
            for pair in pairs(200) {
                let back = Pair::new(pair.view, pair.light);
                let [none, te, tm] = [Polarisation::None, Polarisation::Te, Polarisation::Tm]
                    .map(|polarisation| intensity(index, &pair, polarisation));
                let reversed = intensity(index, &back, Polarisation::None);
                assert!((none / reversed - 1.0).abs() < 1e-12, "{index} {pair:?}: {none} {reversed}");
                assert!((0.5 * (te + tm) / none - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn unpolarised_light_near_the_normal_has_no_azimuth() {
        for index in indices() {
            let view = direction(50.0, 20.0);
            let at = |theta: f64, phi: f64| {
                intensity(index, &Pair::new(direction(theta, phi), view), Polarisation::None)
            };
            let exact = at(0.0, 0.0);
            for phi in [0.0, 70.0, 200.0] {
                assert!((at(1e-5, phi) / exact - 1.0).abs() < 1e-5, "{index} {phi}");
            }
        }
    }

    #[test]
    fn amplitudes_are_those_of_the_first_order_in_the_height() {
        // A sinusoid of vanishing height on a perfect conductor in TE light sends (k a)² c_i c_r into each first order
        // (Rayleigh 1907): here 4 c_i c_r |B|² |c_1|²/w² with |c_1|² = (k w a/2)².
        let perfect = Complex64::new(0.0, 1e6);
        for (theta, view) in [(30.0, 10.0), (0.0, 60.0), (70.0, 20.0)] {
            let pair = Pair::new(direction(theta, 180.0), direction(view, 0.0));
            assert!((intensity(perfect, &pair, Polarisation::Te) - 1.0).abs() < 1e-5);
            // TM: ((1 − sin θ_i sin θ_r)/(c_i c_r))² instead.
            let (c_i, c_r) = (pair.light.z, pair.view.z);
            let (s_i, s_r) = (theta.to_radians().sin(), view.to_radians().sin());
            let expected = ((1.0 - s_i * s_r) / (c_i * c_r)).powi(2);
            let found = intensity(perfect, &pair, Polarisation::Tm);
            assert!((found / expected - 1.0).abs() < 1e-4, "{theta} {view}: {found} {expected}");
        }
    }

    #[test]
    fn the_mean_over_pairs_is_the_reflectance_in_the_mirror_direction_and_near_every_pair_otherwise() {
        for index in indices() {
            for w in [0.1, 0.7, 1.3, 1.99] {
                let theta = (0.5f64 * w).acos().to_degrees();
                let mirror = Pair::new(direction(theta, 0.0), direction(theta, 180.0));
                let exact = intensity(index, &mirror, Polarisation::None);
                let mean = mean_intensity(index, 0.0, w, Polarisation::None);
                assert!((mean / exact - 1.0).abs() < 1e-9, "{index} {w}: {mean} {exact}");
            }
        }
        // Ratios of two wavelengths of gold, over pairs that share (u, v, w).
        let [blue, green] = [indices()[3], Material::from_name_or_file("gold").unwrap().index(0.55)];
        let (mut squares, mut all) = (0.0, 0.0);
        for pair in pairs(2000) {
            let uvw = pair.uvw();
            let (uv, w) = (uvw.truncate().length(), uvw.z.abs());
            let [of_blue, of_green] = [blue, green].map(|n| mean_intensity(n, uv, w, Polarisation::None));
            let [exact, factor] = [blue, green].map(|n| intensity(n, &pair, Polarisation::None));
            let weight = (pair.light.z * pair.view.z).powi(2);
            squares += weight * (factor * of_blue / of_green - exact).powi(2);
            all += weight * exact * exact;
        }
        let error = (squares / all).sqrt();
        eprintln!("gold at 450 nm by 550 nm: {error:.4}");
        assert!(error < 0.05, "{error}");
    }
}
