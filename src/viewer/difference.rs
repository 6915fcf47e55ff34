//! Difference of two pictures in false colour: relative error, colour difference, or the error seen by an observer who
//! flips between them.

use super::compare::Metric;
use crate::figure::palette::ColorMap;
use crate::measure::error::{PixelErrors, flip_map};
use crate::optics::color::DISPLAY_BLACK;
use crate::optics::color_difference::{ciede2000, lab};
use crate::render::frame::Shown;
use crate::render::renderer::Picture;
use glam::DVec3;
use rayon::prelude::*;

/// Difference in false colour.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceMap {
    /// Pixels, sRGB-encoded and opaque, row by row from the top.
    pub pixels: Vec<[u8; 4]>,
    /// Relative L2 error, mean ΔE₀₀ of the covered pixels, or mean ꟻLIP error.
    pub total: f64,
}

/// Maps the difference of `judged` from `judge`, both displayed with the settings `shown`, within their first `size`
/// pixels. Pixels that are uncovered in `judge` are shown as it displays them.
pub fn map(metric: Metric, judged: &Picture, judge: &Picture, shown: Shown, size: [u32; 2]) -> DifferenceMap {
    let [judged, judge] = [judged, judge].map(|picture| PicturePart::of(picture, size));
    let values: Vec<f64> = match metric {
        Metric::Relative => {
            let floor = DISPLAY_BLACK / shown.exposure.exp2();
            let error = |(a, b): (&DVec3, &DVec3)| (*a - *b).length() / b.length().max(floor);
            judged.radiance.par_iter().zip(&judge.radiance).map(error).collect()
        }
        Metric::ColorDifference => {
            let seen = |rgb: &DVec3| lab(shown.tone.map(*rgb * shown.exposure.exp2()));
            let difference = |(a, b): (&DVec3, &DVec3)| ciede2000(seen(a), seen(b));
            judged.radiance.par_iter().zip(&judge.radiance).map(difference).collect()
        }
        Metric::Flip => flip_map(&judged.display, &judge.display, size).into_iter().map(f64::from).collect(),
    };
    let covered = |i: &usize| judge.covered[*i];
    let mean = |indices: &mut dyn Iterator<Item = usize>| {
        let (sum, count) = indices.fold((0.0, 0usize), |(sum, count), i| (sum + values[i], count + 1));
        sum / count.max(1) as f64
    };
    let total = match metric {
        Metric::Relative => PixelErrors::of(&judged.radiance, &judge.radiance, shown.exposure).relative_l2,
        Metric::ColorDifference => mean(&mut (0..values.len()).filter(covered)),
        Metric::Flip => mean(&mut (0..values.len())),
    };
    let color = |i: usize| {
        let [r, g, b] = ColorMap::Viridis.at(metric.place(values[i])).0;
        if judge.covered[i] { [r, g, b, 255] } else { judge.display[i] }
    };
    DifferenceMap { pixels: (0..values.len()).map(color).collect(), total }
}

/// First columns and rows of a picture.
struct PicturePart {
    // Linear radiance; zero at uncovered pixels.
    radiance: Vec<DVec3>,
    covered: Vec<bool>,
    display: Vec<[u8; 4]>,
}

impl PicturePart {
    fn of(picture: &Picture, [width, height]: [u32; 2]) -> Self {
        let [stride, rows] = picture.size.map(|n| n as usize);
        let (width, height) = (width as usize, (height as usize).min(rows));
        let indices = (0..height).flat_map(|row| (0..width).map(move |column| row * stride + column));
        let mut part = Self { radiance: Vec::new(), covered: Vec::new(), display: Vec::new() };
        for i in indices {
            let [r, g, b, alpha] = picture.radiance[i].map(f64::from);
            part.radiance.push(DVec3::new(r, g, b));
            part.covered.push(alpha > 0.0);
            part.display.push(picture.display[i]);
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::color::{Tone, display};

    const SHOWN: Shown = Shown { exposure: 1.0, tone: Tone::None, background: DVec3::ZERO };

    /// Returns a larger picture whose first 4 × 3 pixels have an uncovered first row.
    fn picture(rgb: DVec3) -> Picture {
        let size = [6u32, 5];
        let pixel = |i: usize| {
            if i < 6 { [0.0; 4] } else { rgb.as_vec3().extend(1.0).to_array() }
        };
        let radiance: Vec<[f32; 4]> = (0..30).map(pixel).collect();
        let shown = |p: &[f32; 4]| {
            let [r, g, b] = display(DVec3::new(p[0].into(), p[1].into(), p[2].into()), SHOWN.exposure);
            [r, g, b, 255]
        };
        let display = radiance.iter().map(shown).collect();
        Picture { size, radiance, display, is_opaque: false }
    }

    #[test]
    fn a_known_difference_has_its_number_and_its_colour_where_the_mesh_covers() {
        let (exact, brighter) = (DVec3::new(0.1, 0.2, 0.05), DVec3::new(0.11, 0.22, 0.055));
        let [judge, judged] = [exact, brighter].map(picture);
        let of = |metric| map(metric, &judged, &judge, SHOWN, [4, 3]);
        let relative = of(Metric::Relative);
        assert!((relative.total - 0.1).abs() < 1e-6, "{}", relative.total);
        let expected = ColorMap::Viridis.at(Metric::Relative.place(0.1)).0;
        assert_eq!(relative.pixels.len(), 12);
        assert_eq!(relative.pixels[5][..3], expected);
        assert_eq!(relative.pixels[2], [0, 0, 0, 255], "background");
        let seen = [exact, brighter].map(|rgb| lab(rgb * 2.0));
        let difference = of(Metric::ColorDifference).total;
        assert!((difference - ciede2000(seen[0], seen[1])).abs() < 1e-5 && difference > 1.0, "{difference}");
        assert!(of(Metric::Flip).total > 1e-3);
        for metric in [Metric::Relative, Metric::ColorDifference, Metric::Flip] {
            assert_eq!(map(metric, &judge, &judge, SHOWN, [4, 3]).total, 0.0);
        }
    }
}
