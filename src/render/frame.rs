//! A frame: the view that is drawn, and the settings of its display.

use super::frame_set::{FrameBlock, LIGHT_SLOTS, LightBlock, SampleBlock};
use super::light_passes::{LightPass, LightSchedule};
use super::sampling::Sampling;
use super::shadow_map::ShadowSphere;
use crate::optics::coherence::Coherence;
use crate::optics::color::Tone;
use crate::optics::spectrum::Illuminant;
use crate::scene::environment::Placement;
use crate::scene::light::Emitter;
use crate::scene::{Background, Camera, Environment, Incident, Light, Room, Scene, camera};
use glam::{DVec3, Mat4, Vec3};

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
    /// Albedo of the pigment of each object, linear sRGB.
    pub base_colors: Vec<Vec3>,
}

impl View {
    /// Returns a view of `scene` with its surroundings, under `lights`. The coherence already accounts for part of the
    /// extent of each light, so it is subtracted.
    pub fn under(scene: &Scene, lights: &[Light], coherence: &Coherence) -> Self {
        let room = Self::of(scene, Vec::new()).room();
        let lights =
            lights.iter().map(|light| light.map(|emitter| emitter.beyond(coherence, &room))).collect();
        Self {
            environment: scene.environment.clone(),
            shows_surroundings: scene.display.background == Background::Surroundings,
            ..Self::of(scene, lights)
        }
    }

