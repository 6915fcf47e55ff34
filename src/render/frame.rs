//! A frame: depth, shading, display. The same commands draw offscreen and to a window.

use super::device_mesh::attributes;
use super::frame_set::FrameBlock;
use super::light_passes::{LightPass, LightSchedule};
use super::object::DeviceObject;
use super::sampling::Sampling;
use super::shader;
use super::shadows::{self, Shadows};
use super::source::BoundSource;
use super::source::part::Part;
use super::target::{self, Geometry, GeometrySettings, Target};
use crate::error::Result;
use crate::optics::coherence::Coherence;
use crate::optics::color::{self, Tone};
use crate::optics::spectrum::Illuminant;
use crate::scene::environment::Placement;
use crate::scene::{Background, Camera, Environment, Incident, Light, Room, Scene, Vertex, camera};
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Constant, Depth, Drawing, Pipeline, Stencil};
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Mat4, Vec3};
use std::ops::Range;
use std::sync::Arc;

/// Camera, lights and geometry bounds of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Centre of the scene.
    pub centre: Vec3,
    /// Radius around `centre`.
    pub radius: f32,
    /// Distance from `centre` to the farthest point drawn, at least `radius`.
    pub reach: f32,
    /// Length of a unit of the scene \[m\].
    pub unit: f64,
    /// Lights.
    pub lights: Vec<Light>,
    /// Surroundings, which count as one more light.
    pub environment: Option<Environment>,
    /// True if the surroundings, if any, are displayed as the background.
    pub shows_surroundings: bool,
    /// Albedo of the pigment.
    pub base_color: Vec3,
    /// True if the pigment texture is used.
    pub pigment: bool,
}

impl View {
    /// Returns a view of `scene` with its surroundings, but without its pigment texture, under `lights`. The coherence
    /// already accounts for part of the extent of each light, so it is subtracted.
    pub fn under(scene: &Scene, lights: &[Light], coherence: &Coherence) -> Self {
        let room = Self::of(scene, Vec::new()).room();
        let lights = lights.iter().map(|light| light.map(|own| own.beyond(coherence, &room))).collect();
        Self {
            environment: scene.environment.clone(),
            shows_surroundings: scene.background == Background::Surroundings,
            ..Self::of(scene, lights)
        }
    }

    /// Returns a view of `scene` under `lights` alone, without surroundings and pigment texture.
    pub fn of(scene: &Scene, lights: Vec<Light>) -> Self {
        let bounds = scene.bounds();
        Self {
            camera: scene.camera,
            centre: bounds.centre,
            radius: bounds.radius,
            reach: scene.reach(bounds.centre),
            unit: scene.unit,
            lights,
            environment: None,
            shows_surroundings: false,
            base_color: scene.main_object().base_color,
            pigment: false,
        }
    }

    /// Returns the matrix from the world to the clip space of a picture of `size` pixels.
    pub fn clip_from_world(&self, size: [u32; 2]) -> Mat4 {
        self.camera.clip_from_world(size, self.centre, self.reach)
    }

    /// Returns the position and the unit of the scene.
    pub fn room(&self) -> Room {
        Room { centre: self.centre.as_dvec3(), unit: self.unit }
    }

    /// Returns the number of lights; the surroundings, if any, are the last.
    pub fn light_count(&self) -> usize {
        self.lights.len() + usize::from(self.environment.is_some())
    }

    /// Returns the lights that each sample of a picture by `sampling` draws.
    pub fn schedule(&self, sampling: &Sampling) -> LightSchedule {
        LightSchedule::new(self.lights.len(), self.environment.as_ref().map(Environment::extent), sampling)
    }

    /// Returns true if light number `light` is the surroundings.
    pub fn is_surroundings(&self, light: usize) -> bool {
        light == self.lights.len() && self.environment.is_some()
    }

