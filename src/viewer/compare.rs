//! What stands right of the movable split.

use super::settings::Optics;
use crate::expansion::Basis;
use crate::setup::Method;

/// What the picture is compared with, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compare {
    /// The picture alone.
    #[default]
    Alone,
    /// The same scene by another setting.
    Beside,
    /// How far the picture is from that setting, relative, in false colour.
    Error,
}

impl Compare {
    /// All, in the order of the key that steps through them.
    pub const ALL: [Self; 3] = [Self::Alone, Self::Beside, Self::Error];

    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone => "alone",
            Self::Beside => "split",
            Self::Error => "error",
        }
    }

    /// The next one.
    pub fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % Self::ALL.len()]
    }
}

/// The setting to compare with until the user names another: ten times as strict, by the basis that can be.
pub fn strict(own: &Optics) -> Optics {
    optimal(own, (own.tolerance / 10.0).max(1e-4))
}

/// What is drawn while something moves: ten times as loose.
pub fn coarse(own: &Optics) -> Optics {
    optimal(own, loose(own))
}

/// By how much looser the sum over wavelengths is while something moves, before layers go too; `None` where it is loose enough.
pub fn looser_colours(own: &Optics) -> Option<f64> {
    Some(loose(own) / own.tolerance).filter(|&factor| factor > 1.5)
}

fn loose(own: &Optics) -> f64 {
    (own.tolerance * 10.0).clamp(1e-1, 3e-1)
}

fn optimal(own: &Optics, tolerance: f64) -> Optics {
    Optics {
        method: Method::Spectral,
        windows: own.windows,
        basis: Basis::Optimal,
        tolerance,
        terms: None,
        wavelengths: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_steps_through_all_and_comes_back() {
        let steps: Vec<_> = std::iter::successors(Some(Compare::Alone), |c| Some(c.next())).take(4).collect();
        assert_eq!(steps, [Compare::Alone, Compare::Beside, Compare::Error, Compare::Alone]);
    }

    #[test]
    fn the_judge_is_stricter_and_the_moving_picture_looser() {
        for tolerance in [1e-3, 1e-2, 5e-2] {
            let own = Optics { basis: Basis::Taylor, terms: Some(5), ..optimal(tolerance) };
            assert!(strict(&own).tolerance < tolerance && coarse(&own).tolerance > tolerance);
            assert_eq!(strict(&own).terms, None);
        }
    }
}