    /// Returns a view of `scene` under `lights` alone, without surroundings.
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
            base_colors: scene.objects.iter().map(|object| object.base_color).collect(),
        }
    }

    /// Returns the matrix from the world to the clip space of a picture of `size` pixels.
    pub fn clip_from_world(&self, size: [u32; 2]) -> Mat4 {
        self.camera.clip_from_world(size, self.centre, self.reach)
    }

    /// Returns true if pixels of both views see the same surface points with the same pigment, whatever the lights.
    pub fn sees_the_same_as(&self, other: &Self) -> bool {
        let seen = |view: &Self| (view.camera, view.centre, view.reach);
        seen(self) == seen(other) && self.base_colors == other.base_colors
    }

    /// Returns the albedo of the pigment of object number `object`; black if there is no such object.
    pub fn base_color(&self, object: usize) -> Vec3 {
        self.base_colors.get(object).copied().unwrap_or_default()
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

    /// Returns the light incident on the pixels of `pass` from its first light: one sample, or those among which each pixel
    /// chooses.
    pub fn incidents(&self, pass: &LightPass) -> Vec<Incident> {
        let slots = if pass.choices.is_some() { LIGHT_SLOTS as u32 } else { 1 };
        (0..slots).map(|slot| self.incident_of(pass.light, slot, pass)).collect()
    }

    /// Returns the light incident on the pixels of `pass` from light number `light`, from the direction in `slot` if pixels
    /// choose; none if there is no such light. Each light has a separate pair of sequence dimensions, after the pair of the
    /// position in the pixel.
    fn incident_of(&self, light: usize, slot: u32, pass: &LightPass) -> Incident {
        let LightPass { sample, weight, .. } = *pass;
        let room = self.room();
        let incident = match (self.lights.get(light), &self.environment) {
            (Some(found), _) => found.emitter.incident(sample.pair(1 + light as u32), sample.count, &room),
            (None, Some(around)) if self.is_surroundings(light) => {
                let (number, of) =
                    pass.choices.map_or((sample.index, sample.count), |choices| choices.number(slot));
                around.incident(number, of)
            }
            _ => Incident::NONE,
        };
        Incident { irradiance: incident.irradiance * weight as f32, ..incident }
    }

    /// Returns the part of the `Frame` block about light number `light` of `pass`, or about the direction of it in `slot`.
    fn light_block(&self, size: [u32; 2], light: usize, slot: u32, pass: &LightPass) -> LightBlock {
        let incident = self.incident_of(light, slot, pass);
        let toward = incident.place.map_or(incident.direction, |place| place.point);
        let mirrored = if self.is_surroundings(light) { pass.weight as f32 } else { 0.0 };
        LightBlock {
            toward: toward.as_vec3().extend(incident.variance as f32).to_array(),
            emitter: LightBlock::emitter_of(&incident),
            irradiance: incident.irradiance.extend(mirrored).to_array(),
            shadow_from_world: self.shadow_from_world(size, light, incident, pass).to_cols_array_2d(),
        }
    }

    /// Returns the matrix from the world to the clip space of the depth map of light number `light` for `pass`, from which
    /// it is `incident`. Samples share the map of the light's centre if its penumbrae are narrower than a pixel. Passes share
    /// the maps of directions that pixels choose.
    fn shadow_from_world(&self, size: [u32; 2], light: usize, incident: Incident, pass: &LightPass) -> Mat4 {
        let (sphere, room) = (self.shadow_sphere(size), self.room());
        let emitter = self.lights.get(light).map(|light| light.emitter);
        // One of very many samples stands for its point of the light alone.
        let end = |emitter: &Emitter, corner: f64| emitter.incident([corner; 2], u32::MAX, &room);
        let hidden =
            emitter.filter(|emitter| sphere.hides_penumbrae_between(&end(emitter, 0.0), &end(emitter, 1.0)));
        let shared = hidden.map(|emitter| emitter.incident([0.5; 2], 1, &room));
        let stays = shared.is_some() || pass.choices.is_some();
        let jitter = if stays { [0.0; 2] } else { pass.sample.jitter };
        let incident = shared.unwrap_or(incident);
        match incident.place {
            None => sphere.clip_from_world(incident.direction, jitter),
            Some(place) => sphere.clip_from_lamp(place.point.as_vec3(), jitter),
        }
    }

    /// Returns the sphere that depth maps cover in pictures of `size` pixels.
    pub fn shadow_sphere(&self, size: [u32; 2]) -> ShadowSphere {
        let distance = self.camera.eye().distance(self.centre);
        let pixel_at = |distance: f32| self.camera.height_at(distance) / size[1].max(1) as f32;
        let nearest = (distance - self.radius).max(0.0);
        ShadowSphere {
            centre: self.centre,
            radius: self.radius,
            pixel: pixel_at(distance),
            nearest_pixel: pixel_at(nearest),
        }
    }

    /// Returns the `Frame` block of `pass` in a picture of `size` pixels, without the fields of an object.
    pub fn block(&self, size: [u32; 2], pass: &LightPass) -> FrameBlock {
        let clip_from_world = self.clip_from_world(size);
        let mut lights = [LightBlock::default(); LIGHT_SLOTS];
        if pass.choices.is_some() {
            for (slot, block) in (0..).zip(&mut lights) {
                *block = self.light_block(size, pass.light, slot, pass);
            }
        } else {
            for light in pass.numbers() {
                lights[pass.place_of(light)] = self.light_block(size, light, 0, pass);
            }
        }
        let (turn, parts) = pass.choices.map_or((0, 0), |choices| (choices.turn, choices.parts));
        FrameBlock {
            clip_from_world: camera::jittered(clip_from_world, size, pass.sample.jitter).to_cols_array_2d(),
            viewer: self.camera.viewer().as_vec4().to_array(),
            lights,
            base_color: [0.0; 4],
            grooves: [0.0, 0.0, 2.0 / size[0] as f32, 2.0 / size[1] as f32],
            surroundings: self.environment.as_ref().map_or([0.0; 4], |environment| {
                let Placement { rotation, exposure } = environment.placement;
                let (sin, cos) = rotation.to_radians().sin_cos();
                [cos as f32, sin as f32, exposure.exp2() as f32, 0.0]
            }),
            sample: SampleBlock { turn, parts, ..pass.sample.block() },
        }
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
        Self {
            exposure: scene.display.exposure,
            tone: scene.display.tone,
            background: scene.display.background.color(),
        }
    }

    /// Returns settings with `exposure` and `background`, without tone mapping.
    pub const fn plain(exposure: f64, background: DVec3) -> Self {
        Self { exposure, tone: Tone::None, background }
    }
}
