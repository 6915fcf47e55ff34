//! Directions seen by pixels, from rays in f64: the geometry of the reference, which shares no step with the passes
//! that it checks.
//!
//! A ray passes through the position of a sample in its pixel to the nearest triangle of all objects. Normal and
//! tangent are interpolated there, as the mesh defines them, and the vectors to viewer and light are transformed to
//! that frame; `surface.vert` transforms them at the vertices. A footprint is the difference across one pixel on the
//! plane of the triangle.

mod pixel;
mod reflection;
mod surface_place;
mod triangles;

use super::directions::Directions;
use super::frame::View;
use super::grooves::GrooveDirections;
use super::light_passes::LightPass;
use super::object::ObjectTextures;
use crate::optics::coherence::Windows;
use crate::scene::{Mesh, Object, Scene};
use crate::settings::Optics;
use glam::DVec3;
use pixel::{RayFrame, SeenPixel};
use rayon::prelude::*;
use triangles::Triangles;

/// Object for ray casting.
#[derive(Clone, Copy)]
pub struct RayObject<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Orientation of the patch on the mesh.
    pub grooves: &'a GrooveDirections,
    /// True if it casts shadows from lights that do.
    pub casts_shadows: bool,
}

/// Returns the objects of `scene` with their `textures`.
pub fn objects<'a>(scene: &'a Scene, textures: &'a [ObjectTextures]) -> Vec<RayObject<'a>> {
    let object = |(object, textures): (&'a Object, &'a ObjectTextures)| RayObject {
        mesh: &object.mesh,
        grooves: &textures.grooves,
        casts_shadows: !object.is_ground,
    };
    scene.objects.iter().zip(textures).map(object).collect()
}

/// Settings of the data computed in addition to the directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RaySettings {
    /// Width and height of the picture \[pixels\].
    pub size: [u32; 2],
    /// True if footprints are computed.
    pub footprints: bool,
    /// True if lights cast shadows.
    pub shadows: bool,
    /// Variance of (u, v) of the specular order, if it mirrors surroundings.
    pub specular_spread: Option<f64>,
}

impl RaySettings {
    /// Returns the settings for the reference of a picture of `size` pixels by `optics`: the mean over windows is
    /// averaged over footprints, and its specular order mirrors the surroundings.
    pub fn new(size: [u32; 2], shadows: bool, optics: &Optics) -> Self {
        let footprints = optics.windows == Windows::All;
        Self { size, footprints, shadows, specular_spread: optics.specular_spread().filter(|_| footprints) }
    }
}

/// Scene prepared for ray casting.
pub struct RayScene<'a> {
    objects: Vec<RayObject<'a>>,
    triangles: Triangles,
}

impl<'a> RayScene<'a> {
    /// Prepares `objects` for rays.
    pub fn new(objects: Vec<RayObject<'a>>) -> Self {
        let meshes = objects.iter().map(|object| (object.mesh, object.casts_shadows));
        Self { triangles: Triangles::new(meshes), objects }
    }

    /// Casts the rays of `pass` of `view`.
    pub fn directions(&self, view: &View, pass: &LightPass, settings: &RaySettings) -> Directions {
        let mirrors = settings.specular_spread.is_some() && view.is_surroundings(pass.light);
        let incidents = view.incidents(pass);
        let slot = |pixel: usize| {
            let width = settings.size[0] as usize;
            pass.choices.map_or(0, |choices| choices.slot([pixel % width, pixel / width].map(|n| n as u32)))
        };
        let frame = RayFrame {
            scene: self,
            view,
            pass,
            settings,
            incident: incidents[0],
            mirrored: view.environment.as_ref().filter(|_| mirrors),
        };
        let count = settings.size[0] as usize * settings.size[1] as usize;
        let of_pixel = |pixel| RayFrame { incident: incidents[slot(pixel) as usize], ..frame };
        let seen: Vec<Option<SeenPixel>> =
            (0..count).into_par_iter().map(|pixel| of_pixel(pixel).pixel(pixel)).collect();
        let of_all = |wanted: bool| if wanted { seen.as_slice() } else { &[] };
        let unit = |v: DVec3| v.as_vec3().extend(1.0).to_array();
        let each = |of: fn(&SeenPixel) -> DVec3| {
            seen.iter().map(|pixel| pixel.as_ref().map_or([0.0; 4], |pixel| unit(of(pixel)))).collect()
        };
        fn some<T: Default>(all: &[Option<SeenPixel>], of: impl Fn(&SeenPixel) -> T) -> Vec<T> {
            all.iter().map(|pixel| pixel.as_ref().map_or(T::default(), &of)).collect()
        }
        Directions {
            light_number: pass.light,
            light: each(|pixel| pixel.light),
            view: each(|pixel| pixel.view),
            footprints: some(of_all(settings.footprints), |pixel| pixel.footprint),
            filter: pass.sample.footprint,
            chosen: (0..count).filter(|_| incidents.len() > 1).map(|pixel| slot(pixel) as u8).collect(),
            incidents,
            falloffs: some(of_all(view.has_lamps()), |pixel| pixel.falloff),
            mirrored: some(of_all(mirrors), |pixel| pixel.mirrored),
            objects: some(of_all(self.objects.len() > 1), |pixel| pixel.object),
        }
    }
}
