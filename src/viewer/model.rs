//! What panel, hand and threads share: the settings, and what there is to tell.

use super::compare::{self, Compare};
use super::graph::History;
use super::judge::Verdict;
use super::pace::{Degree, Pace, Rung};
use super::settings::{Optics, Settings};
use super::studio::{Exhibit, Stage};
use super::worker::{Prepared, ROLES, Role};
use std::sync::Arc;

/// What the window asks the program to do beside drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wants {
    /// Save the picture; with `true` as EXR too.
    pub save: Option<bool>,
    /// Measure the error.
    pub measure: bool,
    /// Back to how it began.
    pub reset: bool,
    /// Close the window.
    pub close: bool,
    /// Open a dropped file, or a scene by name.
    pub open: Option<String>,
    /// Turn to the point under this pixel.
    pub focus: Option<[f32; 2]>,
}

/// A line for the user.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The text.
    pub text: String,
    /// Whether something went wrong.
    pub bad: bool,
}

/// The state behind the window.
pub struct Model {
    /// What the user has set.
    pub settings: Settings,
    /// How it began.
    pub original: Settings,
    /// The settings of the optics that are shown; the user's may still be in the making.
    pub applied: Settings,
    /// The coherence length \[µm\] and the copies that were set last, for whichever the user turns back to.
    pub kept: (f64, [u32; 2]),
    /// The setting to compare with.
    pub other: Optics,
    /// What stands right of the split.
    pub compare: Compare,
    /// Where the split is, part of the picture's width.
    pub split: f32,
    /// Mesh and pigment.
    pub stage: Arc<Stage>,
    /// The user's setting, ready.
    pub own: Option<Arc<Prepared>>,
    /// The setting to compare with, ready.
    pub judge: Option<Arc<Prepared>>,
    /// For moving pictures, ready: fewer wavelengths and layers, and fewer wavelengths alone.
    pub lighter: [Option<Arc<Prepared>>; 2],
    /// Steps done and steps in all of each role in the making.
    pub progress: [Option<(usize, usize)>; ROLES],
    /// What is shown.
    pub exhibit: Option<Exhibit>,
    /// Frame times.
    pub history: History,
    /// What to leave out while moving.
    pub pace: Pace,
    /// Frames a second that the user wants while moving.
    pub fps: f64,
    /// The last measured error, for as long as it belongs to what is shown.
    pub verdict: Option<Verdict>,
    /// Something to say.
    pub message: Option<Message>,
    /// Whether the panel is there.
    pub panel: bool,
    /// Whether the list of keys is there.
    pub help: bool,
    /// Whether frames are drawn without end.
    pub continuous: bool,
    /// Whether the hemisphere is there.
    pub inset: bool,
    /// Whether something moves.
    pub moving: bool,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// The device's name.
    pub device: String,
    /// Bytes of memory that the device's resources take.
    pub memory: u64,
    /// How frames are presented.
    pub present: &'static str,
    /// What is asked for.
    pub wants: Wants,
}

impl Model {
    /// The state at the start.
    pub fn new(settings: Settings, stage: Arc<Stage>, fps: f64, device: String) -> Self {
        Self {
            original: settings.clone(),
            applied: settings.clone(),
            other: compare::strict(&settings.optics),
            kept: (65.0, [3, 3]),
            settings,
            compare: Compare::Alone,
            split: 0.5,
            stage,
            own: None,
            judge: None,
            lighter: [None, None],
            progress: [None; ROLES],
            exhibit: None,
            history: History::default(),
            pace: Pace::new(fps),
            fps,
            verdict: None,
            message: None,
            panel: true,
            help: false,
            continuous: false,
            inset: true,
            moving: false,
            size: [0, 0],
            device,
            memory: 0,
            present: "",
            wants: Wants::default(),
        }
    }

    /// The settings of the picture that is shown: optics that are ready, and everything else at once.
    pub fn shown(&self) -> Settings {
        let (now, done) = (&self.settings, &self.applied);
        Settings {
            scene: done.scene.clone(),
            lights: now.lights.clone(),
            exposure: now.exposure,
            base_color: now.base_color,
            camera: now.camera,
            ..done.clone()
        }
    }

    /// How much a frame does now.
    pub fn rung(&self) -> Rung {
        match (&self.exhibit, self.moving) {
            // The first picture of all comes at once, if coarsely, whatever the hand does meanwhile.
            (None, _) => Rung::FIRST,
            (_, false) => Rung::WHOLE,
            // What is compared is of the settings that are named.
            _ => self.pace.moving(|degree| self.compare == Compare::Alone && self.lighter(degree).is_some()),
        }
    }

    /// What moving pictures of `degree` are drawn from, where it is ready; nothing for the user's own.
    pub fn lighter(&self, degree: Degree) -> Option<&Arc<Prepared>> {
        match degree {
            Degree::Own => None,
            Degree::Coarse => self.lighter[0].as_ref(),
            Degree::FewerWavelengths => self.lighter[1].as_ref(),
        }
    }

    /// A line for the user.
    pub fn say(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), bad: false });
    }

    /// A line for the user about what went wrong.
    pub fn complain(&mut self, error: &crate::error::Error) {
        self.message = Some(Message { text: error.to_string(), bad: true });
    }

    /// What is being made, in words, and how far it is.
    pub fn making(&self) -> Option<(&'static str, f32)> {
        let named = [
            (Role::Own, "computing spectra"),
            (Role::Other, "computing spectra to compare with"),
            (Role::Coarse, "computing spectra for moving"),
            (Role::FewerWavelengths, "computing spectra for moving"),
        ];
        named.into_iter().find_map(|(role, name)| {
            let (done, of) = self.progress[role as usize]?;
            Some((name, done as f32 / of.max(1) as f32))
        })
    }
}
