//! A colour table: the spectrum is summed beforehand, and a direction reads the sum. Its twin is `shaders/source_table.glsl`.

use super::bound::{BoundSource, Kind, uniform};
use super::cost::Cost;
use super::{Extent, Summary, stages};
use crate::error::Result;
use crate::expansion::Basis;
use crate::optics::brdf::schlick;
use crate::render::color_table::grid::LEVELS;
use crate::render::color_table::pyramid::in_layers;
use crate::render::color_table::{ColorTable, Filter};
use crate::render::picture::Directions;
use crate::render::shading::Shading;
use crate::render::upload;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::Constant;
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use std::sync::Arc;

/// A colour table, and how a picture reads it.
#[derive(Clone, Debug)]
pub struct Table {
    /// The table.
    pub table: Arc<ColorTable>,
    /// What a pixel shows of it.
    pub filter: Filter,
}

/// Binding numbers of set 1.
mod binding {
    pub const BLOCK: u32 = 0;
    pub const COLOURS: u32 = 1;
}

const KINDS: [Kind; 2] = [Kind::UNIFORM_BUFFER, Kind::COMBINED_IMAGE_SAMPLER];

/// The `Table` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TableBlock {
    /// R₀ of Schlick.
    pub normal_reflectance: f32,
    /// σ of the window, or what stands for it \[µm\].
    pub sigma: f32,
    /// Texture coordinate per unit of u.
    pub texture_per_uv: f32,
    /// Texels of the finest level per unit of u.
    pub texels_per_uv: f32,
    /// What a stored 1 stands for.
    pub unit: f32,
    /// Added to the level that a footprint asks for.
    pub finest: f32,
    /// Pieces of the range of |w|.
    pub pieces: f32,
    /// |u| and |v| up to which the finer part is read.
    pub near: f32,
    /// Texture coordinate per unit of u there.
    pub near_texture_per_uv: f32,
    /// Texture coordinate of u = v = 0 there.
    pub near_centre: f32,
    /// std140 rounds a block up to 16 bytes.
    pub padding: [f32; 2],
}

/// A linear sample of averages over Δ is the average over a box and a tent, with the variance Δ²/4; a footprint of width F has
/// F²/12. So a footprint asks for Δ = F/√3: log₂(1/√3) levels below F.
const OWN_WIDTH: f32 = -0.792_481_25;

impl Table {
    pub(super) fn bind(&self, device: &Arc<Device>, shading: &Shading) -> Result<BoundSource> {
        const MAX_TAPS: u32 = 10;
        let constants = vec![Constant::new(MAX_TAPS, self.filter.taps() as u32)];
        let mut bound = BoundSource::new(device, "table set", &KINDS, stages!("table"), constants)?;
        bound.spectral = false;
        bound.asks_what_is_covered = self.filter == Filter::Pixel;
        bound.reads_footprints = self.filter == Filter::Pixel;
        let grid = &self.table.grid;
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let (texels, layers) = grid.texture(self.filter);
        let (size, layers) = (texels.map(|n| n as u32), layers as u32);
        let format = vk::Format::R16G16B16A16_SFLOAT;
        let description = Description { name: "colour table", format, size, layers, array: true, usage };
        let name = "colour table sampler";
        let (image, sampler) = match self.filter {
            Filter::Point => {
                let image = Image::new(device, &description)?;
                upload::image(device, &image, layers, bytemuck::cast_slice(&self.table.levels[0]))?;
                // Of one level there is nothing to choose, and devices need not look.
                (image, Sampler::linear(device, name, vk::SamplerAddressMode::CLAMP_TO_EDGE)?)
            }
            Filter::Pixel => {
                let image = Image::with_levels(device, &description, LEVELS as u32)?;
                let finest = in_layers(grid, &self.table.levels[0]);
                let levels = std::iter::once(&finest).chain(&self.table.levels[1..]);
                let levels: Vec<&[u8]> = levels.map(|level| bytemuck::cast_slice(level)).collect();
                upload::levels(device, &image, layers, &levels)?;
                (image, Sampler::trilinear(device, name)?)
            }
        };
        bound.data(binding::COLOURS, image, sampler);
        self.set(device, &mut bound, shading)?;
        Ok(bound)
    }

    /// Of a table only the reflectance depends on more than the table.
    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, shading: &Shading) -> Result<()> {
        let (grid, near) = (&self.table.grid, self.table.grid.near());
        let block = TableBlock {
            normal_reflectance: schlick(shading.ior, 1.0) as f32,
            sigma: self.table.sigma as f32,
            texture_per_uv: (1.0 / (grid.spacing * grid.side as f64)) as f32,
            texels_per_uv: (1.0 / grid.spacing) as f32,
            unit: self.table.unit,
            finest: OWN_WIDTH,
            pieces: grid.pieces as f32,
            near: near.extent() as f32,
            near_texture_per_uv: (1.0 / (near.spacing * grid.side as f64)) as f32,
            near_centre: (near.side as f64 / 2.0 / grid.side as f64) as f32,
            padding: [0.0; 2],
        };
        bound.replace(device, Vec::new(), vec![(binding::BLOCK, uniform(device, "table block", &block)?)])
    }

    pub(super) fn extent(&self) -> Extent {
        let grid = &self.table.grid;
        Extent { layers: grid.layers(), size: [grid.side; 2], bytes: grid.bytes() }
    }

    pub(super) fn summary(&self) -> Summary {
        let kernel = match self.filter {
            Filter::Pixel => "trilinear, over pixels",
            Filter::Point => "bilinear, at points",
        };
        let grid = &self.table.grid;
        let (terms, layers) = (grid.values(), grid.layers());
        Summary { method: "table", basis: Basis::Phase, terms, layers, kernel: kernel.to_owned() }
    }

    pub(super) fn cost(&self, directions: &[Directions], size: [u32; 2]) -> Cost {
        let (grid, filter) = (&self.table.grid, self.filter);
        let mut cost = Cost::default();
        for (index, seen) in directions.iter().enumerate() {
            let covered = |i: usize| seen.view[i][3] != 0.0;
            let toward = |i: usize| {
                let along = |c: usize| f64::from(seen.light[i][c]) + f64::from(seen.view[i][c]);
                DVec2::new(along(0), along(1))
            };
            let (width, height) = (size[0] as i64, size[1] as i64);
            // The shorter of the steps to both sides, as `shorter_step` of `shaders/shade.frag` has it.
            let step = |i: usize, next: [i64; 2]| {
                let (x, y) = (i as i64 % width, i as i64 / width);
                [-1, 1]
                    .into_iter()
                    .map(|side| [x + side * next[0], y + side * next[1]])
                    .filter(|[x, y]| (0..width).contains(x) && (0..height).contains(y))
                    .map(|[x, y]| (y * width + x) as usize)
                    .filter(|&other| covered(other))
                    .map(|other| toward(other) - toward(i))
                    .min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
                    .unwrap_or(DVec2::ZERO)
            };
            for i in (0..seen.view.len()).filter(|&i| covered(i)) {
                cost.covered += usize::from(index == 0);
                let taps = filter.taps_over(grid, step(i, [1, 0]), step(i, [0, 1]));
                cost.samples += 3 * taps; // X, Y, Z
            }
        }
        cost
    }
}
