//! Rows of the panel: label, tooltip, and the corresponding option of `diffract view`.

use crate::viewer::style;
use crate::viewer::view_settings::ViewSettings;
use egui::{Align, Id, Label, Layout, Rect, RichText, Sense, Ui, vec2};
use std::sync::Arc;

/// Width of the labels [points].
const LABEL: f32 = 100.0;

/// Row of the panel.
pub struct SettingRow {
    /// Label.
    pub label: &'static str,
    /// Tooltip: the quantity shown or set, with its unit.
    pub tip: &'static str,
    /// Option of the command line.
    pub option: Option<&'static str>,
    /// Copies the settings of the row from the second argument to the first.
    pub copy: Option<Copy>,
}

/// Copies a setting from the second settings to the first.
pub type Copy = fn(&mut ViewSettings, &ViewSettings);

impl SettingRow {
    const fn setting(label: &'static str, option: &'static str, tip: &'static str) -> Self {
        Self { label, tip, option: Some(option), copy: None }
    }

    const fn copied(self, copy: Copy) -> Self {
        Self { copy: Some(copy), ..self }
    }

    const fn other(label: &'static str, tip: &'static str) -> Self {
        Self { label, tip, option: None, copy: None }
    }

    /// Returns the tooltip with the option.
    pub fn help(&self) -> String {
        self.option.map_or_else(|| self.tip.to_owned(), |option| format!("{}\n{option}", self.tip))
    }
}

/// Declares the rows, and a list of all.
macro_rules! rows {
    ($($name:ident = $row:expr;)*) => {
        $(pub const $name: SettingRow = $row;)*
        /// All rows.
        pub const ALL: &[&SettingRow] = &[$(&$name),*];
    };
}

