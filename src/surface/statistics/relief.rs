//! The kind of profile that a field has, with the two lengths on which errors of scalar theory depend.

use super::height_spectrum::analysed_part;
use super::joining::joining;
use super::profile_form::{MeasuredSpectrum, ProfileForm, ProfileKind};
use crate::error::Result;
use crate::surface::HeightField;
use crate::surface::si::metres;
use crate::surface::tiling::Verdict;
use serde::Serialize;
use std::f64::consts::{SQRT_2, TAU};

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
    /// Slopes in two directions, or a second period in another direction: the larger and the smaller RMS slope of the principal axes.
    Crossed([f64; 2]),
    /// Grooves with a profile that is none of [`ProfileKind`].
    OtherProfile,
    /// More than half of the variance has fewer than three periods over the field, whose copies do not join.
    FewPeriods,
}

/// Smaller over larger RMS slope above which a field has no grooves: at 1/√3 a quarter of the slope variance lies along them.
const CROSSED: f64 = 0.577;
/// RMS height over the height range, below which a field is flat but for rounding.
const ROUNDING: f64 = 1e-12;
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
        let joins = joining(&part)?.verdict == Verdict::Tiles;
        let measured = MeasuredSpectrum::new(&part, joins)?;
        if measured.rms() <= ROUNDING * low.abs().max(high.abs()) {
            return Ok(Self::Flat);
        }
        let slopes = principal_slopes(&part);
        if slopes[1] > CROSSED * slopes[0] {
            return Ok(Self::Crossed(slopes));
        }
        if !joins && measured.has_few_periods() {
            return Ok(Self::FewPeriods);
        }
        if measured.has_second() {
            return Ok(Self::Crossed(slopes));
        }
        let form = measured.form(&part)?;
        if joins && form == ProfileForm::Kind(ProfileKind::Rough) {
            // A seam may join by chance, where a flank lies on it.
            let windowed = MeasuredSpectrum::new(&part, false)?;
            let other = windowed.form(&part)?;
            if other != form {
                return Ok(Self::from_form(other, &windowed, slopes));
            }
        }
        Ok(Self::from_form(form, &measured, slopes))
    }

    /// Returns the relief of a field of this form and these RMS slopes.
    fn from_form(form: ProfileForm, measured: &MeasuredSpectrum, slopes: [f64; 2]) -> Self {
        match form {
            ProfileForm::Kind(kind) => Self::Grooves(grooves(measured, kind, slopes)),
            ProfileForm::Other => Self::OtherProfile,
        }
    }
}

