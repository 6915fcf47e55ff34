//! Choice of the basis of a colour table: the principal components of a sample of the surface's colours, as few as the tolerance allows.

use super::basis::{ColorBasis, MOST_COMPONENTS, MOST_PIECES, PER_TEXEL};
use super::sums::{DirectionWavelengths, NODES, Scratch, Sums, nodes_of_pieces};
use super::{LARGEST_W, TableSettings};
use crate::error::{Error, Remedy, Result};
use crate::optics::color::xyz_to_linear_srgb as linear_srgb;
use crate::optics::spectrum::MIDDLE;
use crate::optics::svd::Svd;
use crate::spectra::power::OrderReader;
use crate::spectra::power::chebyshev::{coefficients_from_values, nodes, polynomials};
use glam::{DMat3, DVec2, DVec3, Vec3, Vec4};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;

/// Number of layers up to which a table has more pieces, so that each needs fewer components and a direction fewer reads: that of two
/// pieces of all components.
const LAYERS: usize = 6;

/// Basis, and the projection of colours on it.
pub struct Projection {
    /// Basis.
    pub basis: ColorBasis,
    /// Relative error of colours: the larger of the RMS of the relative errors of single colours, since most of the colour is in the faint
    /// directions far from the specular one, and of the relative L2 error. For pictures whose pixels average over many places, it is the
    /// error of such averages.
    pub error: f64,
    // `[piece][component][channel]`, over the nodes in the piece.
    from_nodes: Vec<[Vec4; 3]>,
}

impl Projection {
    /// Appends the numbers of a place, `[piece][component]`, to `out`. `values` are those at the nodes, for each channel the pieces and
    /// perhaps padding.
    pub fn project(&self, values: &[Vec4], out: &mut Vec<f32>) {
        let (components, stride) = (self.basis.components, values.len() / 3);
        let each_piece = self.from_nodes.chunks_exact(components).enumerate();
        out.extend(each_piece.flat_map(|(piece, rows)| {
            let of_piece: [Vec4; 3] = std::array::from_fn(|channel| values[channel * stride + piece]);
            rows.iter()
                .map(move |row| row.iter().zip(&of_piece).map(|(row, value)| row.dot(*value)).sum::<f32>())
        }));
    }

    /// Chooses the basis of fewest reads, and then of fewest pieces, whose error the settings allow.
    ///
    /// # Errors
    /// No such basis.
    pub fn choose(
        reader: &OrderReader<'_>,
        spectrum: &DirectionWavelengths,
        settings: &TableSettings,
    ) -> Result<Self> {
        let colours = ColourSamples::new(reader, spectrum, settings);
        let allowed = |projection: &Self| projection.error <= settings.budget.basis;
        let mut least = f64::INFINITY;
        let whole = (1..=MOST_PIECES)
            .map(|pieces| colours.projection(pieces, MOST_COMPONENTS))
            .inspect(|projection| least = least.min(projection.error))
            .find(allowed);
        let whole = whole.ok_or_else(|| {
            Error::limit(
                format!("{MOST_PIECES} cubics do not hold the colours of so high a surface"),
                [
                    Remedy::TimesTolerance(least / settings.budget.basis),
                    Remedy::OneWindow,
                    Remedy::ShorterCoherence,
                ],
            )
        })?;
        let layers = whole.basis.layers().max(LAYERS);
        for components in (PER_TEXEL..MOST_COMPONENTS).step_by(PER_TEXEL) {
            let most = (layers * PER_TEXEL / components).min(MOST_PIECES);
            // Most surfaces need more components; then fewer pieces need not be tried.
            if !allowed(&colours.projection(most, components)) {
                continue;
            }
            if let Some(found) = (1..=most).map(|pieces| colours.projection(pieces, components)).find(allowed)
            {
                return Ok(found);
            }
        }
        Ok(whole)
    }
}

/// Colours of a surface at representative places.
struct ColourSamples {
    // Colours from which bases are made, and others by which they are judged: averages over as many places as in the settings.
    made_for: Vec<PlaceColours>,
    judged: Vec<PlaceColours>,
    // Floor of the size of a colour in its relative error, linear sRGB.
    dark: f64,
}

/// XYZ over |w| at a place, or an average of it over places side by side.
struct PlaceColours {
    // Largest |w| of directions at the place.
    largest_w: f64,
    // Coefficients of Chebyshev polynomials over 0 … 2.
    series: Vec<DVec3>,
    // |w| within the range of directions, and linear sRGB there.
    judged: Vec<(f64, DVec3)>,
    // Largest of these colours.
    largest: f64,
}

