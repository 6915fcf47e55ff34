//! The state that panel, input and background threads share: what the user has set, and what there is to show.

use super::compare::{self, Compare};
use super::controls::in_controls;
use super::error_probe::ProbeStatus;
use super::frame::{LoadedScene, RenderedFrame};
use super::graph::History;
use super::prepared::{Prepared, ROLES, Role};
use super::quality::{Detail, Quality, QualityControl};
use super::settings::{OpticsSettings, ViewSettings};
use crate::error::Error;
use std::sync::Arc;

/// One-off actions that the user has asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Actions {
    /// Save the picture.
    pub save: Option<SaveAs>,
    /// Measure the error.
    pub measure: bool,
    /// Reset all settings.
    pub reset: bool,
    /// Close the window.
    pub close: bool,
    /// Open a dropped file, or a scene by name.
    pub open: Option<String>,
    /// Turn the camera to the point under this pixel.
    pub focus: Option<[f32; 2]>,
}

/// File formats of a saved picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveAs {
    /// The displayed picture.
    Png,
    /// The displayed picture, and the radiance as EXR.
    PngAndExr,
}

/// A line for the user.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The text.
    pub text: String,
    /// Whether it reports an error.
    pub is_error: bool,
}

/// The comparison with another setting.
pub struct Comparison {
    /// What is shown right of the split.
    pub mode: Compare,
    /// Position of the split as a fraction of the picture's width.
    pub split: f32,
    /// The other setting.
    pub optics: OpticsSettings,
    /// The other setting, ready to be drawn.
    pub prepared: Option<Arc<Prepared>>,
}

/// The settings that are ready to be drawn, and the progress of those that are not.
#[derive(Default)]
pub struct Sources {
    /// The user's own.
    pub own: Option<Arc<Prepared>>,
    /// For moving pictures: fewer terms and wavelengths.
    pub coarse: Option<Arc<Prepared>>,
    /// For moving pictures: fewer wavelengths.
    pub fewer_wavelengths: Option<Arc<Prepared>>,
    /// Progress by [`Role`].
    pub progress: [Option<Progress>; ROLES],
}

/// Progress of a setting in preparation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Steps done.
    pub done: usize,
    /// Steps in total.
    pub of: usize,
}

impl Sources {
    /// What moving pictures of `detail` are drawn from, if it is ready; `None` for the user's own.
    pub fn lighter(&self, detail: Detail) -> Option<&Arc<Prepared>> {
        match detail {
            Detail::Full => None,
            Detail::Coarse => self.coarse.as_ref(),
            Detail::FewerWavelengths => self.fewer_wavelengths.as_ref(),
        }
    }

    /// Drops what moving pictures of `detail` are drawn from.
    pub fn forget(&mut self, detail: Detail) {
        match detail {
            Detail::Full => {}
            Detail::Coarse => self.coarse = None,
            Detail::FewerWavelengths => self.fewer_wavelengths = None,
        }
    }

    /// What is being computed, and the fraction done.
    pub fn in_progress(&self) -> Option<(&'static str, f32)> {
        let named = [
            (Role::Own, "computing spectra"),
            (Role::Other, "computing spectra to compare with"),
            (Role::Coarse, "computing spectra for moving"),
            (Role::FewerWavelengths, "computing spectra for moving"),
        ];
        named.into_iter().find_map(|(role, name)| {
            let Progress { done, of } = self.progress[role as usize]?;
            Some((name, done as f32 / of.max(1) as f32))
        })
    }
}

/// When frames are drawn, and how fast.
pub struct Pacing {
    /// Recent frame times.
    pub history: History,
    /// What to leave out while moving.
    pub quality: QualityControl,
    /// Frames a second to keep while moving.
    pub fps: f64,
    /// Whether frames are drawn all the time, not only on changes.
    pub continuous: bool,
    /// Whether camera or lights are moving.
    pub moving: bool,
}

/// Which parts of the user interface are shown.
pub struct Visible {
    /// The panel.
    pub panel: bool,
    /// The list of keys.
    pub help: bool,
    /// The hemisphere.
    pub inset: bool,
}

