//! How many cubics hold the colours over |w|.

use super::sums::{CUBIC, DirectionWavelengths, Scratch, Sums};
use super::{LARGEST_W, TableSettings};
use crate::error::{Error, Remedy, Result};
use crate::spectra::power::read::{SpectraReader, Square};
use glam::DVec2;
use rayon::prelude::*;

/// Most pieces of the range of |w|.
pub const MOST_PIECES: usize = 16;

/// The fewest pieces whose cubics err by no more than the settings allow, and that error: RMS over directions spread evenly and over |w|,
/// each relative to its own value, since the faint directions far from the specular one are where the colours are.
pub fn choose_pieces(
    reader: &SpectraReader,
    spectrum: &DirectionWavelengths,
    settings: &TableSettings,
) -> Result<(usize, f64)> {
    /// Places in |w|, between nodes of any pieces.
    const BETWEEN: usize = 41;
    /// What a value counts for at the least, over the largest of its direction: small |w| are small in pictures, too.
    const FAINT: f32 = 0.05;
    /// The same over the mean of the largest of all directions: between the orders of a grating there is nothing but what reading leaves.
    const DARK: f32 = 1e-4;
    let fine: Vec<f64> = (0..BETWEEN).map(|i| LARGEST_W * (i as f64 + 0.37) / BETWEEN as f64).collect();
    let exact = Sums::at(reader, spectrum, fine.clone());
    let places = judged(reader, spectrum);
    let truth: Vec<Vec<[f32; 3]>> = places
        .par_iter()
        .map_init(Scratch::default, |scratch, place| exact.colours(*place, scratch))
        .collect();
    let largest_of = |truth: &[[f32; 3]]| -> [f32; 3] {
        std::array::from_fn(|channel| truth.iter().map(|colour| colour[channel]).fold(0.0, f32::max))
    };
    let dark: [f32; 3] = std::array::from_fn(|channel| {
        DARK * truth.iter().map(|truth| largest_of(truth)[channel]).sum::<f32>() / truth.len() as f32
    });
    let error_of = |pieces: usize| {
        let sums = Sums::new(reader, spectrum, pieces);
        let parts: Vec<(f64, f64)> = places
            .par_iter()
            .zip(&truth)
            .map_init(
                || (Scratch::default(), vec![0f32; pieces * 3 * CUBIC]),
                |(scratch, cubics), (place, truth)| {
                    sums.cubics(&Square::point(*place), scratch, |_, found| cubics.copy_from_slice(found));
                    let largest_w = (4.0 - place.length_squared()).max(0.0).sqrt();
                    let mut parts = (0.0, 0.0);
                    let largest = largest_of(truth);
                    for (w, truth) in fine.iter().zip(truth).filter(|(w, _)| **w <= largest_w) {
                        for (channel, truth) in truth.iter().enumerate() {
                            let value = evaluate(cubics, pieces, channel, *w);
                            let size = truth.hypot(FAINT * largest[channel]).hypot(dark[channel]);
                            if size > 0.0 {
                                parts.0 += f64::from((value - truth) / size).powi(2);
                                parts.1 += 1.0;
                            }
                        }
                    }
                    parts
                },
            )
            .collect();
        let lit: Vec<f64> =
            parts.iter().filter(|p| p.1 > 0.0).map(|(error, energy)| error / energy).collect();
        (lit.iter().sum::<f64>() / lit.len().max(1) as f64).sqrt()
    };
    for pieces in 1..=MOST_PIECES {
        let error = error_of(pieces);
        if error <= settings.cubic_error {
            return Ok((pieces, error));
        }
    }
    Err(Error::failed(
        format!("{MOST_PIECES} cubics do not hold the colours of so high a surface"),
        [Remedy::LargerTolerance, Remedy::SpectralMethod],
    ))
}

/// Places that the cubics are judged at: the brightest ones, which of a grating are few, and others evenly spread.
fn judged(reader: &SpectraReader, spectrum: &DirectionWavelengths) -> Vec<DVec2> {
    /// Candidates, on a spiral of equal areas, and how many of them are chosen for their light and for their place.
    const CANDIDATES: usize = 3000;
    const BRIGHT: usize = 100;
    const SPREAD: usize = 100;
    const GOLDEN_ANGLE: f64 = 2.399_963;
    let place = |i: usize| {
        let radius = LARGEST_W * ((i as f64 + 0.5) / CANDIDATES as f64).sqrt();
        DVec2::from_angle(GOLDEN_ANGLE * i as f64) * radius
    };
    let middle = Sums::at(reader, spectrum, vec![0.7 * LARGEST_W]);
    let mut candidates: Vec<(f32, DVec2)> = (0..CANDIDATES)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, i| (middle.colours(place(i), scratch)[0][1], place(i)))
        .collect();
    let spread: Vec<DVec2> =
        candidates.iter().step_by(CANDIDATES / SPREAD).map(|(_, place)| *place).collect();
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    candidates.iter().take(BRIGHT).map(|(_, place)| *place).chain(spread).collect()
}

/// A channel at |w| from [piece][channel][power].
fn evaluate(cubics: &[f32], pieces: usize, channel: usize, w: f64) -> f32 {
    let place = w / LARGEST_W * pieces as f64;
    let piece = (place as usize).min(pieces - 1);
    let t = (2.0 * (place - piece as f64) - 1.0) as f32;
    let c = &cubics[(piece * 3 + channel) * CUBIC..][..CUBIC];
    c[0] + t * (c[1] + t * (c[2] + t * c[3]))
}
