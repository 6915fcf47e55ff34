//! The comparison: what is shown right of the movable split.

use super::settings::OpticsSettings;
use crate::expansion::Basis;
use crate::setup::Method;

/// How the picture is compared with another setting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compare {
    /// Not at all.
    #[default]
    Alone,
    /// The scene drawn with the other setting is shown beside it.
    Beside,
    /// The relative difference from the other setting is shown in false colour.
    Error,
}

impl Compare {
    /// All, in the order in which a key steps through them.
    pub const ALL: [Self; 3] = [Self::Alone, Self::Beside, Self::Error];

    /// The name on the panel.
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone => "off",
            Self::Beside => "split",
            Self::Error => "error",
        }
    }

    /// The next one.
    pub fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % Self::ALL.len()]
    }
}

/// The setting to compare with until the user changes it: a tenth of the tolerance, by the most accurate basis.
pub fn strict(own: &OpticsSettings) -> OpticsSettings {
    optimal(own, (own.tolerance / 10.0).max(1e-4))
}

/// The setting for the first colours of a picture; `None` if its own is as quick to prepare.
pub fn preview(own: &OpticsSettings, of_mean: bool) -> Option<OpticsSettings> {
    /// Enough to recognise the colours, and in a small part of the usual time.
    const TOLERANCE: f64 = 0.3;
    let method = if of_mean { Method::Table } else { Method::Spectral };
    (own.tolerance < TOLERANCE).then(|| OpticsSettings { method, ..optimal(own, TOLERANCE) })
}

/// The setting for moving pictures: ten times the tolerance.
pub fn coarse(own: &OpticsSettings) -> OpticsSettings {
    optimal(own, loose(own))
}

/// The factor on the tolerance of the sum over wavelengths in moving pictures; `None` if the setting is loose already.
pub fn looser_colours(own: &OpticsSettings) -> Option<f64> {
    Some(loose(own) / own.tolerance).filter(|&factor| factor > 1.5)
}

fn loose(own: &OpticsSettings) -> f64 {
    (own.tolerance * 10.0).clamp(1e-1, 3e-1)
}

fn optimal(own: &OpticsSettings, tolerance: f64) -> OpticsSettings {
    OpticsSettings {
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
    use crate::optics::coherence::Windows;

    #[test]
    fn the_key_steps_through_all_and_comes_back() {
        let steps: Vec<_> = std::iter::successors(Some(Compare::Alone), |c| Some(c.next())).take(4).collect();
        assert_eq!(steps, [Compare::Alone, Compare::Beside, Compare::Error, Compare::Alone]);
    }

    #[test]
    fn the_compared_setting_is_stricter_and_the_moving_picture_looser() {
        for tolerance in [1e-3, 1e-2, 5e-2] {
            let own = OpticsSettings {
                method: Method::Table,
                windows: Windows::ONE,
                basis: Basis::Taylor,
                tolerance,
                terms: Some(5),
                wavelengths: None,
            };
            assert!(strict(&own).tolerance < tolerance && coarse(&own).tolerance > tolerance);
            let first = preview(&own, true).unwrap();
            assert!(first.tolerance >= coarse(&own).tolerance && first.method == Method::Table);
            assert_eq!(preview(&first, true), None);
            assert_eq!((strict(&own).terms, strict(&own).windows), (None, own.windows));
        }
    }
}