/// The device, as the panel shows it.
pub struct DeviceStatus {
    /// Name, and why it was chosen.
    pub name: String,
    /// Bytes that the program's resources take.
    pub memory: u64,
    /// Presentation mode.
    pub present_mode: &'static str,
}

/// The settings of each coherence that was chosen last, to return to.
pub struct LastCoherence {
    /// Coherence length \[µm\].
    pub length: f64,
    /// Copies along x and y.
    pub copies: [u32; 2],
}

impl Default for LastCoherence {
    fn default() -> Self {
        // The length of `Coherence::SUNLIGHT`.
        Self { length: 65.0, copies: [3, 3] }
    }
}

/// The state behind the window.
pub struct Model {
    /// What the user has set.
    pub settings: ViewSettings,
    /// The settings at the start.
    pub original: ViewSettings,
    /// The settings of the picture that is shown; those of the user may still be in preparation.
    pub applied: ViewSettings,
    /// The comparison with another setting.
    pub comparison: Comparison,
    /// Coherences to return to.
    pub last_coherence: LastCoherence,
    /// Mesh and pigment.
    pub loaded: Arc<LoadedScene>,
    /// What can be drawn.
    pub sources: Sources,
    /// What is shown.
    pub frame: Option<RenderedFrame>,
    /// When frames are drawn, and how fast.
    pub pacing: Pacing,
    /// The measured error of what is shown.
    pub probe: Option<ProbeStatus>,
    /// The line for the user.
    pub message: Option<Message>,
    /// Which parts of the user interface are shown.
    pub visible: Visible,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// The device.
    pub device: DeviceStatus,
    /// What the user has asked for.
    pub actions: Actions,
    /// Whether the next picture says how it is exposed.
    pub measures_exposure: bool,
}

impl Model {
    /// The state at the start, to keep `fps` frames a second on `device`.
    pub fn new(settings: ViewSettings, loaded: Arc<LoadedScene>, fps: f64, device: String) -> Self {
        Self {
            original: settings.clone(),
            applied: settings.clone(),
            comparison: Comparison {
                mode: Compare::Alone,
                split: 0.5,
                optics: compare::strict(&settings.optics),
                prepared: None,
            },
            last_coherence: LastCoherence::default(),
            settings,
            loaded,
            sources: Sources::default(),
            frame: None,
            pacing: Pacing {
                history: History::default(),
                quality: QualityControl::new(fps),
                fps,
                continuous: false,
                moving: false,
            },
            probe: None,
            message: None,
            visible: Visible { panel: true, help: false, inset: true },
            size: [0, 0],
            device: DeviceStatus { name: device, memory: 0, present_mode: "" },
            actions: Actions::default(),
            measures_exposure: false,
        }
    }

    /// Exposes as a picture asks for that was measured; a reset returns to it.
    pub fn expose(&mut self, stops: f64) {
        (self.settings.exposure, self.original.exposure) = (stops, stops);
        self.measures_exposure = false;
    }

    /// The settings of the picture that is shown: optics as prepared, everything else as set now.
    pub fn shown(&self) -> ViewSettings {
        let (now, done) = (&self.settings, &self.applied);
        ViewSettings {
            scene: done.scene.clone(),
            lights: now.lights.clone(),
            exposure: now.exposure,
            tone: now.tone,
            base_color: now.base_color,
            camera: now.camera,
            ..done.clone()
        }
    }

    /// The quality of the next frame.
    pub fn quality(&self) -> Quality {
        match (&self.frame, self.pacing.moving) {
            // The first frame appears at once, at low resolution, even while moving.
            (None, _) => Quality::FIRST,
            (_, false) => Quality::WHOLE,
            // A comparison always shows the two settings that it names.
            _ => self.pacing.quality.moving(|detail| {
                self.comparison.mode == Compare::Alone && self.sources.lighter(detail).is_some()
            }),
        }
    }

    /// Shows a line to the user.
    pub fn say(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_error: false });
    }

    /// Shows an error to the user.
    pub fn report(&mut self, error: &Error) {
        self.message = Some(Message { text: in_controls(error), is_error: true });
    }
}
