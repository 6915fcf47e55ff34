//! Sequences of pictures: what moves from one picture to the next, and how their files are numbered.

use crate::error::{Error, Result};
use crate::render::frame::View;
use clap::Args;
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Most pictures of a sequence: seven minutes at 24 a second.
const MOST: i64 = 10_000;
/// Fewest digits of the number in a file's name.
const DIGITS: usize = 4;
/// Views that stand for a whole sequence, 30 degrees from one to the next. On the sphere under a turning light their finest footprints are 1.2
/// times those of 36 views, and sources are made in octaves of that size.
const VIEWS: u32 = 12;

/// Which pictures are drawn instead of one.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Sequence")]
pub struct SequenceOptions {
    /// N pictures, once around: the camera turns about its target by 360/N degrees from each to the next, about the world's up. With
    /// `-o turn.png` the files are turn-0000.png, turn-0001.png and so on. Those that an earlier run finished are kept
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST), allow_hyphen_values = true)]
    turntable: Option<u32>,
    /// N pictures, once around: all lights and the surroundings turn about the world's up by 360/N degrees from each to the next. Files as for --turntable
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST), allow_hyphen_values = true)]
    light_sweep: Option<u32>,
    /// Draw only pictures A to B-1 of the sequence, counted from 0: 0..24 are the first 24. Several machines can share a sequence so
    #[arg(long, value_name = "A..B", value_parser = frames, allow_hyphen_values = true)]
    frames: Option<Range<u32>>,
}

impl SequenceOptions {
    /// The sequence that the options ask for, if they ask for one.
    ///
    /// # Errors
    /// Options that do not go together.
    pub fn chosen(&self) -> Result<Option<Sequence>> {
        let (motion, count) = match (self.turntable, self.light_sweep) {
            (Some(_), Some(_)) => {
                return Err(Error::usage(
                    "--turntable and --light-sweep are two sequences",
                    "give one of them, and the other in a run of its own",
                ));
            }
            (Some(count), None) => (Motion::Turntable, count),
            (None, Some(count)) => (Motion::LightSweep, count),
            (None, None) if self.frames.is_some() => {
                return Err(Error::usage(
                    "--frames is about a sequence of pictures",
                    "add --turntable N or --light-sweep N, or leave --frames away",
                ));
            }
            (None, None) => return Ok(None),
        };
        let frames = self.frames.clone().unwrap_or(0..count);
        if frames.end > count {
            let Range { start, end } = frames;
            return Err(Error::usage(
                format!("--frames {start}..{end} goes beyond the last of {count} pictures"),
                format!("end at {count} at most, which is one past the last"),
            ));
        }
        Ok(Some(Sequence { motion, count, frames }))
    }
}

/// The pictures `A..B` of a sequence, the last one left out.
///
/// # Errors
/// Anything but two whole numbers, the first below the second.
pub fn frames(text: &str) -> Result<Range<u32>> {
    let number = |field: &str| field.trim().parse::<u32>().ok();
    let ends = text.split_once("..").and_then(|(a, b)| Some(number(a)?..number(b)?));
    ends.filter(|frames| !frames.is_empty()).ok_or_else(|| {
        Error::usage(
            format!("`{text}` are no pictures of a sequence"),
            "give the first and one past the last, as in 0..24 for the first 24",
        )
    })
}

/// What turns about the world's up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The camera, about its target.
    Turntable,
    /// The lights.
    LightSweep,
}

/// Pictures of one scene, each turned against the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// What turns.
    pub motion: Motion,
    /// Pictures in a whole turn.
    pub count: u32,
    /// Those that are asked for.
    pub frames: Range<u32>,
}

impl Sequence {
    /// Fails where nothing moves, as `first` has it.
    ///
    /// # Errors
    /// A sweep without lights.
    pub fn check(&self, first: &View) -> Result<()> {
        if self.motion == Motion::LightSweep && first.lights.is_empty() && first.environment.is_none() {
            return Err(Error::usage(
                "--light-sweep turns the lights, and the scene has none",
                "add a light, as in --light 40,180",
            ));
        }
        Ok(())
    }

    /// Picture number `frame`, where `first` is picture number 0.
    pub fn view(&self, first: &View, frame: u32) -> View {
        let degrees = 360.0 * f64::from(frame) / f64::from(self.count);
        let mut view = first.clone();
        match self.motion {
            Motion::Turntable => {
                view.camera.phi = (f64::from(first.camera.phi) + degrees.to_radians()) as f32;
            }
            Motion::LightSweep => {
                let room = first.room();
                view.lights = first.lights.iter().map(|light| light.turned(degrees, &room)).collect();
                if let Some(environment) = &mut view.environment {
                    environment.placement.rotation += degrees;
                }
            }
        }
        view
    }