    /// Returns the surroundings if they are displayed as the background.
    pub fn background(&self) -> Option<&Environment> {
        self.environment.as_ref().filter(|_| self.shows_surroundings)
    }

    /// Returns the illuminant of light number `light` if it differs from the scene's.
    pub fn illuminant(&self, light: usize) -> Option<&Illuminant> {
        self.lights.get(light).and_then(Light::illuminant)
    }

    /// Returns true if any light is a lamp.
    pub fn has_lamps(&self) -> bool {
        self.lights.iter().any(Light::is_lamp)
    }

    /// Returns the light incident on the pixels of `pass`; no light if its number does not exist. Each light has a
    /// separate pair of sequence dimensions, after the pair of the position in the pixel.
    pub fn incident(&self, pass: &LightPass) -> Incident {
        let LightPass { light, sample, weight, .. } = *pass;
        let room = self.room();
        let incident = match (self.lights.get(light), &self.environment) {
            (Some(own), _) => own.emitter.incident(sample.pair(1 + light as u32), sample.count, &room),
            (None, Some(around)) if self.is_surroundings(light) => {
                around.incident(sample.rank(), sample.count)
            }
            _ => Incident::NONE,
        };
        Incident { irradiance: incident.irradiance * weight as f32, ..incident }
    }

    /// Returns the `Frame` block of `pass` in a picture of `size` pixels.
    pub fn block(&self, size: [u32; 2], pass: &LightPass) -> FrameBlock {
        let incident = self.incident(pass);
        let toward = incident.place.map_or(incident.direction, |place| place.point);
        let (centre, radius, jitter) = (self.centre, self.radius, pass.sample.jitter);
        let shadow_from_world = match incident.place {
            None => shadows::clip_from_world(incident.direction, centre, radius, size, jitter),
            Some(place) => shadows::clip_from_lamp(place.point.as_vec3(), centre, radius, size, jitter),
        };
        let mirrored = if self.is_surroundings(pass.light) { pass.weight as f32 } else { 0.0 };
        let clip_from_world = self.clip_from_world(size);
        FrameBlock {
            clip_from_world: camera::jittered(clip_from_world, size, jitter).to_cols_array_2d(),
            eye: self.camera.eye().extend(0.0).to_array(),
            light: toward.as_vec3().extend(incident.variance as f32).to_array(),
            emitter: FrameBlock::emitter_of(incident.place.as_ref()),
            irradiance: incident.irradiance.extend(mirrored).to_array(),
            shadow_from_world: shadow_from_world.to_cols_array_2d(),
            base_color: self.base_color.extend(if self.pigment { 1.0 } else { 0.0 }).to_array(),
            grooves: [0.0; 4],
            surroundings: self.environment.as_ref().map_or([0.0; 4], |environment| {
                let Placement { rotation, exposure } = environment.placement;
                let (sin, cos) = rotation.to_radians().sin_cos();
                [cos as f32, sin as f32, exposure.exp2() as f32, 0.0]
            }),
            sample: pass.sample.block(),
        }
    }
}

/// Geometry pass: finds the surface seen by each pixel and its directions under one light. If the light casts shadows,
/// its depth map is drawn first.
pub struct GeometryPass {
    // One per object.
    pipelines: Vec<Pipeline>,
    // The same under surroundings, if the view has any.
    mirroring: Vec<Pipeline>,
    shadows: Option<Shadows>,
}