/// Floor of the size of a colour, relative to the largest of its place: colours at small |w| are small in pictures, too.
const FAINT: f64 = 0.05;
/// Floor of the size of a colour, relative to the mean over all places of their largest: between the orders of a grating there are only
/// interpolation errors.
const DARK: f64 = 1e-4;
/// Number of |w| at which bases are judged, between the nodes of any pieces.
const BETWEEN: usize = 41;

fn between() -> impl Iterator<Item = f64> {
    (0..BETWEEN).map(|i| LARGEST_W * (i as f64 + 0.37) / BETWEEN as f64)
}

impl ColourSamples {
    fn new(reader: &OrderReader<'_>, spectrum: &DirectionWavelengths, settings: &TableSettings) -> Self {
        /// Additional nodes for the reflectance.
        const MORE: usize = 8;
        let count = reader.series.terms + MORE;
        let sums = Sums::at(reader, spectrum, nodes(count, LARGEST_W));
        let matrix = coefficients_from_values(count);
        let colours =
            |scratch: &mut Scratch, place: &Vec<DVec2>| PlaceColours::of(place, &sums, &matrix, scratch);
        let all = |places: Vec<Vec<DVec2>>| -> Vec<PlaceColours> {
            places.par_iter().map_init(Scratch::default, colours).collect()
        };
        let [made_for, judged] = places(reader, spectrum);
        let rows = |places: Vec<DVec2>| {
            places.into_iter().enumerate().map(|(i, place)| row(i, place, reader, settings))
        };
        let [made_for, judged] = [made_for, judged].map(|places| all(rows(places).collect()));
        let dark = DARK * judged.iter().map(|colour| colour.largest).sum::<f64>() / judged.len() as f64;
        Self { made_for, judged, dark }
    }

    /// Returns the best basis with this number of pieces and components, with its error at the judged places.
    fn projection(&self, pieces: usize, components: usize) -> Projection {
        let count = self.made_for[0].series.len();
        let polynomials: Vec<Vec<f64>> =
            nodes_of_pieces(pieces).into_iter().map(|w| polynomials_at(w, count)).collect();
        let values: Vec<Vec<Vec4>> =
            self.made_for.iter().map(|colour| colour.at_nodes(&polynomials)).collect();
        let mut basis = ColorBasis { pieces, components, cubics: Vec::new() };
        let mut from_nodes = Vec::new();
        for piece in 0..pieces {
            let start = LARGEST_W * piece as f64 / pieces as f64;
            let reached = self.made_for.iter().zip(&values).filter(|(colour, _)| colour.largest_w > start);
            let columns = reached.map(|(_, values)| relative(values, piece, pieces, self.dark)).collect();
            let principal = Svd::of(columns).u;
            for k in 0..components {
                let srgb = principal.get(k).map_or([Vec4::ZERO; 3], |u| by_channel(u));
                from_nodes.push(to_srgb_transposed(&srgb));
                basis.cubics.push(to_xyz(&srgb).map(cubic_through));
            }
        }
        let mut made = Projection { basis, error: 0.0, from_nodes };
        let each = self.judged.iter().map(|judged| made.error_at(judged, &polynomials, self.dark));
        made.error = each.fold(JudgedError::default(), JudgedError::plus).largest();
        made
    }
}

/// Sums of squared errors of colours at the judged places.
#[derive(Clone, Copy, Default)]
struct JudgedError {
    // Errors relative to each colour, weighted by |w|: a picture shows less of a surface that is seen from the side.
    relative: f64,
    weights: f64,
    // Errors of colours as in pictures, and the colours.
    shown: f64,
    exact: f64,
}

impl JudgedError {
    fn plus(self, other: Self) -> Self {
        Self {
            relative: self.relative + other.relative,
            weights: self.weights + other.weights,
            shown: self.shown + other.shown,
            exact: self.exact + other.exact,
        }
    }

    /// Returns the larger of the RMS of the relative errors of single colours and of the relative L2 error of colours in pictures.
    fn largest(&self) -> f64 {
        let part = |error: f64, of: f64| if of > 0.0 { (error / of).sqrt() } else { 0.0 };
        part(self.relative, self.weights).max(part(self.shown, self.exact))
    }
}

