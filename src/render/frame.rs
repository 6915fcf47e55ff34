//! A frame: depth, shading, display. The same commands draw offscreen and to a window.

use super::device_mesh::attributes;
use super::frame_set::FrameBlock;
use super::object::DeviceObject;
use super::sampling::Sample;
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
use crate::scene::light::most_lights;
use crate::scene::{
    Background, Camera, Environment, Incident, Light, MAX_LIGHTS, Room, Scene, Vertex, camera,
};
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Code, Constant, Depth, Drawing, Pipeline, Stencil};
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
    /// Lights; those beyond [`most_lights`] are not drawn.
    pub lights: Vec<Light>,
    /// Surroundings, from which each sample draws one light more.
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

    /// What the last of the directions is drawn from, where the other lights leave room for it.
    pub fn surroundings(&self) -> Option<&Environment> {
        self.environment.as_ref().filter(|_| self.lights.len() < most_lights(&self.lights))
    }

    /// Directions of light that a sample shades, at most [`most_lights`].
    pub fn light_count(&self) -> usize {
        (self.lights.len() + usize::from(self.environment.is_some())).min(most_lights(&self.lights))
    }

    /// The illuminant of direction of light number `light`, where it has one of its own.
    pub fn illuminant(&self, light: usize) -> Option<&Illuminant> {
        self.lights.get(light).and_then(Light::illuminant)
    }

    /// Whether lamps are among the lights.
    pub fn has_lamps(&self) -> bool {
        self.lights.iter().any(Light::is_lamp)
    }

    /// What `sample` gets from each light, that from the surroundings last. Each light has a pair of dimensions of its own, behind that of the place in
    /// the pixel.
    pub fn incidents(&self, sample: &Sample) -> Vec<Incident> {
        let point = |number: usize| sample.pair(1 + number as u32);
        let room = self.room();
        let lights = self.lights.iter().enumerate();
        let lights = lights.map(|(i, light)| light.emitter.incident(point(i), sample.count, &room));
        let around = self.environment.iter().map(|e| e.incident(sample.rank(), sample.count));
        lights.chain(around).take(self.light_count()).collect()
    }

    /// The `Frame` block for a `sample` of a picture of `size` pixels.
    pub fn block(&self, size: [u32; 2], sample: &Sample) -> FrameBlock {
        let incidents = self.incidents(sample);
        let mut lights = [[0.0, 0.0, 1.0, 0.0]; MAX_LIGHTS];
        let mut emitters = [[0.0; 4]; MAX_LIGHTS];
        let mut irradiances = [[0.0; 4]; MAX_LIGHTS];
        let mut shadow_from_world = [[[0.0; 4]; 4]; MAX_LIGHTS];
        for (i, incident) in incidents.iter().enumerate() {
            let light = incident.place.map_or(incident.direction, |place| place.point);
            lights[i] = light.as_vec3().extend(incident.variance as f32).to_array();
            emitters[i] = FrameBlock::emitter(incident.place.as_ref());
            irradiances[i] = incident.irradiance.extend(0.0).to_array();
            let (centre, radius, jitter) = (self.centre, self.radius, sample.jitter);
            let map = match incident.place {
                None => shadows::clip_from_world(incident.direction, centre, radius, size, jitter),
                Some(place) => shadows::clip_from_lamp(place.point.as_vec3(), centre, radius, size, jitter),
            };
            shadow_from_world[i] = map.to_cols_array_2d();
        }
        let clip_from_world = self.clip_from_world(size);
        FrameBlock {
            clip_from_world: camera::jittered(clip_from_world, size, sample.jitter).to_cols_array_2d(),
            eye: self.camera.eye().extend(0.0).to_array(),
            lights,
            emitters,
            irradiances,
            shadow_from_world,
            base_color: self.base_color.extend(if self.pigment { 1.0 } else { 0.0 }).to_array(),
            grooves: [0.0; 4],
            surroundings: self.surroundings().map_or([0.0; 4], |environment| {
                let Placement { rotation, exposure } = environment.placement;
                let (sin, cos) = rotation.to_radians().sin_cos();
                [cos as f32, sin as f32, exposure.exp2() as f32, 0.0]
            }),
            sample: sample.block(),
        }
    }
}

