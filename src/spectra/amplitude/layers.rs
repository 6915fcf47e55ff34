//! Layers: spectra of the basis functions under the window, packed for the shader. The number of terms follows from a comparison with the
//! transform of e^{izh} itself.

use super::audit::{Audit, FAINT, PLANES};
use super::coefficients::Coefficients;
use super::kernel::{Interpolation, Transformed};
use super::pairs::PairRule;
use super::plan::{axes, bands_of, too_large};
use super::settings::LayerSettings;
use super::texels::Texels;
use super::transform::{TermPair, Transformer};
use crate::error::{Error, Remedy, Result};
use crate::memory;
use crate::spectra::amplitude::expansion::optimal::Optimal;
use crate::spectra::amplitude::expansion::taylor::{F32_ROUNDOFF, Taylor, terms_for};
use crate::spectra::amplitude::expansion::{Basis, Expansion, HeightScale};
use crate::surface::HeightField;
use crate::task::Task;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Returns the largest |z| = k|w| for wavelengths from `shortest` \[µm\] on \[rad/µm\]: |w| ≤ 2.
pub fn largest_z(shortest: f64) -> f64 {
    4.0 * PI / shortest
}

/// Errors of the layers, RMS over directions brighter than [`FAINT`] and relative to the intensity of each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Truncation and rounding together, measured against the transform of e^{izh}.
    pub expansion: f64,
    /// Interpolation between texels, from the kernel's transform.
    pub interpolation: f64,
    /// Bound on |e^{izh} − Σ c_n b_n| over all heights, angles and wavelengths, relative to the specular peak's amplitude.
    pub truncation_bound: f64,
    /// Bound on the error that rounding adds.
    pub rounding_bound: f64,
}

/// Spectra of the basis functions, two terms to an RGBA texel: of real functions on the half plane f_x ≥ 0, since
/// P(−f) = P*(f) there, of complex ones on the whole plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Texels along f_x and f_y.
    pub size: [usize; 2],
    /// Texel of f = 0.
    pub origin: [usize; 2],
    /// L_x, L_y: texels per unit of frequency \[µm\].
    pub length: [f64; 2],
    /// Largest frequencies of the band \[µm⁻¹\].
    pub band: [f64; 2],
    /// σ of the window \[µm\].
    pub sigma: f64,
    /// True if only f_x ≥ 0 is stored.
    pub half_plane: bool,
    /// Number of terms K.
    pub terms: usize,
    /// c_n over k|w|.
    pub coefficients: Coefficients,
    /// Largest k|w| of the layers \[rad/µm\].
    pub z_max: f64,
    /// Rule for the pairs of terms at each k|w|.
    pub pairs_needed: PairRule,
    /// Interpolation between texels.
    pub interpolation: Interpolation,
    /// Errors of the layers.
    pub errors: Errors,
    /// RGBA texels (Re, Im of term 2p; Re, Im of term 2p + 1), pair by pair, row by row in growing f_y; in units of the flat mirror's
    /// peak amplitude.
    pub texels: Texels,
}

impl Layers {
    /// Returns the number of pairs of terms, one for each layer of the texture.
    pub fn pairs(&self) -> usize {
        self.terms.div_ceil(2)
    }

    /// Returns the size of all texels \[bytes\].
    pub fn bytes(&self) -> usize {
        self.texels.bytes().len()
    }

    /// Returns the number of pairs of terms that are summed at k|w| = `z` \[rad/µm\].
    pub fn pairs_at(&self, z: f64) -> usize {
        self.pairs_needed.at(z).clamp(1, self.pairs())
    }
}

/// Name of the work in reports of progress.
const SPECTRA: &str = "spectra";

/// Transforms `field` into layers. `task` is told of each step.
///
/// # Errors
/// An expansion that 32-bit floats cannot hold at this tolerance, an exceeded memory limit, a cancelled task.
pub fn compute(field: &HeightField, settings: &LayerSettings, task: &Task) -> Result<Layers> {
    compute_at(field, settings, [0.0; 2], task)
}

