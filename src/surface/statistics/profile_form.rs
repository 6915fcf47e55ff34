//! Form of the profile that a field has across its strongest frequency.

use super::harmonics::Harmonics;
use super::height_spectrum::SurfaceSpectrum;
use super::periods::{amplitude, refined};
use crate::error::Result;
use crate::surface::HeightField;
use serde::Serialize;

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

/// Fewer periods over a field whose copies do not join are not resolved.
const FEWEST_CYCLES: f64 = 3.0;
/// Share of the variance in a frequency across which the strongest lies, from which on it is a second period: an
/// amplitude of a seventh of that of a sinusoid.
const SECOND_SHARE: f64 = 0.02;
/// Least angle between the two, as its cosine, and least second frequency over the first: longer periods along grooves bend them.
const SECOND_COSINE: f64 = 0.866;
const SECOND_FREQUENCY: f64 = 0.25;
/// Least share of the variance in the strongest frequency of a periodic profile.
const PERIODIC_SHARE: f64 = 0.5;
/// Least share of the variance in the strongest frequency of a sinusoid.
const SINUSOID_SHARE: f64 = 0.9;
/// Least share in the strongest frequency of a lamellar profile, which has 8/π² with ridges of half a period, and
/// limits of the share of samples above the middle of the heights.
const LAMELLAR_SHARE: f64 = 0.7;
const LAMELLAR_DUTY: std::ops::RangeInclusive<f64> = 0.42..=0.58;
/// Least share of the samples in the outer tenths of the height range for a lamellar profile; 0.2 of a blaze, 0.4 of a sinusoid.
const LAMELLAR_ENDS: f64 = 0.7;
/// Least share of the variance in multiples of the strongest frequency of a blaze, which has 0.87 in four of them, and
/// of profiles that are periodic although most of the variance is in overtones.
const HARMONIC_SHARE: f64 = 0.75;

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

/// Form of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProfileForm {
    /// One of those for which errors were computed.
    Kind(ProfileKind),
    /// Periodic, of another form.
    Other,
}

/// The strongest frequency of a spectrum.
struct StrongestFrequency {
    /// Its place in the spectrum.
    place: [usize; 2],
    /// The frequency \[1/µm\].
    frequency: [f64; 2],
    /// Share of the variance.
    share: f64,
    /// Periods over the field. Below three under a window the lobes of both signs overlap, and the share is that of both.
    cycles: f64,
}

/// Spectrum of a field, of one period or windowed, with what is read from it.
pub(super) struct MeasuredSpectrum {
    spectrum: SurfaceSpectrum,
    is_period: bool,
    moments: SpectralMoments,
    strongest: StrongestFrequency,
}

impl MeasuredSpectrum {
    /// Measures `field`, as one period or windowed.
    ///
    /// # Errors
    /// Too little memory for the spectrum.
    pub fn new(field: &HeightField, is_period: bool) -> Result<Self> {
        let spectrum = if is_period {
            SurfaceSpectrum::of_one_period(field)?
        } else {
            SurfaceSpectrum::windowed(field)?
        };
        let moments = SpectralMoments::new(&spectrum);
        let (_, place) = moments.strongest;
        let frequency =
            if is_period { spectrum.frequency(place[0], place[1]) } else { refined(&spectrum, place) };
        let cycles = (frequency[0] * spectrum.patch[0]).hypot(frequency[1] * spectrum.patch[1]);
        let share = variance_at(&spectrum, place, is_period) / moments.variance;
        let strongest = StrongestFrequency { place, frequency, share, cycles };
        Ok(Self { spectrum, is_period, moments, strongest })
    }

    /// Returns the RMS height \[µm\].
    pub fn rms(&self) -> f64 {
        self.moments.variance.sqrt()
    }

    /// Returns true if more than half of the variance has fewer than three periods over the field.
    pub fn has_few_periods(&self) -> bool {
        self.moments.few > 0.5 * self.moments.variance
    }

    /// Returns the period of the strongest frequency \[µm\].
    pub fn strongest_period(&self) -> f64 {
        1.0 / self.strongest.frequency[0].hypot(self.strongest.frequency[1])
    }

