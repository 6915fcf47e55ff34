//! Baking of colour tables: the sum over the spectrum at every texel.

use super::basis::PER_TEXEL;
use super::grid::{LEVELS_OF_MIP, TableGrid};
use super::projection::Projection;
use super::specular::Specular;
use super::sums::{DirectionWavelengths, Scratch, Sums};
use super::{ColorTable, TableHeader, TableSettings};
use crate::error::{Error, Remedy, Result};
use crate::memory;
use crate::optics::factor::IndexTriple;
use crate::optics::reflectance::MeanReflectance;
use crate::optics::spectrum::{BLUE, MIDDLE};
use crate::optics::theory::Theory;
use crate::spectra::power::{OrderReader, OrderSeries, Square};
use crate::task::Task;
use glam::{DVec2, Vec4};
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Relative L2 error of linear interpolation of prefiltered samples, per (Δ/b)² for the spacing Δ and the standard deviation b of the blur:
/// 4·√(3/(64·720)) along each axis, from (2πΔf)²/√720 averaged over the blur's spectrum.
const LINEAR_ERROR: f64 = 0.0323 * std::f64::consts::SQRT_2;

/// |w| of directions 30 degrees off the normal.
const USUAL_W: f64 = 1.7;

/// Bakes the table of the surface of `series`.
///
/// # Errors
/// Limits or memory that do not suffice; a cancelled task.
pub fn bake(series: &OrderSeries, settings: &TableSettings, task: &Task) -> Result<ColorTable> {
    let reader = OrderReader::new(series);
    let spectrum = DirectionWavelengths::new(series, settings);
    let Plan { projection, grid, coherence_blur, effective_orders } =
        Plan::new(series, &reader, &spectrum, settings)?;
    let layers = projection.basis.layers();
    check_room(&grid, layers, settings)?;
    let sums = Sums::new(&reader, &spectrum, projection.basis.pieces);
    let width = layers * PER_TEXEL;
    let finest = bake_finest(&sums, &projection, &grid, task)?;
    let unit = unit_of(&finest);
    let mut mips = vec![Vec::new(); grid.mips()];
    let mut current = finest;
    for level in 0..grid.levels {
        mips[level / LEVELS_OF_MIP].extend(texels(&current, grid.side_of(level), layers, unit));
        if level + 1 < grid.levels {
            current = next_level(&current, width, level, &grid);
        }
    }
    task.report(COLOURS, 1, 1)?;
    let specular = Specular::new(series, settings);
    let held = settings.reflectance.as_ref();
    let mean_reflectance = held.filter(|r| r.theory() == Theory::Stam).map(MeanReflectance::new);
    let indices = held.filter(|r| r.theory() == Theory::SmallSlope).map(IndexTriple::of);
    let header = TableHeader {
        grid,
        budget: settings.budget,
        series_error: series.error,
        basis_error: projection.error,
        basis: projection.basis,
        unit,
        specular,
        coherence_blur,
        effective_orders,
        mean_reflectance,
        indices,
        energy: None,
    };
    Ok(ColorTable { header, mips })
}

/// Basis and grid of a table.
struct Plan {
    projection: Projection,
    grid: TableGrid,
    coherence_blur: f64,
    effective_orders: f64,
}

impl Plan {
    fn new(
        series: &OrderSeries,
        reader: &OrderReader<'_>,
        spectrum: &DirectionWavelengths,
        settings: &TableSettings,
    ) -> Result<Self> {
        let orders = series.blur.variance;
        let coherence_blur = BLUE * BLUE * 0.5 * (orders[0] + orders[1]);
        let blur = settings.finest.powi(2) + coherence_blur;
        let projection = Projection::choose(reader, spectrum, settings)?;
        let effective_orders = series.effective_orders(2.0 * PI * USUAL_W / MIDDLE);
        let grid = choose_grid(effective_orders, settings, blur, projection.basis.layers());
        Ok(Self { projection, grid, coherence_blur, effective_orders })
    }
}

/// Size of a table, known before baking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedTable {
    /// Bytes of the texels of all levels.
    pub bytes: usize,
    /// Variance of (u, v) by the coherence of blue light, as in [`TableHeader::coherence_blur`].
    pub coherence_blur: f64,
}

impl PlannedTable {
    /// Plans the table that [`bake`] makes of `series` under `settings`.
    ///
    /// # Errors
    /// A basis that cannot be chosen.
    pub fn new(series: &OrderSeries, settings: &TableSettings) -> Result<Self> {
        let spectrum = DirectionWavelengths::new(series, settings);
        let Plan { projection, grid, coherence_blur, .. } =
            Plan::new(series, &OrderReader::new(series), &spectrum, settings)?;
        Ok(Self { bytes: grid.bytes(projection.basis.layers()), coherence_blur })
    }
}