impl GeometryPass {
    /// Makes a pass that draws `objects` into `geometry`; the objects then read its depth map.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error or the device is out of memory.
    pub fn new(device: &Arc<Device>, objects: &[DeviceObject], geometry: &Geometry) -> Result<Self> {
        let GeometrySettings { textured, footprints, shadows, mirrored, lamps, several, .. } =
            geometry.settings;
        // Specialisation constants of the fragment stage.
        const TEXTURED: u32 = 0;
        const FOOTPRINTS: u32 = 1;
        const SHADOWS: u32 = 2;
        const MIRRORED: u32 = 3;
        const LAMPS: u32 = 4;
        const GROOVES: u32 = 5;
        let pipeline = |object: &DeviceObject, mirrors: bool| {
            let drawing = Drawing {
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &attributes(),
                colors: &geometry.images(mirrors).map(Image::format).collect::<Vec<_>>(),
                depth: Some(Depth {
                    format: geometry.settings.depth_format(),
                    compare: vk::CompareOp::LESS,
                    write: true,
                    stencil: several.then_some(Stencil::Write),
                }),
            };
            let constants = [
                Constant::new(TEXTURED, textured),
                Constant::new(FOOTPRINTS, footprints),
                Constant::new(SHADOWS, shadows),
                Constant::new(MIRRORED, mirrors),
                Constant::new(LAMPS, lamps),
                Constant::new(GROOVES, object.layout as u32),
            ];
            let fragment = Some(shader!("geometry.frag").with(&constants));
            let sets = [&object.frame.descriptors];
            Pipeline::graphics(device, shader!("surface.vert"), fragment, &drawing, &sets, 0)
        };
        let pipelines = objects.iter().map(|object| pipeline(object, false)).collect::<Result<_>>()?;
        let under_surroundings = if mirrored { objects } else { &[] };
        let mirroring =
            under_surroundings.iter().map(|object| pipeline(object, true)).collect::<Result<_>>()?;
        // Last, because it points the sets of the objects at its depth map.
        let size = geometry.directions.size();
        let shadows = shadows.then(|| Shadows::new(device, objects, size)).transpose()?;
        Ok(Self { pipelines, mirroring, shadows })
    }

    /// Selects the depth map of light number `light` for the next draw, which `block` describes. The device must not be
    /// using the sets of `objects`.
    ///
    /// # Errors
    /// Fails if the device is out of memory for the light's first map.
    pub fn select_shadow(
        &mut self,
        device: &Arc<Device>,
        objects: &[DeviceObject],
        light: usize,
        block: &FrameBlock,
    ) -> Result<()> {
        match &mut self.shadows {
            Some(shadows) => shadows.select(device, objects, light, block.shadow_from_world),
            None => Ok(()),
        }
    }

    /// Records the drawing of `objects` into `geometry`, whose images become readable by shaders. `mirrored`: the light
    /// is the surroundings, and their radiance in the mirrored direction is written too.
    pub fn record(
        &self,
        record: &Recorder<'_>,
        geometry: &Geometry,
        objects: &[DeviceObject],
        mirrored: bool,
    ) {
        let pipelines = if mirrored { &self.mirroring } else { &self.pipelines };
        if let Some(shadows) = &self.shadows {
            shadows.record(record, objects);
        }
        let change = |from: Access, to: Access| -> Vec<_> {
            geometry.images(mirrored).map(|image| (image, from, to)).collect()
        };
        let mut before = change(Access::Nothing, Access::ColorAttachment);
        before.push((&geometry.depth, Access::Nothing, Access::DepthAttachment));
        // Images unused under this light must be readable all the same, because shaders declare them.
        let unused = geometry.mirrored.iter().filter(|_| !mirrored);
        before.extend(unused.map(|image| (image, Access::Nothing, Access::ShaderRead)));
        record.images(&before);
        let mark = geometry.settings.marked.then_some([target::UNCOVERED; 4]);
        let colors: Vec<_> = geometry.images(mirrored).map(|image| (image, mark)).collect();
        record.render(&colors, Some(&geometry.depth), |draw| {
            for (number, (object, pipeline)) in objects.iter().zip(pipelines).enumerate() {
                draw.bind(pipeline, &[&object.frame.descriptors]);
                if geometry.settings.several {
                    draw.stencil(stencil_of(number));
                }
                object.mesh.draw(draw);
            }
        });
        record.images(&change(Access::ColorAttachment, Access::ShaderRead));
    }
}

