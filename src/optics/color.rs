//! Conversion from tristimulus values to linear sRGB, and from there to a display.

use crate::error::{Error, Result};
use glam::{DMat3, DVec3};

/// Relative luminance of linear sRGB, the second row of the matrix to XYZ (IEC 61966-2-1).
pub const LUMINANCE: DVec3 = DVec3::new(0.212_639_005_871_510, 0.715_168_678_767_756, 0.072_192_315_360_734);

/// Converts XYZ (Y = 1 for a perfect mirror image of the light) to linear sRGB: the inverse of the matrix that the primaries and the D65
/// white (0.3127, 0.3290) of IEC 61966-2-1 define. Components may be negative: diffraction colours leave the gamut, and floats keep them.
pub fn xyz_to_linear_srgb(xyz: DVec3) -> DVec3 {
    DMat3::from_cols(
        DVec3::new(3.240_969_941_904_521, -0.969_243_636_280_880, 0.055_630_079_696_994),
        DVec3::new(-1.537_383_177_570_094, 1.875_967_501_507_721, -0.203_976_958_888_977),
        DVec3::new(-0.498_610_760_293_003, 0.041_555_057_407_176, 1.056_971_514_242_879),
    ) * xyz
}

/// Adapts a colour in XYZ from a viewer's `white` to D65: the linear Bradford transform (ICC.1:2022, annex E).
pub fn adapted_to_d65(xyz: DVec3, white: DVec3) -> DVec3 {
    let to_cones = DMat3::from_cols(
        DVec3::new(0.8951, -0.7502, 0.0389),
        DVec3::new(0.2664, 1.7135, -0.0685),
        DVec3::new(-0.1614, 0.0367, 1.0296),
    );
    // (0.3127, 0.3290), as in IEC 61966-2-1.
    let d65 = DVec3::new(0.3127, 0.3290, 1.0 - 0.3127 - 0.3290) / 0.3290;
    let gain = (to_cones * d65) / (to_cones * white);
    to_cones.inverse() * (to_cones * xyz * gain)
}

/// Moves a linear colour into the display's gamut along the line to the grey of the same luminance: hue stays, saturation is reduced.
/// Luminance is limited to 0 … 1. Twin of `map_to_gamut` in `color.glsl`.
pub fn map_to_gamut(rgb: DVec3) -> DVec3 {
    let grey = LUMINANCE.dot(rgb).clamp(0.0, 1.0);
    let away = rgb - DVec3::splat(grey);
    let reach = (0..3).fold(1.0f64, |reach, i| {
        if away[i] > 0.0 {
            reach.min((1.0 - grey) / away[i])
        } else if away[i] < 0.0 {
            reach.min(grey / -away[i])
        } else {
            reach
        }
    });
    (DVec3::splat(grey) + away * reach).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Tone curve for a display that is less bright and less saturated than the colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Unchanged colours up to the edge of the gamut: [`map_to_gamut`].
    #[default]
    None,
    /// Soft roll-off of highlights to white: [`neutral`].
    Neutral,
}

impl Tone {
    /// All tones.
    pub const ALL: [Self; 2] = [Self::None, Self::Neutral];

    /// Returns the name in options.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Neutral => "neutral",
        }
    }

    /// Returns the tone of that name.
    ///
    /// # Errors
    /// Another name; lists the known ones.
    pub fn from_name(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|tone| tone.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(" or ");
            Error::usage(format!("there is no tone `{name}`"), format!("give {names}"))
        })
    }

    /// Maps an exposed linear colour to 0 … 1.
    pub fn map(self, rgb: DVec3) -> DVec3 {
        match self {
            Self::None => map_to_gamut(rgb),
            Self::Neutral => neutral(rgb),
        }
    }
}

