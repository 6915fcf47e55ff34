//! Sequences of pictures: the motion between pictures and the numbers in their file names.

use super::frame::View;
use crate::error::{Error, Result};
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Minimum number of digits in a file name.
const DIGITS: usize = 4;
/// Views that represent a whole sequence, 30 degrees apart. On the sphere under a turning light their smallest
/// footprints are 1.2 times those of 36 views, and sources are made in octaves of footprint size.
const VIEWS: u32 = 12;

/// Rotation about the world's up axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The camera, about its target.
    Turntable,
    /// The lights.
    LightSweep,
}

/// Sequence of pictures of one scene that is rotated step by step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// Rotated part.
    pub motion: Motion,
    /// Pictures in a whole turn.
    pub count: u32,
    /// Numbers of the pictures to draw.
    pub frames: Range<u32>,
}

impl Sequence {
    /// Checks that something moves in the sequence that starts with `first`.
    ///
    /// # Errors
    /// Fails for a light sweep without lights.
    pub fn check(&self, first: &View) -> Result<()> {
        if self.motion == Motion::LightSweep && first.lights.is_empty() && first.environment.is_none() {
            return Err(Error::usage(
                "a light sweep turns the lights, and the scene has none",
                "add a light",
            ));
        }
        Ok(())
    }

    /// Returns the view of picture number `frame`; `first` is the view of picture number 0.
    pub fn view(&self, first: &View, frame: u32) -> View {
        let degrees = 360.0 * f64::from(frame) / f64::from(self.count);
        let mut view = first.clone();
        match self.motion {
            Motion::Turntable => {
                view.camera.phi = (f64::from(first.camera.phi) + degrees.to_radians()) as f32;
            }
            Motion::LightSweep => {
                let room = first.room();
                view.lights = first
                    .lights
                    .iter()
                    .map(|light| light.map(|emitter| emitter.turned(degrees, &room)))
                    .collect();
                if let Some(environment) = &mut view.environment {
                    environment.placement.rotation += degrees;
                }
            }
        }
        view
    }

    /// Returns views that represent the whole sequence, independent of the pictures to draw, so that all runs of a
    /// sequence use the same data.
    pub fn typical_views(&self, first: &View) -> Vec<View> {
        let views = self.count.min(VIEWS);
        (0..views).map(|place| self.view(first, place * self.count / views)).collect()
    }

    /// Returns the file name of picture number `frame` for `output`: turn-0007.png for turn.png.
    pub fn file(&self, output: &Path, frame: u32) -> PathBuf {
        let digits = DIGITS.max(self.count.saturating_sub(1).to_string().len());
        let mut name = OsString::from(output.file_stem().unwrap_or_default());
        name.push(format!("-{frame:0digits$}"));
        if let Some(extension) = output.extension() {
            name.push(".");
            name.push(extension);
        }
        output.with_file_name(name)
    }

    /// Returns the file names of all pictures to draw.
    pub fn files(&self, output: &Path) -> Vec<PathBuf> {
        self.frames.clone().map(|frame| self.file(output, frame)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Light, Scene};

    fn whole(motion: Motion, count: u32) -> Sequence {
        Sequence { motion, count, frames: 0..count }
    }

    fn plate() -> View {
        let scene = Scene::open("plate").unwrap();
        View::of(&scene, vec![Light::point(40.0, 180.0, 2.0), scene.lights[0].clone()])
    }

    #[test]
    fn a_turntable_turns_the_camera_alone_and_begins_with_the_scene_s_own_view() {
        let turn = whole(Motion::Turntable, 8);
        let first = plate();
        assert_eq!(turn.view(&first, 0), first);
        let third = turn.view(&first, 2);
        // The eye goes a quarter around, from +x to +y.
        let [from, to] = [&first, &third].map(|view| view.camera.eye() - view.camera.target);
        assert!((to.x + from.y).abs() < 1e-6 && (to.y - from.x).abs() < 1e-6 && (to.z - from.z).abs() < 1e-6);
        assert_eq!(View { camera: first.camera, ..third }, first);
    }

    #[test]
    fn a_light_sweep_turns_every_light_and_nothing_else() {
        let sweep = whole(Motion::LightSweep, 4);
        let first = plate();
        assert_eq!(sweep.view(&first, 0), first);
        let last = sweep.view(&first, 3);
        for (from, to) in first.lights.iter().zip(&last.lights) {
            let [from, to] = [from, to].map(|light| light.emitter.from_afar(&first.room()));
            assert_eq!((to.theta, to.intensity), (from.theta, from.intensity));
            let (from, to) = (from.direction(), to.direction());
            assert!((to.x - from.y).abs() < 1e-6 && (to.y + from.x).abs() < 1e-6);
        }
        assert_eq!(View { lights: first.lights.clone(), ..last }, first);
    }

    #[test]
    fn files_have_four_digits_or_as_many_as_the_last_one_needs() {
        let of = |count| whole(Motion::Turntable, count);
        assert_eq!(of(24).file(Path::new("out/turn.png"), 23), Path::new("out/turn-0023.png"));
        assert_eq!(of(10_000).file(Path::new("a.b.EXR"), 0), Path::new("a.b-0000.EXR"));
        let many = Sequence { count: 10_001, ..of(24) };
        assert_eq!(many.file(Path::new("turn.png"), 7), Path::new("turn-00007.png"));
        let some = Sequence { frames: 2..4, ..of(24) };
        assert_eq!(some.files(Path::new("t.png")), [Path::new("t-0002.png"), Path::new("t-0003.png")]);
    }

    #[test]
    fn typical_views_are_of_the_whole_turn_whatever_part_is_drawn() {
        let all = whole(Motion::Turntable, 100);
        let first = plate();
        let views = all.typical_views(&first);
        assert_eq!((views.len(), &views[0]), (12, &first));
        assert_eq!(views[11], all.view(&first, 91));
        assert_eq!(Sequence { frames: 7..8, ..all }.typical_views(&first), views);
        let few = whole(Motion::Turntable, 3);
        assert_eq!(few.typical_views(&first), [0, 1, 2].map(|frame| few.view(&first, frame)));
    }
}