/// Transforms `field` like [`compute`], with the centre of the window `shift` \[µm\] from that of the patch.
///
/// # Errors
/// See [`compute`].
pub fn compute_at(
    field: &HeightField,
    settings: &LayerSettings,
    shift: [f64; 2],
    task: &Task,
) -> Result<Layers> {
    let work = LayersWork::new(field, settings, shift)?;
    let mut audit = Audit::new(&work.transformer, &work.heights, work.half_range, work.z_max, |i| {
        task.report(SPECTRA, i, work.steps(0))
    })?;
    let made = work.transform(&mut audit, task)?;
    // 16-bit floats take half the memory, and are used if their rounding is within the budget too. Powers of the height cancel each other
    // by orders of magnitude and need 32 bits.
    let family = work.family.as_ref();
    let in_halves = audit.error_of_halves(family, made.terms);
    let budget = settings.budget.expansion;
    let half = in_halves <= budget && settings.terms.is_none() && Texels::fit_halves(&made.texels);
    let expansion_error = if half { in_halves } else { audit.error(family, made.terms) };
    if settings.terms.is_none() && expansion_error > budget {
        return Err(beyond_32_bits(settings, expansion_error));
    }
    task.report(SPECTRA, work.steps(made.pairs), work.steps(made.pairs))?;
    // The halves exist beside the texels from which they are made.
    let finished = if half { made.texels.len() * size_of::<f32>() / 2 } else { 0 };
    memory::ensure_room(finished as u64, "the spectra")?;
    let (z_max, terms) = (work.z_max, made.terms);
    Ok(Layers {
        size: work.size,
        origin: work.origin,
        length: [work.transformer.x.length, work.transformer.y.length],
        band: bands_of(field, settings.shortest_wavelength),
        sigma: settings.sigma,
        half_plane: work.half_plane,
        terms,
        coefficients: Coefficients::new(settings.basis, family, terms, z_max, work.half_range, budget),
        z_max,
        pairs_needed: match settings.terms {
            None => PairRule::over(&audit.terms_by_z(family, terms, budget)),
            // A number of terms that the user names is used everywhere.
            Some(_) => PairRule::constant(terms.div_ceil(2)),
        },
        interpolation: work.interpolation,
        errors: Errors {
            expansion: expansion_error,
            interpolation: work.interpolation_error,
            truncation_bound: family.truncation_bound(z_max, terms),
            rounding_bound: family.rounding_bound(z_max, F32_ROUNDOFF),
        },
        texels: Texels::of(half, made.texels),
    })
}

/// State of the computation of layers.
struct LayersWork<'a> {
    settings: &'a LayerSettings,
    interpolation: Interpolation,
    interpolation_error: f64,
    z_max: f64,
    half_range: f64,
    /// Heights within ±1.
    heights: Vec<f64>,
    family: Box<dyn Expansion>,
    most_terms: usize,
    transformer: Transformer<'a>,
    half_plane: bool,
    /// First column of the transforms that is kept.
    first_column: usize,
    size: [usize; 2],
    origin: [usize; 2],
}

/// Spectra of the pairs of terms made so far.
struct MadeSpectra {
    texels: Vec<f32>,
    pairs: usize,
    terms: usize,
}

impl<'a> LayersWork<'a> {
    fn new(field: &'a HeightField, settings: &'a LayerSettings, shift: [f64; 2]) -> Result<Self> {
        let scale = HeightScale::of(field);
        let z_max = largest_z(settings.shortest_wavelength);
        let (interpolation, interpolation_error) = interpolation(settings)?;
        let [x, y] = axes(field, settings, interpolation, shift)?;
        if settings.basis == Basis::Taylor && settings.terms.is_none() {
            // Refuses impossible heights before any work.
            terms_for(z_max * scale.half_range, settings.budget.expansion, F32_ROUNDOFF)?;
        }
        let family = family(field, settings.basis, z_max);
        let most_terms = most_terms(family.as_ref(), settings, z_max);
        let half_plane = settings.basis.is_real();
        // Texels left of f_x = 0 exist for the kernel alone if only the half plane is stored.
        let first_column = if half_plane { x.bins - interpolation.kernels[0].guard() } else { 0 };
        let (size, origin) = ([x.kept() - first_column, y.kept()], [x.bins - first_column, y.bins]);
        let work = Self {
            settings,
            interpolation,
            interpolation_error,
            z_max,
            half_range: scale.half_range,
            heights: field.heights().iter().map(|&h| scale.normalise(h)).collect(),
            family,
            most_terms,
            transformer: Transformer::new(field, x, y),
            half_plane,
            first_column,
            size,
            origin,
        };
        work.ensure_limit(if settings.terms.is_some() { most_terms.div_ceil(2) } else { 1 })?;
        Ok(work)
    }

