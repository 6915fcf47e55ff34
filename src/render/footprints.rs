//! Sizes of pixel footprints: in (u, v), which decides how fine a table has to be, and on the surface, which decides
//! if a pixel sees the mean over coherence areas.

use super::directions::Directions;
use super::frame::View;
use super::light_passes::LightPass;
use super::object::{ObjectData, ObjectSources};
use super::pigment::Pigment;
use super::renderer::{Renderer, RendererSettings};
use super::sampling::Sampling;
use super::source::{ClassicalGrating, Source};
use crate::error::Result;
use crate::filter::FootprintSizes;
use crate::scene::Mesh;
use crate::scene::camera::pixel_in_clip;
use crate::settings::Optics;
use crate::vk::device::Device;
use std::sync::Arc;

/// Semi-axes of the footprints of a frame: singular values of the Jacobian of (u, v), per pixel, over all lights. A
/// pixel filter of standard deviation s \[pixels\] becomes an ellipse in (u, v) with these semi-axes times s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Distribution {
    // In ascending order.
    minor: Vec<f64>,
    major: Vec<f64>,
}

impl Distribution {
    /// Collects the covered pixels of a frame, one entry of `directions` per light. Pixels whose light or viewer is
    /// below the horizon are not shaded and not counted.
    pub fn of(directions: &[Directions]) -> Self {
        let mut sizes = Self::default();
        for seen in directions {
            let above = |(light, view): (&[f32; 4], &[f32; 4])| light[2] > 0.0 && view[2] > 0.0;
            let shaded = seen.light.iter().zip(&seen.view).map(above);
            for (footprint, _) in seen.footprints.iter().zip(shaded).filter(|(_, shaded)| *shaded) {
                let [minor, major] = semi_axes(*footprint);
                sizes.minor.push(minor);
                sizes.major.push(major);
            }
        }
        sizes.minor.sort_by(f64::total_cmp);
        sizes.major.sort_by(f64::total_cmp);
        sizes
    }

    /// Returns the number of footprints.
    pub fn count(&self) -> usize {
        self.minor.len()
    }

    /// Returns the quantile `share` (0 … 1) of the minor semi-axes; 0 if there are none.
    pub fn minor(&self, share: f64) -> f64 {
        quantile(&self.minor, share)
    }

    /// Returns the quantile `share` (0 … 1) of the major semi-axes; 0 if there are none.
    pub fn major(&self, share: f64) -> f64 {
        quantile(&self.major, share)
    }
}

/// Returns the smaller and the larger singular value of the Jacobian in a footprint `[du/dx, dv/dx, du/dy, dv/dy]`.
pub fn semi_axes(footprint: [f32; 4]) -> [f64; 2] {
    let [a, b, c, d] = footprint.map(f64::from);
    // Sum and difference of the singular values of [[a, c], [b, d]].
    let sum = (a + d).hypot(b - c);
    let difference = (a - d).hypot(b + c);
    [(sum - difference).abs() / 2.0, (sum + difference) / 2.0]
}

/// Returns the quantile `share` (0 … 1) of the ascending `values`; 0 if there are none.
fn quantile(values: &[f64], share: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    values.get((share.clamp(0.0, 1.0) * last as f64).round() as usize).copied().unwrap_or(0.0)
}

/// Returns the smallest footprint sizes over all `views` of pictures of `size` pixels. The longer axis is that of
/// pictures with few samples: many samples of a pixel together average over at least the length that one of few does.
///
/// # Errors
/// Fails if the device is lost or out of memory.
pub fn sizes(
    device: &Arc<Device>,
    mesh: &Mesh,
    views: &[View],
    size: [u32; 2],
    sampling: &Sampling,
) -> Result<FootprintSizes> {
    let source = Source::ClassicalGrating(ClassicalGrating::default());
    let (sources, pigment) = (ObjectSources::new(source, Optics::default()), Pigment::white());
    let objects = [ObjectData::new(mesh, &pigment, &sources)];
    let mut renderer = Renderer::new(device, &objects, size, RendererSettings::default())?;
    views.iter().try_fold(FootprintSizes::default(), |finest, view| {
        let mut of = |sampling: &Sampling| {
            let directions =
                each_light(view, sampling).into_iter().map(|pass| renderer.directions_in(view, &pass));
            Ok(sizes_of(&directions.collect::<Result<Vec<_>>>()?))
        };
        let few = sampling.with_large_footprints();
        let of_few = of(&few)?;
        let shorter = if few == *sampling { of_few.shorter } else { of(sampling)?.shorter };
        Ok(finest.finer(FootprintSizes { shorter, ..of_few }))
    })
}

