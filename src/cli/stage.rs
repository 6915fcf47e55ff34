//! What `profile` and `trade` measure on: a scene on a device, and the reference of its very directions.

use super::options::lights_of;
use super::prepare;
use super::profile::Arguments;
use crate::error::{Error, Result};
use crate::measure::budget::Budget;
use crate::measure::error::{self, PixelErrors};
use crate::optics::coherence::Windows;
use crate::render::frame::View;
use crate::render::picture::{Directions, Painter, Picture};
use crate::render::pigment::Pigment;
use crate::render::reference_picture::{covered, displayed, reference_pixels};
use crate::render::sampling::Sampling;
use crate::render::shading::Shading;
use crate::render::source::cost::Cost;
use crate::render::source::{Source, Summary};
use crate::scene::Scene;
use crate::setup::{self, Method, Settings};
use crate::surface::HeightField;
use crate::vk::device::Device;
use glam::DVec3;
use std::sync::Arc;

/// What stays the same whatever the setting is.
pub struct Stage {
    pub device: Arc<Device>,
    pub scene: Scene,
    pub field: HeightField,
    pub view: View,
    pub size: [u32; 2],
}

/// The f64 picture of a frame.
pub struct Exact {
    /// The covered pixels.
    pub pixels: Vec<usize>,
    /// Linear sRGB of each.
    pub colors: Vec<DVec3>,
}

/// The f64 pictures of one frame, by the windows that they average over; each is made once.
#[derive(Default)]
pub struct References {
    pictures: Vec<(Windows, Exact)>,
}

impl References {
    /// The picture for the windows of `shading`, of the frame that shades `directions`.
    pub fn of(&mut self, stage: &Stage, shading: &Shading, directions: &[Directions]) -> Result<&Exact> {
        let known = self.pictures.iter().position(|(windows, _)| *windows == shading.windows);
        let index = match known {
            Some(index) => index,
            None => {
                let pixels = covered(directions);
                let colors = stage.exact(shading, directions, &pixels)?;
                self.pictures.push((shading.windows, Exact { pixels, colors }));
                self.pictures.len() - 1
            }
        };
        Ok(&self.pictures[index].1)
    }
}

/// A setting, ready to be drawn.
pub struct Ready {
    pub painter: Painter,
    pub summary: Summary,
    pub cost: Cost,
    pub budget: Budget,
    pub directions: Vec<Directions>,
}

impl Stage {
    /// Opens what `arguments` name.
    pub fn set(arguments: &Arguments) -> Result<Self> {
        let method = arguments.optics.picture_method();
        if method == Method::Reference {
            return Err(Error::usage(
                "--method reference has no frames to time",
                "use --method spectral or --method table",
            ));
        }
        arguments.optics.for_pictures(&arguments.colour)?;
        let scene = Scene::open(&arguments.scene)?;
        let field = arguments.surface.load(None, Some(&scene), "elaphe")?;
        let view = View::of(&scene, lights_of(&arguments.light, &scene));
        let device = prepare::device(&arguments.device.wish())?;
        Ok(Self { device, scene, field, view, size: arguments.size })
    }

    /// Pixels of a picture.
    pub fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// A painter from `source`, and the directions that it shades.
    pub fn painter(&self, source: &Source, shading: &Shading) -> Result<(Painter, Vec<Directions>)> {
        let (mesh, pigment, lights) = (&self.scene.mesh, Pigment::white(), self.view.lights.len());
        let mut painter = Painter::new(&self.device, source, shading, mesh, &pigment, self.size, lights)?;
        let directions =
            (0..lights).map(|light| painter.directions(&self.view, light)).collect::<Result<Vec<_>>>()?;
        source.check(shading, &directions)?;
        Ok((painter, directions))
    }

    /// What `arguments` ask for.
    pub fn prepare(&self, arguments: &Arguments, shading: &Shading) -> Result<Ready> {
        let method = arguments.optics.picture_method();
        if method == Method::Reference {
            return Err(Error::usage(
                "--method reference has no frames to time",
                "use --method spectral or --method table",
            ));
        }
        let mut settings = Settings::new(method, shading.clone());
        if setup::averages_footprints(&settings) {
            let sample = Sampling::ONE.sample(0);
            settings.least_footprint =
                prepare::least_footprint(&self.device, &self.scene, &self.view, self.size, &sample)?;
        }
        let source = prepare::source(&self.field, &settings, &self.device)?;
        let (painter, directions) = self.painter(&source, shading)?;
        Ok(Ready {
            painter,
            summary: source.summary(shading),
            cost: source.cost(shading, &directions),
            budget: Budget::of(&source, shading),
            directions,
        })
    }

    /// Errors of what `painter` shows at `count` random pixels, and what an observer sees of them where that is every
    /// pixel.
    pub fn compare(
        &self,
        painter: &mut Painter,
        shading: &Shading,
        directions: &[Directions],
        count: usize,
    ) -> Result<(Option<PixelErrors>, Option<f64>)> {
        let picture = painter.paint(&self.view, self.scene.exposure, self.scene.background)?;
        let covered = covered(directions);
        let pixels = error::sample(&covered, count);
        let exact = self.exact(shading, directions, &pixels)?;
        let errors = PixelErrors::of(&shown(&picture, &pixels), &exact, self.scene.exposure);
        let whole = pixels.len() == covered.len();
        Ok((Some(errors), whole.then(|| self.seen(&picture, &pixels, &exact))))
    }

    /// The f64 reference of `pixels`, linear sRGB.
    pub fn exact(
        &self,
        shading: &Shading,
        directions: &[Directions],
        pixels: &[usize],
    ) -> Result<Vec<DVec3>> {
        let bar = prepare::progress_bar("reference");
        let exact = reference_pixels(&self.field, shading, &self.view, directions, pixels, &|done, of| {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
            Ok(())
        });
        bar.finish_and_clear();
        exact
    }

    /// What an observer sees between `picture` and the one that is `exact` at `pixels`.
    pub fn seen(&self, picture: &Picture, pixels: &[usize], exact: &[DVec3]) -> f64 {
        let mut radiance = vec![[0.0; 4]; picture.radiance.len()];
        for (&pixel, color) in pixels.iter().zip(exact) {
            radiance[pixel] = color.as_vec3().extend(1.0).to_array();
        }
        let exact = displayed(&radiance, self.scene.exposure, self.scene.background);
        error::flip(&picture.display, &exact, picture.size)
    }
}

/// Linear sRGB of `pixels` of `picture`.
pub fn shown(picture: &Picture, pixels: &[usize]) -> Vec<DVec3> {
    let color = |&i: &usize| {
        let [r, g, b, _] = picture.radiance[i];
        DVec3::new(r.into(), g.into(), b.into())
    };
    pixels.iter().map(color).collect()
}
