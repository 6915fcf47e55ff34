//! The layers: spectra of the basis functions under the window, packed for the shader, with the number of terms chosen
//! by comparing against the transform of e^{izh} itself.

use super::audit::{Audit, FAINT, PLANES, PlaneTerms};
use super::coefficients::Coefficients;
use super::kernel::{Interpolation, Kernel};
use super::transform::{PaddedAxis, Spectrum, Transformer};
use crate::error::{Error, Result};
use crate::expansion::chebyshev::Chebyshev;
use crate::expansion::optimal::Optimal;
use crate::expansion::taylor::{F32_ROUNDOFF, Taylor, terms_for};
use crate::expansion::{Basis, Expansion, HeightScale};
use crate::memory;
use crate::surface::HeightField;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// What the layers are made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Standard deviation of the Gaussian window over the endless surface \[µm\]; infinite: one period alone, without a
    /// window.
    pub sigma: f64,
    /// Shortest wavelength that will be asked for \[µm\].
    pub shortest_wavelength: f64,
    /// Relative intensity error that the user accepts.
    pub tolerance: f64,
    /// Which expansion.
    pub basis: Basis,
    /// Number of terms, where the user names it.
    pub terms: Option<usize>,
    /// Most bytes that the layers may take.
    pub memory_limit: usize,
    /// Most texels along a side of a layer.
    pub side_limit: usize,
}

/// Share of the tolerance that goes to reading between texels, which costs the most to lower.
const INTERPOLATION_SHARE: f64 = 0.7;
/// Share of the tolerance that goes to truncation and rounding together; shares add as squares.
const EXPANSION_SHARE: f64 = 0.35;

/// The largest |z| = k|w| that wavelengths from `shortest` \[µm\] allow \[rad/µm\]: |w| ≤ 2.
pub fn largest_z(shortest: f64) -> f64 {
    4.0 * PI / shortest
}

/// The errors that the layers bring, RMS over directions brighter than [`FAINT`] and relative to each one's own intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Truncation and rounding together, measured against the transform of e^{izh}.
    pub expansion: f64,
    /// Reading between texels, from the kernel's transform.
    pub interpolation: f64,
    /// The bound on |e^{izh} − Σ c_n b_n| over all heights, angles and wavelengths, relative to the mirror peak's amplitude.
    pub truncation_bound: f64,
    /// The bound on what rounding adds to it.
    pub rounding_bound: f64,
}

/// Spectra of the basis functions on the half plane f_x ≥ 0, two terms to an RGBA texel. The other half follows from
/// P(−f) = P*(f), that is from turning (u, v, w) around.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Texels along f_x and f_y.
    pub size: [usize; 2],
    /// Texel of f = 0.
    pub origin: [usize; 2],
    /// L_x, L_y: texels per unit of frequency \[µm\].
    pub length: [f64; 2],
    /// Frequencies beyond these hold nothing \[µm⁻¹\].
    pub band: [f64; 2],
    /// σ of the window \[µm\].
    pub sigma: f64,
    /// Number of terms K.
    pub terms: usize,
    /// c_n over k|w|.
    pub coefficients: Coefficients,
    /// Largest k|w| served \[rad/µm\].
    pub z_max: f64,
    /// Terms that k|w| up to each audited plane needs, by growing k|w|.
    pub terms_by_z: [PlaneTerms; PLANES.len()],
    /// How to read between texels.
    pub interpolation: Interpolation,
    /// What it is accurate to.
    pub errors: Errors,
    /// RGBA texels (Re, Im of term 2p; Re, Im of term 2p + 1), pair by pair, row by row in growing f_y; in units of the
    /// flat mirror's peak amplitude.
    pub texels: Vec<f32>,
}

impl Layers {
    /// Terms that k|w| = `z` \[rad/µm\] needs: those of the next audited plane above it. Scattering fades with z as fast
    /// as the terms do, so the sup bound, which is relative to the mirror peak, would drop terms that are seen.
    pub fn terms_at(&self, z: f64) -> usize {
        self.terms_by_z.iter().find(|plane| plane.z >= z).map_or(self.terms, |plane| plane.terms)
    }

    /// Layers of the texture: pairs of terms.
    pub fn pairs(&self) -> usize {
        self.terms.div_ceil(2)
    }
}

/// The padded grid for `settings`, checked against its memory limit before any of it is taken.
fn plan(field: &HeightField, settings: &Settings, interpolation: Interpolation) -> Result<[PaddedAxis; 2]> {
    let samples = [field.columns(), field.rows()];
    let band = bands(field, settings.shortest_wavelength);
    // Whether it fits is known before the axes, which are as long as the window, are made.
    let patch = field.patch_size();
    let extent = |axis: usize| if settings.sigma.is_finite() { settings.sigma } else { patch[axis] };
    let texels = |axis: usize| 2.0 * band[axis] * interpolation.ratio * extent(axis);
    let bytes = texels(0) * texels(1) / 2.0 * 8.0 * settings.terms.unwrap_or(2) as f64;
    if bytes > settings.memory_limit as f64 {
        return Err(too_large(bytes, settings));
    }
    let axis = |i: usize| {
        PaddedAxis::new(
            samples[i],
            field.pixel_size()[i],
            settings.sigma,
            interpolation.ratio,
            interpolation.kernel,
            band[i],
            i == 1,
        )
    };
    let axes = [axis(0), axis(1)];
    let longest = axes[0].kept().max(axes[1].kept());
    if longest > settings.side_limit {
        return Err(Error::failed(
            format!("the spectra would be {longest} texels long, the device holds {}", settings.side_limit),
            "ask for a shorter --coherence or a larger --tolerance, or use --method reference",
        ));
    }
    memory::ensure_room(Transformer::memory(&axes[0], &axes[1]), "the Fourier transforms")?;
    Ok(axes)
}