rows! {
    SCENE = SettingRow::setting("scene", "diffract view SCENE", "Mesh, camera, lights and surface. What you have set yourself stays.");
    FILE = SettingRow::setting("file", "diffract view FILE", "Open a scene (.toml), a mesh (.obj, .gltf, .glb, .ply, .stl) or a height field, or one that was opened lately; save the scene with all settings as .toml.  [Ctrl + O, Ctrl + S]");
    EXPOSURE = SettingRow::setting("exposure", "--exposure", "Brightness of the picture in stops (EV): one more doubles it.")
        .copied(|to, from| to.exposure = from.exposure);
    TONE = SettingRow::setting("tone mapping", "--tone", "What the display makes of highlights. none: colours as they are, up to the edge of what it can show. \
        neutral: highlights go softly to white.")
        .copied(|to, from| to.tone = from.tone);
    SAMPLES = SettingRow::setting("samples", "--samples", "Samples a pixel that a still picture is the mean of: smooth edges, soft lights. 1: pixel centres only.")
        .copied(|to, from| to.samples = from.samples);
    TURNTABLE = SettingRow::other("turntable", "Pictures of a whole turn of the camera about its target, which are recorded into a new folder.  [T]");
    BASE_COLOR = SettingRow::setting("base colour", "--base-color", "Colour of the pigment below the surface, linear sRGB. Black shows the diffraction alone.")
        .copied(|to, from| to.base_color = from.base_color);
    WINDOWS = SettingRow::setting("windows", "--windows", "mean: what a pixel sees, the average over all positions of the coherence window. \
        one: a single window, with its speckle.")
        .copied(|to, from| to.optics.windows = from.optics.windows);
    BASIS = SettingRow::setting("basis", "--basis", "Functions that the phase is expanded in. optimal: fewest terms for the tolerance. taylor: powers of the height.")
        .copied(|to, from| to.optics.basis = from.optics.basis);
    TOLERANCE = SettingRow::setting("tolerance", "--tolerance", "Accepted relative error of the colours, root mean square. Smaller is slower.")
        .copied(|to, from| to.optics.tolerance = from.optics.tolerance);
    TERMS = SettingRow::setting("terms", "--terms", "Number of terms of the expansion. automatic: as many as the tolerance needs.")
        .copied(|to, from| to.optics.terms = from.optics.terms);
    WAVELENGTHS = SettingRow::setting("wavelengths", "--wavelengths", "Number of wavelengths in the sum over the spectrum. automatic: as many as the tolerance needs.")
        .copied(|to, from| to.optics.wavelengths = from.optics.wavelengths);
    ILLUMINANT = SettingRow::setting("illuminant", "--illuminant", "Spectrum of all lights that have none of their own. D65: daylight. A: incandescent lamp. E: equal energy. LED: neutral white, CIE LED-B3.")
        .copied(|to, from| to.optics.illuminant.clone_from(&from.optics.illuminant));
    COMPARE = SettingRow::other("show", "What lies right of the line. off: nothing. split: the same scene with the settings below. \
        In false colour, how far the picture is from it: error: relative, of radiance. ΔE: CIEDE2000 of what is displayed; 1 is just noticeable. FLIP: what is seen when flipping between them, 0 to 1.  [C, X]");
    OTHER_SURFACE = SettingRow::other("other surface", "The height field of what is compared with: the same, or another, as a model beside a scan.");
    OTHER_LEVEL = SettingRow::other("other level", "What is subtracted from the heights of the other surface: nothing, their mean, or the plane that fits them.");
    SURFACE = SettingRow::setting("height field", "--surface", "The surface that diffracts: a generated one, or a file that was opened or dropped on the window.")
        .copied(|to, from| to.surface.clone_from(&from.surface));
    SPACING = SettingRow::setting("sample spacing", "--pixel-size", "Distance between neighbouring samples of the height image along x and y, in nanometres.")
        .copied(|to, from| to.surface.pixel_size = from.surface.pixel_size);
    HEIGHT = SettingRow::setting("full height", "--height", "Height that white stands for in the height image, in nanometres.")
        .copied(|to, from| to.surface.height = from.surface.height);
    SEED = SettingRow::setting("seed", "--seed", "Which of the many random surfaces of this kind.")
        .copied(|to, from| to.surface.seed = from.surface.seed);
    LEVEL = SettingRow::setting("level", "--level", "What is subtracted from the heights: nothing, their mean, or the plane that fits them.")
        .copied(|to, from| to.surface.set_level(from.surface.level()));
    COHERENCE = SettingRow::setting("coherence", "--coherence", "gaussian: light that is coherent over a certain length. repeats: a finite grating of copies of the patch.")
        .copied(|to, from| to.optics.coherence = from.optics.coherence);
    LENGTH = SettingRow::setting("length", "--coherence gaussian:", "Coherence length on the surface in micrometres. Sunlight: 65 µm.")
        .copied(|to, from| to.optics.coherence = from.optics.coherence);
    COPIES = SettingRow::setting("copies", "--coherence grating:", "Number of copies of the patch along x and y.")
        .copied(|to, from| to.optics.coherence = from.optics.coherence);
    INDEX = SettingRow::setting("refractive index", "--ior", "Refractive index of the surface, for how much it reflects. --material names one with its spectrum.")
        .copied(|to, from| to.optics.reflectance.clone_from(&from.optics.reflectance));
    LIGHT = SettingRow::setting("light", "--light", "θ: degrees from up. φ: degrees from +x toward +y. ×: irradiance over π. Of a lamp in the scene: where it stands, its diameter ⌀ or its width and height, its radiance L or power W. A right drag on the picture moves the first light.")
        .copied(|to, from| to.lights.clone_from(&from.lights));
    SURROUNDINGS = SettingRow::setting("surroundings", "--rotate-environment, --environment-exposure", "How far the surroundings are turned about the vertical, in degrees, and how much brighter they are, in stops (EV). Shift + right drag on the picture turns them.")
        .copied(|to, from| to.surroundings = from.surroundings);
    LIGHT_SPECTRUM = SettingRow::setting("spectrum of a light", "--light ...@a", "The spectrum of this light alone. Without one it has that of the illuminant. A colour table is made for each spectrum.");
    ADD_LIGHT = SettingRow::setting("add a light", "--light", "A point of the sky that shines on the whole scene.");
    ADD_LAMP = SettingRow::setting("add a lamp", "--light sphere:", "A sphere that shines, above the scene.");
    DEVICE = SettingRow::setting("device", "--device, --present", "The device that draws, and how frames reach the display.");
    FRAME_MOVING = SettingRow::other("frame, moving", "Time from the request of a frame to its picture while camera or lights move: median and 95th percentile of the last 120 frames.");
    FRAME_AT_REST = SettingRow::other("frame, at rest", "The same while nothing moves: each frame is drawn whole, however long that takes.");
    TEXTURE = SettingRow::other("texture", "Size of the spectra or colours on the device.");
    READS = SettingRow::other("texture reads", "Texture reads of a covered pixel, with the number of terms and wavelengths that they are summed from.");
    MEMORY = SettingRow::other("memory", "Device memory that the program takes.");
    BOUND = SettingRow::other("error bound", "Relative error that the settings promise, root mean square.");
    MEASURED = SettingRow::other("measured error", "Relative error of random pixels of this picture against the direct sum in f64.  [E]");
    SCALAR_THEORY = SettingRow::other("scalar theory", "Error of the brightness of orders against rigorous optics, by the angle of incidence.");
    FPS = SettingRow::setting("frame rate", "--fps", "Frames a second to keep while something moves, by leaving work out. continuous: draw all the time.  [space]");
}