/// Returns the depth test of passes over the pixels that the geometry pass covered, in a depth of this `format`. Their
/// one triangle lies at the clear depth, so that devices discard uncovered pixels before the fragment shader runs.
/// Software devices do not skip these with a branch in the shader.
pub(super) fn covered(format: vk::Format) -> Depth {
    Depth { format, compare: vk::CompareOp::GREATER, write: false, stencil: None }
}

/// Returns the stencil value of object `number`, from 0; stencil 0 marks uncovered pixels.
fn stencil_of(number: usize) -> u8 {
    (number + 1).min(u8::MAX.into()) as u8
}

/// Pass that shades every covered pixel of a picture once. One triangle covers the picture, because the small triangles
/// of a mesh would leave most lanes of a device idle.
///
/// Adds to the picture: parts of a sum, lights and samples are drawn one after the other.
pub struct PixelPass {
    pipeline: Pipeline,
    // The same under surroundings, if the view has any.
    mirroring: Option<Pipeline>,
    /// Draws per pixel and light.
    pub parts: u32,
    // True if the pass draws only the pixels of its object.
    of_object: bool,
}

impl PixelPass {
    /// Makes the pass that shades the output of a geometry pass with these `settings`, from `source`, with the set
    /// layout of `frame`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn shading(
        device: &Arc<Device>,
        frame: &Descriptors,
        source: &BoundSource,
        settings: GeometrySettings,
    ) -> Result<Self> {
        let stencil = settings.several.then_some(Stencil::Match);
        let depth = Some(Depth { stencil, ..covered(settings.depth_format()) });
        let pipeline = |mirrored: bool| {
            let constants = source.shade_constants(settings, mirrored);
            let (vertex, code) = (shader!("display.vert"), source.shade().with(&constants));
            let (sets, push_bytes) = ([frame, &source.descriptors], size_of::<ShadeBlock>() as u32);
            Pipeline::adding(device, vertex, code, &Self::drawing(depth), &sets, push_bytes)
        };
        Ok(Self {
            pipeline: pipeline(false)?,
            mirroring: settings.mirrored.then(|| pipeline(true)).transpose()?,
            parts: source.parts(settings.mirrored),
            of_object: settings.several,
        })
    }

    /// Makes the pass that measures how fast the device reads the texture of `source`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn probe(device: &Arc<Device>, frame: &Descriptors, source: &BoundSource) -> Result<Self> {
        let code = source.probe().with(source.constants());
        let push_bytes = size_of::<Probe>() as u32;
        let (vertex, sets) = (shader!("display.vert"), [frame, &source.descriptors]);
        let pipeline =
            Pipeline::graphics(device, vertex, Some(code), &Self::drawing(None), &sets, push_bytes)?;
        Ok(Self { pipeline, mirroring: None, parts: 1, of_object: false })
    }

    /// Returns the state of a triangle drawn over `target.radiance`.
    fn drawing(depth: Option<Depth>) -> Drawing<'static> {
        Drawing { vertex_stride: 0, attributes: &[], colors: &[target::RADIANCE], depth }
    }

    /// Adds these `parts` of the sum to the pixels of an object.
    fn draw(&self, draw: &Recorder<'_>, shaded: &ShadedObject<'_>, parts: &Range<u32>) {
        let ShadedObject { number, object, source, mirrored, white, counts, .. } = *shaded;
        let pipeline = self.mirroring.as_ref().filter(|_| mirrored).unwrap_or(&self.pipeline);
        for part in Part::each(self.parts).filter(|part| parts.contains(&part.first)) {
            draw.bind(pipeline, &[&object.frame.descriptors, &source.descriptors]);
            if self.of_object {
                draw.stencil(stencil_of(number));
            }
            let coverage = if counts && part.first == 0 { 1.0 } else { 0.0 };
            let block = ShadeBlock { part, coverage, padding: 0.0, white: white.extend(0.0).to_array() };
            draw.push(pipeline, bytemuck::bytes_of(&block));
            draw.draw(3);
        }
    }

    /// Records the pass of [`PixelPass::probe`] over all of `target.radiance`.
    pub fn record_probe(
        &self,
        record: &Recorder<'_>,
        target: &Target,
        sets: [&Descriptors; 2],
        probe: Probe,
    ) {
        record.images(&[(&target.radiance, Access::Nothing, Access::ColorAttachment)]);
        record.render(&[(&target.radiance, Some([0.0; 4]))], None, |draw| {
            draw.bind(&self.pipeline, &sets);
            draw.push(&self.pipeline, bytemuck::bytes_of(&probe));
            draw.draw(3);
        });
    }
}

