//! One picture, offscreen: what `diffract render` writes.

use super::frame::{DeviceMesh, DisplayPass, GeometryPass, PixelPass, View};
use super::resources::{Pigment, Resources};
use super::shading::Shading;
use super::tables::Combs;
use super::target::{self, Geometry, Target};
use crate::error::{Error, Result};
use crate::precompute::Layers;
use crate::scene::{MAX_LIGHTS, Mesh};
use crate::vk::access::Access;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::queries::Timestamps;
use glam::DVec3;
use std::sync::Arc;

pub mod timing;

/// Draws pictures of one mesh with one surface.
pub struct Painter {
    commands: Commands,
    find: GeometryPass,
    shade: PixelPass,
    geometry: Geometry,
    display: DisplayPass,
    target: Target,
    mesh: DeviceMesh,
    timestamps: Timestamps,
    resources: Resources,
    device: Arc<Device>,
}

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Linear radiance, signed, RGBA, row by row from the top; alpha is 1 where the mesh covers.
    pub radiance: Vec<[f32; 4]>,
    /// What is displayed, sRGB-encoded RGBA.
    pub display: Vec<[u8; 4]>,
}

/// The directions that a frame shades.
#[derive(Clone, Debug)]
pub struct Directions {
    /// ω_i per pixel (w: covered).
    pub light: Vec<[f32; 4]>,
    /// ω_r per pixel (w: covered).
    pub view: Vec<[f32; 4]>,
}

impl Painter {
    /// Uploads everything for pictures of `size` pixels under at most `lights` lights.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(
        device: &Arc<Device>,
        layers: &Layers,
        shading: &Shading,
        mesh: &Mesh,
        pigment: &Pigment,
        size: [u32; 2],
        lights: usize,
    ) -> Result<Self> {
        let resources = Resources::new(device, layers, shading, pigment)?;
        let geometry = Geometry::new(device, size, lights.min(MAX_LIGHTS))?;
        resources.read_from(&geometry);
        let target = Target::new(device, size)?;
        let display = DisplayPass::new(device, target::DISPLAY)?;
        display.read_from(&target);
        Ok(Self {
            commands: Commands::new(device, "frame")?,
            find: GeometryPass::new(device, &resources.descriptors, &geometry)?,
            shade: PixelPass::shading(device, &resources.descriptors)?,
            geometry,
            display,
            target,
            mesh: DeviceMesh::new(device, mesh)?,
            timestamps: Timestamps::new(device, 3)?,
            resources,
            device: device.clone(),
        })
    }

    /// Draws `view` and leaves the result on the device; milliseconds that the device took for shading and display.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn draw(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<[f64; 2]> {
        self.resources.frame.write(bytemuck::bytes_of(&view.block(self.target.size())))?;
        let (target, resources) = (&self.target, &self.resources);
        self.commands.run(|record| {
            record.reset(&self.timestamps);
            record.timestamp(&self.timestamps, 0);
            self.find.record(record, &self.geometry, &resources.descriptors, &self.mesh);
            self.shade.record(record, target, &resources.descriptors, &[]);
            record.timestamp(&self.timestamps, 1);
            self.display.record(record, target, &target.display, exposure, background);
            record.timestamp(&self.timestamps, 2);
            Ok(())
        })?;
        let times = self.timestamps.intervals()?;
        Ok([times[0], times[1]])
    }

    /// Milliseconds in which the device reads `samples` bilinear samples per pixel of the layers with nothing else to do: what
    /// it could reach, with neighbours for neighbouring pixels or, `scattered`, with a place of its own for each pixel.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn probe(&mut self, samples: u32, scattered: bool) -> Result<f64> {
        let push = [samples, u32::from(scattered)];
        let pass = PixelPass::probe(&self.device, &self.resources.descriptors)?;
        let target = &self.target;
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            self.commands.run(|record| {
                record.reset(&self.timestamps);
                record.timestamp(&self.timestamps, 0);
                pass.record(record, target, &self.resources.descriptors, bytemuck::cast_slice(&push));
                record.timestamp(&self.timestamps, 1);
                record.timestamp(&self.timestamps, 2);
                Ok(())
            })?;
            best = best.min(self.timestamps.intervals()?[0]);
        }
        Ok(best)
    }

    /// From now on shades as a classical grating shader does, by [`PixelPass::grating`].
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn shade_as_grating(&mut self, axis: [f32; 2], period: f32, strength: f32) -> Result<()> {
        self.shade = PixelPass::grating(&self.device, &self.resources.descriptors, axis, period, strength)?;
        Ok(())
    }

    /// The wavelength combs that the pictures use.
    pub fn combs(&self) -> &Combs {
        &self.resources.combs
    }

    /// Draws `view` and reads the picture back.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn paint(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<Picture> {
        self.draw(view, exposure, background)?;
        let radiance = target::read_back(&self.device, &self.target.radiance, Access::ShaderRead)?;
        let display = target::read_back(&self.device, &self.target.display, Access::ColorAttachment)?;
        Ok(Picture {
            size: self.target.size(),
            radiance: bytemuck::pod_collect_to_vec(&radiance),
            display: bytemuck::pod_collect_to_vec(&display),
        })
    }

    /// The directions of light number `light` in `view`, as the shading has them.
    ///
    /// # Errors
    /// Where the device is lost, and where the pictures have no such light.
    pub fn directions(&mut self, view: &View, light: usize) -> Result<Directions> {
        let Some(lights) = self.geometry.lights.get(light) else {
            return Err(Error::failed(
                format!("there is no light {light}"),
                "report this as a bug of diffract",
            ));
        };
        self.resources.frame.write(bytemuck::bytes_of(&view.block(self.target.size())))?;
        self.commands.run(|record| {
            self.find.record(record, &self.geometry, &self.resources.descriptors, &self.mesh);
            Ok(())
        })?;
        let read = |image| {
            let bytes = target::read_back(&self.device, image, Access::ShaderRead)?;
            Ok(bytemuck::pod_collect_to_vec(&bytes))
        };
        Ok(Directions { light: read(lights)?, view: read(&self.geometry.view)? })
    }
}