/// Rows of the inspector.
pub mod inspected {
    use super::SettingRow;

    pub const TO_LIGHT: SettingRow = SettingRow::other(
        "to the light",
        "θ from the surface's normal, φ from its tangent toward its bitangent.",
    );
    pub const TO_VIEWER: SettingRow = SettingRow::other(
        "to the viewer",
        "θ from the surface's normal, φ from its tangent toward its bitangent.",
    );
    pub const UVW: SettingRow = SettingRow::other("u, v, w", "(u, v, w) = −ω_i − ω_r, without unit.");
    pub const FOOTPRINT: SettingRow = SettingRow::other(
        "footprint",
        "Standard deviations of (u, v) that the pixel averages over, along its axes.",
    );
    pub const PERIOD: SettingRow = SettingRow::other(
        "period",
        "Period of the surface whose first order of 450, 550 and 650 nm goes from this light to this viewer: λ/|(u, v)|. \
         Order n comes from n times the period.",
    );
    pub const AZIMUTH: SettingRow = SettingRow::other(
        "azimuth",
        "Direction along which that period repeats, from the tangent toward the bitangent.",
    );
    pub const BRDF: SettingRow = SettingRow::other(
        "BRDF",
        "X, Y and Z [1/sr] for these directions by the f64 reference, not averaged over the footprint.",
    );
    pub const RADIANCE: SettingRow =
        SettingRow::other("radiance", "Linear sRGB of the pixel, all lights and the pigment together.");
    pub const REFERENCE: SettingRow = SettingRow::other(
        "reference",
        "The radiance by the f64 reference, averaged over the same footprint.",
    );
    pub const ERROR: SettingRow =
        SettingRow::other("error", "Relative difference of radiance and reference.");
    pub const SPECTRUM: SettingRow = SettingRow::other(
        "f [1/sr]",
        "The BRDF over the wavelength by the f64 reference, not averaged over the footprint.",
    );
    pub const COPY: SettingRow = SettingRow::other(
        "Copy for eval",
        "Copies the directions as CSV. `diffract eval --queries` answers them with the BRDF that is shown here.",
    );
}

/// Parts of the surface pane.
pub mod surface_pane {
    use super::SettingRow;

    pub const SHOWN: SettingRow = SettingRow::other(
        "heights",
        "heights: in false colour, over the range of almost all of them. relief: as if lit from the upper left, exaggerated.",
    );
    pub const HEIGHTS: SettingRow =
        SettingRow::other("surface", "Drag to draw the line of the profile. Double-click: the middle row.");
    pub const PROFILE: SettingRow =
        SettingRow::other("profile", "The heights along the line, in nanometres.");
    pub const HISTOGRAM: SettingRow = SettingRow::other(
        "distribution",
        "How often each height occurs: probability density over nanometres.",
    );
    pub const WAVELENGTH: SettingRow = SettingRow::other(
        "orders of",
        "Wavelength of the light whose first orders are shown in the power spectrum, in nanometres.",
    );
    pub const POWER: SettingRow = SettingRow::other(
        "power spectrum",
        "Power over spatial frequency, seven decades from black to yellow. What lies within the circle is sent to some viewer by the light that the hemisphere shows. \
         Orange: periods that stand out. White: the inspected pixel.",
    );
}

