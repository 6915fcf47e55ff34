//! Perceived difference of two displayed colours: CIEDE2000 (CIE 142-2001), in the form of Sharma, Wu and Dalal, *The CIEDE2000
//! color-difference formula* (Color Research and Application 30, 2005), with all parametric factors 1.

use glam::{DMat3, DVec3};

/// Returns CIE L\*a\*b\* of a linear sRGB colour, under the white of sRGB, D65.
pub fn lab(rgb: DVec3) -> DVec3 {
    /// Matrix from linear sRGB to XYZ (IEC 61966-2-1), row by row.
    const XYZ: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
    let matrix = DMat3::from_cols_array_2d(&XYZ).transpose();
    lab_under(matrix * rgb, matrix * DVec3::ONE)
}

/// Returns CIE L\*a\*b\* of a colour in XYZ under a `white`.
pub fn lab_under(xyz: DVec3, white: DVec3) -> DVec3 {
    /// Ratio below which the cube root is continued by a line (CIE 15:2004, 8.2.1).
    const LINEAR: f64 = 216.0 / 24389.0;
    let root = |t: f64| if t > LINEAR { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
    let [x, y, z] = (xyz / white).to_array().map(root);
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Returns ΔE₀₀ of two colours in L\*a\*b\*. A difference of about 1 is just noticeable.
pub fn ciede2000(one: DVec3, other: DVec3) -> f64 {
    let [(l1, c1, h1), (l2, c2, h2)] = adapted(one, other);
    let lightness = l2 - l1;
    let chroma = c2 - c1;
    // Hue differences are taken the short way around; grey has none.
    let is_grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if is_grey => 0.0,
        turn if turn > 180.0 => turn - 360.0,
        turn if turn < -180.0 => turn + 360.0,
        turn => turn,
    };
    let hue = 2.0 * (c1 * c2).sqrt() * (turn / 2.0).to_radians().sin();
    let mean_hue = match h1 + h2 {
        sum if is_grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => sum / 2.0,
        sum if sum < 360.0 => (sum + 360.0) / 2.0,
        sum => (sum - 360.0) / 2.0,
    };
    let mean_chroma = (c1 + c2) / 2.0;
    let cosine = |factor: f64, shift: f64| (factor * mean_hue + shift).to_radians().cos();
    let weight = 1.0 - 0.17 * cosine(1.0, -30.0) + 0.24 * cosine(2.0, 0.0) + 0.32 * cosine(3.0, 6.0)
        - 0.20 * cosine(4.0, -63.0);
    let from_middle = ((l1 + l2) / 2.0 - 50.0).powi(2);
    let scaled = DVec3::new(
        lightness / (1.0 + 0.015 * from_middle / (20.0 + from_middle).sqrt()),
        chroma / (1.0 + 0.045 * mean_chroma),
        hue / (1.0 + 0.015 * mean_chroma * weight),
    );
    // Chroma and hue of blues depend on each other.
    let rotation = 60.0 * (-((mean_hue - 275.0) / 25.0).powi(2)).exp();
    let coupling = -2.0 * saturation(mean_chroma) * rotation.to_radians().sin();
    (scaled.length_squared() + coupling * scaled.y * scaled.z).max(0.0).sqrt()
}

/// Returns √(C⁷/(C⁷ + 25⁷)).
fn saturation(chroma: f64) -> f64 {
    let seventh = chroma.powi(7);
    (seventh / (seventh + 25f64.powi(7))).sqrt()
}

/// Returns L, C′ and h′ \[degrees, 0 to 360\] of both colours: a\* is stretched near grey.
fn adapted(one: DVec3, other: DVec3) -> [(f64, f64, f64); 2] {
    let mean_chroma = (one.y.hypot(one.z) + other.y.hypot(other.z)) / 2.0;
    let stretch = 1.0 + 0.5 * (1.0 - saturation(mean_chroma));
    [one, other].map(|color| {
        let a = color.y * stretch;
        let hue = if a == 0.0 && color.z == 0.0 { 0.0 } else { color.z.atan2(a).to_degrees() };
        (color.x, a.hypot(color.z), hue.rem_euclid(360.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// L\*, a\*, b\* of two colours and ΔE₀₀, from table 1 of Sharma, Wu and Dalal.
    const PAIRS: [[f64; 7]; 34] = [
        [50.0, 2.6772, -79.7751, 50.0, 0.0, -82.7485, 2.0425],
        [50.0, 3.1571, -77.2803, 50.0, 0.0, -82.7485, 2.8615],
        [50.0, 2.8361, -74.0200, 50.0, 0.0, -82.7485, 3.4412],
        [50.0, -1.3802, -84.2814, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -1.1848, -84.8006, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -0.9009, -85.5211, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, 0.0, 0.0, 50.0, -1.0, 2.0, 2.3669],
        [50.0, -1.0, 2.0, 50.0, 0.0, 0.0, 2.3669],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0009, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0010, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0011, 7.2195],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0012, 7.2195],
        [50.0, -0.0010, 2.4900, 50.0, 0.0009, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0010, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0011, -2.4900, 4.7461],
        [50.0, 2.5, 0.0, 50.0, 0.0, -2.5, 4.3065],
        [50.0, 2.5, 0.0, 73.0, 25.0, -18.0, 27.1492],
        [50.0, 2.5, 0.0, 61.0, -5.0, 29.0, 22.8977],
        [50.0, 2.5, 0.0, 56.0, -27.0, -3.0, 31.9030],
        [50.0, 2.5, 0.0, 58.0, 24.0, 15.0, 19.4535],
        [50.0, 2.5, 0.0, 50.0, 3.1736, 0.5854, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 3.2972, 0.0, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 1.8634, 0.5757, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 3.2592, 0.3350, 1.0000],
        [60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644],
        [63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.2630],
        [61.2901, 3.7196, -5.3901, 61.4292, 2.2480, -4.9620, 1.8731],
        [35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645],
        [22.7233, 20.0904, -46.6940, 23.0331, 14.9730, -42.5619, 2.0373],
        [36.4612, 47.8580, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146],
        [90.8027, -2.0831, 1.4410, 91.1528, -1.6435, 0.0447, 1.4441],
        [90.9257, -0.5406, -0.9208, 88.6381, -0.8985, -0.7239, 1.5381],
        [6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377],
        [2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082],
    ];

    #[test]
    fn differences_are_those_of_the_published_pairs_both_ways() {
        for [l1, a1, b1, l2, a2, b2, published] in PAIRS {
            let (one, other) = (DVec3::new(l1, a1, b1), DVec3::new(l2, a2, b2));
            for found in [ciede2000(one, other), ciede2000(other, one)] {
                assert!((found - published).abs() < 6e-5, "{one} {other}: {found} {published}");
            }
            assert_eq!(ciede2000(one, one), 0.0);
        }
    }

    #[test]
    fn white_black_and_the_primaries_have_their_place() {
        assert!((lab(DVec3::ONE) - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-9);
        assert!(lab(DVec3::ZERO).length() < 1e-9);
        // sRGB red, green and blue (Lindbloom's calculator, D65).
        for (rgb, expected) in [
            (DVec3::X, DVec3::new(53.24, 80.09, 67.20)),
            (DVec3::Y, DVec3::new(87.73, -86.18, 83.18)),
            (DVec3::Z, DVec3::new(32.30, 79.19, -107.86)),
        ] {
            assert!((lab(rgb) - expected).length() < 0.05, "{rgb}: {}", lab(rgb));
        }
    }
}
