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

/// What a frame shows.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Centre and radius of what is looked at.
    pub centre: Vec3,
    /// Radius around `centre`.
    pub radius: f32,
    /// Distance from `centre` to the farthest point of what is drawn, at least `radius`.
    pub reach: f32,
    /// Length of a unit of the scene \[m\].
    pub unit: f64,
    /// Lights.
    pub lights: Vec<Light>,
    /// Surroundings, which are one light more.
    pub environment: Option<Environment>,
    /// Whether the surroundings, where there are any, are displayed as the background.
    pub shows_surroundings: bool,
    /// Albedo of the pigment.
    pub base_color: Vec3,
    /// Whether the pigment texture counts.
    pub pigment: bool,
}

impl View {
    /// `scene` under `lights` of this coherence, which holds a part of their extent already, in its surroundings, without its pigment texture.
    pub fn under(scene: &Scene, lights: &[Light], coherence: &Coherence) -> Self {
        let room = Self::of(scene, Vec::new()).room();
        let lights = lights.iter().map(|light| light.map(|own| own.beyond(coherence, &room))).collect();
        Self {
            environment: scene.environment.clone(),
            shows_surroundings: scene.background == Background::Surroundings,
            ..Self::of(scene, lights)
        }
    }

    /// `scene` under `lights` alone, without surroundings and without its pigment texture.
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
            base_color: scene.base_color,
            pigment: false,
        }
    }

    /// World to the clip space of a picture of `size` pixels.
    pub fn clip_from_world(&self, size: [u32; 2]) -> Mat4 {
        self.camera.clip_from_world(size, self.centre, self.reach)
    }

    /// Where and how large the scene is.
    pub fn room(&self) -> Room {
        Room { centre: self.centre.as_dvec3(), unit: self.unit }
    }

    /// Number of lights; the surroundings, where there are any, are the last.
    pub fn light_count(&self) -> usize {
        self.lights.len() + usize::from(self.environment.is_some())
    }

    /// What the samples of a picture by `sampling` draw.
    pub fn schedule(&self, sampling: &Sampling) -> LightSchedule {
        LightSchedule::new(self.lights.len(), self.environment.as_ref().map(Environment::extent), sampling)
    }

    /// Whether light number `light` is the surroundings.
    pub fn is_surroundings(&self, light: usize) -> bool {
        light == self.lights.len() && self.environment.is_some()
    }

    /// The surroundings, where they are displayed as the background.
    pub fn background(&self) -> Option<&Environment> {
        self.environment.as_ref().filter(|_| self.shows_surroundings)
    }

    /// The illuminant of light number `light`, where it has one of its own.
    pub fn illuminant(&self, light: usize) -> Option<&Illuminant> {
        self.lights.get(light).and_then(Light::illuminant)
    }

    /// Whether lamps are among the lights.
    pub fn has_lamps(&self) -> bool {
        self.lights.iter().any(Light::is_lamp)
    }

    /// What the pixels of `pass` get from its light; no light where there is none of that number. Each light has a pair of dimensions of its own,
    /// behind that of the place in the pixel.
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

    /// The `Frame` block for a `pass` in a picture of `size` pixels.
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

/// The pass that finds what each pixel sees, and its directions there under one light; before it, the depth map of a light that casts shadows.
pub struct GeometryPass {
    // One for each object.
    pipelines: Vec<Pipeline>,
    // The same under surroundings, where they are among the lights.
    mirroring: Vec<Pipeline>,
    shadows: Option<Shadows>,
}

impl GeometryPass {
    /// A pass that draws `objects` into `geometry`; they read its depth map from now on.
    ///
    /// # Errors
    /// Where the device refuses or has no room.
    pub fn new(device: &Arc<Device>, objects: &[DeviceObject], geometry: &Geometry) -> Result<Self> {
        let GeometrySettings { textured, footprints, shadows, mirrored, lamps, several, .. } =
            geometry.settings;
        // `constant_id`s of the fragment stage.
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
        // Last, because the objects read its map from now on.
        let size = geometry.directions.size();
        let shadows = shadows.then(|| Shadows::new(device, objects, size)).transpose()?;
        Ok(Self { pipelines, mirroring, shadows })
    }

    /// Selects the depth map of light number `light` for the next drawing, which `block` describes. The device must not be using the sets of `objects`.
    ///
    /// # Errors
    /// When the device has no room for the light's first map.
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

    /// Records the drawing of `objects` into `geometry`, which it leaves readable by shaders, under a light that is drawn from surroundings whose specular
    /// order is `mirrored`, or under another.
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
        // What this light has no use for is readable all the same, because shaders name it.
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

/// The test of passes over what the geometry pass covered, in a depth of this `format`: their one triangle stands where depth was cleared to, so
/// that devices drop everything else before its shader runs, as no branch in it makes software devices do.
pub(super) fn covered(format: vk::Format) -> Depth {
    Depth { format, compare: vk::CompareOp::GREATER, write: false, stencil: None }
}

/// What the stencil holds where object `number`, from 0, is seen; 0 where there is none.
fn stencil_of(number: usize) -> u8 {
    (number + 1).min(u8::MAX.into()) as u8
}

/// A pass that shades every covered pixel of a picture once, neighbours together: small triangles would leave most lanes of a
/// device idle in a fragment stage of their own.
///
/// It adds to what the picture holds: parts of a sum, lights and samples come one after the other.
pub struct PixelPass {
    pipeline: Pipeline,
    // The same under surroundings, where they are among the lights.
    mirroring: Option<Pipeline>,
    /// Draws of a pixel under one light.
    pub parts: u32,
    // Whether it draws only where its object is seen.
    of_object: bool,
}

impl PixelPass {
    /// The pass that shades what the geometry pass finds by its `settings`, from `source`, over the layout of `frame`.
    ///
    /// # Errors
    /// Where the device refuses.
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