/// Rows that can be reset, and the requested reset.
#[derive(Clone, Default)]
struct Resets {
    // Labels of the rows whose settings differ from those of a reset. Empty if rows have no reset.
    offered: Arc<Vec<&'static str>>,
    asked: Option<Copy>,
}

/// Offers to reset the following rows to `start` if their `settings` differ from it.
pub fn offer_resets(ui: &Ui, settings: &ViewSettings, start: &ViewSettings) {
    let differs = |copy: Copy| {
        let mut reset = settings.clone();
        copy(&mut reset, start);
        reset != *settings
    };
    let offered = ALL.iter().filter(|row| row.copy.is_some_and(differs)).map(|row| row.label).collect();
    ui.data_mut(|data| data.insert_temp(Id::NULL, Resets { offered: Arc::new(offered), asked: None }));
}

/// Applies the requested reset to `settings`.
pub fn reset(ui: &Ui, settings: &mut ViewSettings, start: &ViewSettings) {
    if let Some(copy) = resets(ui).asked {
        copy(settings, start);
    }
}

/// Shows rows of other settings, which have no reset.
pub fn without_reset(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    let outside = resets(ui);
    ui.data_mut(|data| data.insert_temp(Id::NULL, Resets::default()));
    add(ui);
    ui.data_mut(|data| data.insert_temp(Id::NULL, outside));
}

fn resets(ui: &Ui) -> Resets {
    ui.data(|data| data.get_temp(Id::NULL)).unwrap_or_default()
}

/// Shows `row`, with `add` behind its label; returns its place.
pub fn show(ui: &mut Ui, row: &SettingRow, add: impl FnOnce(&mut Ui)) -> Rect {
    numbered(ui, row, row.label, add)
}

/// Shows `row` as [`show`] does, under another label.
pub fn numbered(ui: &mut Ui, row: &SettingRow, label: &str, add: impl FnOnce(&mut Ui)) -> Rect {
    let height = ui.spacing().interact_size.y;
    let copy = row.copy.filter(|_| resets(ui).offered.contains(&row.label));
    let shown = ui.horizontal_top(|ui| {
        ui.allocate_ui_with_layout(vec2(LABEL, height), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(LABEL);
            name(ui, label, copy);
        });
        ui.horizontal_wrapped(add);
    });
    // Covers the row's controls, because only the topmost area is hovered.
    let whole = ui.interact(shown.response.rect, shown.response.id.with("tip"), Sense::hover());
    let reset = if copy.is_some() { "\nDouble-click the label to reset it." } else { "" };
    whole.on_hover_text(row.help() + reset);
    shown.response.rect
}

/// Shows the label of a row, bright if `copy` undoes a change of the user.
fn name(ui: &mut Ui, label: &str, copy: Option<Copy>) {
    let Some(copy) = copy else {
        ui.add(Label::new(RichText::new(label).color(style::FAINT)).selectable(false));
        return;
    };
    let text = RichText::new(label).color(style::TEXT);
    let label = ui.add(Label::new(text).selectable(false).sense(Sense::click()));
    let mut is_asked = label.double_clicked();
    label.context_menu(|ui| is_asked |= ui.button("Reset").clicked());
    if is_asked {
        let asked = Resets { asked: Some(copy), ..resets(ui) };
        ui.data_mut(|data| data.insert_temp(Id::NULL, asked));
    }
}

/// Shows `row` with a text.
pub fn value(ui: &mut Ui, row: &SettingRow, text: impl Into<String>) {
    show(ui, row, |ui| {
        ui.label(text.into());
    });
}
