//! Colours that are distinguishable with any colour vision.

/// Opaque sRGB colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color(pub [u8; 3]);

impl Color {
    /// Returns the colour in the form of SVG: `#rrggbb`.
    pub fn hex(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// Colour of text and frames.
pub const INK: Color = Color([0x22, 0x26, 0x2b]);
/// Colour of captions and ticks.
pub const QUIET: Color = Color([0x5a, 0x62, 0x6b]);
/// Colour of grid lines.
pub const FAINT: Color = Color([0xe3, 0xe6, 0xea]);
/// Colour of pages.
pub const PAPER: Color = Color([0xff, 0xff, 0xff]);

/// Colours of series, in their order of use: those of Okabe and Ito (*Color Universal Design*, 2008), without yellow, which is too faint on
/// white.
pub const SERIES: [Color; 6] = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY];
/// Blue of [`SERIES`].
pub const BLUE: Color = Color([0x00, 0x72, 0xb2]);
/// Vermilion of [`SERIES`].
pub const VERMILION: Color = Color([0xd5, 0x5e, 0x00]);
/// Green of [`SERIES`].
pub const GREEN: Color = Color([0x00, 0x9e, 0x73]);
/// Purple of [`SERIES`].
pub const PURPLE: Color = Color([0xcc, 0x79, 0xa7]);
/// Orange of [`SERIES`].
pub const ORANGE: Color = Color([0xe6, 0x9f, 0x00]);
/// Sky blue of [`SERIES`].
pub const SKY: Color = Color([0x56, 0xb4, 0xe9]);

/// Colours of paper and letters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Theme {
    /// Dark letters on white.
    #[default]
    Light,
    /// Light letters on a dark ground, for slides and screens.
    Dark,
}

impl Theme {
    /// Returns the colour that takes the place of `color`, which is one of the palette's, on this ground.
    pub fn shown(self, color: Color) -> Color {
        /// Blue that is as far from the dark ground as the palette's is from white.
        const LIGHT_BLUE: Color = Color([0x4d, 0xa6, 0xe0]);
        match (self, color) {
            (Self::Light, color) => color,
            (Self::Dark, INK) => Color([0xe8, 0xea, 0xed]),
            (Self::Dark, QUIET) => Color([0xb0, 0xb7, 0xbf]),
            (Self::Dark, FAINT) => Color([0x3a, 0x40, 0x47]),
            (Self::Dark, PAPER) => Color([0x1b, 0x1e, 0x22]),
            (Self::Dark, BLUE) => LIGHT_BLUE,
            (Self::Dark, color) => color,
        }
    }
}

/// Map from values to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorMap {
    /// Perceptually even from dark violet to yellow (van der Walt and Smith, matplotlib, CC0).
    Viridis,
    /// Perceptually even from black to pale yellow (same source): nothing is black.
    Magma,
    /// From blue through white to red (Brewer's RdBu, reversed): for differences, whose 0 is in the middle.
    Difference,
}

impl ColorMap {
    /// Returns colours at equal distances from the lowest value to the highest.
    fn anchors(self) -> [u32; 11] {
        match self {
            Self::Viridis => [
                0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70, 0x7ad151,
                0xbddf26, 0xfde725,
            ],
            Self::Magma => [
                0x000004, 0x140e36, 0x3b0f70, 0x641a80, 0x8c2981, 0xb73779, 0xde4968, 0xf7705c, 0xfe9f6d,
                0xfecf92, 0xfcfdbf,
            ],
            Self::Difference => [
                0x053061, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582, 0xd6604d,
                0xb2182b, 0x67001f,
            ],
        }
    }

    /// Returns the colour at `share` of the way, 0 … 1, clamped to the ends.
    pub fn at(self, share: f64) -> Color {
        let anchors = self.anchors();
        let place = share.clamp(0.0, 1.0) * (anchors.len() - 1) as f64;
        let place = if place.is_finite() { place } else { 0.0 };
        let below = (place as usize).min(anchors.len() - 2);
        let part = place - below as f64;
        let channel = |anchor: u32, shift: u32| f64::from((anchor >> shift) & 0xff);
        Color([16, 8, 0].map(|shift| {
            let (a, b) = (channel(anchors[below], shift), channel(anchors[below + 1], shift));
            (a + (b - a) * part).round() as u8
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_begin_and_end_at_their_ends_and_keep_there() {
        assert_eq!(ColorMap::Viridis.at(0.0).hex(), "#440154");
        assert_eq!(ColorMap::Viridis.at(1.0).hex(), "#fde725");
        assert_eq!(ColorMap::Viridis.at(7.0), ColorMap::Viridis.at(1.0));
        assert_eq!(ColorMap::Magma.at(f64::NAN), ColorMap::Magma.at(0.0));
        assert_eq!(ColorMap::Difference.at(0.5).hex(), "#f7f7f7");
    }

    #[test]
    fn the_maps_of_values_grow_lighter_all_the_way() {
        let light =
            |c: Color| 0.2126 * f64::from(c.0[0]) + 0.7152 * f64::from(c.0[1]) + 0.0722 * f64::from(c.0[2]);
        for map in [ColorMap::Viridis, ColorMap::Magma] {
            let lights: Vec<f64> = (0..=100).map(|i| light(map.at(f64::from(i) / 100.0))).collect();
            assert!(lights.windows(2).all(|w| w[1] >= w[0] - 0.5), "{map:?}");
        }
    }
}