/// Draw call of an object under one light.
#[derive(Clone, Copy)]
pub struct ShadedObject<'a> {
    /// Number of the object, from 0.
    pub number: usize,
    /// The object, with its frame.
    pub object: &'a DeviceObject,
    /// Source of the object.
    pub source: &'a BoundSource,
    /// Shading pass.
    pub pass: &'a PixelPass,
    /// True if the light is the surroundings, whose specular order is reflected.
    pub mirrored: bool,
    /// White diffuse surface under the illuminant, linear sRGB.
    pub white: Vec3,
    /// True if this draw adds 1 to the coverage of its pixels.
    pub counts: bool,
}

/// Push constants of `shade.frag`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ShadeBlock {
    part: Part,
    coverage: f32,
    padding: f32,
    white: [f32; 4],
}

/// Records the shading of `objects` in the pixels that `geometry` found, by these `parts` of their sums, into
/// `target.radiance`, which stays a colour attachment. The `first` shading of a picture clears the radiance; the others
/// add to it. Alpha counts the samples that cover a pixel.
pub fn record_shading(
    record: &Recorder<'_>,
    (geometry, target): (&Geometry, &Target),
    objects: &[ShadedObject<'_>],
    parts: Range<u32>,
    first: bool,
) {
    record.images(&[
        (&target.radiance, Access::ColorAttachment, Access::ColorAttachment),
        (&geometry.depth, Access::DepthAttachment, Access::DepthAttachment),
    ]);
    let shade = |draw: &Recorder<'_>| {
        objects.iter().for_each(|shaded| shaded.pass.draw(draw, shaded, &parts));
    };
    if first {
        record.render_over(&[(&target.radiance, Some([0.0; 4]))], &geometry.depth, shade);
    } else {
        record.render_onto(&target.radiance, Some(&geometry.depth), shade);
    }
}

/// Records the barrier that makes `target.radiance` a colour attachment for [`record_shading`].
pub fn begin_shading(record: &Recorder<'_>, target: &Target) {
    record.images(&[(&target.radiance, Access::Nothing, Access::ColorAttachment)]);
}

/// Push constants of `probe.frag`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Probe {
    /// Texture samples per pixel.
    pub samples: u32,
    /// 1 if every pixel reads at a random place, 0 if neighbours read neighbours.
    pub scattered: u32,
}

/// Pass that turns radiance into a displayed picture.
pub struct DisplayPass {
    pipeline: Pipeline,
    descriptors: Descriptors,
    _sampler: Sampler,
}

