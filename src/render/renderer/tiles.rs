//! Pieces of a picture, each short enough to give the device to other work in between.

use std::ops::Range;

/// Target time of a piece \[ms\]. Two pieces are in flight, so that other work waits twice as long: no perceptible delay.
const LONGEST: f64 = 15.0;
/// Sides of a tile are multiples of this, so that no 2 × 2 quad is split. A pixel may take milliseconds on a software
/// device.
const STEP: u32 = 4;
/// Decay of the weight of former tiles, per tile: some hundred tiles of background, as between two rows of a mesh, matter
/// little.
const FADING: f64 = 0.995;
/// Least time of a loop iteration on a software device \[ms\]: a fraction of the usual time, because few pixels reach
/// the maximum of iterations.
const ITERATION_TIME: f64 = 1e-6;
/// Pixels of the first tile of a picture like the last, which may have shown less of the mesh.
const FIRST_KNOWN: u32 = 256;
/// Largest ratio of the pixels of a tile to those of the tile before in a picture of unknown cost: the next tile may be more
/// expensive.
const UNKNOWN_GROWTH: f64 = 2.0;
/// The same in a picture like the last.
const KNOWN_GROWTH: f64 = 4.0;
/// Assumed ratio of the most expensive part of a picture to its average.
const MOST_EXPENSIVE: f64 = 4.0;

/// Part of a picture that is drawn in one submission.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    /// Columns and rows.
    pub tile: [Range<u32>; 2],
    /// Parts of the sum over wavelengths.
    pub parts: Range<u32>,
    /// Number of pixels; a part of a sum counts as its fraction.
    pub pixels: f64,
}

impl Piece {
    /// Returns true if this is the first piece of a picture.
    pub(super) fn is_first(&self) -> bool {
        self.parts.start == 0 && self.tile.iter().all(|range| range.start == 0)
    }

    /// Returns true if this is the last piece of a picture of `size` pixels whose sum has `parts` parts.
    pub(super) fn is_last(&self, size: [u32; 2], parts: u32) -> bool {
        self.parts.end == parts && self.tile.iter().zip(size).all(|(range, end)| range.end == end)
    }
}

/// Tiles of a picture from the upper left, row after row. Tiles that may take long are drawn in parts of their sums.
pub(super) struct Tiles {
    size: [u32; 2],
    // Parts of the sum of a pixel.
    parts: u32,
    // Upper left corner of the next tile.
    corner: [u32; 2],
    // Tile with parts left to draw, and the first of these parts.
    begun: Option<([Range<u32>; 2], u32)>,
    // Pixels drawn so far; a part of a sum counts as its fraction.
    drawn: f64,
    // Approximate pixels of the next tile, and pixels of the last.
    pixels: f64,
    last: f64,
    // Mean milliseconds per pixel, if known from the last picture.
    known: Option<f64>,
    // The two largest of the decaying milliseconds per pixel of former tiles, without the time of a submission. The
    // largest may be an outlier: the device does other work, or compiles a shader. Six windows that open at once need 1.2
    // to 1.5 times the processor time if it counts.
    most_expensive: [f64; 2],
    // Milliseconds per pixel of the last tile.
    latest: f64,
    // Milliseconds of the shortest piece: an upper bound of the time of a submission without pixels.
    shortest: f64,
    // Lower bound of the milliseconds per pixel until tiles are measured.
    least: f64,
}

impl Tiles {
    /// Makes the tiles of a picture of `size` pixels. `known`: mean milliseconds per pixel when it was drawn last. A
    /// pixel takes up to `iterations` of a loop, in `parts` parts.
    pub(super) fn new(size: [u32; 2], known: Option<f64>, iterations: usize, parts: u32) -> Self {
        let least = if known.is_none() { iterations as f64 * ITERATION_TIME } else { 0.0 };
        Self {
            size,
            parts,
            corner: [0; 2],
            begun: None,
            drawn: 0.0,
            pixels: f64::from(if known.is_some() { FIRST_KNOWN } else { STEP * STEP }),
            last: 0.0,
            known,
            most_expensive: [0.0; 2],
            latest: 0.0,
            shortest: f64::INFINITY,
            least,
        }
    }

