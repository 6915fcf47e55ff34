//! The promise of a tolerance, over many surfaces and settings.
//!
//! What is held to it is the relative L2 error over directions, as of a picture. The RMS of each direction's own relative error
//! is printed beside it: between the orders of small gratings it can exceed the tolerance (docs/ACCURACY.md).

use crate::device::with_device;
use crate::evaluation::{layers, queries, window};
use crate::measure::per_direction;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::color::DISPLAY_BLACK;
use diffract::internals::optics::reference::Reference;
use diffract::internals::random::Random;
use diffract::internals::render::evaluator::Evaluator;
use diffract::internals::settings::Optics;
use diffract::internals::spectra::amplitude::expansion::Basis;
use diffract::internals::surface::HeightField;

/// Surfaces times settings, of each basis.
const COMBINATIONS: usize = 105;
/// Directions and wavelengths of each.
const DIRECTIONS: usize = 100;

/// A periodic surface of a few random waves, smooth, stepped or rough, on a grid of random sides and spacings.
fn surface(uniform: &mut impl FnMut() -> f64, largest_height: f64) -> HeightField {
    let mut whole = |low: usize, high: usize| low + (uniform() * (high - low + 1) as f64) as usize;
    let (columns, rows) = (whole(12, 40), whole(12, 40));
    let waves: Vec<[usize; 2]> = (0..4).map(|_| [whole(0, 5), whole(0, 5)]).collect();
    let shape = whole(0, 2);
    let (dx, dy) = (0.05 + 0.05 * uniform(), 0.05 + 0.05 * uniform());
    let phases: Vec<f64> = (0..4).map(|_| uniform() * std::f64::consts::TAU).collect();
    let mut heights: Vec<f64> = (0..columns * rows)
        .map(|i| {
            let (x, y) = ((i % columns) as f64 / columns as f64, (i / columns) as f64 / rows as f64);
            let wave = |([m, n], phase): (&[usize; 2], &f64)| {
                (std::f64::consts::TAU * (*m as f64 * x + *n as f64 * y) + phase).sin()
            };
            let sum: f64 = waves.iter().zip(&phases).map(wave).sum();
            match shape {
                0 => sum,
                1 => (2.0 * sum).floor(),
                _ => sum + 3.0 * uniform(),
            }
        })
        .collect();
    let (low, high) = heights.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    let full = largest_height * (0.1 + 0.9 * uniform());
    heights.iter_mut().for_each(|h| *h = (*h - low) / (high - low).max(1e-9) * full);
    HeightField::new(columns, rows, [dx, dy], heights).unwrap()
}

#[test]
fn the_promised_error_of_a_taylor_series_is_never_below_the_measured_one_and_seldom_far_above_it() {
    // The series refuses what 32-bit floats cannot hold.
    judge_promises(Basis::Taylor, 0.4, 2014);
}

#[test]
fn the_promised_error_of_optimal_functions_is_never_below_the_measured_one_and_seldom_far_above_it() {
    judge_promises(Basis::Optimal, 0.9, 2015);
}

/// Compares promised with measured errors on surfaces up to `largest_height` \[µm\].
fn judge_promises(basis: Basis, largest_height: f64, seed: u64) {
    let mut random = Random::new(seed);
    let mut uniform = || random.share();
    let (mut ratios, mut own) = (Vec::new(), Vec::new());
    with_device(|device| {
        for combination in 0..COMBINATIONS {
            let field = surface(&mut uniform, largest_height);
            let optics = Optics {
                coherence: Coherence::Gaussian { length: 5.0 + 7.0 * uniform() },
                tolerance: 10f64.powf(-1.0 - 2.0 * uniform()),
                reflectance: (1.2 + uniform()).into(),
                basis,
                windows: Windows::ONE,
                ..Optics::default()
            };
            let queries = queries(seed + combination as u64, DIRECTIONS);
            let reference = Reference::new(&field, optics.coherence, [1, 1], optics.reflectance.clone());
            let exact: Vec<f64> = queries
                .iter()
                .map(|q| reference.brdf(&q.pair, q.wavelength.unwrap()) * q.pair.light.z.max(0.0))
                .collect();
            let mut evaluator = Evaluator::new(device, &window(&layers(&field, &optics)), &optics).unwrap();
            let found: Vec<f64> = evaluator.cosine_weighted(&queries).unwrap().iter().map(|v| v.x).collect();
            let difference: f64 = found.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum();
            let size: f64 = exact.iter().map(|b| b * b).sum();
            let ratio = optics.tolerance / (difference / size).sqrt().max(1e-12);
            let single = per_direction(&found, &exact, DISPLAY_BLACK / std::f64::consts::PI);
            own.push(optics.tolerance / single.max(1e-12));
            if ratio < 1.0 || single > optics.tolerance {
                eprintln!(
                    "{combination}: {basis:?}, {} x {} samples, {:.2} um high, {:?}, {:.2e}: L2 {:.2e}, own {single:.2e}",
                    field.columns(),
                    field.rows(),
                    field.range().1 - field.range().0,
                    optics.coherence,
                    optics.tolerance,
                    optics.tolerance / ratio
                );
            }
            ratios.push(ratio);
        }
    });
    ratios.sort_by(f64::total_cmp);
    let (worst, median) = (ratios[0], ratios[ratios.len() / 2]);
    eprintln!(
        "promised over measured: smallest {worst:.2}, median {median:.1}, {} combinations",
        ratios.len()
    );
    own.sort_by(f64::total_cmp);
    let beyond = own.iter().filter(|r| **r < 1.0).count();
    eprintln!(
        "each direction to its own: smallest {:.2}, median {:.1}, {beyond} below 1",
        own[0],
        own[own.len() / 2]
    );
    let broken = ratios.iter().filter(|r| **r < 1.0).count();
    assert!(broken == 0, "{broken} of {COMBINATIONS} promises are broken, the worst by {:.2}", 1.0 / worst);
    assert!(median <= 30.0, "the promises are pessimistic by {median:.0} at the median");
}