/// The pass that finds what each pixel sees, and its directions there; before it, the depth maps of lights that cast shadows.
pub struct GeometryPass {
    // One for each object.
    pipelines: Vec<Pipeline>,
    shadows: Option<Shadows>,
}

impl GeometryPass {
    /// A pass that draws `objects` into `geometry`; they read its depth maps from now on.
    ///
    /// # Errors
    /// Where the device refuses or has no room.
    pub fn new(device: &Arc<Device>, objects: &[DeviceObject], geometry: &Geometry) -> Result<Self> {
        let drawing = Drawing {
            vertex_stride: size_of::<Vertex>() as u32,
            attributes: &attributes(),
            colors: &geometry.images().map(Image::format).collect::<Vec<_>>(),
            depth: Some(Depth {
                format: geometry.settings.depth_format(),
                compare: vk::CompareOp::LESS,
                write: true,
                stencil: geometry.settings.several.then_some(Stencil::Write),
            }),
        };
        let GeometrySettings { lights, textured, footprints, shadows, mirrored, lamps, .. } =
            geometry.settings;
        // `constant_id`s of both stages.
        const LIGHTS: u32 = 0;
        const TEXTURED: u32 = 1;
        const FOOTPRINTS: u32 = 2;
        const SHADOWS: u32 = 3;
        const MIRRORED: u32 = 4;
        const LAMPS: u32 = 5;
        const GROOVES: u32 = 6;
        let constants = [
            Constant::new(LIGHTS, lights as u32),
            Constant::new(TEXTURED, textured),
            Constant::new(FOOTPRINTS, footprints),
            Constant::new(SHADOWS, shadows),
            Constant::new(MIRRORED, mirrored),
            Constant::new(LAMPS, lamps),
        ];
        let pipeline = |object: &DeviceObject| {
            let constants = [constants.as_slice(), &[Constant::new(GROOVES, object.layout as u32)]].concat();
            let fragment = Some(shader!("geometry.frag").with(&constants));
            let vertex = shader!("surface.vert").with(&constants);
            Pipeline::graphics(device, vertex, fragment, &drawing, &[&object.frame.descriptors], 0)
        };
        let pipelines = objects.iter().map(pipeline).collect::<Result<_>>()?;
        // Last, because the objects read its maps from now on.
        let size = geometry.directions.size();
        let shadows = shadows.then(|| Shadows::new(device, objects, lights, size)).transpose()?;
        Ok(Self { pipelines, shadows })
    }

