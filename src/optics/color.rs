//! From tristimulus values to linear sRGB, and from there to a display.

use glam::{DMat3, DVec3};

/// Relative luminance of linear sRGB, the second row of the matrix to XYZ (IEC 61966-2-1).
pub const LUMINANCE: DVec3 = DVec3::new(0.212_639_005_871_510, 0.715_168_678_767_756, 0.072_192_315_360_734);

/// XYZ (Y = 1 for a perfect mirror image of the light) to linear sRGB: the inverse of the matrix that the primaries
/// and the D65 white (0.3127, 0.3290) of IEC 61966-2-1 define. Components may be negative: diffraction colours leave
/// the gamut, and floats keep them.
pub fn xyz_to_linear_srgb(xyz: DVec3) -> DVec3 {
    DMat3::from_cols(
        DVec3::new(3.240_969_941_904_521, -0.969_243_636_280_880, 0.055_630_079_696_994),
        DVec3::new(-1.537_383_177_570_094, 1.875_967_501_507_721, -0.203_976_958_888_977),
        DVec3::new(-0.498_610_760_293_003, 0.041_555_057_407_176, 1.056_971_514_242_879),
    ) * xyz
}

/// Moves a linear colour into the display's gamut along the line to the grey of its own luminance, so that hue stays
/// and only saturation gives way; luminance is limited to 0 … 1. The twin of `map_to_gamut` in `color.glsl`.
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

/// The sRGB transfer function (IEC 61966-2-1) from linear 0 … 1 to code value 0 … 1.
pub fn srgb_transfer(linear: f64) -> f64 {
    // The two segments meet here by the standard's definition.
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// What a display shows as black: half of the first 8-bit code above zero, in linear light. Errors below it cannot be
/// seen, so it is the floor of every relative error.
pub const DISPLAY_BLACK: f64 = 0.5 / 255.0 / 12.92;

/// The 8-bit display value of a linear colour at `exposure` stops: exposure, gamut, transfer, rounding.
pub fn display(rgb: DVec3, exposure: f64) -> [u8; 3] {
    code(map_to_gamut(rgb * exposure.exp2()))
}

/// The same where `rgb` covers the part `coverage` (0 … 1) of a pixel and `background`, linear sRGB that no exposure changes, the rest. What is
/// seen of both is mixed in linear light, as it reaches a sensor. The twin of `display.frag`.
pub fn display_over(rgb: DVec3, exposure: f64, coverage: f64, background: DVec3) -> [u8; 3] {
    code(map_to_gamut(background).lerp(map_to_gamut(rgb * exposure.exp2()), coverage))
}

/// The 8-bit code of a linear colour within 0 … 1.
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
}
