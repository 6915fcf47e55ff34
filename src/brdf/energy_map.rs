//! Map of the limit of energy for one light: what colour tables and shaders read.

use super::albedo::DirectionalAlbedo;
use crate::optics::colour_excess::{ColourWeights, largest_ratio};
use crate::optics::energy::{DirectionGrid, EnergyLimit};
use crate::optics::geometry::Pair;
use crate::optics::spectrum::Illuminant;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Limit of energy over the directions of a [`DirectionGrid`] for the colours of one light.
///
/// A colour has one divisor: the largest ratio of the albedo to the reflectance of a flat surface among X, Y, Z and
/// those of linear red, green and blue that the flat surface reflects. So hues stay, and none of them exceeds that of a
/// flat surface.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyMap {
    /// For each point, E/R, and the share of the light that passes the surface on its way to a pigment and is not sent
    /// back, √-normalised as in [`Self::pigment`].
    points: Vec<[f32; 2]>,
    /// Errors of the map.
    header: EnergyMapHeader,
}

/// Numbers of an [`EnergyMap`] beside its points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnergyMapHeader {
    /// Largest E/R of a direction up to 85°.
    pub largest: f64,
    /// RMS relative error of the divisor at a few directions, by interpolation; 0 if not measured.
    pub error: f64,
}

impl EnergyMap {
    /// Makes the map of `albedo` under `illuminant`; its error is not measured.
    pub fn new(albedo: &DirectionalAlbedo, illuminant: &Illuminant) -> Self {
        let (table, weights) = (albedo.table(), ColourWeights::new(illuminant));
        let white = weights.white();
        let colours: Vec<[DVec3; 2]> = (0..DirectionGrid::COUNT)
            .map(|point| weights.colours(|layer| table.of_layer(layer, point)))
            .collect();
        let ratios: Vec<f64> = colours.iter().map(|[sent, allowed]| largest_ratio(*sent, *allowed)).collect();
        let albedos = colours
            .iter()
            .zip(&ratios)
            .map(|([sent, _], ratio)| (largest_ratio(*sent, white) / ratio.max(1.0)).clamp(0.0, 1.0));
        let transmitted: Vec<f64> = albedos.map(|albedo| 1.0 - albedo).collect();
        let scale = mean_over_cosines(&transmitted).max(f64::MIN_POSITIVE).sqrt().recip();
        let points = ratios.iter().zip(&transmitted).map(|(r, t)| [*r as f32, (t * scale) as f32]).collect();
        let largest = largest_below_85_degrees(|point| ratios[point]);
        Self { points, header: EnergyMapHeader { largest, error: 0.0 } }
    }

    /// Returns the map of `albedo` under `illuminant` with its error: the divisor at a few directions against that from
    /// the orders.
    pub fn measured(albedo: &DirectionalAlbedo, illuminant: &Illuminant) -> Self {
        /// Number of directions.
        const DIRECTIONS: usize = 48;
        /// Turn between two directions, 2π over the square of the golden ratio.
        const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
        let mut map = Self::new(albedo, illuminant);
        let mut squares = 0.0;
        for number in 0..DIRECTIONS {
            // A spiral, spread evenly over the hemisphere.
            let z = (number as f64 + 0.5) / DIRECTIONS as f64;
            let (sin, cos) = (GOLDEN_ANGLE * number as f64).sin_cos();
            let across = (1.0 - z * z).sqrt();
            let direction = DVec3::new(across * cos, across * sin, z);
            let exact = albedo.colour(&Pair::new(direction, direction), illuminant);
            squares += (map.excess(direction).max(1.0) / exact - 1.0).powi(2);
        }
        map.header.error = (squares / DIRECTIONS as f64).sqrt();
        map
    }

    /// Returns E/R of colours for a direction above the horizon.
    pub fn excess(&self, direction: DVec3) -> f64 {
        excess(&self.points, direction)
    }