    /// The pass that finds out how fast the device reads the texture of `source`.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn probe(device: &Arc<Device>, frame: &Descriptors, source: &BoundSource) -> Result<Self> {
        let code = source.probe().with(source.constants());
        let push_bytes = size_of::<Probe>() as u32;
        let (vertex, sets) = (shader!("display.vert"), [frame, &source.descriptors]);
        let pipeline =
            Pipeline::graphics(device, vertex, Some(code), &Self::drawing(None), &sets, push_bytes)?;
        Ok(Self { pipeline, mirroring: None, parts: 1, of_object: false })
    }

    /// A triangle over `target.radiance`.
    fn drawing(depth: Option<Depth>) -> Drawing<'static> {
        Drawing { vertex_stride: 0, attributes: &[], colors: &[target::RADIANCE], depth }
    }

    /// Adds these `parts` of the sum for what the geometry pass found of an object.
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

/// An object as it is shaded under one light.
#[derive(Clone, Copy)]
pub struct ShadedObject<'a> {
    /// Its number, from 0.
    pub number: usize,
    /// The object, with its frame.
    pub object: &'a DeviceObject,
    /// What it is shaded from.
    pub source: &'a BoundSource,
    /// What shades it.
    pub pass: &'a PixelPass,
    /// Whether the light is drawn from surroundings whose specular order is mirrored.
    pub mirrored: bool,
    /// A white diffuse surface under the illuminant, linear sRGB.
    pub white: Vec3,
    /// Whether its pixels count as covered once more.
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

/// Records the shading of `objects` where `geometry` found them by these `parts` of their sums into `target.radiance`, which it leaves as a colour
/// attachment. The shading adds to what is there; where it is the `first` of a picture, to nothing. Alpha counts the samples that cover a pixel.
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

/// Records what makes `target.radiance` ready for [`record_shading`] of a picture.
pub fn begin_shading(record: &Recorder<'_>, target: &Target) {
    record.images(&[(&target.radiance, Access::Nothing, Access::ColorAttachment)]);
}

/// Push constants of `probe.frag`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Probe {
    /// Texture samples of a pixel.
    pub samples: u32,
    /// 1 where every pixel reads at a place of its own, 0 where neighbours read neighbours.
    pub scattered: u32,
}

/// The pass that turns radiance into a displayed picture.
pub struct DisplayPass {
    pipeline: Pipeline,
    descriptors: Descriptors,
    _sampler: Sampler,
}

impl DisplayPass {
    /// A pass that draws one sample into images of `format` where a depth of `depth_format` says.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn new(device: &Arc<Device>, format: vk::Format, depth_format: vk::Format) -> Result<Self> {
        Self::with(device, format, Some(covered(depth_format)))
    }

    /// A pass that draws the mean of samples into images of `format`.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn of_mean(device: &Arc<Device>, format: vk::Format) -> Result<Self> {
        Self::with(device, format, None)
    }

    /// Without a `depth` test it is of a mean.
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

    /// Points the pass at `radiance`, of a sample or summed. The device must not be using the pass.
    pub fn read_from(&self, radiance: &Image) {
        self.descriptors.image(0, radiance, &self._sampler);
    }

    /// Records the display of `target.radiance` (a colour attachment until now) into `into` where `geometry` covers, over the
    /// background; leaves radiance readable by shaders and `into` a colour attachment.
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
            // The pass before stored it.
            (&geometry.depth, Access::DepthAttachment, Access::DepthAttachment),
        ]);
        let background = Some(displayed(shown.background));
        record.render_over(&[(into, background)], &geometry.depth, |draw| self.draw(draw, 1, shown));
    }

    /// Records the display of the mean of `samples` samples, whose sum the pass reads, into `into`, which it leaves a colour attachment.
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

/// How radiance is displayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Exposure \[stops\].
    pub exposure: f64,
    /// What becomes of highlights.
    pub tone: Tone,
    /// What is displayed where nothing is covered, linear sRGB; neither exposure nor tone changes it.
    pub background: DVec3,
}

impl Shown {
    /// As `scene` says.
    pub fn of(scene: &Scene) -> Self {
        Self { exposure: scene.exposure, tone: scene.tone, background: scene.background.color() }
    }

    /// At `exposure` over `background`, without a tone.
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
    /// For the mean of `samples` samples.
    pub(super) fn new(samples: u32, shown: Shown) -> Self {
        Self {
            background: color::map_to_gamut(shown.background).as_vec3().to_array(),
            exposure: shown.exposure as f32,
            samples: samples as f32,
            neutral: (shown.tone == Tone::Neutral).into(),
        }
    }
}

/// What a display pass clears to: the code of `background`, which no exposure changes.
pub(super) fn displayed(background: DVec3) -> [f32; 4] {
    let [r, g, b] = color::display(background, 0.0).map(|code| f32::from(code) / 255.0);
    [r, g, b, 1.0]
}