/// Returns grooves of this kind and these RMS slopes.
fn grooves(
    measured: &MeasuredSpectrum,
    profile: ProfileKind,
    [across, slope_along]: [f64; 2],
) -> ProfileShape {
    let height_over_rms = match profile {
        ProfileKind::Sinusoid => 2.0 * SQRT_2,
        ProfileKind::Blaze => 12_f64.sqrt(),
        ProfileKind::Lamellar => 2.0,
        ProfileKind::Rough => {
            let period = measured.mean_period();
            let height = 2.0 * SQRT_2 * across.hypot(slope_along) * period / TAU;
            return ProfileShape { profile, period, height, slope_along };
        }
    };
    let height = height_over_rms * measured.rms();
    ProfileShape { profile, period: measured.strongest_period(), height, slope_along }
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

    /// Returns a profile of the phase, 0.3 µm high, repeated `periods` times over 20 µm.
    fn periodic(periods: f64, profile: impl Fn(f64) -> f64) -> HeightField {
        field(400, 20, |x, _| 0.3 * profile((x * periods / 40.0 + 0.1234).fract()))
    }

    #[test]
    fn blazes_fall_and_rise_and_have_blunt_flanks() {
        // 16.6: copies that do not join.
        for periods in [16.0, 16.6] {
            for flank in [0.06, 0.12, 0.18] {
                let blunt = move |u: f64| if u < 1.0 - flank { u / (1.0 - flank) } else { (1.0 - u) / flank };
                assert_grooves(&periodic(periods, blunt), ProfileKind::Blaze, 40.0 / periods, 0.3);
                let falls = move |u: f64| blunt(1.0 - u);
                assert_grooves(&periodic(periods, falls), ProfileKind::Blaze, 40.0 / periods, 0.3);
            }
        }
        let turned = field(400, 800, |x, y| 0.3 * ((x + y) / 4.0).fract());
        assert_grooves(&turned, ProfileKind::Blaze, 2.0 * SQRT_2, 0.3);
    }

    #[test]
    fn other_periodic_profiles_are_none_of_those_that_were_computed() {
        let cosine = |u: f64| (TAU * u).cos();
        for periods in [16.0, 16.6] {
            for (name, other) in [
                ("triangle", periodic(periods, |u| (2.0 * u - 1.0).abs())),
                ("slanting triangle", periodic(periods, |u| (u / 0.65).min((1.0 - u) / 0.35))),
                ("quarter duty", periodic(periods, |u| if u < 0.25 { 1.0 } else { 0.0 })),
                ("narrow ridges", periodic(periods, |u| if u < 0.16 { 1.0 } else { 0.0 })),
                ("sharp crests", periodic(periods, |u| cosine(u) + 0.25 * cosine(2.0 * u))),
                ("steep sides", periodic(periods, |u| cosine(u) + 0.25 * (2.0 * TAU * u).sin())),
                ("half of a sawtooth", periodic(periods, |u| (2.0 * u).min(1.0))),
                ("half a wave", periodic(periods, |u| cosine(u).max(0.0))),
            ] {
                assert_eq!(Relief::of(&other).unwrap(), Relief::OtherProfile, "{name}, {periods} periods");
            }
        }
    }

    #[test]
    fn nearly_sinusoidal_grooves_are_sinusoids() {
        let bent = field(200, 400, |x, y| 0.15 * (TAU * (x / 2.0 + 0.05 * (TAU * y / 20.0).sin())).sin());
        assert_grooves(&bent, ProfileKind::Sinusoid, 2.0, 0.3);
        let noise = |x: f64, y: f64| 0.002 * ((x * 7919.1 + y * 104_729.3).sin() * 43_758.5).fract();
        let noisy = field(203, 200, |x, y| 0.15 * (TAU * x / 2.5).sin() + noise(x, y));
        assert_grooves(&noisy, ProfileKind::Sinusoid, 2.5, 0.3);
    }

    #[test]
    fn a_weaker_second_period_in_another_direction_is_crossed() {
        // Joining copies, and the same cut elsewhere.
        for [columns, rows] in [[220, 440], [211, 431]] {
            for second in [0.2, 0.45, 0.8] {
                let cosines = field(columns, rows, |x, y| {
                    0.03 * ((TAU * x / 1.1).cos() + second * (TAU * y / 1.1).cos())
                });
                assert!(matches!(Relief::of(&cosines).unwrap(), Relief::Crossed(_)), "{second}");
            }
            let unlike = field(columns, rows, |x, y| 0.03 * ((TAU * x / 1.1).cos() + (TAU * y / 3.3).cos()));
            assert!(matches!(Relief::of(&unlike).unwrap(), Relief::Crossed(_)));
        }
    }

    #[test]
    fn many_frequencies_of_any_phase_are_rough() {
        let grooves = |x: f64| -> f64 {
            (6..30).map(|k| 0.03 * (TAU * f64::from(k) * x / 20.0 + f64::from(k * k * k)).sin()).sum()
        };
        let Relief::Grooves(found) = Relief::of(&field(200, 40, |x, _| grooves(x))).unwrap() else {
            panic!()
        };
        assert_eq!(found.profile, ProfileKind::Rough);
    }

    #[test]
    fn built_in_surfaces_have_their_kinds() {
        for (surface, name) in [
            (SurfaceKind::Sinusoid, "sinusoid"),
            (SurfaceKind::Blaze, "blaze"),
            (SurfaceKind::Bumps, "crossed"),
            (SurfaceKind::Xenopeltis, "other"),
            (SurfaceKind::Cd, "rough"),
            (SurfaceKind::Dvd, "crossed"),
            (SurfaceKind::Brushed, "rough"),
            (SurfaceKind::Tulip, "rough"),
        ] {
            let relief = Relief::of(&generate(&Spec::new(surface)).unwrap()).unwrap();
            let found = match relief {
                Relief::Grooves(found) => found.profile.name(),
                Relief::Crossed(_) => "crossed",
                Relief::OtherProfile => "other",
                _ => "none",
            };
            assert_eq!(found, name, "{surface:?}: {relief:?}");
        }
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
