//! A tolerance and its shares: the allowed error of each approximation, and the measurement behind each share.
//!
//! Errors of different parts are independent, so their squares add up. The squares of the shares of one method sum to at most 1.

use crate::filter::ERROR_OF_ONE_SAMPLE;
use serde::{Deserialize, Serialize};

/// Answer to which a tolerance applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Single directions, each relative to its value, at single wavelengths too (RMS over directions); of a colour table, all of them together
    /// (relative L2).
    #[default]
    Directions,
    /// The colours of a picture: relative L2 of linear RGB over the covered pixels, and RMS of the relative errors of single pixels.
    Picture,
}

/// Question for a budget.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Question {
    /// Answer to which the tolerance applies.
    pub purpose: Purpose,
    /// True for finite gratings, whose colours may come from a few orders.
    pub is_grating: bool,
    /// True if pixels average over footprints that are long beside the blur of a single reading of a table.
    pub has_long_footprints: bool,
}

/// Tolerance and its shares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorBudget {
    /// Relative error that the user accepts.
    pub tolerance: f64,
    /// Shares of one window and of finite gratings.
    pub window: WindowBudget,
    /// Shares of the mean over coherence areas.
    pub mean: MeanBudget,
}

/// Relative errors allowed to the parts of a sum over wavelengths and terms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WindowBudget {
    /// Error of a single wavelength of a single direction for an error of 1 of the answer. Spectra do not depend on it.
    #[serde(skip)]
    pub gain: f64,
    /// Interpolation of the spectra between texels: an intensity error, RMS over single directions and wavelengths.
    pub interpolation: f64,
    /// Truncation and rounding of the expansion together, likewise.
    pub expansion: f64,
    /// Sum over the wavelengths of a colour. Spectra do not depend on it.
    #[serde(skip)]
    pub wavelengths: f64,
}

/// Relative errors allowed to the parts of a colour table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeanBudget {
    /// Series of the orders in z, RMS over orders.
    pub series: f64,
    /// Interpolation between texels.
    pub reading: f64,
    /// Factor on the error of a single reading, because pixels average it over orders and along footprints. It is smaller for a surface of
    /// few orders.
    pub averaging: f64,
    /// The same factor for a table that would take too much room.
    pub most_averaging: f64,
    /// Colours over |w| by a few numbers.
    pub basis: f64,
    /// Number of places in a pixel whose errors over |w| are independent.
    pub places: usize,
    /// Sum over the wavelengths of a colour.
    pub wavelengths: f64,
    /// Aliases of single directions on the CPU, relative to the brightest: a colour a thousand times as dark keeps the tolerance.
    pub aliases: f64,
    /// Colours of one sample of a picture, whose taps are fewer because several samples are averaged.
    pub one_sample: f64,
}

/// Share of an error budget in reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Part of the computation.
    pub part: &'static str,
    /// Allowed error, relative to the answer.
    pub allowed: f64,
    /// Measurement behind the share.
    pub reason: &'static str,
}

/// Ratio of the relative intensity error of single dark directions to the amplitude error: 2√ln(1/floor) with the floor at a thousandth of the
/// local mean, because intensities of speckle are distributed exponentially.
pub const SPECKLE: f64 = 2.0 * 2.628;

/// Gain of pictures: their colours average the errors of many wavelengths. What remains coherent in the brightest pixels, which decide the L2
/// error, is an intensity error of twice the amplitude error.
const PICTURE_GAIN: f64 = SPECKLE / 2.0;

/// Ratio of the error of linear interpolation midway between texels to its RMS: (1/8)/√(1/120). The one bright pixel of a picture may lie
/// midway.
const MIDWAY: f64 = 1.369;

impl ErrorBudget {
    /// Shares out `tolerance` for the answers of `question`.
    pub fn new(tolerance: f64, question: Question) -> Self {
        Self {
            tolerance,
            window: WindowBudget::new(tolerance, question),
            mean: MeanBudget::new(tolerance, question),
        }
    }

    /// Shares out `tolerance` for single directions.
    pub fn of_directions(tolerance: f64) -> Self {
        Self::new(tolerance, Question::default())
    }
}