/// Applies the Khronos PBR Neutral Tone Mapper (Khronos Group, 2024) after [`without_negatives`]. Colours are kept, less the part that
/// Fresnel's equations add to a dielectric of index 1.5; only colours with a bright component go to white, and hue stays. Twin of `neutral`
/// in `color.glsl`.
pub fn neutral(rgb: DVec3) -> DVec3 {
    /// Reflectance at normal incidence of a dielectric, which is subtracted.
    const FRESNEL: f64 = 0.04;
    /// Brightest component from which highlights are compressed.
    const START: f64 = 0.8 - FRESNEL;
    /// Rate at which highlights lose their saturation.
    const DESATURATION: f64 = 0.15;
    /// Range between the start and white.
    const ROOM: f64 = 1.0 - START;
    let rgb = without_negatives(rgb);
    let least = rgb.min_element();
    // A parabola from 0 that joins the constant offset smoothly at twice the reflectance.
    let offset = if least < 2.0 * FRESNEL { least - least * least / (4.0 * FRESNEL) } else { FRESNEL };
    let rgb = (rgb - offset).max(DVec3::ZERO);
    let peak = rgb.max_element();
    if peak < START {
        return rgb;
    }
    let compressed = 1.0 - ROOM * ROOM / (peak + ROOM - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    (rgb * (compressed / peak)).lerp(DVec3::splat(compressed), white)
}

/// Moves a linear colour along the line to the grey of the same luminance until no component is negative. Twin of `without_negatives` in
/// `color.glsl`.
pub fn without_negatives(rgb: DVec3) -> DVec3 {
    let least = rgb.min_element();
    if least >= 0.0 {
        return rgb;
    }
    let grey = LUMINANCE.dot(rgb).max(0.0);
    let reach = grey / (grey - least);
    DVec3::splat(grey).lerp(rgb, reach).max(DVec3::ZERO)
}

/// Applies the sRGB transfer function (IEC 61966-2-1), from linear 0 … 1 to code value 0 … 1.
pub fn srgb_transfer(linear: f64) -> f64 {
    // The two segments meet here by the standard's definition.
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Smallest visible value on a display: half of the first 8-bit code above zero, in linear light. Errors below it cannot be seen, so it is
/// the floor of every relative error.
pub const DISPLAY_BLACK: f64 = 0.5 / 255.0 / 12.92;

/// Returns the 8-bit display value of a linear colour at `exposure` stops: exposure, gamut, transfer, rounding.
pub fn display(rgb: DVec3, exposure: f64) -> [u8; 3] {
    code(map_to_gamut(rgb * exposure.exp2()))
}

/// Returns the 8-bit display value by `tone` of a pixel that `rgb` covers by the part `coverage` (0 … 1). The rest is `background`, linear
/// sRGB that neither exposure nor tone changes. Both are mixed in linear light, as on a sensor. Twin of `display.frag`.
pub fn display_over(rgb: DVec3, exposure: f64, tone: Tone, coverage: f64, background: DVec3) -> [u8; 3] {
    code(map_to_gamut(background).lerp(tone.map(rgb * exposure.exp2()), coverage))
}

/// Returns the 8-bit code of a linear colour within 0 … 1.
fn code(linear: DVec3) -> [u8; 3] {
    [0, 1, 2].map(|i| (srgb_transfer(linear[i]) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_white_of_the_standard_is_white_and_its_luminance_one() {
        // x = 0.3127, y = 0.3290
        let white = DVec3::new(0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290);
        assert!((xyz_to_linear_srgb(white) - DVec3::ONE).length() < 1e-9);
        assert!((LUMINANCE.dot(DVec3::ONE) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn gamut_mapping_keeps_what_is_inside_and_the_luminance_of_what_is_not() {
        let inside = DVec3::new(0.2, 0.5, 0.9);
        assert!((map_to_gamut(inside) - inside).length() < 1e-15);
        let outside = DVec3::new(-0.1, 0.6, 0.2);
        let mapped = map_to_gamut(outside);
        assert!((LUMINANCE.dot(mapped) - LUMINANCE.dot(outside)).abs() < 1e-12);
        assert!(mapped.min_element() >= 0.0);
        // A per-channel clip would change the hue: here it would leave (0, 0.6, 0.2).
        assert!((mapped - DVec3::new(0.0, 0.6, 0.2)).length() > 0.01);
        assert_eq!(display(DVec3::splat(1e30), 0.0), [255; 3]);
        assert_eq!(display(DVec3::splat(-1.0), 0.0), [0; 3]);
    }

    /// Returns colours of every kind, also outside of the gamut.
    fn colours() -> Vec<DVec3> {
        let steps = [-0.4, 0.0, 0.03, 0.08, 0.3, 0.76, 1.0, 7.0];
        let with = |r, g| steps.map(|b| DVec3::new(r, g, b));
        steps.iter().flat_map(|&r| steps.iter().flat_map(move |&g| with(r, g))).collect()
    }

    #[test]
    fn the_neutral_tone_is_what_its_formula_gives_by_hand() {
        for (rgb, expected) in [
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            // The least component is above 0.08: 0.04 less.
            ([0.5, 0.5, 0.5], [0.46, 0.46, 0.46]),
            ([0.1, 0.3, 0.7], [0.06, 0.26, 0.66]),
            // Below: 0.04 − 6.25 · 0.04² = 0.03 less.
            ([0.04, 0.04, 0.04], [0.01, 0.01, 0.01]),
            ([0.04, 0.24, 0.53], [0.01, 0.21, 0.50]),
            ([0.0, 0.5, 0.75], [0.0, 0.5, 0.75]),
            // 1 − 0.24²/(1.96 − 0.52) = 0.96.
            ([2.0, 2.0, 2.0], [0.96, 0.96, 0.96]),
            // 1 − 0.24²/(4 − 0.52) = 0.983448…, of which 1 − 1/(0.15 · 3.016551… + 1) = 0.311523… is white.
            ([4.0, 0.0, 0.0], [0.983_448_275_862, 0.306_367_415_504, 0.306_367_415_504]),
        ] {
            let found = neutral(rgb.into());
            assert!((found - DVec3::from(expected)).abs().max_element() < 1e-9, "{rgb:?}: {found}");
        }
    }

    #[test]
    fn the_neutral_tone_has_no_step_where_its_pieces_meet() {
        const STEP: f64 = 1e-9;
        let apart = |a: [f64; 3], b: [f64; 3]| (neutral(a.into()) - neutral(b.into())).abs().max_element();
        // Seams of the offset, at 0.08; of the compression, at 0.76 behind the offset; of the gamut.
        assert!(apart([0.08 - STEP, 0.3, 0.5], [0.08 + STEP, 0.3, 0.5]) < 4.0 * STEP);
        assert!(apart([0.0, 0.3, 0.76 - STEP], [0.0, 0.3, 0.76 + STEP]) < 4.0 * STEP);
        assert!(apart([0.2, 0.3, 0.8 - STEP], [0.2, 0.3, 0.8 + STEP]) < 4.0 * STEP);
        assert!(apart([-STEP, 0.3, 0.9], [STEP, 0.3, 0.9]) < 4.0 * STEP);
    }

    #[test]
    fn the_neutral_tone_is_within_the_gamut_and_more_light_is_brighter() {
        for rgb in colours() {
            let mut former = -1.0;
            for stops in -30..30 {
                let shown = neutral(rgb * f64::from(stops).exp2());
                assert!(shown.min_element() >= 0.0 && shown.max_element() <= 1.0, "{rgb}: {shown}");
                let luminance = LUMINANCE.dot(shown);
                assert!(luminance >= former - 1e-12, "{rgb} at {stops} stops: {luminance} after {former}");
                former = luminance;
            }
        }
        assert!((neutral(DVec3::splat(1e30)) - DVec3::ONE).length() < 1e-15);
    }

    #[test]
    fn the_neutral_tone_keeps_hue_and_below_its_start_the_differences_of_components() {
        for rgb in colours() {
            let inside = without_negatives(rgb);
            assert!((LUMINANCE.dot(inside) - LUMINANCE.dot(rgb).max(0.0)).abs() < 1e-12, "{rgb}: {inside}");
            let shown = neutral(rgb);
            // The same ratios of differences of components: (a − b)(b' − c') = (a' − b')(b − c).
            for from in [inside, rgb] {
                let across =
                    (from.x - from.y) * (shown.y - shown.z) - (shown.x - shown.y) * (from.y - from.z);
                assert!(across.abs() < 1e-12, "{rgb} is shown as {shown}");
            }
            if inside.max_element() < 0.76 {
                let lost = inside - shown;
                assert!((lost - lost.x).abs().max_element() < 1e-15, "{rgb} is shown as {shown}");
            }
        }
    }

    #[test]
    fn tones_have_names_and_other_names_are_refused_with_them() {
        for tone in Tone::ALL {
            assert_eq!(Tone::from_name(tone.name()).unwrap(), tone);
        }
        let wrong = Tone::from_name("filmic").unwrap_err().to_string();
        assert!(wrong.contains("`filmic`") && wrong.contains("none or neutral"), "{wrong}");
        assert_eq!(Tone::default().map(DVec3::splat(0.5)), DVec3::splat(0.5));
    }
}