/// Fails if [`bake`] would refuse to make a table of `series` under `settings`: a check that takes far less time.
///
/// # Errors
/// Limits or memory that do not suffice.
pub fn check(series: &OrderSeries, settings: &TableSettings) -> Result<()> {
    let spectrum = DirectionWavelengths::new(series, settings);
    let plan = Plan::new(series, &OrderReader::new(series), &spectrum, settings)?;
    check_room(&plan.grid, plan.projection.basis.layers(), settings)
}

/// Returns the grid for a table of `layers` whose finest level averages over `blur`. The errors of orders are independent, so that pictures
/// of many orders err by less than single points, up to [`MeanBudget::averaging`](crate::budget::MeanBudget) times less. Pictures of few
/// orders get more texels. If these would take more than [`ROOM`], the spacing grows as far as `most_averaging` allows.
fn choose_grid(effective_orders: f64, settings: &TableSettings, blur: f64, layers: usize) -> TableGrid {
    let grid = |averaging: f64| {
        let spacing = (settings.budget.reading * averaging / LINEAR_ERROR).sqrt().min(MOST_SPACING);
        TableGrid::new(spacing * blur.sqrt(), settings.finest, blur.sqrt())
    };
    let averaged = (effective_orders / UNAVERAGED).sqrt().clamp(1.0, settings.budget.averaging.max(1.0));
    let over_room = grid(averaged).bytes(layers) as f64 / ROOM;
    grid((averaged * over_room.max(1.0)).min(settings.budget.most_averaging.max(averaged)))
}

/// Largest spacing of texels in standard deviations of the blur. Errors grow as the squared spacing up to here, and much faster beyond: a
/// sphere under 2e-1 erred by 0.22 at a spacing of 3.5, and errs by 0.07 at this one.
const MOST_SPACING: f64 = 2.4;
/// Number of orders with which a picture errs as much as a single point does: by pictures of a sinusoid on a compact disc.
const UNAVERAGED: f64 = 0.6;
/// Largest size of a table with the preferred spacing \[bytes\].
const ROOM: f64 = 512.0 * 1024.0 * 1024.0;

/// Texels along a side of the squares that are summed at once.
const TILE: usize = 16;

/// Name of the work in reports of progress.
const COLOURS: &str = "colours";
/// Rows of tiles between two reports of progress, for each thread.
const TILE_ROWS: usize = 2;

/// Sums the texels of the finest level, `[row][column][number]`.
fn bake_finest(sums: &Sums<'_>, projection: &Projection, grid: &TableGrid, task: &Task) -> Result<Vec<f32>> {
    let width = projection.basis.layers() * PER_TEXEL;
    let mut finest = vec![0f32; grid.side * grid.side * width];
    let tile_row = TILE * grid.side * width;
    let rows_at_once = TILE_ROWS * rayon::current_num_threads();
    for (batch, rows) in finest.chunks_mut(rows_at_once * tile_row).enumerate() {
        task.report(COLOURS, batch * rows_at_once * TILE, grid.side)?;
        rows.par_chunks_mut(tile_row).enumerate().for_each_init(
            Scratch::default,
            |scratch, (row, texels)| {
                let first = (batch * rows_at_once + row) * TILE;
                bake_row(sums, projection, grid, first, scratch, texels);
            },
        );
    }
    Ok(finest)
}

/// Sums the texels of a row of tiles, whose first row of texels is `first`.
fn bake_row(
    sums: &Sums<'_>,
    projection: &Projection,
    grid: &TableGrid,
    first: usize,
    scratch: &mut Scratch,
    texels: &mut [f32],
) {
    let (side, width) = (grid.side, projection.basis.layers() * PER_TEXEL);
    let mut numbers = Vec::with_capacity(width);
    for column in (0..side).step_by(TILE) {
        let corner = DVec2::new(grid.at(0, column), grid.at(0, first));
        let tile = Square { first: corner, step: grid.spacing(0), side: TILE };
        // No two directions are farther apart than opposite ones; footprints reach a little beyond.
        if tile.nearest() > grid.extent + 2.0 * grid.spacing(0) {
            continue;
        }
        for (i, values) in sums.at_nodes(&tile, scratch).enumerate() {
            let (x, y) = (column + i % TILE, i / TILE);
            if x < side && (y * side + x) * width < texels.len() {
                numbers.clear();
                projection.project(values, &mut numbers);
                texels[(y * side + x) * width..][..width].copy_from_slice(&numbers);
            }
        }
    }
}

