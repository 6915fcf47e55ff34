//! One picture, offscreen: what `diffract render` writes.

use super::evaluator::{Asker, Query};
use super::frame::{DeviceMesh, DisplayPass, GeometryPass, PixelPass, Probe, View};
use super::frame_set::FrameSet;
use super::pigment::Pigment;
use super::shading::Shading;
use super::source::{BoundSource, Source};
use super::target::{self, Geometry, Target};
use crate::error::{Error, Result};
use crate::scene::{MAX_LIGHTS, Mesh};
use crate::vk::access::Access;
use crate::vk::commands::{Commands, FAR, Recorder};
use crate::vk::device::Device;
use crate::vk::queries::Timestamps;
use glam::DVec3;
use std::ops::Range;
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
    asker: Option<Asker>,
    source: BoundSource,
    frame: FrameSet,
    // Rows of a strip that take a fitting time.
    strip: u32,
    // Whether all of radiance is of one picture, and displayed.
    whole: bool,
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
    /// Uploads everything for pictures of `size` pixels under at most `lights` lights, shaded from `source`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(
        device: &Arc<Device>,
        source: &Source,
        shading: &Shading,
        mesh: &Mesh,
        pigment: &Pigment,
        size: [u32; 2],
        lights: usize,
    ) -> Result<Self> {
        let source = source.bind(device, shading)?;
        let looks = [pigment.is_textured(), source.asks_what_is_covered];
        let geometry = Geometry::new(device, size, lights.min(MAX_LIGHTS), looks)?;
        let frame = FrameSet::new(device, pigment, &geometry)?;
        let target = Target::new(device, size)?;
        let display = DisplayPass::new(device, target::DISPLAY)?;
        display.read_from(&target);
        Ok(Self {
            commands: Commands::new(device, "frame")?,
            find: GeometryPass::new(device, &frame.descriptors, &geometry)?,
            shade: PixelPass::shading(device, &frame.descriptors, &source, lights)?,
            geometry,
            display,
            target,
            mesh: DeviceMesh::new(device, mesh)?,
            timestamps: Timestamps::new(device, 3)?,
            asker: None,
            source,
            frame,
            strip: 64,
            whole: false,
            device: device.clone(),
        })
    }

    /// Other sizes and numbers of lights for the pictures from now on.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn resize(&mut self, size: [u32; 2], lights: usize) -> Result<()> {
        let lights = lights.min(MAX_LIGHTS);
        self.whole = false;
        if lights != self.geometry.lights {
            let frame = &self.frame.descriptors;
            self.shade = PixelPass::shading(&self.device, frame, &self.source, lights)?;
        }
        if lights != self.geometry.lights || size != self.target.size() {
            let looks = [self.geometry.textured, self.geometry.marked];
            self.geometry = Geometry::new(&self.device, size, lights, looks)?;
            self.frame.read_from(&self.geometry);
            self.find = GeometryPass::new(&self.device, &self.frame.descriptors, &self.geometry)?;
        }
        if size != self.target.size() {
            self.target = Target::new(&self.device, size)?;
            self.display.read_from(&self.target);
        }
        Ok(())
    }

    /// Shades by `shading` from now on, from `source`, whose data the painter has: what depends on the index, the illuminant or the number
    /// of copies is uploaded, and the rest stays.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn shade_by(&mut self, source: &Source, shading: &Shading) -> Result<()> {
        self.whole = false;
        source.rebind(&self.device, &mut self.source, shading)
    }

    /// Draws `view` and leaves the result on the device; milliseconds that the device took for shading and display.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn draw(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<[f64; 2]> {
        let size = self.target.size();
        self.write(view, size)?;
        self.submit(size, 0..size[1], exposure, background)
    }

    /// Draws `view` with `size` pixels, at most those of the pictures, in strips of some ten milliseconds each, between which
    /// others get the device. `go_on` is asked before each strip; where it says no, the former display stays. Milliseconds
    /// that the device took, or `None` for a picture that was given up.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn draw_while(
        &mut self,
        view: &View,
        exposure: f64,
        background: DVec3,
        size: [u32; 2],
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Option<f64>> {
        /// Long enough to keep a device busy, short enough for a hand not to feel it \[ms\].
        const STRIP: f64 = 30.0;
        /// Rows of a strip are a multiple of it, so that no group of neighbours is torn apart.
        const STEP: u32 = 16;
        self.write(view, size)?;
        let (mut row, mut total) = (0, 0.0);
        while row < size[1] {
            if !go_on() {
                return Ok(None);
            }
            let end = (row + self.strip.max(STEP)).min(size[1]);
            let times = self.submit(size, row..end, exposure, background)?;
            let per_row = times[0].max(1e-3) / f64::from(end - row);
            self.strip = ((STRIP / per_row) as u32).next_multiple_of(STEP).min(1 << 16);
            total += times[0] + times[1];
            row = end;
        }
        Ok(Some(total))
    }

    /// Shows the radiance that is there at another exposure or before another background; false where there is none.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn display_again(&mut self, size: [u32; 2], exposure: f64, background: DVec3) -> Result<bool> {
        if !self.whole {
            return Ok(false);
        }
        let (geometry, target, display) = (&self.geometry, &self.target, &self.display);
        self.commands.run(|record| {
            record.images(&[(&target.radiance, Access::ShaderRead, Access::ColorAttachment)]);
            let all = record.within(size, 0..size[1]);
            record_display(&all, display, (geometry, target), exposure, background);
            Ok(())
        })?;
        Ok(true)
    }

    /// Draws `rows` of a picture of `size`: with the first row goes the geometry, with the last the display.
    fn submit(
        &mut self,
        size: [u32; 2],
        rows: Range<u32>,
        exposure: f64,
        background: DVec3,
    ) -> Result<[f64; 2]> {
        let (geometry, target) = (&self.geometry, &self.target);
        let (display, frame) = (&self.display, &self.frame.descriptors);
        let sets = [frame, &self.source.descriptors];
        let (first, last) = (rows.start == 0, rows.end == size[1]);
        self.whole = false;
        self.commands.run(|record| {
            let (all, some) = (record.within(size, 0..size[1]), record.within(size, rows));
            record.reset(&self.timestamps);
            record.timestamp(&self.timestamps, 0);
            if first {
                self.find.record(&all, geometry, frame, &self.mesh);
                self.shade.record(&some, (geometry, target), sets);
            } else {
                self.shade.go_on(&some, (geometry, target), sets);
            }
            record.timestamp(&self.timestamps, 1);
            if last {
                record_display(&all, display, (geometry, target), exposure, background);
            }
            record.timestamp(&self.timestamps, 2);
            Ok(())
        })?;
        self.whole = last;
        let times = self.timestamps.intervals()?;
        Ok([times[0], times[1]])
    }

    /// The images of the pictures.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// What each of their pixels sees.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// f·cos θ_i \[sr⁻¹\] of single directions, as [`super::evaluator::Evaluator::cosine_weighted`].
    ///
    /// # Errors
    /// Where the device is lost or has no room.
    pub fn cosine_weighted(&mut self, queries: &[Query]) -> Result<Vec<DVec3>> {
        let asker = match &mut self.asker {
            Some(asker) => asker,
            none => none.insert(Asker::new(&self.device, &self.source)?),
        };
        asker.ask(&self.source, queries)
    }

    /// Milliseconds in which the device reads `samples` bilinear samples per pixel of its texture with nothing else to do: what
    /// it could reach, with neighbours for neighbouring pixels or, `scattered`, with a place of its own for each pixel.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn probe(&mut self, samples: u32, scattered: bool) -> Result<f64> {
        let probe = Probe { samples, scattered: scattered.into() };
        let pass = PixelPass::probe(&self.device, &self.frame.descriptors, &self.source)?;
        let target = &self.target;
        let sets = [&self.frame.descriptors, &self.source.descriptors];
        self.whole = false;
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            self.commands.run(|record| {
                record.reset(&self.timestamps);
                record.timestamp(&self.timestamps, 0);
                pass.record_probe(record, target, sets, probe);
                record.timestamp(&self.timestamps, 1);
                record.timestamp(&self.timestamps, 2);
                Ok(())
            })?;
            best = best.min(self.timestamps.intervals()?[0]);
        }
        Ok(best)
    }

    /// Draws `view` and reads the picture back.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn paint(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<Picture> {
        self.draw(view, exposure, background)?;
        self.picture()
    }

    /// Reads back what was drawn last, in the size of the pictures.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn picture(&self) -> Result<Picture> {
        let radiance = target::read_back(&self.device, &self.target.radiance, Access::ShaderRead)?;
        let mut radiance: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&radiance);
        for (pixel, _) in radiance.iter_mut().zip(self.covered()?).filter(|(_, covered)| !covered) {
            *pixel = [0.0; 4];
        }
        let display = target::read_back(&self.device, &self.target.display, Access::ShaderRead)?;
        Ok(Picture { size: self.target.size(), radiance, display: bytemuck::pod_collect_to_vec(&display) })
    }

    /// The directions of light number `light` in `view`, as the shading has them.
    ///
    /// # Errors
    /// Where the device is lost, and where the pictures have no such light.
    pub fn directions(&mut self, view: &View, light: usize) -> Result<Directions> {
        if light >= self.geometry.lights {
            return Err(Error::failed(
                format!("there is no light {light}"),
                "report this as a bug of diffract",
            ));
        }
        self.write(view, self.target.size())?;
        // What is covered may be other pixels than those of the radiance that is there.
        self.whole = false;
        self.commands.run(|record| {
            self.find.record(record, &self.geometry, &self.frame.descriptors, &self.mesh);
            Ok(())
        })?;
        let read = |image| -> Result<Vec<[f32; 4]>> {
            let bytes = target::read_back(&self.device, image, Access::ShaderRead)?;
            Ok(bytemuck::pod_collect_to_vec(&bytes))
        };
        let first = read(&self.geometry.directions)?;
        let lights = match light.checked_sub(1) {
            None => first.iter().map(|&[.., x, y]| [x, y]).collect(),
            Some(more) => {
                let image = read(&self.geometry.more_lights[more / 2])?;
                image
                    .iter()
                    .map(|&[a, b, c, d]| if more % 2 == 0 { [a, b] } else { [c, d] })
                    .collect::<Vec<_>>()
            }
        };
        let covered = self.covered()?;
        let of = |(s, covered): ([f32; 2], &bool)| if *covered { unprojected(s) } else { [0.0; 4] };
        Ok(Directions {
            light: lights.into_iter().zip(&covered).map(of).collect(),
            view: first.iter().map(|stored| [stored[0], stored[1]]).zip(&covered).map(of).collect(),
        })
    }

    /// Whether the mesh covers each pixel.
    fn covered(&self) -> Result<Vec<bool>> {
        let depth = target::read_back(&self.device, &self.geometry.depth, Access::DepthAttachment)?;
        let depth: Vec<f32> = bytemuck::pod_collect_to_vec(&depth);
        Ok(depth.into_iter().map(|depth| depth < FAR).collect())
    }

    /// Writes the `Frame` block of `view` for pictures of `size`.
    fn write(&mut self, view: &View, size: [u32; 2]) -> Result<()> {
        let mut block = view.block(size);
        if !self.geometry.textured {
            // There are no albedos to read.
            block.base_color[3] = 0.0;
        }
        self.frame.write(&block)
    }
}

/// The unit vector at `s` of the stereographic projection from −N that directions are stored by; w is 1.
fn unprojected(s: [f32; 2]) -> [f32; 4] {
    let k = 2.0 / (1.0 + s[0] * s[0] + s[1] * s[1]);
    [k * s[0], k * s[1], k - 1.0, 1.0]
}

/// Records the display, which a window may be showing, and leaves it readable.
fn record_display(
    record: &Recorder<'_>,
    pass: &DisplayPass,
    (geometry, target): (&Geometry, &Target),
    exposure: f64,
    background: DVec3,
) {
    record.memory(Access::ShaderRead, Access::ColorAttachment);
    pass.record(record, (geometry, target), &target.display, exposure, background);
    record.images(&[(&target.display, Access::ColorAttachment, Access::ShaderRead)]);
}