    /// Returns the fraction of the picture that is drawn.
    pub(super) fn drawn(&self) -> f64 {
        self.drawn / (f64::from(self.size[0]) * f64::from(self.size[1])).max(1.0)
    }

    /// Returns the next piece to draw.
    pub(super) fn next_piece(&mut self) -> Option<Piece> {
        let (tile, first) = match self.begun.take() {
            Some(begun) => begun,
            None => (self.next_tile()?, 0),
        };
        let end = self.parts.min(first + self.parts_together());
        if end < self.parts {
            self.begun = Some((tile.clone(), end));
        }
        let pixels = self.last * f64::from(end - first) / f64::from(self.parts);
        self.drawn += pixels;
        Some(Piece { tile, parts: first..end, pixels })
    }

    /// Returns the number of parts of a tile to draw together: few enough to meet the target time even if the tile is
    /// more expensive than the last ones.
    fn parts_together(&self) -> u32 {
        if self.latest == 0.0 {
            // No tile is measured yet.
            return 1;
        }
        let of_part = self.expected() * self.last / f64::from(self.parts);
        (LONGEST / MOST_EXPENSIVE / of_part).clamp(1.0, f64::from(self.parts)) as u32
    }

    /// Returns the columns and rows of the next tile.
    fn next_tile(&mut self) -> Option<[Range<u32>; 2]> {
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

    /// Returns the milliseconds per pixel to expect of the next tile.
    fn expected(&self) -> f64 {
        self.most_expensive[1].max(self.latest).max(self.least).max(1e-9)
    }

    /// Adjusts the size of the following tiles to the time of a finished piece \[ms\] of so many `pixels`.
    pub(super) fn took(&mut self, pixels: f64, milliseconds: f64) {
        self.latest = milliseconds / pixels;
        self.shortest = self.shortest.min(milliseconds);
        let of_pixel = (milliseconds - self.shortest) / pixels;
        let [first, second] = self.most_expensive.map(|former| FADING * former);
        self.most_expensive = [first.max(of_pixel), second.max(first.min(of_pixel))];
        let fitting = LONGEST / self.expected();
        self.pixels = match self.known {
            Some(average) => {
                fitting.min(LONGEST / (MOST_EXPENSIVE * average).max(1e-9)).min(KNOWN_GROWTH * self.last)
            }
            None => fitting.min(UNKNOWN_GROWTH * self.last),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the tiles of a picture whose pixels take `cost` \[ms\], and the time of each.
    fn draw(
        size: [u32; 2],
        known: Option<f64>,
        cost: impl Fn(u32, u32) -> f64,
    ) -> Vec<([Range<u32>; 2], f64)> {
        let mut tiles = Tiles::new(size, known, 0, 1);
        let mut drawn = Vec::new();
        // The time of a piece is known after the next one was submitted.
        let mut before = None;
        while let Some(Piece { tile: [columns, rows], pixels, .. }) = tiles.next_piece() {
            let time = rows
                .clone()
                .flat_map(|y| columns.clone().map(move |x| (x, y)))
                .map(|(x, y)| cost(x, y))
                .sum();
            if let Some((pixels, time)) = before.replace((pixels, time)) {
                tiles.took(pixels, time);
            }
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
        assert!(again.len() < 800, "{} tiles", again.len());
    }

    #[test]
    fn a_mesh_that_comes_into_view_makes_no_long_tile_after_a_cheap_picture() {
        // The last picture was background alone.
        let drawn = draw([640, 480], Some(1e-7), |_, _| 0.05);
        let longest = drawn.iter().map(|t| t.1).fold(0.0, f64::max);
        assert!(longest <= 2.0 * LONGEST, "{longest} ms");
    }

    #[test]
    fn background_beside_an_expensive_mesh_makes_long_tiles_no_more_than_a_few_times() {
        // A pixel of the mesh takes 2 ms, so that only a tile of the smallest size fits.
        let cost = |x: u32, y: u32| if (300..600).contains(&x) && y > 40 { 2.0 } else { 1e-4 };
        let drawn = draw([1024, 160], None, cost);
        // The piece after the first one of the mesh is submitted before the time of that one is known.
        let long = drawn.iter().filter(|tile| tile.1 > 3.0 * LONGEST).count();
        assert!(long <= 4, "{long} of {} tiles take longer than {} ms", drawn.len(), 3.0 * LONGEST);
        let of_mesh = 300 * 119 / (STEP * STEP) as usize;
        assert!(drawn.len() < 3 * of_mesh, "{} tiles, {of_mesh} of the mesh", drawn.len());
        // If pixels may be expensive, no tile of background grows much.
        let mut tiles = Tiles::new([1024, 160], None, 100_000, 1);
        while let Some(Piece { tile: [columns, rows], .. }) = tiles.next_piece() {
            let pixels = columns.len() * rows.len();
            assert!(pixels <= 400, "{pixels} pixels");
            tiles.took(pixels as f64, 1e-4 * pixels as f64);
        }
    }

    #[test]
    fn tiles_grow_soon_after_one_that_compiles_a_shader_or_waits_for_other_work() {
        for (known, slow) in [(None, 0), (Some(0.01), 0), (None, 3), (Some(0.01), 3)] {
            let mut tiles = Tiles::new([640, 480], known, 0, 1);
            let (mut count, mut before) = (0, None);
            while let Some(Piece { pixels, .. }) = tiles.next_piece() {
                // A submission takes a millisecond.
                let time = 0.01 * pixels + if count == slow { 3000.0 } else { 1.0 };
                if let Some((pixels, time)) = before.replace((pixels, time)) {
                    tiles.took(pixels, time);
                }
                count += 1;
            }
            // A tile of 15 ms has at most 1500 pixels, a quarter of that where the picture is known to take 0.01 ms a pixel.
            let least = if known.is_some() { 4 } else { 1 } * 640 * 480 / 1500;
            assert!(count < 2 * least, "{known:?}, slow piece {slow}: {count} tiles, {least} at least");
        }
    }

    #[test]
    fn tiles_that_may_take_long_are_drawn_in_parts_of_their_sums() {
        /// Parts of the sum.
        const PARTS: u32 = 6;
        let size = [64, 32];
        // A pixel of the right half takes so long that only tiles of the smallest size are drawn there.
        let cost = |x: u32| if x >= 32 { 2.0 } else { 1e-4 };
        let mut tiles = Tiles::new(size, None, 100_000, PARTS);
        let mut drawn = vec![0; (size[0] * size[1] * PARTS) as usize];
        let (mut firsts, mut lasts, mut together, mut long) = (0, 0, 0, 0);
        while let Some(piece) = tiles.next_piece() {
            let Piece { tile: [columns, rows], parts, pixels } = piece.clone();
            (firsts, lasts) =
                (firsts + u32::from(piece.is_first()), lasts + u32::from(piece.is_last(size, PARTS)));
            assert_eq!(firsts, 1, "the first piece comes first");
            together += u32::from(parts.len() > 1);
            let mut time = 0.0;
            for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
                for part in parts.clone() {
                    drawn[((y * size[0] + x) * PARTS + part) as usize] += 1;
                    time += cost(x) / f64::from(PARTS);
                }
            }
            tiles.took(pixels, time);
            long += u32::from(time > LONGEST);
        }
        // A part of a smallest tile of the right half takes 5.3 ms; only the first tile that reaches this half takes
        // long.
        assert!(long <= PARTS, "{long} long pieces");
        assert!(drawn.iter().all(|&times| times == 1), "each part of each pixel once");
        assert_eq!(lasts, 1);
        assert!(together > 0, "every part is drawn alone");
    }
}