/// Returns the first pass of each light of `view` in a picture by `sampling`.
fn each_light(view: &View, sampling: &Sampling) -> Vec<LightPass> {
    let first = view.schedule(sampling).after(0).passes.into_iter().flat_map(LightPass::each_light);
    let first: Vec<LightPass> = first.collect();
    let of = |light| first.iter().find(|pass| pass.light == light).copied();
    (0..view.light_count()).filter_map(of).collect()
}

/// Returns the footprint sizes of the shaded pixels in `directions` (one entry per light), as low quantiles.
pub fn sizes_of(directions: &[Directions]) -> FootprintSizes {
    const BELOW_SHORTER: f64 = 0.02;
    const BELOW_LONGER: f64 = 0.25;
    let all = Distribution::of(directions);
    // The filter of a sample is the same for all lights.
    let filter = directions.first().map_or(0.0, |seen| seen.filter);
    FootprintSizes { shorter: filter * all.minor(BELOW_SHORTER), longer: filter * all.major(BELOW_LONGER) }
}

/// Returns the median surface area seen by a covered pixel of `view` \[units of the scene, squared\]; `None` if no
/// pixel shows the front of the surface.
///
/// # Errors
/// Fails if the device is lost, or if the view has no light.
pub fn median_pixel_area(renderer: &mut Renderer, view: &View) -> Result<Option<f64>> {
    let directions = renderer.directions(view, 0)?;
    let depth = renderer.depth()?;
    let mut areas = pixel_areas(view, renderer.target().size(), &depth, &directions.view);
    areas.sort_by(f64::total_cmp);
    Ok((!areas.is_empty()).then(|| quantile(&areas, 0.5)))
}

/// Returns the surface area seen by each covered pixel \[units of the scene, squared\], from its depth and ω_r in its
/// tangent frame.
fn pixel_areas(view: &View, size: [u32; 2], depth: &[f32], to_view: &[[f32; 4]]) -> Vec<f64> {
    let camera = &view.camera;
    let world_from_clip = view.clip_from_world(size).as_dmat4().inverse();
    // Side of a pixel in the plane at distance 1 from the eye.
    let side = f64::from(camera.height_at(1.0)) / f64::from(size[1]);
    let area = |(pixel, (depth, to_view)): (usize, (&f32, &[f32; 4]))| {
        let [covered, cosine] = [to_view[3], to_view[2]];
        if covered == 0.0 || cosine <= 0.0 {
            return None;
        }
        let place = pixel_in_clip(pixel, size).extend((*depth).into());
        let to_viewer = camera.toward_viewer(world_from_clip.project_point3(place));
        // A pixel `side` wide at distance 1 subtends the solid angle side² cos³ of the off-axis angle, and the distance
        // from the eye is `along` over that cosine. For an orthographic camera `along` is 1, and so is the cosine.
        let along = -to_viewer.dot(camera.forward());
        let off_axis = along / to_viewer.length();
        Some(along.powi(2) * side.powi(2) * off_axis / f64::from(cosine))
    };
    depth.iter().zip(to_view).enumerate().filter_map(area).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Incident;

    #[test]
    fn semi_axes_are_singular_values() {
        // A rotation by an angle, stretches of 3 and 0.5, another rotation.
        let (a, b) = (0.7f64, -1.9f64);
        let [u, v] = [a, b].map(|t| [[t.cos(), -t.sin()], [t.sin(), t.cos()]]);
        let stretch = [3.0, 0.5];
        let entry = |i: usize, j: usize| (0..2).map(|k| u[i][k] * stretch[k] * v[k][j]).sum::<f64>() as f32;
        let [minor, major] = semi_axes([entry(0, 0), entry(1, 0), entry(0, 1), entry(1, 1)]);
        assert!((minor - 0.5).abs() < 1e-6 && (major - 3.0).abs() < 1e-6, "{minor}, {major}");
        assert_eq!(semi_axes([0.0; 4]), [0.0; 2]);
        assert_eq!(semi_axes([1.0, 0.0, 0.0, -1.0]), [1.0; 2]);
    }

    #[test]
    fn a_distribution_counts_what_is_shaded_and_no_more() {
        let up = [0.0, 0.0, 1.0, 1.0];
        let seen = Directions {
            incidents: vec![Incident::NONE],
            chosen: Vec::new(),
            falloffs: Vec::new(),
            light_number: 0,
            light: vec![up, up, [0.0, 0.0, -1.0, 1.0], [0.0; 4]],
            view: vec![up, up, up, [0.0; 4]],
            footprints: vec![[2.0, 0.0, 0.0, 1.0], [4.0, 0.0, 0.0, 3.0], [9.0; 4], [0.0; 4]],
            filter: 0.5,
            mirrored: Vec::new(),
            objects: Vec::new(),
        };
        let all = Distribution::of(&[seen]);
        assert_eq!((all.count(), all.minor(0.0), all.minor(1.0), all.major(1.0)), (2, 1.0, 3.0, 4.0));
        assert_eq!(Distribution::of(&[]).major(0.5), 0.0);
    }
}