impl DisplayPass {
    /// Makes a pass that draws one sample into images of `format`, limited to the pixels covered in a depth of
    /// `depth_format`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, format: vk::Format, depth_format: vk::Format) -> Result<Self> {
        Self::with(device, format, Some(covered(depth_format)))
    }

    /// Makes a pass that draws the mean of samples into images of `format`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn of_mean(device: &Arc<Device>, format: vk::Format) -> Result<Self> {
        Self::with(device, format, None)
    }

    /// Makes the pass; without a `depth` test it displays a mean.
    fn with(device: &Arc<Device>, format: vk::Format, depth: Option<Depth>) -> Result<Self> {
        let descriptors = Descriptors::new(device, "display set", &[Binding::texture(0)])?;
        let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[format], depth };
        /// `constant_id` of `display.frag`.
        const MEAN: u32 = 0;
        let constants = [Constant::new(MEAN, depth.is_none())];
        let fragment = Some(shader!("display.frag").with(&constants));
        let pipeline = Pipeline::graphics(
            device,
            shader!("display.vert"),
            fragment,
            &drawing,
            &[&descriptors],
            size_of::<DisplayBlock>() as u32,
        )?;
        let sampler = Sampler::linear(device, "display sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        Ok(Self { pipeline, descriptors, _sampler: sampler })
    }

    /// Points the pass at `radiance`, of one sample or summed. The device must not be using the pass.
    pub fn read_from(&self, radiance: &Image) {
        self.descriptors.image(0, radiance, &self._sampler);
    }

    /// Records the display of `target.radiance` (a colour attachment before) into the pixels of `into` that `geometry`
    /// covers, over the background. Afterwards the radiance is readable by shaders and `into` a colour attachment.
    pub fn record(
        &self,
        record: &Recorder<'_>,
        (geometry, target): (&Geometry, &Target),
        into: &Image,
        shown: Shown,
    ) {
        record.images(&[
            (&target.radiance, Access::ColorAttachment, Access::ShaderRead),
            (into, Access::Nothing, Access::ColorAttachment),
            // The previous pass wrote the depth.
            (&geometry.depth, Access::DepthAttachment, Access::DepthAttachment),
        ]);
        let background = Some(displayed(shown.background));
        record.render_over(&[(into, background)], &geometry.depth, |draw| self.draw(draw, 1, shown));
    }

    /// Records the display of the mean of the `samples` summed samples into `into`, which becomes a colour attachment.
    pub fn record_mean(&self, record: &Recorder<'_>, into: &Image, samples: u32, shown: Shown) {
        record.images(&[(into, Access::Nothing, Access::ColorAttachment)]);
        let background = Some(displayed(shown.background));
        record.render(&[(into, background)], None, |draw| self.draw(draw, samples, shown));
    }

    fn draw(&self, draw: &Recorder<'_>, samples: u32, shown: Shown) {
        draw.bind(&self.pipeline, &[&self.descriptors]);
        draw.push(&self.pipeline, bytemuck::bytes_of(&DisplayBlock::new(samples, shown)));
        draw.draw(3);
    }
}

/// Display settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Exposure \[stops\].
    pub exposure: f64,
    /// Tone mapping of highlights.
    pub tone: Tone,
    /// Colour of the background, linear sRGB; unaffected by exposure and tone.
    pub background: DVec3,
}

impl Shown {
    /// Returns the display settings of `scene`.
    pub fn of(scene: &Scene) -> Self {
        Self { exposure: scene.exposure, tone: scene.tone, background: scene.background.color() }
    }

    /// Returns settings with `exposure` and `background`, without tone mapping.
    pub const fn plain(exposure: f64, background: DVec3) -> Self {
        Self { exposure, tone: Tone::None, background }
    }
}

/// Push constants of `displayed.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct DisplayBlock {
    background: [f32; 3],
    exposure: f32,
    samples: f32,
    neutral: u32,
}

impl DisplayBlock {
    /// Makes the block for the mean of `samples` samples.
    pub(super) fn new(samples: u32, shown: Shown) -> Self {
        Self {
            background: color::map_to_gamut(shown.background).as_vec3().to_array(),
            exposure: shown.exposure as f32,
            samples: samples as f32,
            neutral: (shown.tone == Tone::Neutral).into(),
        }
    }
}

/// Returns the clear colour of a display pass: the sRGB code of `background`, without exposure.
pub(super) fn displayed(background: DVec3) -> [f32; 4] {
    let [r, g, b] = color::display(background, 0.0).map(|code| f32::from(code) / 255.0);
    [r, g, b, 1.0]
}