    /// Returns the size of a layer \[bytes\].
    fn layer_bytes(&self) -> usize {
        TEXEL * self.size[0] * self.size[1]
    }

    /// Fails if this number of layers exceeds the user's limit.
    fn ensure_limit(&self, layers: usize) -> Result<()> {
        let bytes = layers * self.layer_bytes();
        if bytes <= self.settings.memory_limit { Ok(()) } else { Err(too_large(bytes as f64, self.settings)) }
    }

    /// Estimates the steps of the whole work after `layers` layers.
    fn steps(&self, layers: usize) -> usize {
        PLANES + self.settings.terms.unwrap_or(GUESSED_TERMS).div_ceil(2).max(layers)
    }

    /// Transforms pair after pair of terms, until the `audit` reports a small enough error.
    fn transform(&self, audit: &mut Audit, task: &Task) -> Result<MadeSpectra> {
        let Self { settings, transformer, heights, most_terms, .. } = self;
        let family = self.family.as_ref();
        let [columns, rows] = self.size;
        let mut texels: Vec<f32> = Vec::new();
        let mut pairs = 0;
        loop {
            task.report(SPECTRA, PLANES + pairs, self.steps(pairs + 1))?;
            self.ensure_limit(pairs + 1)?;
            let pair = transformer.pair(self.half_plane, |n, i| family.basis(2 * pairs + n, heights[i]));
            // Requested as the texels grow: the number of layers is known only at the end.
            memory::ensure_room(self.layer_bytes() as u64, "the spectra")?;
            let begin = texels.len();
            texels.reserve_exact(columns * rows * 4);
            texels.resize(begin + columns * rows * 4, 0.0);
            pack(&pair, columns, self.first_column, &mut texels[begin..]);
            audit.add(&pair);
            transformer.take_back(pair);
            pairs += 1;
            let terms = (2 * pairs).min(*most_terms);
            let enough = settings.terms.is_none() && audit.error(family, terms) <= settings.budget.expansion;
            if enough || terms == *most_terms {
                return Ok(MadeSpectra { texels, pairs, terms });
            }
        }
    }
}

/// Returns the interpolation between texels within the budget of `settings`, and its error.
fn interpolation(settings: &LayerSettings) -> Result<(Interpolation, f64)> {
    let budget = settings.budget.interpolation;
    let of = if settings.sigma.is_finite() { Transformed::Window } else { Transformed::Period };
    let interpolation = Interpolation::for_tolerance(budget, of);
    let error = interpolation.relative_error();
    if error > budget {
        return Err(Error::limit(
            format!(
                "spectra of any size that is sensible leave more than {budget:.0e} between their samples"
            ),
            [Remedy::TimesTolerance(error / budget), Remedy::ReferenceMethod],
        ));
    }
    Ok((interpolation, error))
}

fn beyond_32_bits(settings: &LayerSettings, error: f64) -> Error {
    Error::limit(
        format!(
            "the {} expansion in 32-bit floats leaves a relative error of {error:.1e} on this surface, more than its share {:.1e} of the \
             tolerance",
            settings.basis.name(),
            settings.budget.expansion
        ),
        [
            Remedy::TimesTolerance(error / settings.budget.expansion),
            Remedy::OptimalBasis,
            Remedy::ReferenceMethod,
        ],
    )
}

/// Returns the expansion of `basis` for the heights of `field` and |z| up to `z_max` \[rad/µm\].
fn family(field: &HeightField, basis: Basis, z_max: f64) -> Box<dyn Expansion> {
    let half_range = HeightScale::of(field).half_range;
    match basis {
        Basis::Taylor => Box::new(Taylor { half_range }),
        Basis::Optimal => Box::new(Optimal::new(field, [0.0, z_max])),
    }
}

/// Returns the number of terms at which the audit may stop searching.
fn most_terms(family: &dyn Expansion, settings: &LayerSettings, z_max: f64) -> usize {
    let most = family.most_terms();
    // No judged texel is fainter than FAINT: a sup error of √FAINT times the tolerance suffices, with a margin of 10.
    let enough = settings.budget.expansion * FAINT.sqrt() * 0.1;
    match settings.terms {
        Some(terms) => terms.clamp(1, most),
        // The bound of other expansions is measured, which takes longer than a term.
        None if settings.basis.is_real() => {
            (1..most).find(|&n| family.truncation_bound(z_max, n) <= enough).unwrap_or(most)
        }
        None => most,
    }
}