fn check_room(grid: &TableGrid, layers: usize, settings: &TableSettings) -> Result<()> {
    const MIB: f64 = 1024.0 * 1024.0;
    let bytes = grid.bytes(layers);
    if grid.side > settings.side_limit || bytes > settings.memory_limit {
        // Texels are as many as the tolerance is small.
        let sides = grid.side as f64 / settings.side_limit as f64;
        let growth = (bytes as f64 / settings.memory_limit as f64).max(sides * sides);
        return Err(Error::limit(
            format!(
                "the colour table would take {0} x {0} texels and {1:.0} MiB",
                grid.side,
                bytes as f64 / MIB
            ),
            [Remedy::TimesTolerance(growth), Remedy::FartherCamera, Remedy::OneWindow],
        ));
    }
    // The finest level in 32-bit floats, the next one and its average along rows exist beside all levels in 16-bit floats.
    memory::ensure_room(bytes as u64 * 7 / 2, "the colour table")
}

/// Returns a unit in which the largest coefficient is near the largest 16-bit floats.
fn unit_of(values: &[f32]) -> f64 {
    const NEAR: f32 = 3e4;
    let largest = values.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
    if largest > 0.0 { f64::from(largest / NEAR) } else { 1.0 }
}

/// Returns the level after `level`, of `width` numbers a texel: a blur by the growth of the grid, at the same texels or halfway between each two. No pair of
/// directions is beyond the grid, so the values there are 0.
fn next_level(values: &[f32], width: usize, level: usize, grid: &TableGrid) -> Vec<f32> {
    let (side, next) = (grid.side_of(level), grid.side_of(level + 1));
    let spread = (grid.variance(level + 1) - grid.variance(level)).sqrt() / grid.spacing(level);
    let ratio = side / next;
    // Distance from the first texel that a texel stands for to its middle, in texels.
    let middle = 0.5 * (ratio as f64 - 1.0);
    // Weights to e^(−8) of the largest.
    let reach = (4.0 * spread).ceil() as i64;
    let weight = |i: i64| (-0.5 * ((i as f64 - middle) / spread).powi(2)).exp();
    let total: f64 = (-reach..=reach + 1).map(weight).sum();
    let taps: Vec<(i64, f32)> = (-reach..=reach + 1).map(|i| (i, (weight(i) / total) as f32)).collect();
    // The texels that a texel of the next level averages over, with their weights.
    let within = |i: usize| {
        taps.iter().filter_map(move |&(offset, weight)| {
            let source = (ratio * i) as i64 + offset;
            (0..side as i64).contains(&source).then_some((source as usize, weight))
        })
    };
    let mut along_x = vec![0f32; next * side * width];
    along_x.par_chunks_mut(next * width).zip(values.par_chunks(side * width)).for_each(|(out, row)| {
        for (i, texel) in out.chunks_mut(width).enumerate() {
            for (source, weight) in within(i) {
                let source = &row[source * width..(source + 1) * width];
                texel.iter_mut().zip(source).for_each(|(t, s)| *t += weight * s);
            }
        }
    });
    let mut both = vec![0f32; next * next * width];
    both.par_chunks_mut(next * width).enumerate().for_each(|(j, out)| {
        for (source, weight) in within(j) {
            let row = &along_x[source * next * width..][..next * width];
            out.iter_mut().zip(row).for_each(|(o, s)| *o += weight * s);
        }
    });
    both
}

/// Converts a level to 16-bit texels, prefiltered for linear reading: (−1, 14, −1)/12 along each axis (Condat, Blu, Unser, *Beyond
/// interpolation*, 2005). Values beyond the edges are 0.
fn texels(values: &[f32], side: usize, layers: usize, unit: f64) -> Vec<f16> {
    /// Largest 16-bit float, with room for the growth by the prefilter.
    const LARGEST: f32 = 65_000.0;
    let width = layers * PER_TEXEL;
    let scale = (1.0 / unit) as f32;
    let prefiltered = |[before, middle, after]: [Vec4; 3]| (14.0 * middle - before - after) / 12.0;
    let mut out = vec![f16::ZERO; values.len()];
    out.par_chunks_mut(side * PER_TEXEL).enumerate().for_each(|(number, out)| {
        let (layer, row) = (number / side, number % side);
        // Numbers along columns, prefiltered along y; none beside the table.
        let at = |column: Option<usize>| {
            let Some(column) = column.filter(|column| *column < side) else { return Vec4::ZERO };
            let texel = |row: Option<usize>| match row.filter(|row| *row < side) {
                Some(row) => Vec4::from_slice(&values[(row * side + column) * width + layer * PER_TEXEL..]),
                None => Vec4::ZERO,
            };
            prefiltered([texel(row.checked_sub(1)), texel(Some(row)), texel(Some(row + 1))])
        };
        let mut along_y = [Vec4::ZERO, at(Some(0)), at(Some(1))];
        for (column, out) in out.chunks_exact_mut(PER_TEXEL).enumerate() {
            let value = prefiltered(along_y) * scale;
            let least = Vec4::splat(-LARGEST);
            out.convert_from_f32_slice(&value.clamp(least, -least).to_array());
            along_y = [along_y[1], along_y[2], at(Some(column + 2))];
        }
    });
    out
}
