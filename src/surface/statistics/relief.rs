//! The kind of profile that a field has, with the two lengths on which errors of scalar theory depend.

use super::height_spectrum::{SurfaceSpectrum, analysed_part};
use super::periods::{amplitude, refined};
use crate::error::Result;
use crate::surface::HeightField;
use crate::surface::si::metres;
use crate::surface::tiling::{Verdict, tiles};
use serde::Serialize;
use std::f64::consts::{SQRT_2, TAU};

/// Profile of grooves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProfileKind {
    /// One frequency.
    Sinusoid,
    /// Sawtooth.
    Blaze,
    /// Ridges with flat tops and flat grooves.
    Lamellar,
    /// Several frequencies without a fixed phase.
    Rough,
}

impl ProfileKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Sinusoid, Self::Blaze, Self::Lamellar, Self::Rough];

    /// Returns the name in tables and lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sinusoid => "sinusoid",
            Self::Blaze => "blaze",
            Self::Lamellar => "lamellar",
            Self::Rough => "rough",
        }
    }
}

/// Grooves in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProfileShape {
    /// The profile across them.
    pub profile: ProfileKind,
    /// Period \[µm\]; of a rough profile the mean of 1/f weighted by the power of the slope, Σ P f / Σ P f².
    #[serde(rename = "period_m", serialize_with = "metres")]
    pub period: f64,
    /// Height range \[µm\]; of a rough profile that of the sinusoid with the same period and RMS slope.
    #[serde(rename = "height_m", serialize_with = "metres")]
    pub height: f64,
    /// RMS slope along the grooves, which the table of errors leaves out.
    pub slope_along: f64,
}

/// Shape of a field in the terms of scalar theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// A mirror.
    Flat,
    /// Grooves in one direction.
    Grooves(ProfileShape),
    /// Slopes in two directions: the larger and the smaller RMS slope of the principal axes.
    Crossed([f64; 2]),
    /// More than half of the variance has fewer than three periods over the field, whose copies do not join.
    FewPeriods,
}

/// Smaller over larger RMS slope above which a field has no grooves: at 1/√3 a quarter of the slope variance lies along them.
const CROSSED: f64 = 0.577;
/// Fewer periods over a field whose copies do not join are not resolved.
const FEWEST_CYCLES: f64 = 3.0;
/// RMS height over the height range, below which a field is flat but for rounding.
const ROUNDING: f64 = 1e-12;
/// Least share of the variance in the strongest frequency of a sinusoid; 1 of an ideal one, 8/π² of a lamellar profile, 6/π² of a blaze.
const SINUSOID_SHARE: f64 = 0.9;
/// Least share in the strongest frequency of a periodic profile.
const PERIODIC_SHARE: f64 = 0.5;
/// Least share of the samples in the outer tenths of the height range for a lamellar profile; 0.2 of a blaze, 0.4 of a sinusoid.
const LAMELLAR_ENDS: f64 = 0.7;

/// Sums over a spectrum.
#[derive(Clone, Copy, Default)]
struct SpectralMoments {
    /// Σ P: the variance \[µm²\].
    variance: f64,
    /// Σ P over frequencies of less than [`FEWEST_CYCLES`] \[µm²\].
    few: f64,
    /// Σ P f \[µm\].
    first: f64,
    /// Σ P f².
    second: f64,
    /// The largest P of one frequency, and its place.
    strongest: (f64, [usize; 2]),
}

impl SpectralMoments {
    fn new(spectrum: &SurfaceSpectrum) -> Self {
        let part = |sums: &mut Self, i: usize, j: usize, weight: f64| {
            let [x, y] = spectrum.frequency(i, j);
            let power = spectrum.power(i, j);
            let weighted = weight * power;
            sums.variance += weighted;
            if (x * spectrum.patch[0]).hypot(y * spectrum.patch[1]) < FEWEST_CYCLES {
                sums.few += weighted;
            }
            sums.first += weighted * x.hypot(y);
            sums.second += weighted * (x * x + y * y);
            if power > sums.strongest.0 {
                sums.strongest = (power, [i, j]);
            }
        };
        let add = |a: Self, b: Self| Self {
            variance: a.variance + b.variance,
            few: a.few + b.few,
            first: a.first + b.first,
            second: a.second + b.second,
            strongest: if a.strongest.0 >= b.strongest.0 { a.strongest } else { b.strongest },
        };
        spectrum.sum(Self::default, part, add)
    }
}

