//! The tiles that a picture is drawn in: each takes so little time that others get the device in between.

use std::ops::Range;

/// Long enough to keep a device busy, short enough for a hand not to feel it \[ms\].
const LONGEST: f64 = 30.0;
/// Sides of a tile are multiples of it, so that no group of neighbours is torn apart. A pixel may take milliseconds on a software device.
const STEP: u32 = 4;
/// Each tile counts so much less for the next than for the one before: some fifty tiles of background, as beside each row of a mesh, change little, and one that was
/// held up by something else is soon forgotten.
const FADING: f64 = 0.99;
/// What an iteration of a loop takes at least on a software device \[ms\]: a part of what is usual, because few pixels take all of theirs.
const AN_ITERATION: f64 = 1e-6;
/// How much more than the picture on average its dearest part costs, at most.
const DEAREST: f64 = 4.0;

/// Tiles of a picture from the upper left, row after row.
pub(super) struct Tiles {
    size: [u32; 2],
    // Upper left corner of the next tile.
    corner: [u32; 2],
    // Pixels of the next tile, about, and of the last.
    pixels: f64,
    last: f64,
    // Milliseconds a pixel on average, where that is known.
    known: Option<f64>,
    // Milliseconds a pixel in the dearest of the last tiles.
    dearest: f64,
    // What a pixel is taken to take at least until the picture is known.
    least: f64,
}

impl Tiles {
    /// For a picture of `size` whose pixels took `known` milliseconds on average when it was drawn last, and of which a pixel may take `iterations` of a
    /// loop.
    pub(super) fn new(size: [u32; 2], known: Option<f64>, iterations: usize) -> Self {
        let least = if known.is_none() { iterations as f64 * AN_ITERATION } else { 0.0 };
        let smallest = f64::from(STEP * STEP);
        let pixels = known.map_or(smallest, |time| LONGEST / (DEAREST * time).max(1e-9));
        Self { size, corner: [0; 2], pixels, last: 0.0, known, dearest: 0.0, least }
    }

    /// The part of the picture that the tiles so far cover.
    pub(super) fn drawn(&self) -> f64 {
        let [width, height] = self.size.map(f64::from);
        let [left, top] = self.corner.map(f64::from);
        if width * height > 0.0 { (top + left / width) / height } else { 1.0 }
    }

    /// Columns and rows of the next tile.
    pub(super) fn next_tile(&mut self) -> Option<[Range<u32>; 2]> {
        let ([width, height], [left, top]) = (self.size, self.corner);
        if top >= height || width == 0 {
            return None;
        }
        let steps = |pixels: f64, across: u32| {
            let steps = pixels / f64::from(across) / f64::from(STEP);
            (steps.clamp(1.0, 1e6) as u32) * STEP
        };
        let rows = if left == 0 { steps(self.pixels, width) } else { STEP };
        let columns = if rows > STEP { width } else { steps(self.pixels, STEP) };
        let [right, bottom] = [(left + columns).min(width), (top + rows).min(height)];
        self.corner = if right == width { [0, bottom] } else { [right, top] };
        self.last = f64::from(right - left) * f64::from(bottom - top);
        Some([left..right, top..bottom])
    }

    /// Fits the size of the next tile to the time that the last one took \[ms\].
    pub(super) fn took(&mut self, milliseconds: f64) {
        self.dearest = (milliseconds / self.last).max(FADING * self.dearest);
        let fitting = LONGEST / self.dearest.max(self.least).max(1e-9);
        self.pixels = match self.known {
            Some(average) => fitting.min(LONGEST / (DEAREST * average).max(1e-9)),
            // What comes may be dearer than what was.
            None => fitting.min(2.0 * self.last),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tiles of a picture whose pixels cost what `cost` says \[ms\], and the time of each.
    fn draw(
        size: [u32; 2],
        known: Option<f64>,
        cost: impl Fn(u32, u32) -> f64,
    ) -> Vec<([Range<u32>; 2], f64)> {
        let mut tiles = Tiles::new(size, known, 0);
        let mut drawn = Vec::new();
        while let Some([columns, rows]) = tiles.next_tile() {
            let time = rows
                .clone()
                .flat_map(|y| columns.clone().map(move |x| (x, y)))
                .map(|(x, y)| cost(x, y))
                .sum();
            tiles.took(time);
            drawn.push(([columns, rows], time));
        }
        drawn
    }

    #[test]
    fn tiles_cover_every_pixel_once_and_begin_and_end_in_the_corners() {
        for size in [[1, 1], [640, 480], [333, 77], [16, 900]] {
            for cost in [1e-9, 1e-4, 1.0] {
                for known in [None, Some(cost)] {
                    let drawn = draw(size, known, |_, _| cost);
                    let mut covered = vec![0; (size[0] * size[1]) as usize];
                    for ([columns, rows], _) in &drawn {
                        assert_eq!((columns.start % STEP, rows.start % STEP), (0, 0));
                        for y in rows.clone() {
                            columns.clone().for_each(|x| covered[(y * size[0] + x) as usize] += 1);
                        }
                    }
                    assert!(covered.iter().all(|&times| times == 1), "{size:?} {cost}");
                    let starts = |t: &&([Range<u32>; 2], f64)| t.0.iter().all(|range| range.start == 0);
                    let ends = |t: &&([Range<u32>; 2], f64)| t.0[0].end == size[0] && t.0[1].end == size[1];
                    assert_eq!(drawn.iter().filter(starts).count(), 1);
                    assert_eq!(drawn.iter().filter(ends).count(), 1);
                }
            }
        }
    }

    #[test]
    fn a_picture_that_was_drawn_before_has_no_long_tiles_below_its_background() {
        let size = [1280, 800];
        let cost = |_, row: u32| if row < 300 { 1e-7 } else { 0.002 };
        let drawn = draw(size, None, cost);
        let pixels = f64::from(size[0] * size[1]);
        let average = drawn.iter().map(|t| t.1).sum::<f64>() / pixels;
        let again = draw(size, Some(average), cost);
        let longest = again.iter().map(|t| t.1).fold(0.0, f64::max);
        assert!(longest <= 2.0 * LONGEST, "{longest} ms");
        assert!(again.len() < 400, "{} tiles", again.len());
    }

    #[test]
    fn background_beside_a_dear_mesh_makes_long_tiles_no_more_than_a_few_times() {
        // A pixel of the mesh takes 2 ms: a tile of the smallest size is all that fits.
        let cost = |x: u32, y: u32| if (300..600).contains(&x) && y > 40 { 2.0 } else { 1e-4 };
        let drawn = draw([1024, 160], None, cost);
        let long = drawn.iter().filter(|tile| tile.1 > 3.0 * LONGEST).count();
        assert!(long <= 2, "{long} of {} tiles take longer than {} ms", drawn.len(), 3.0 * LONGEST);
        let of_mesh = 300 * 119 / (STEP * STEP) as usize;
        assert!(drawn.len() < 3 * of_mesh, "{} tiles, {of_mesh} of the mesh", drawn.len());
        // Where it is known that pixels may be dear, no tile of background grows much.
        let mut tiles = Tiles::new([1024, 160], None, 100_000);
        while let Some([columns, rows]) = tiles.next_tile() {
            let pixels = columns.len() * rows.len();
            assert!(pixels <= 400, "{pixels} pixels");
            tiles.took(1e-4 * pixels as f64);
        }
    }
}
