//! Questions about scales that are probably wrong by a factor of a thousand.

/// Plausible distances of samples \[m\]: from a tenth of an atom to more than any optical profiler's.
const SPACINGS: (f64, f64) = (5e-12, 20e-6);
/// Largest plausible range of heights \[m\].
const HIGHEST: f64 = 1e-3;
/// Plausible ranges of heights relative to the longer side of the patch: from a polished mirror's to a deep trench's.
const RELIEFS: (f64, f64) = (1e-7, 3.0);

/// Part of the codes of an image below which their full height is questioned: 12-bit codes in 16 bits use a sixteenth.
const NARROW: f64 = 1.0 / 8.0;

/// Who says how high a surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightSource {
    /// The file.
    File,
    /// The user.
    Given,
}

/// Returns a question about each scale that no surface of a microscope has: `size` samples, `spacing` apart \[m\], heights over a range of
/// `range` \[m\] by `scale`.
pub fn questions(size: [usize; 2], spacing: [f64; 2], range: f64, scale: HeightSource) -> Vec<String> {
    let mut questions = Vec::new();
    if spacing.iter().any(|d| !(SPACINGS.0..=SPACINGS.1).contains(d)) {
        let [x, y] = spacing.map(in_words);
        questions.push(format!(
            "samples lie {x} x {y} apart: is the lateral unit right? (a pixel size overrides it)"
        ));
    }
    let side = (size[0] as f64 * spacing[0]).max(size[1] as f64 * spacing[1]);
    let relief = range / side;
    if range > HIGHEST || range > 0.0 && !(RELIEFS.0..=RELIEFS.1).contains(&relief) {
        let (range, side) = (in_words(range), in_words(side));
        let question = match scale {
            HeightSource::File => "is their unit right? (a full height overrides it)",
            HeightSource::Given => "is the full height right that was given?",
        };
        questions.push(format!("heights span {range} over a patch of {side}: {question}"));
    }
    questions
}

/// Returns a question about codes that use a small part of their range: `shares` of the `largest` code, of a surface that is not flat.
pub fn narrow_codes(shares: &[f64], largest: f64) -> Option<String> {
    let low = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let high = shares.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let is_narrow = high > low && high - low < NARROW;
    is_narrow.then(|| {
        let [low, high] = [low, high].map(|share| (share * largest).round());
        format!(
            "its codes go from {low} to {high} of {largest}: is the full height that of the code {largest}?"
        )
    })
}

/// Returns a length in a suitable unit.
pub fn in_words(metres: f64) -> String {
    let (factor, unit) = match metres.abs() {
        x if x < 1e-9 => (1e12, "pm"),
        x if x < 1e-6 => (1e9, "nm"),
        x if x < 1e-3 => (1e6, "um"),
        x if x < 1.0 => (1e3, "mm"),
        _ => (1.0, "m"),
    };
    format!("{:.4} {unit}", metres * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scans_of_every_kind_raise_no_question() {
        for (count, spacing, range) in [
            (256, 40e-9, 125e-9),
            (512, 2e-9, 26e-9),
            (300, 267e-9, 7e-6),
            (563, 3.5e-6, 1.5e-6),
            (918, 2.58e-6, 132e-6),
            (512, 20e-12, 0.2e-9),
            (7, 1e-6, 50e-9),
            (1, 90e-9, 100e-9),
            (512, 97.66e-9, 434.7e-9),
            (4096, 1e-6, 1e-9),
        ] {
            assert_eq!(
                questions([count, count], [spacing; 2], range, HeightSource::File),
                Vec::<String>::new(),
                "{spacing} {range}"
            );
        }
        assert!(
            questions([9, 9], [1e-8; 2], 0.0, HeightSource::Given).is_empty(),
            "a flat field is no question of units"
        );
    }

    #[test]
    fn a_factor_of_a_thousand_is_questioned() {
        for (count, spacing, range) in [
            (256, 40e-6, 125e-9),
            (256, 40e-9, 125e-6),
            (256, 4e-12, 1e-9),
            (3, 4e-6, 15.0),
            (512, 97.66e-6, 434.7e-9),
            (512, 97.66e-9, 434.7e-6),
            (500, 1e-6, 1e-12),
        ] {
            assert!(
                !questions([count, count], [spacing; 2], range, HeightSource::File).is_empty(),
                "{spacing} {range}"
            );
        }
        let said = questions([3, 4], [4.1133e-6, 1.4e-6], 15.0, HeightSource::File).concat();
        assert!(said.contains("15.0000 m") && said.contains("12.3399 um"), "{said}");
    }

    #[test]
    fn codes_of_a_small_part_of_their_range_are_questioned() {
        let said = narrow_codes(&[0.0, f64::NAN, 4095.0 / 65_535.0], 65_535.0).unwrap();
        assert!(said.contains("from 0 to 4095 of 65535"), "{said}");
        assert!(narrow_codes(&[0.1, 0.6], 255.0).is_none() && narrow_codes(&[0.1; 2], 255.0).is_none());
    }

    #[test]
    fn a_height_that_a_user_gives_is_questioned_as_such() {
        let said = questions([512; 2], [97.66e-9; 2], 434.7e-6, HeightSource::Given).concat();
        assert!(said.contains("434.7000 um") && said.contains("full height"), "{said}");
        assert!(questions([512; 2], [97.66e-9; 2], 434.7e-9, HeightSource::Given).is_empty());
    }
}
