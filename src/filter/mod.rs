//! Averages over the directions that a pixel sees: the Gaussian ellipse of (u, v), and the taps that stand for it.

mod ellipse;
mod taps;

pub use ellipse::{Covariance, FootprintSizes};
pub use taps::{
    ERROR_ACROSS, ERROR_ALONG, ERROR_OF_ONE_SAMPLE, Levels, MOST_OF_ROW, MOST_TAPS, Tap, Taps, least_own,
};