fn too_large(bytes: f64, settings: &Settings) -> Error {
    Error::failed(
        format!(
            "the spectra would take {:.1} GiB or more, the limit is {:.1} GiB",
            bytes / f64::from(1 << 30),
            settings.memory_limit as f64 / f64::from(1 << 30)
        ),
        "ask for a shorter --coherence, a larger --tolerance or fewer --terms, or use --method reference",
    )
}

/// Largest frequencies that directions at `shortest` \[µm\] can ask for and samples can hold: min(2/λ, 1/(2dx)).
fn bands(field: &HeightField, shortest: f64) -> [f64; 2] {
    field.pixel_size().map(|d| (2.0 / shortest).min(0.5 / d))
}

/// Transforms `field` into layers. `progress(done, of)` is called as work goes on; an error from it ends the work.
///
/// # Errors
/// Where 32-bit floats cannot hold the expansion at this tolerance, where the memory limit is exceeded, where `progress`
/// says so.
pub fn compute(
    field: &HeightField,
    settings: &Settings,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<Layers> {
    let scale = HeightScale::of(field);
    let z_max = largest_z(settings.shortest_wavelength);
    let expansion: Box<dyn Expansion> = match settings.basis {
        Basis::Taylor => Box::new(Taylor { half_range: scale.half_range }),
        Basis::Chebyshev => Box::new(Chebyshev { half_range: scale.half_range }),
        Basis::Optimal => Box::new(Optimal::new(field, z_max)),
    };
    let expansion = expansion.as_ref();
    if settings.basis == Basis::Taylor && settings.terms.is_none() {
        // Refuses what is hopeless before any work.
        terms_for(z_max * scale.half_range, settings.tolerance, F32_ROUNDOFF)?;
    }
    // No judged texel is fainter than FAINT, so a sup error of its square root times the tolerance is more than enough;
    // the loop below stops as soon as the measured error allows.
    let enough = settings.tolerance * FAINT.sqrt() * 0.1;
    let most_terms = match settings.terms {
        Some(terms) => terms.clamp(1, expansion.most_terms()),
        None => (1..expansion.most_terms())
            .find(|&n| settings.basis != Basis::Optimal && expansion.truncation_bound(z_max, n) <= enough)
            .unwrap_or(expansion.most_terms()),
    };
    let share = settings.tolerance * INTERPOLATION_SHARE;
    let (interpolation, interpolation_error) = if settings.sigma.is_finite() {
        let gaussian = Interpolation::for_tolerance(share);
        (gaussian, gaussian.relative_error())
    } else {
        Interpolation::of_patch(share)
    };
    if interpolation_error > share {
        return Err(Error::failed(
            format!(
                "spectra of any size that is sensible leave more than the tolerance {:.0e}",
                settings.tolerance
            ),
            "ask for a larger --tolerance, or use --method reference",
        ));
    }
    let [x, y] = plan(field, settings, interpolation)?;
    let size = [x.bins + interpolation.kernel.guard() + 1, y.kept()];
    let pair_bytes = size[0] * size[1] * 16;
    let transformer = Transformer::new(field, x, y);
    let heights: Vec<f64> = field.heights().iter().map(|&h| scale.normalise(h)).collect();

    let guess = settings.terms.unwrap_or(GUESSED_TERMS);
    let steps = |terms: usize| PLANES.len() + guess.max(terms).div_ceil(2);
    let mut audit = Audit::new(&transformer, &heights, scale.half_range, z_max, |i| progress(i, steps(0)))?;
    let mut texels: Vec<f32> = Vec::new();
    let mut terms = 0;
    while terms < most_terms {
        progress(PLANES.len() + terms / 2, steps(terms + 2))?;
        if texels.len() * 4 + pair_bytes > settings.memory_limit {
            return Err(too_large((texels.len() * 4 + pair_bytes) as f64, settings));
        }
        let (even, odd) = (terms, terms + 1);
        let spectrum = transformer.spectrum(|i| {
            Complex64::new(expansion.basis(even, heights[i]), expansion.basis(odd, heights[i]))
        });
        texels.extend(pack(&spectrum, size, &transformer, interpolation.kernel));
        audit.add(&spectrum);
        terms = (terms + 2).min(most_terms);
        if settings.terms.is_none() && audit.error(expansion, terms) <= EXPANSION_SHARE * settings.tolerance {
            break;
        }
    }
    let expansion_error = audit.error(expansion, terms);
    if settings.terms.is_none() && expansion_error > EXPANSION_SHARE * settings.tolerance {
        return Err(Error::failed(
            format!(
                "the {} expansion in 32-bit floats leaves a relative error of {expansion_error:.1e} on this surface, more \
                 than its share of the tolerance {:.1e}",
                settings.basis.name(),
                settings.tolerance
            ),
            "ask for a larger --tolerance, or use --basis optimal or --method reference",
        ));
    }
    progress(steps(terms), steps(terms))?;
    let guard = interpolation.kernel.guard();
    Ok(Layers {
        size,
        origin: [guard, transformer.y.bins],
        length: [transformer.x.length, transformer.y.length],
        band: bands(field, settings.shortest_wavelength),
        sigma: settings.sigma,
        terms,
        coefficients: Coefficients::new(expansion, terms, z_max, scale.half_range, settings.tolerance),
        z_max,
        terms_by_z: match settings.terms {
            // What the user names is done everywhere.
            Some(_) => audit.planes.each_ref().map(|plane| PlaneTerms { z: plane.z, terms }),
            None => audit.terms_by_z(expansion, terms, EXPANSION_SHARE * settings.tolerance),
        },
        interpolation,
        errors: Errors {
            expansion: expansion_error,
            interpolation: interpolation_error,
            truncation_bound: expansion.truncation_bound(z_max, terms),
            rounding_bound: expansion.rounding_bound(z_max, F32_ROUNDOFF),
        },
        texels,
    })
}

/// One pair of terms as RGBA texels on the half plane, row by row.
fn pack(spectrum: &Spectrum, size: [usize; 2], transformer: &Transformer, kernel: Kernel) -> Vec<f32> {
    let first_column = transformer.x.bins - kernel.guard();
    let mut texels = vec![0.0f32; size[0] * size[1] * 4];
    texels.par_chunks_mut(size[0] * 4).enumerate().for_each(|(row, out)| {
        for (column, texel) in out.chunks_mut(4).enumerate() {
            let [a, b] = spectrum.split(first_column + column, row);
            texel.copy_from_slice(&[a.re as f32, a.im as f32, b.re as f32, b.im as f32]);
        }
    });
    texels
}

/// What the progress counts on before the number of terms is known.
const GUESSED_TERMS: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    fn bumpy(range: f64) -> HeightField {
        let heights = (0..64 * 48)
            .map(|i| {
                let (x, y) = ((i % 64) as f64, (i / 64) as f64);
                range / 2.0 * (0.6 * (x / 64.0 * 25.13).sin() + 0.4 * (y / 48.0 * 18.85 + x * 0.1).cos())
            })
            .collect();
        HeightField::new(64, 48, [0.09, 0.09], heights).unwrap()
    }

    fn settings(tolerance: f64) -> Settings {
        Settings {
            sigma: 2.0,
            shortest_wavelength: 0.38,
            tolerance,
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
            let layers = compute(&field, &settings(tolerance), &|_, _| Ok(())).unwrap();
            assert!(layers.errors.expansion <= EXPANSION_SHARE * tolerance);
            assert_eq!(layers.texels.len(), layers.size[0] * layers.size[1] * 4 * layers.pairs());
            terms.push(layers.terms);
        }
        assert!(terms.is_sorted() && terms[0] < terms[2], "{terms:?}");
    }

    #[test]
    fn too_few_terms_are_seen_by_the_audit() {
        let field = bumpy(0.3);
        let few = Settings { terms: Some(3), ..settings(1e-2) };
        assert!(compute(&field, &few, &|_, _| Ok(())).unwrap().errors.expansion > 0.1);
    }

    #[test]
    fn heights_beyond_32_bit_floats_and_windows_beyond_memory_are_refused() {
        let high = compute(&bumpy(1.2), &settings(1e-2), &|_, _| Ok(())).unwrap_err().to_string();
        assert!(high.contains("32-bit"), "{high}");
        let wide = Settings { sigma: 2500.0, ..settings(1e-2) };
        let message = compute(&bumpy(0.1), &wide, &|_, _| Ok(())).unwrap_err().to_string();
        assert!(message.contains("GiB"), "{message}");
    }

    #[test]
    fn work_ends_where_progress_says_so() {
        let stop =
            |done: usize, _| if done > 1 { Err(Error::failed("stopped", "start again")) } else { Ok(()) };
        assert!(compute(&bumpy(0.1), &settings(1e-2), &stop).is_err());
    }

    #[test]
    fn a_flat_surface_needs_one_pair() {
        let field = HeightField::new(16, 16, [0.1, 0.1], vec![3.0; 256]).unwrap();
        let layers = compute(&field, &settings(1e-3), &|_, _| Ok(())).unwrap();
        assert!(layers.terms <= 2);
        let peak = (layers.origin[1] * layers.size[0] + layers.origin[0]) * 4;
        // Deapodisation lifts the sum of the weights above the window's integral by the kernel's own loss at the peak.
        assert!((layers.texels[peak] - 1.0).abs() < 0.1, "{}", layers.texels[peak]);
    }
}