impl Projection {
    /// Returns the error at a place with these `exact` colours.
    fn error_at(&self, exact: &PlaceColours, polynomials: &[Vec<f64>], dark: f64) -> JudgedError {
        let mut numbers = Vec::new();
        self.project(&exact.at_nodes(polynomials), &mut numbers);
        let numbers: Vec<&[f32]> = numbers.chunks_exact(self.basis.components).collect();
        let least = (FAINT * exact.largest).hypot(dark);
        let error = |&(w, exact): &(f64, DVec3)| {
            let (piece, t) = self.basis.piece(w);
            let colour = ColorBasis::colour(self.basis.of_piece(piece), numbers[piece], t);
            let off = (linear_srgb(colour.as_dvec3()) - exact).length_squared();
            let size = exact.length_squared();
            let least = size + least * least;
            // Beside the specular direction, f cos θ_i is w³ times the colour up to constants.
            let shown = w * w.powi(3).powi(2);
            JudgedError {
                relative: if least > 0.0 { w * off / least } else { 0.0 },
                weights: w,
                shown: shown * off,
                exact: shown * size,
            }
        };
        exact.judged.iter().map(error).fold(JudgedError::default(), JudgedError::plus)
    }
}

impl PlaceColours {
    /// Returns the mean over `places`, from `sums` at Chebyshev nodes over 0 … 2 and the `matrix` from values there to coefficients.
    fn of(places: &[DVec2], sums: &Sums<'_>, matrix: &[Vec<f64>], scratch: &mut Scratch) -> Self {
        let mut series = vec![DVec3::ZERO; matrix.len()];
        for place in places {
            let values = sums.colours(*place, scratch);
            for (slot, row) in series.iter_mut().zip(matrix) {
                let sum: DVec3 = row.iter().zip(&values).map(|(m, v)| *m * Vec3::from(*v).as_dvec3()).sum();
                *slot += sum / places.len() as f64;
            }
        }
        let largest_w = largest_w(places[0]);
        let at = |w| (w, linear_srgb(sum_of(&series, &polynomials_at(w, series.len()))));
        let judged: Vec<(f64, DVec3)> = between().take_while(|w| *w <= largest_w).map(at).collect();
        let largest = judged.iter().map(|(_, colour)| colour.length()).fold(0.0, f64::max);
        Self { largest_w, series, judged, largest }
    }

    /// Returns XYZ at the nodes with these `polynomials`, `[channel][piece]`.
    fn at_nodes(&self, polynomials: &[Vec<f64>]) -> Vec<Vec4> {
        let values: Vec<DVec3> =
            polynomials.iter().map(|polynomial| sum_of(&self.series, polynomial)).collect();
        let channel = |channel: usize| {
            let (fours, _) = values.as_chunks::<NODES>();
            fours.iter().map(move |four| Vec4::from_array(four.map(|value| value[channel] as f32)))
        };
        (0..3).flat_map(channel).collect()
    }
}

/// Returns Σ coefficient · polynomial.
fn sum_of(series: &[DVec3], polynomials: &[f64]) -> DVec3 {
    series.iter().zip(polynomials).map(|(a, t)| *a * *t).sum()
}

/// Returns `count` Chebyshev polynomials over 0 … 2 at |w| = `w`.
fn polynomials_at(w: f64, count: usize) -> Vec<f64> {
    let mut values = vec![0.0; count];
    polynomials(2.0 * w / LARGEST_W - 1.0, &mut values);
    values
}

/// Returns the places whose average is one sample: `place` alone or, if pictures average over many places, a row of them through `place`.
/// Number `i` chooses its direction.
fn row(i: usize, place: DVec2, reader: &OrderReader<'_>, settings: &TableSettings) -> Vec<DVec2> {
    /// Distance of the places in standard deviations of the blur, so that they are independent.
    const APART: f64 = 3.0;
    let count = settings.budget.places.max(1);
    let blur = MIDDLE * reader.series.blur.variance[0].sqrt();
    let step = DVec2::from_angle(GOLDEN_ANGLE * i as f64) * (APART * blur.hypot(settings.finest));
    (0..count).map(|k| place + step * (k as f64 - 0.5 * (count - 1) as f64)).collect()
}

/// Returns the largest |w| at a place (u, v).
fn largest_w(place: DVec2) -> f64 {
    (LARGEST_W * LARGEST_W - place.length_squared()).max(0.0).sqrt()
}