    /// Views that stand for the whole sequence, whichever of its pictures are asked for: so all runs that share it draw from the same data.
    pub fn typical_views(&self, first: &View) -> Vec<View> {
        let views = self.count.min(VIEWS);
        (0..views).map(|place| self.view(first, place * self.count / views)).collect()
    }

    /// The file of picture number `frame` where `output` is asked for: turn-0007.png for turn.png.
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

    /// The files of all pictures that are asked for.
    pub fn files(&self, output: &Path) -> Vec<PathBuf> {
        self.frames.clone().map(|frame| self.file(output, frame)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Light;
    use crate::scene::Scene;

    fn options(
        turntable: Option<u32>,
        light_sweep: Option<u32>,
        frames: Option<Range<u32>>,
    ) -> SequenceOptions {
        SequenceOptions { turntable, light_sweep, frames }
    }

    fn plate() -> View {
        let scene = Scene::open("plate").unwrap();
        View::of(&scene, vec![Light::point(40.0, 180.0, 2.0), scene.lights[0]])
    }

    #[test]
    fn ranges_leave_their_end_out_and_have_two_ends_in_order() {
        assert_eq!(frames("0..24").unwrap(), 0..24);
        assert_eq!(frames(" 3 .. 4 ").unwrap(), 3..4);
        for bad in ["", "5", "..", "1..", "..5", "5..5", "6..5", "-1..5", "0..=5", "0...5", "0.5..3", "a..b"]
        {
            let e = frames(bad).unwrap_err();
            assert!(e.exit_code() == 2 && e.to_string().contains("as in 0..24"), "{bad}: {e}");
        }
    }

    #[test]
    fn options_that_do_not_go_together_are_refused_with_a_remedy() {
        assert_eq!(options(None, None, None).chosen().unwrap(), None);
        let all = options(Some(24), None, None).chosen().unwrap().unwrap();
        assert_eq!(all, Sequence { motion: Motion::Turntable, count: 24, frames: 0..24 });
        let some = options(None, Some(24), Some(20..24)).chosen().unwrap().unwrap();
        assert_eq!(some, Sequence { motion: Motion::LightSweep, count: 24, frames: 20..24 });
        for (wrong, said) in [
            (options(Some(4), Some(4), None), "give one of them"),
            (options(None, None, Some(0..4)), "add --turntable N or --light-sweep N"),
            (options(Some(4), None, Some(0..5)), "end at 4 at most"),
            (options(Some(4), None, Some(4..5)), "end at 4 at most"),
        ] {
            let e = wrong.chosen().unwrap_err();
            assert!(e.exit_code() == 2 && e.to_string().contains(said), "{e}");
        }
    }

    #[test]
    fn a_turntable_turns_the_camera_alone_and_begins_with_the_scene_s_own_view() {
        let turn = options(Some(8), None, None).chosen().unwrap().unwrap();
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
        let sweep = options(None, Some(4), None).chosen().unwrap().unwrap();
        let first = plate();
        assert_eq!(sweep.view(&first, 0), first);
        let last = sweep.view(&first, 3);
        for (from, to) in first.lights.iter().zip(&last.lights) {
            let [from, to] = [from, to].map(|light| light.from_afar(&first.room()));
            assert_eq!((to.theta, to.intensity), (from.theta, from.intensity));
            let (from, to) = (from.direction(), to.direction());
            assert!((to.x - from.y).abs() < 1e-6 && (to.y + from.x).abs() < 1e-6);
        }
        assert_eq!(View { lights: first.lights.clone(), ..last }, first);
    }

    #[test]
    fn files_have_four_digits_or_as_many_as_the_last_one_needs() {
        let of = |count| options(Some(count), None, None).chosen().unwrap().unwrap();
        assert_eq!(of(24).file(Path::new("out/turn.png"), 23), Path::new("out/turn-0023.png"));
        assert_eq!(of(10_000).file(Path::new("a.b.EXR"), 0), Path::new("a.b-0000.EXR"));
        let many = Sequence { count: 10_001, ..of(24) };
        assert_eq!(many.file(Path::new("turn.png"), 7), Path::new("turn-00007.png"));
        let some = Sequence { frames: 2..4, ..of(24) };
        assert_eq!(some.files(Path::new("t.png")), [Path::new("t-0002.png"), Path::new("t-0003.png")]);
    }

    #[test]
    fn typical_views_are_of_the_whole_turn_whatever_part_is_drawn() {
        let all = options(Some(100), None, None).chosen().unwrap().unwrap();
        let first = plate();
        let views = all.typical_views(&first);
        assert_eq!((views.len(), &views[0]), (12, &first));
        assert_eq!(views[11], all.view(&first, 91));
        assert_eq!(Sequence { frames: 7..8, ..all }.typical_views(&first), views);
        let few = options(Some(3), None, None).chosen().unwrap().unwrap();
        assert_eq!(few.typical_views(&first), [0, 1, 2].map(|frame| few.view(&first, frame)));
    }
}