    /// Returns the mean of 1/f weighted by the power of the slope \[µm\].
    pub fn mean_period(&self) -> f64 {
        self.moments.first / self.moments.second
    }

    /// Returns true if another direction than that of the strongest frequency has a period of its own.
    pub fn has_second(&self) -> bool {
        let StrongestFrequency { frequency: [fx, fy], .. } = self.strongest;
        let first = fx.hypot(fy);
        // Under a window a line of frequencies is as wide as its lobes.
        let least_cycles = if self.is_period { 0.5 } else { FEWEST_CYCLES };
        let part = |best: &mut (f64, [usize; 2]), i: usize, j: usize, _: f64| {
            let power = self.spectrum.power(i, j);
            if power <= best.0 {
                return;
            }
            let [x, y] = self.spectrum.frequency(i, j);
            let (length, along) = (x.hypot(y), (x * fx + y * fy) / first);
            let across = [x - along * fx / first, y - along * fy / first];
            let cycles = (across[0] * self.spectrum.patch[0]).hypot(across[1] * self.spectrum.patch[1]);
            let is_across = along.abs() < SECOND_COSINE * length && cycles >= least_cycles;
            if is_across && length >= SECOND_FREQUENCY * first {
                *best = (power, [i, j]);
            }
        };
        let (power, place) = self.spectrum.sum(|| (0.0, [0; 2]), part, |a, b| if a.0 >= b.0 { a } else { b });
        let second = || variance_at(&self.spectrum, place, self.is_period);
        power > 0.0 && second() >= SECOND_SHARE * self.moments.variance
    }

    /// Returns the form of the profile of `field`.
    ///
    /// # Errors
    /// Too little memory.
    pub fn form(&self, field: &HeightField) -> Result<ProfileForm> {
        let StrongestFrequency { place, frequency, share, cycles } = self.strongest;
        let is_resolved = cycles >= FEWEST_CYCLES;
        if !self.is_period && !is_resolved {
            return Ok(ProfileForm::Kind(ProfileKind::Rough));
        }
        let harmonics = if self.is_period {
            Harmonics::of_one_period(&self.spectrum, place)
        } else {
            Harmonics::windowed(field, frequency)?
        };
        let is_harmonic = harmonics.variance() >= HARMONIC_SHARE * self.moments.variance;
        let [ends, above] = shares_of_heights(field);
        let is_lamellar = ends >= LAMELLAR_ENDS && LAMELLAR_DUTY.contains(&above);
        Ok(if share >= SINUSOID_SHARE && harmonics.is_sinusoid() {
            ProfileForm::Kind(ProfileKind::Sinusoid)
        } else if share >= PERIODIC_SHARE && is_harmonic && harmonics.is_blaze() {
            ProfileForm::Kind(ProfileKind::Blaze)
        } else if share >= LAMELLAR_SHARE && is_lamellar {
            ProfileForm::Kind(ProfileKind::Lamellar)
        } else if share >= PERIODIC_SHARE || (is_harmonic && is_resolved) {
            ProfileForm::Other
        } else {
            ProfileForm::Kind(ProfileKind::Rough)
        })
    }
}

/// Returns the mean square height of the frequency at `place` and its opposite \[µm²\], of a spectrum of one period or windowed.
fn variance_at(spectrum: &SurfaceSpectrum, place: [usize; 2], is_period: bool) -> f64 {
    if is_period {
        2.0 * spectrum.power(place[0], place[1])
    } else {
        amplitude(spectrum, place).powi(2) / 2.0
    }
}

/// Returns the share of the samples in the lowest and highest tenth of the height range together, and that of those
/// above its middle.
fn shares_of_heights(field: &HeightField) -> [f64; 2] {
    let (low, high) = field.range();
    let [tenth, middle] = [(high - low) / 10.0, f64::midpoint(low, high)];
    let share = |counts: &dyn Fn(f64) -> bool| {
        field.heights().iter().filter(|h| counts(**h)).count() as f64 / field.heights().len() as f64
    };
    [share(&|h| h <= low + tenth || h >= high - tenth), share(&|h| h > middle)]
}