impl WindowBudget {
    fn new(tolerance: f64, question: Question) -> Self {
        let gain = match question.purpose {
            Purpose::Picture if !question.is_grating => PICTURE_GAIN,
            _ => 1.0,
        };
        // Reading costs the most to lower and gets the most; wavelengths cost the logarithm of their share.
        let [interpolation, expansion, wavelengths] = match question.purpose {
            Purpose::Directions => [0.7, 0.35, 0.6],
            // Near the specular direction the error of reading is common to all directions.
            Purpose::Picture => [0.5 / MIDWAY, 0.5, 0.48],
        };
        Self {
            gain,
            interpolation: gain * interpolation * tolerance,
            expansion: gain * expansion * tolerance,
            wavelengths: wavelengths * tolerance,
        }
    }

    /// Returns the shares for reports.
    pub fn shares(&self) -> [Share; 3] {
        [
            Share {
                part: "truncation and rounding",
                allowed: self.expansion / self.gain,
                reason: "audited against the transform of the exact phase",
            },
            Share {
                part: "reading between texels",
                allowed: self.interpolation / self.gain,
                reason: "by the transform of the kernel; costs the most to lower",
            },
            Share {
                part: "wavelengths of a colour",
                allowed: self.wavelengths,
                reason: "by the quadrature rule; costs the logarithm of its share",
            },
        ]
    }
}

impl MeanBudget {
    fn new(tolerance: f64, question: Question) -> Self {
        /// Share of the series. All pixels with light of one order share its error, which no average reduces: a plate of *Xenopeltis* under
        /// 0.023 erred by 0.043. Series converge fast, so that a small share costs four terms at most.
        const SERIES: f64 = 0.25;
        let [reading, basis, wavelengths] = match question.purpose {
            Purpose::Directions => [0.7, 0.3, 0.4],
            // On the snake, the interpolation error is 0.006 times the squared ratio of spacing and blur, and 0.046 at single points: long
            // footprints average it.
            Purpose::Picture if question.has_long_footprints => [0.5, 0.72, 0.48],
            // A picture of few places may show places with a larger error than most.
            Purpose::Picture => [0.5, 0.3, 0.48],
        };
        let gain = WindowBudget::new(tolerance, question).gain;
        let [averaging, most_averaging] = match question.purpose {
            Purpose::Directions => [1.0, 1.0],
            Purpose::Picture if question.has_long_footprints => [3.9 * gain, 3.9 * gain],
            Purpose::Picture => [1.5 * gain, 2.5 * gain],
        };
        Self {
            series: SERIES * tolerance,
            reading: reading * tolerance,
            averaging,
            most_averaging,
            basis: basis * tolerance,
            places: if question.has_long_footprints { 16 } else { 1 },
            wavelengths: wavelengths * tolerance,
            aliases: 1e-3 * tolerance,
            one_sample: tolerance.max(ERROR_OF_ONE_SAMPLE),
        }
    }

    /// Returns the shares for reports.
    pub fn shares(&self) -> [Share; 4] {
        [
            Share {
                part: "series of the orders",
                allowed: self.series,
                reason: "audited between the nodes in z; all pixels of an order share it",
            },
            Share {
                part: "reading between texels",
                allowed: self.reading,
                reason: "by the blur of the finest level; pixels average it",
            },
            Share {
                part: "colours over w",
                allowed: self.basis,
                reason: "measured at places that the basis was not made for",
            },
            Share {
                part: "wavelengths of a colour",
                allowed: self.wavelengths,
                reason: "by the quadrature rule; costs the logarithm of its share",
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_squares_of_the_shares_make_one_at_the_most() {
        for purpose in [Purpose::Directions, Purpose::Picture] {
            for has_long_footprints in [false, true] {
                let question = Question { purpose, has_long_footprints, ..Question::default() };
                let budget = ErrorBudget::new(1e-2, question);
                let total = |shares: &[Share]| shares.iter().map(|s| (s.allowed / 1e-2).powi(2)).sum::<f64>();
                assert!(total(&budget.window.shares()) <= 1.0, "{budget:?}");
                // The series' error counts against the worst direction and not the sum.
                assert!(total(&budget.mean.shares()[1..]) <= 1.001, "{budget:?}");
            }
        }
    }
}
