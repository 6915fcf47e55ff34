//! Lights that are far away: points and discs of the sky.

use super::incident::{Incident, WIDER, concentric, spread_of};
use crate::optics::coherence::Coherence;
use crate::optics::geometry::direction;
pub use crate::units::FarLight;
use glam::Vec3;

impl FarLight {
    /// The unit vector to the light's centre, `theta` from the world's up (+z), `phi` from +x toward +y. Its intensity is the irradiance
    /// over π: a white diffuse surface that faces a light of intensity 1 has a radiance of 1.
    pub fn direction(&self) -> Vec3 {
        direction(self.theta, self.phi).as_vec3()
    }

    /// What the sample at `point` (uniform in 0 … 1) of `count` samples gets. Directions are spread evenly over a disc around the light's
    /// centre, by the map of Shirley and Chiu (1997), which keeps neighbours together. Each stands for four times its part of the
    /// variance, and the disc is smaller by as much, so that all samples together have the light's. Few samples look at the centre.
    pub fn incident(&self, point: [f64; 2], count: u32) -> Incident {
        let centre = direction(self.theta, self.phi);
        let share = (WIDER / f64::from(count.max(1))).min(1.0);
        let cap = (1.0 - (0.5 * self.size).to_radians().cos()) * (1.0 - share);
        let (radius, angle) = concentric(point);
        let height = radius * radius * cap; // 1 − cos α
        let sine = (height * (2.0 - height)).max(0.0).sqrt();
        let (across, along) = centre.any_orthonormal_pair();
        let direction = centre * (1.0 - height) + (across * angle.cos() + along * angle.sin()) * sine;
        Incident {
            direction,
            place: None,
            irradiance: Vec3::splat(self.intensity as f32),
            variance: self.variance() * share,
        }
    }

    /// Variance of the disc's directions along each axis across its centre: ⟨sin² α⟩/2 over its solid angle.
    fn variance(&self) -> f64 {
        let cap = 1.0 - (0.5 * self.size).to_radians().cos();
        (cap - cap * cap / 3.0) / 2.0
    }

    /// The light without the extent that `coherence` holds already: light of a coherence length comes from directions that spread by
    /// λ/(√8 π σ), which is the sun's disc for sunlight.
    #[must_use]
    pub fn beyond(self, coherence: &Coherence) -> Self {
        let held = spread_of(coherence);
        let own = self.variance();
        let left = if own > 0.0 { (1.0 - held / own).max(0.0).sqrt() } else { 0.0 };
        Self { size: self.size * left, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::spectrum::MIDDLE;
    use crate::units;
    use glam::DVec3;
    use std::f64::consts::PI;

    #[test]
    fn samples_of_a_disc_cover_its_solid_angle_evenly() {
        let light = units::light("disc:40deg:30,70").unwrap();
        let centre = light.direction().as_dvec3();
        let side = 200;
        let place = |i: usize| (i as f64 + 0.5) / f64::from(side);
        let points = (0..side * side).map(|i| [place((i % side) as usize), place((i / side) as usize)]);
        let directions: Vec<DVec3> = points.map(|p| light.incident(p, 1 << 20).direction).collect();
        let count = directions.len() as f64;
        let cosines: Vec<f64> = directions.iter().map(|d| d.dot(centre)).collect();
        let edge = 20f64.to_radians().cos();
        assert!(cosines.iter().all(|c| *c >= edge - 1e-12));
        assert!(directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-12));
        // The cosine is uniform over a cap.
        assert!((cosines.iter().sum::<f64>() / count - (1.0 + edge) / 2.0).abs() < 1e-4);
        let across = centre.any_orthonormal_vector();
        let variance = directions.iter().map(|d| d.dot(across).powi(2)).sum::<f64>() / count;
        assert!((variance / light.variance() - 1.0).abs() < 1e-3);
        assert!((light.incident([0.1, 0.2], 4).direction - centre).length() < 1e-7);
        // However many samples there are, their spread and what each averages over make up the light's variance.
        for count in [5, 16, 100] {
            let all = (0..side * side)
                .map(|i| light.incident([place((i % side) as usize), place((i / side) as usize)], count));
            let spread = all.map(|i| i.direction.dot(across).powi(2)).sum::<f64>() / f64::from(side * side);
            let sum = spread + light.incident([0.1, 0.2], count).variance;
            assert!((sum / light.variance() - 1.0).abs() < 0.01, "{count}: {sum}");
        }
    }

    #[test]
    fn the_sun_is_no_more_than_what_the_coherence_of_sunlight_holds() {
        let sun = units::light("sun:30,70").unwrap();
        assert_eq!(sun.beyond(&Coherence::SUNLIGHT).size, 0.0);
        assert_eq!(sun.beyond(&Coherence::Repeats([3, 3])), sun);
        let disc = units::light("disc:5deg:30,70").unwrap();
        let left = disc.beyond(&Coherence::SUNLIGHT);
        let held = (MIDDLE / (8f64.sqrt() * PI * 65.0 / 4.0)).powi(2);
        assert!((left.variance() + held - disc.variance()).abs() < 1e-3 * held, "{left:?}");
        assert_eq!(units::light("30,70").unwrap().beyond(&Coherence::SUNLIGHT).size, 0.0);
    }
}