    /// Returns the divisor of the BRDF.
    pub fn limit(&self, pair: &Pair) -> f64 {
        Self::limit_of(&self.points, pair)
    }

    /// Returns the divisor of the BRDF for the points of a map.
    pub fn limit_of(points: &[[f32; 2]], pair: &Pair) -> f64 {
        excess(points, pair.light).max(excess(points, pair.view)).max(1.0)
    }

    /// Returns the factor of a pigment below the surface: (1 − E(ω_i))(1 − E(ω_r))/(1 − Ē), the light that is not
    /// reflected on the way in, nor on the way out, normalised by the mean of 1 − E over directions, so that a white
    /// pigment and the surface together reflect at most all light (\[Kelemen and Szirmay-Kalos 2001\], *A microfacet
    /// based coupled specular-matte BRDF model*, Eurographics short papers).
    pub fn pigment(&self, pair: &Pair) -> f64 {
        let passed =
            |direction| DirectionGrid::interpolate(direction, |point| f64::from(self.points[point][1]));
        passed(pair.light) * passed(pair.view)
    }

    /// Returns the points of the grid, row by row: E/R and the root of the factor of a pigment.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points
    }

    /// Returns by how much the theory was limited, in words; `None` up to 2 %.
    pub fn note(&self) -> Option<String> {
        excess_note(self.header.largest)
    }

    /// Returns the largest ratio and the error.
    pub fn header(&self) -> EnergyMapHeader {
        self.header
    }

    /// Returns the map of an export, whose errors are not known here; `None` if the points are not valid.
    pub fn of_points(points: &[[f32; 2]]) -> Option<Self> {
        if !Self::are_sound(points) {
            return None;
        }
        let largest = largest_below_85_degrees(|point| f64::from(points[point][0]));
        Self::from_parts(EnergyMapHeader { largest, error: 0.0 }, points.to_vec())
    }

    /// Returns the map of `points` from an untrusted source; `None` if they are not valid.
    pub fn from_parts(header: EnergyMapHeader, points: Vec<[f32; 2]>) -> Option<Self> {
        let is_sound = Self::are_sound(&points) && header.largest.is_finite() && header.error.is_finite();
        is_sound.then_some(Self { points, header })
    }

    /// Returns true if `points` can be those of a map.
    pub fn are_sound(points: &[[f32; 2]]) -> bool {
        points.len() == DirectionGrid::COUNT && points.iter().flatten().all(|x| x.is_finite() && *x >= 0.0)
    }
}

/// Returns by how much a theory was limited whose largest albedo is so many times that of a flat surface, in words;
/// `None` up to 2 %.
pub fn excess_note(largest: f64) -> Option<String> {
    /// Ratio up to which nothing is said.
    const SAID: f64 = 1.02;
    (largest > SAID).then(|| {
        format!(
            "the theory would send up to {:.0} % more light than a flat surface reflects, and is limited to that",
            100.0 * (largest - 1.0)
        )
    })
}

/// Returns the largest ratio of the directions up to 85° from the normal; nearer to the horizon the ratio changes fast
/// and there is little light.
fn largest_below_85_degrees(ratio: impl Fn(usize) -> f64) -> f64 {
    let least = 85f64.to_radians().cos();
    let seen = (0..DirectionGrid::COUNT).filter(|point| DirectionGrid::direction(*point).z > least);
    seen.map(ratio).fold(0.0, f64::max)
}

/// Interpolates E/R between the points of a map.
fn excess(points: &[[f32; 2]], direction: DVec3) -> f64 {
    DirectionGrid::interpolate(direction, |point| f64::from(points[point][0]))
}

/// Returns ∫ value cos θ dω/π over the directions of the grid.
fn mean_over_cosines(values: &[f64]) -> f64 {
    let weighed = values
        .iter()
        .enumerate()
        .map(|(point, value)| (value * DirectionGrid::weight(point), DirectionGrid::weight(point)));
    let (sum, weights) = weighed.fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    sum / weights
}