/// Returns the RMS slopes along the principal axes, the larger first, from differences of neighbouring samples.
fn principal_slopes(field: &HeightField) -> [f64; 2] {
    let [dx, dy] = field.pixel_size();
    let (mut sums, mut count) = ([0.0; 3], 0_usize);
    for r in 1..field.rows() {
        let (above, here) = (field.row(r - 1), field.row(r));
        for c in 1..field.columns() {
            let [x, y] = [(here[c] - here[c - 1]) / dx, (above[c] - here[c]) / dy];
            sums = [sums[0] + x * x, sums[1] + y * y, sums[2] + x * y];
        }
        count += field.columns() - 1;
    }
    let [x, y, xy] = sums.map(|sum| sum / count.max(1) as f64);
    let (mean, half) = ((x + y) / 2.0, ((x - y) / 2.0).hypot(xy));
    [mean + half, (mean - half).max(0.0)].map(f64::sqrt)
}

impl Relief {
    /// Measures `field`.
    ///
    /// # Errors
    /// Too little memory for the spectrum.
    pub fn of(field: &HeightField) -> Result<Self> {
        let part = analysed_part(field);
        let (low, high) = part.range();
        // Copies that join are one period, in which each frequency is resolved.
        let joins = tiles(&part).verdict == Verdict::Tiles;
        let spectrum =
            if joins { SurfaceSpectrum::of_one_period(&part)? } else { SurfaceSpectrum::windowed(&part)? };
        let moments = SpectralMoments::new(&spectrum);
        if moments.variance.sqrt() <= ROUNDING * low.abs().max(high.abs()) {
            return Ok(Self::Flat);
        }
        let slopes = principal_slopes(&part);
        if slopes[1] > CROSSED * slopes[0] {
            return Ok(Self::Crossed(slopes));
        }
        if !joins && moments.few > 0.5 * moments.variance {
            return Ok(Self::FewPeriods);
        }
        Ok(Self::Grooves(grooves(&part, &spectrum, &moments, joins)))
    }
}

/// Returns the grooves of a field with this spectrum, of one period or windowed.
fn grooves(
    field: &HeightField,
    spectrum: &SurfaceSpectrum,
    moments: &SpectralMoments,
    is_period: bool,
) -> ProfileShape {
    let (power, place) = moments.strongest;
    let ([x, y], share) = if is_period {
        (spectrum.frequency(place[0], place[1]), 2.0 * power / moments.variance)
    } else {
        (refined(spectrum, place), amplitude(spectrum, place).powi(2) / 2.0 / moments.variance)
    };
    // Below three periods the lobes of both signs overlap, and the share is that of both.
    let is_resolved = is_period || (x * spectrum.patch[0]).hypot(y * spectrum.patch[1]) >= FEWEST_CYCLES;
    let sq = moments.variance.sqrt();
    let [across, slope_along] = principal_slopes(field);
    let periodic = |profile, height_over_sq: f64| ProfileShape {
        profile,
        period: 1.0 / x.hypot(y),
        height: height_over_sq * sq,
        slope_along,
    };
    if share < PERIODIC_SHARE || !is_resolved {
        let period = moments.first / moments.second;
        let height = 2.0 * SQRT_2 * across.hypot(slope_along) * period / TAU;
        return ProfileShape { profile: ProfileKind::Rough, period, height, slope_along };
    }
    if share_of_ends(field) >= LAMELLAR_ENDS {
        periodic(ProfileKind::Lamellar, 2.0)
    } else if share >= SINUSOID_SHARE {
        periodic(ProfileKind::Sinusoid, 2.0 * SQRT_2)
    } else {
        periodic(ProfileKind::Blaze, 12_f64.sqrt())
    }
}

