//! Comparison of the picture with another setting, shown right of the movable split.

use crate::filter::FootprintSizes;
use crate::optics::coherence::Windows;
use crate::settings::{LEAST_TABLE_TOLERANCE, Optics};
use crate::spectra::amplitude::expansion::Basis;

/// Mode of the comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compare {
    /// No comparison.
    #[default]
    Alone,
    /// The scene drawn with the other setting, shown right of the split.
    Beside,
    /// The difference from the other setting, shown in false colour.
    Difference(Metric),
}

/// Measure of the difference of two pictures, pixel by pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// |a − b|/|b| of linear radiance.
    Relative,
    /// CIEDE2000 of the displayed pictures.
    ColorDifference,
    /// ꟻLIP of the displayed pictures (Andersson et al. 2020).
    Flip,
}

impl Metric {
    /// Returns the labels along the colour scale, at equal distances.
    pub fn ticks(self) -> &'static [&'static str] {
        match self {
            Self::Relative => &["0.01 %", "0.1 %", "1 %", "10 %", "100 %"],
            Self::ColorDifference => &["0.1", "1: noticeable", "10", "100"],
            Self::Flip => &["0", "0.25", "0.5", "0.75", "1"],
        }
    }

    /// Returns the position of `value` on the colour scale, 0 to 1.
    pub fn place(self, value: f64) -> f64 {
        let logarithmic =
            |low: f64, decades: f64| ((value.max(1e-20) / low).log10() / decades).clamp(0.0, 1.0);
        match self {
            Self::Relative => logarithmic(1e-4, 4.0),
            Self::ColorDifference => logarithmic(0.1, 3.0),
            Self::Flip => value.clamp(0.0, 1.0),
        }
    }

    /// Returns the value for a whole picture as text, with the name of the measure.
    pub fn describe(self, total: f64) -> String {
        match self {
            Self::Relative => format!("relative L2 {:.3} %", total * 1e2),
            Self::ColorDifference => format!("mean ΔE00 {total:.3}"),
            Self::Flip => format!("mean FLIP {total:.4}"),
        }
    }
}

/// Side of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The user's picture.
    Own,
    /// The picture it is compared with.
    Other,
}

impl Compare {
    /// All modes, in the order in which a key steps through them.
    pub const ALL: [Self; 5] = [
        Self::Alone,
        Self::Beside,
        Self::Difference(Metric::Relative),
        Self::Difference(Metric::ColorDifference),
        Self::Difference(Metric::Flip),
    ];

    /// Returns the name on the panel.
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone => "off",
            Self::Beside => "split",
            Self::Difference(Metric::Relative) => "error",
            Self::Difference(Metric::ColorDifference) => "ΔE",
            Self::Difference(Metric::Flip) => "FLIP",
        }
    }

    /// Returns the next mode.
    pub fn next(self) -> Self {
        let place = Self::ALL.iter().position(|mode| *mode == self).unwrap_or(0);
        Self::ALL[(place + 1) % Self::ALL.len()]
    }
}

/// Returns the setting to compare with until the user changes it. For a colour table this is a table of three tenths of
/// the tolerance: one of a tenth takes a gigabyte for the default scene. For one window it is a tenth of the tolerance
/// with the most accurate basis.
pub fn strict(optics: &Optics) -> Optics {
    let (share, least) =
        if optics.windows == Windows::All { (0.3, LEAST_TABLE_TOLERANCE) } else { (0.1, 1e-4) };
    optimal(optics, (share * optics.tolerance).max(least))
}

/// Footprints assumed for the first colours of a picture, whatever its view: four times the blur by the coherence of
/// sunlight. No picture is drawn to measure footprints, which takes 2.4 s for the default scene on two slow cores of
/// lavapipe, and baking takes 1.5 s instead of 2.2 s (2026-11-27).
pub const PREVIEWED: FootprintSizes = FootprintSizes { shorter: 0.016, longer: 0.06 };

/// Returns the setting for the first colours of a picture; `None` if the given one is as fast to prepare.
pub fn preview(optics: &Optics) -> Option<Optics> {
    /// Accurate enough to recognise the colours, in a small fraction of the usual time.
    const TOLERANCE: f64 = 0.3;
    (optics.tolerance < TOLERANCE).then(|| optimal(optics, TOLERANCE))
}

fn optimal(optics: &Optics, tolerance: f64) -> Optics {
    Optics { basis: Basis::Optimal, tolerance, terms: None, wavelengths: None, ..optics.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_steps_through_all_and_comes_back() {
        let steps: Vec<_> = std::iter::successors(Some(Compare::Alone), |c| Some(c.next())).take(5).collect();
        assert_eq!(steps, Compare::ALL);
        assert_eq!(steps[4].next(), Compare::Alone);
    }

    #[test]
    fn scales_have_their_ticks_at_their_values() {
        for (metric, values) in [
            (Metric::Relative, &[1e-4, 1e-3, 1e-2, 1e-1, 1.0][..]),
            (Metric::ColorDifference, &[0.1, 1.0, 10.0, 100.0]),
            (Metric::Flip, &[0.0, 0.25, 0.5, 0.75, 1.0]),
        ] {
            assert_eq!(metric.ticks().len(), values.len());
            for (i, value) in values.iter().enumerate() {
                let even = i as f64 / (values.len() - 1) as f64;
                assert!((metric.place(*value) - even).abs() < 1e-9, "{metric:?} {value}");
            }
            assert_eq!([metric.place(0.0), metric.place(1e9)], [0.0, 1.0]);
        }
    }

    #[test]
    fn the_compared_setting_is_stricter_and_the_preview_looser() {
        for tolerance in [1e-3, 1e-2, 5e-2] {
            let optics = Optics {
                windows: Windows::ONE,
                basis: Basis::Taylor,
                tolerance,
                terms: Some(5),
                ..Optics::default()
            };
            assert!(strict(&optics).tolerance < tolerance);
            let first = preview(&optics).unwrap();
            assert!(first.tolerance > tolerance);
            assert_eq!(preview(&first), None);
            assert_eq!((strict(&optics).terms, strict(&optics).windows), (None, optics.windows));
        }
    }
}