/// Packs one pair of terms into RGBA `texels`, row by row, each of `columns` from kept column `first_column` on.
fn pack(pair: &TermPair, columns: usize, first_column: usize, texels: &mut [f32]) {
    texels.par_chunks_mut(columns * 4).enumerate().for_each(|(row, out)| {
        for (column, texel) in out.chunks_mut(4).enumerate() {
            let [a, b] = pair.at(first_column + column, row);
            texel.copy_from_slice(&[a.re as f32, a.im as f32, b.re as f32, b.im as f32]);
        }
    });
}

/// Bytes of a texel: two complex numbers of 32-bit floats.
const TEXEL: usize = 16;
/// Number of terms that the progress assumes before it is known.
const GUESSED_TERMS: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::ErrorBudget;
    use std::sync::atomic::Ordering;

    fn bumpy(range: f64) -> HeightField {
        let heights = (0..64 * 48)
            .map(|i| {
                let (x, y) = ((i % 64) as f64, (i / 64) as f64);
                range / 2.0 * (0.6 * (x / 64.0 * 25.13).sin() + 0.4 * (y / 48.0 * 18.85 + x * 0.1).cos())
            })
            .collect();
        HeightField::new(64, 48, [0.09, 0.09], heights).unwrap()
    }

    fn settings(tolerance: f64) -> LayerSettings {
        LayerSettings {
            sigma: 2.0,
            shortest_wavelength: 0.38,
            budget: ErrorBudget::of_directions(tolerance).window,
            basis: Basis::Taylor,
            terms: None,
            memory_limit: 1 << 30,
            side_limit: 16_384,
        }
    }

    #[test]
    fn tighter_tolerances_take_more_terms_and_keep_their_share() {
        let field = bumpy(0.3);
        let mut terms = Vec::new();
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let layers = compute(&field, &settings(tolerance), &Task::silent()).unwrap();
            assert!(layers.errors.expansion <= 0.35 * tolerance);
            assert_eq!(layers.texels.len(), layers.size[0] * layers.size[1] * 4 * layers.pairs());
            terms.push(layers.terms);
        }
        assert!(terms.is_sorted() && terms[0] < terms[2], "{terms:?}");
    }

    #[test]
    fn too_few_terms_are_seen_by_the_audit() {
        let field = bumpy(0.3);
        let few = LayerSettings { terms: Some(3), ..settings(1e-2) };
        assert!(compute(&field, &few, &Task::silent()).unwrap().errors.expansion > 0.1);
    }

    #[test]
    fn heights_beyond_32_bit_floats_and_windows_beyond_memory_are_refused() {
        let high = compute(&bumpy(1.2), &settings(1e-2), &Task::silent()).unwrap_err().to_string();
        assert!(high.contains("32-bit"), "{high}");
        let wide = LayerSettings { sigma: 2500.0, ..settings(1e-2) };
        let message = compute(&bumpy(0.1), &wide, &Task::silent()).unwrap_err().to_string();
        assert!(message.contains("GiB"), "{message}");
    }

    #[test]
    fn work_ends_when_it_is_cancelled() {
        let (task, reports) = Task::cancelled_at(3);
        assert!(compute(&bumpy(0.1), &settings(1e-2), &task).is_err_and(|e| e.is_cancelled()));
        assert_eq!(reports.load(Ordering::Relaxed), 3);
    }

    #[test]
    fn a_flat_surface_needs_one_pair() {
        let field = HeightField::new(16, 16, [0.1, 0.1], vec![3.0; 256]).unwrap();
        let layers = compute(&field, &settings(1e-3), &Task::silent()).unwrap();
        assert!(layers.terms <= 2);
        let peak = (layers.origin[1] * layers.size[0] + layers.origin[0]) * 4;
        // Deapodisation lifts the sum of the weights above the window's integral by the loss of the kernel at the peak.
        let peak = layers.texels.at(peak);
        assert!((peak - 1.0).abs() < 0.1, "{peak}");
    }
}