/// Returns the share of the samples in the lowest and in the highest tenth of the height range.
fn share_of_ends(field: &HeightField) -> f64 {
    let (low, high) = field.range();
    let tenth = (high - low) / 10.0;
    let ends = field.heights().iter().filter(|h| **h <= low + tenth || **h >= high - tenth).count();
    ends as f64 / field.heights().len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::statistics::tests::field;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    /// Asserts grooves of this kind, period and height \[µm\].
    fn assert_grooves(field: &HeightField, profile: ProfileKind, period: f64, height: f64) {
        let Relief::Grooves(found) = Relief::of(field).unwrap() else {
            panic!("{:?}", Relief::of(field).unwrap())
        };
        assert_eq!(found.profile, profile, "{found:?}");
        assert!((found.period / period - 1.0).abs() < 0.02, "{period} um: {found:?}");
        assert!((found.height / height - 1.0).abs() < 0.06, "{height} um: {found:?}");
    }

    fn sinusoid(periods: f64) -> HeightField {
        field(200, 20, |x, _| 0.15 * (TAU * x * periods / 20.0).sin())
    }

    fn sawtooth(periods: f64) -> HeightField {
        field(200, 20, |x, _| 0.3 * (x * periods / 20.0 + 0.25).fract())
    }

    #[test]
    fn profiles_have_their_kind_period_and_height() {
        // 8.3: copies that do not join.
        for periods in [8.0, 8.3] {
            assert_grooves(&sinusoid(periods), ProfileKind::Sinusoid, 20.0 / periods, 0.3);
            assert_grooves(&sawtooth(periods), ProfileKind::Blaze, 20.0 / periods, 0.3);
        }
        let steps = field(200, 20, |x, _| if (x * 0.4).fract() < 0.5 { 0.3 } else { 0.0 });
        assert_grooves(&steps, ProfileKind::Lamellar, 2.5, 0.3);
        let turned = field(200, 400, |x, y| 0.15 * (TAU * (x + y) / 2.0).sin());
        assert_grooves(&turned, ProfileKind::Sinusoid, SQRT_2, 0.3);
    }

    #[test]
    fn one_or_two_periods_are_not_taken_for_a_harmonic() {
        for periods in [1.0, 2.0] {
            assert_grooves(&sinusoid(periods), ProfileKind::Sinusoid, 20.0 / periods, 0.3);
            assert_grooves(&sawtooth(periods), ProfileKind::Blaze, 20.0 / periods, 0.3);
        }
        for cut in [sawtooth(1.6), sinusoid(1.4), sinusoid(2.3)] {
            assert_eq!(Relief::of(&cut).unwrap(), Relief::FewPeriods);
        }
    }

    #[test]
    fn waviness_of_less_than_three_periods_is_no_profile() {
        // 40 % of the variance in 1.2 periods, the rest in fingers of several frequencies.
        let wavy = field(200, 20, |x, _| {
            let fingers: f64 =
                (9..16).map(|k| 0.04 * (TAU * f64::from(k) * x / 19.3 + f64::from(k * k)).sin()).sum();
            0.09 * (TAU * 1.2 * x / 20.0 + 0.6).sin() + fingers
        });
        let Relief::Grooves(found) = Relief::of(&wavy).unwrap() else {
            panic!("{:?}", Relief::of(&wavy).unwrap())
        };
        assert_eq!(found.profile, ProfileKind::Rough, "{found:?}");
        assert!((1.0..3.0).contains(&found.period), "{found:?}");
    }

    #[test]
    fn crossed_gratings_and_mirrors_are_no_grooves() {
        let crossed = field(200, 400, |x, y| 0.1 * ((TAU * x).sin() + (TAU * y / 1.25).sin()));
        assert!(matches!(Relief::of(&crossed).unwrap(), Relief::Crossed(_)));
        assert_eq!(Relief::of(&field(50, 50, |_, _| 0.3)).unwrap(), Relief::Flat);
    }

    #[test]
    fn skin_is_rough_with_the_slope_of_its_fingers() {
        let skin = generate(&Spec::new(SurfaceKind::Elaphe)).unwrap();
        let Relief::Grooves(found) = Relief::of(&skin).unwrap() else { panic!("no grooves") };
        assert_eq!(found.profile, ProfileKind::Rough);
        let slope = TAU / found.period * found.height / 8_f64.sqrt();
        let sdq = crate::surface::statistics::Slopes::of(&skin).sdq;
        assert!((slope / sdq - 1.0).abs() < 1e-3, "{slope}, Sdq {sdq}: {found:?}");
        assert!((0.5..1.2).contains(&found.period), "{found:?}");
    }
}