/// Returns the linear sRGB in the nodes of `piece`, `[channel][node]`, of a place with these `values`, relative to their size.
fn relative(values: &[Vec4], piece: usize, pieces: usize, dark: f64) -> Vec<Complex64> {
    let xyz: [Vec4; 3] = std::array::from_fn(|channel| values[channel * pieces + piece]);
    let node = |node: usize| linear_srgb(Vec3::from(xyz.map(|channel| channel[node])).as_dvec3());
    let nodes: [DVec3; NODES] = std::array::from_fn(node);
    let square: f64 = nodes.iter().map(|colour| colour.length_squared()).sum();
    let size = (square / NODES as f64).sqrt().hypot(dark);
    let size = if size > 0.0 { size } else { 1.0 };
    (0..3).flat_map(|channel| nodes.map(|colour| Complex64::from(colour[channel] / size))).collect()
}

/// Returns the real parts of `[channel][node]`, by channel.
fn by_channel(u: &[Complex64]) -> [Vec4; 3] {
    std::array::from_fn(|channel| {
        Vec4::from_array(std::array::from_fn(|node| u[channel * NODES + node].re as f32))
    })
}

/// Returns the matrix from XYZ to linear sRGB.
fn srgb_from_xyz() -> DMat3 {
    DMat3::from_cols(linear_srgb(DVec3::X), linear_srgb(DVec3::Y), linear_srgb(DVec3::Z))
}

/// Converts every node's linear sRGB to XYZ.
fn to_xyz(srgb: &[Vec4; 3]) -> [Vec4; 3] {
    combined(srgb_from_xyz().inverse(), srgb)
}

/// Returns the row that gives the product of `srgb` with a place's linear sRGB from its XYZ.
fn to_srgb_transposed(srgb: &[Vec4; 3]) -> [Vec4; 3] {
    combined(srgb_from_xyz().transpose(), srgb)
}

/// Returns `matrix` times the channels at every node.
fn combined(matrix: DMat3, channels: &[Vec4; 3]) -> [Vec4; 3] {
    std::array::from_fn(|row| {
        (0..3).map(|column| channels[column] * matrix.col(column)[row] as f32).sum::<Vec4>()
    })
}

/// Returns the coefficients of 1, t, t² and t³ of the cubic with these values at the four Chebyshev nodes of −1 … 1.
fn cubic_through(values: Vec4) -> [f32; NODES] {
    let rows = coefficients_from_values(NODES);
    let [a, b, c, d]: [f64; NODES] =
        std::array::from_fn(|k| rows[k].iter().zip(values.to_array()).map(|(m, v)| m * f64::from(v)).sum());
    // T_2 = 2t² − 1 and T_3 = 4t³ − 3t.
    [a - c, b - 3.0 * d, 2.0 * c, 4.0 * d].map(|x| x as f32)
}

/// Golden angle π (3 − √5): successive multiples are spread evenly around (Vogel, "A better way to construct the sunflower head", 1979).
const GOLDEN_ANGLE: f64 = 2.399_963;

/// Returns places from which bases are made, and others at which they are judged. Both include the brightest places, few for a grating, and
/// evenly spread ones.
fn places(reader: &OrderReader<'_>, spectrum: &DirectionWavelengths) -> [Vec<DVec2>; 2] {
    /// Number of candidates, on a spiral of equal areas, and numbers of those chosen for their light and for their place.
    const CANDIDATES: usize = 3000;
    const BRIGHT: usize = 300;
    const SPREAD: usize = 300;
    /// One in this many places is judged.
    const JUDGED: usize = 3;
    let place = |i: usize| {
        let radius = LARGEST_W * ((i as f64 + 0.5) / CANDIDATES as f64).sqrt();
        DVec2::from_angle(GOLDEN_ANGLE * i as f64) * radius
    };
    let middle = Sums::at(reader, spectrum, vec![0.7 * LARGEST_W]);
    let mut candidates: Vec<(f32, DVec2)> = (0..CANDIDATES)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, i| (middle.colours(place(i), scratch)[0][1], place(i)))
        .collect();
    let spread: Vec<DVec2> =
        candidates.iter().step_by(CANDIDATES / SPREAD).map(|(_, place)| *place).collect();
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let all = candidates.iter().take(BRIGHT).map(|(_, place)| *place).chain(spread).enumerate();
    let (judged, made_for): (Vec<_>, Vec<_>) = all.partition(|(i, _)| i % JUDGED == 0);
    [made_for, judged].map(|places| places.into_iter().map(|(_, place)| place).collect())
}