    /// Records the drawing of `objects` into `geometry`, which it leaves readable by shaders.
    pub fn record(&self, record: &Recorder<'_>, geometry: &Geometry, objects: &[DeviceObject]) {
        if let Some(shadows) = &self.shadows {
            shadows.record(record, objects);
        }
        let change =
            |from: Access, to: Access| -> Vec<_> { geometry.images().map(|i| (i, from, to)).collect() };
        let mut before = change(Access::Nothing, Access::ColorAttachment);
        before.push((&geometry.depth, Access::Nothing, Access::DepthAttachment));
        record.images(&before);
        let mark = geometry.settings.marked.then_some([target::UNCOVERED; 4]);
        let colors: Vec<_> = geometry.images().map(|image| (image, mark)).collect();
        record.render(&colors, Some(&geometry.depth), |draw| {
            for (number, (object, pipeline)) in objects.iter().zip(&self.pipelines).enumerate() {
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
pub struct PixelPass {
    pipeline: Pipeline,
    // Adds the other parts of a sum to what `pipeline` drew.
    adding: Option<Pipeline>,
    /// Draws of a pixel.
    pub parts: u32,
    // Whether it draws only where its object is seen.
    of_object: bool,
}

impl PixelPass {
    /// The pass that shades what the geometry pass found by its `settings`, from `source`, over the layout of `frame`. Where it `adds`, it adds to
    /// what another has drawn of its object.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn shading(
        device: &Arc<Device>,
        frame: &Descriptors,
        source: &BoundSource,
        settings: GeometrySettings,
        adds: bool,
    ) -> Result<Self> {
        let constants = source.shade_constants(settings);
        let (code, sets) = (source.shade().with(&constants), [frame, &source.descriptors]);
        let push_bytes = size_of::<ShadeBlock>() as u32;
        let stencil = settings.several.then_some(Stencil::Match);
        let depth = Some(Depth { stencil, ..covered(settings.depth_format()) });
        let parts = source.parts(settings);
        let adding = (adds || parts > 1)
            .then(|| {
                let (vertex, drawing) = (shader!("display.vert"), Self::drawing(depth));
                Pipeline::adding(device, vertex, code, &drawing, &sets, push_bytes)
            })
            .transpose()?;
        Ok(Self {
            adding,
            parts,
            of_object: settings.several,
            ..Self::new(device, code, sets, push_bytes, depth)?
        })
    }

    /// The pass that finds out how fast the device reads the texture of `source`.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn probe(device: &Arc<Device>, frame: &Descriptors, source: &BoundSource) -> Result<Self> {
        let code = source.probe().with(source.constants());
        let push_bytes = size_of::<Probe>() as u32;
        Self::new(device, code, [frame, &source.descriptors], push_bytes, None)
    }

    fn new(
        device: &Arc<Device>,
        code: Code<'_>,
        sets: [&Descriptors; 2],
        push_bytes: u32,
        depth: Option<Depth>,
    ) -> Result<Self> {
        let (vertex, drawing) = (shader!("display.vert"), Self::drawing(depth));
        let pipeline = Pipeline::graphics(device, vertex, Some(code), &drawing, &sets, push_bytes)?;
        Ok(Self { pipeline, adding: None, parts: 1, of_object: false })
    }

    /// A triangle over `target.radiance`.
    fn drawing(depth: Option<Depth>) -> Drawing<'static> {
        Drawing { vertex_stride: 0, attributes: &[], colors: &[target::RADIANCE], depth }
    }

    /// Shades what the geometry pass found of an object by these `parts` of its sum.
    fn draw(&self, draw: &Recorder<'_>, shaded: &ShadedObject<'_>, parts: &Range<u32>) {
        let ShadedObject { number, object, source, lights, white, adds, .. } = *shaded;
        for part in Part::each(self.parts).filter(|part| parts.contains(&part.first)) {
            let is_first = part.first == 0 && !adds;
            let pipeline = if is_first { Some(&self.pipeline) } else { self.adding.as_ref() };
            let Some(pipeline) = pipeline else { break };
            draw.bind(pipeline, &[&object.frame.descriptors, &source.descriptors]);
            if self.of_object {
                draw.stencil(stencil_of(number));
            }
            let coverage = if is_first { 1.0 } else { 0.0 };
            let block = ShadeBlock { part, lights, coverage, white: white.extend(0.0).to_array() };
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

/// An object as it is shaded by the lights of one illuminant.
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
    /// The lights that count, one bit each, from the lowest.
    pub lights: u32,
    /// A white diffuse surface under the illuminant, linear sRGB.
    pub white: Vec3,
    /// Whether this adds to what the object's first one has drawn.
    pub adds: bool,
}

/// Push constants of `shade.frag`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ShadeBlock {
    part: Part,
    lights: u32,
    coverage: f32,
    white: [f32; 4],
}

/// Records what makes `target.radiance` ready for [`record_shading`] of what `geometry` found.
pub fn begin_shading(record: &Recorder<'_>, (geometry, target): (&Geometry, &Target)) {
    record.images(&[
        (&target.radiance, Access::Nothing, Access::ColorAttachment),
        (&geometry.depth, Access::DepthAttachment, Access::DepthAttachment),
    ]);
}

/// Records the shading of `objects` where `geometry` found them by these `parts` of their sums, from 0 or from where the last ended, into
/// `target.radiance`, which it leaves as a colour attachment. What is not covered holds anything: who reads radiance asks the depth.
pub fn record_shading(
    record: &Recorder<'_>,
    (geometry, target): (&Geometry, &Target),
    objects: &[ShadedObject<'_>],
    parts: Range<u32>,
) {
    let shade = |draw: &Recorder<'_>| {
        objects.iter().for_each(|shaded| shaded.pass.draw(draw, shaded, &parts));
    };
    if parts.start == 0 {
        record.render_over(&[(&target.radiance, None)], &geometry.depth, shade);
    } else {
        record.images(&[
            (&target.radiance, Access::ColorAttachment, Access::ColorAttachment),
            (&geometry.depth, Access::DepthAttachment, Access::DepthAttachment),
        ]);
        record.render_onto(&target.radiance, &geometry.depth, shade);
    }
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
