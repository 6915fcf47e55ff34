//! The rows of the panel: what each is called, what it sets, and the option of `diffract view` that sets the same.

use crate::viewer::style;
use egui::{Align, DragValue, Label, Layout, RichText, Sense, Ui, vec2};

/// Width of the labels [points].
const LABEL: f32 = 100.0;

/// A row of the panel.
pub struct Row {
    /// The label.
    pub label: &'static str,
    /// What it shows or sets, with the unit.
    pub tip: &'static str,
    /// The option of the command line.
    pub option: Option<&'static str>,
}

impl Row {
    const fn setting(label: &'static str, option: &'static str, tip: &'static str) -> Self {
        Self { label, tip, option: Some(option) }
    }

    const fn other(label: &'static str, tip: &'static str) -> Self {
        Self { label, tip, option: None }
    }

    /// The text beside the pointer.
    pub fn help(&self) -> String {
        self.option.map_or_else(|| self.tip.to_owned(), |option| format!("{}\n{option}", self.tip))
    }
}

/// Declares the rows, and a list of all.
macro_rules! rows {
    ($($name:ident = $row:expr;)*) => {
        $(pub const $name: Row = $row;)*
        #[cfg(test)]
        pub const ALL: &[&Row] = &[$(&$name),*];
    };
}

rows! {
    SCENE = Row::setting("scene", "diffract view SCENE", "Mesh, camera, lights and surface. What you have set yourself stays.");
    EXPOSURE = Row::setting("exposure", "--exposure", "Brightness of the picture in stops (EV): one more doubles it.");
    TONE = Row::setting("tone mapping", "--tone", "What the display makes of highlights. none: colours as they are, up to the edge of what it can show. \
        neutral: highlights go softly to white.");
    SAMPLES = Row::setting("samples", "--samples", "Samples a pixel that a still picture is the mean of: smooth edges, soft lights. 1: pixel centres only.");
    BASE_COLOR = Row::setting("base colour", "--base-color", "Colour of the pigment below the surface, linear sRGB. Black shows the diffraction alone.");
    WINDOWS = Row::setting("windows", "--windows", "mean: what a pixel sees, the average over all positions of the coherence window. \
        one: a single window, with its speckle.");
    METHOD = Row::setting("method", "--method", "table: reads colours that are summed beforehand, the fastest. spectral: sums the wavelengths in every pixel.");
    BASIS = Row::setting("basis", "--basis", "Functions that the phase is expanded in. optimal: fewest terms for the tolerance. taylor: powers of the height.");
    TOLERANCE = Row::setting("tolerance", "--tolerance", "Accepted relative error of the colours, root mean square. Smaller is slower.");
    TERMS = Row::setting("terms", "--terms", "Number of terms of the expansion. automatic: as many as the tolerance needs.");
    WAVELENGTHS = Row::setting("wavelengths", "--wavelengths", "Number of wavelengths in the sum over the spectrum. automatic: as many as the tolerance needs.");
    ILLUMINANT = Row::setting("illuminant", "--illuminant", "Spectrum of the light. D65: daylight. A: incandescent lamp. E: equal energy.");
    COMPARE = Row::other("show", "What lies right of the line. off: nothing. split: the same scene with the settings below. \
        error: its relative difference from them in false colour.  [C]");
    SURFACE = Row::setting("height field", "--surface", "The surface that diffracts: a generated one, or a file that was opened or dropped on the window.");
    SPACING = Row::setting("sample spacing", "--pixel-size", "Distance between neighbouring samples of the height image along x and y, in nanometres.");
    HEIGHT = Row::setting("full height", "--height", "Height that white stands for in the height image, in nanometres.");
    SEED = Row::setting("seed", "--seed", "Which of the many random surfaces of this kind.");
    LEVEL = Row::setting("level", "--level", "What is subtracted from the heights: nothing, their mean, or the plane that fits them.");
    COHERENCE = Row::setting("coherence", "--coherence", "gaussian: light that is coherent over a certain length. repeats: a finite grating of copies of the patch.");
    LENGTH = Row::setting("length", "--coherence gaussian:", "Coherence length on the surface in micrometres. Sunlight: 65 µm.");
    COPIES = Row::setting("copies", "--coherence grating:", "Number of copies of the patch along x and y.");
    INDEX = Row::setting("refractive index", "--ior", "Refractive index of the surface, for how much it reflects. --material names one with its spectrum.");
    LIGHT = Row::setting("light", "--light", "θ: degrees from up. φ: degrees from +x toward +y. ×: irradiance over π. Of a lamp in the scene: where it stands, its diameter ⌀ or its width and height, its radiance L or power W. A right drag on the picture moves the first light.");
    ADD_LIGHT = Row::setting("add a light", "--light", "Four lights at most, three beside surroundings.");
    ADD_LAMP = Row::setting("add a lamp", "--light sphere:", "A sphere that shines, above the scene. Three lights at most where one is a lamp, two beside surroundings.");
    DEVICE = Row::setting("device", "--device, --present", "The device that draws, and how frames reach the display.");
    FRAME = Row::other("frame time", "Time from the request of a frame to its picture: median and 95th percentile of the last 120.");
    TEXTURE = Row::other("texture", "Size of the spectra or colours on the device.");
    READS = Row::other("texture reads", "Texture reads of a covered pixel, with the number of terms and wavelengths that they are summed from.");
    MEMORY = Row::other("memory", "Device memory that the program takes.");
    BOUND = Row::other("error bound", "Relative error that the settings promise, root mean square.");
    MEASURED = Row::other("measured error", "Relative error of random pixels of this picture against the direct sum in f64.  [E]");
    FPS = Row::setting("frame rate", "--fps", "Frames a second to keep while something moves, by leaving work out. continuous: draw all the time.  [space]");
}

/// The rows of the inspector.
pub mod inspected {
    use super::Row;

    pub const TO_LIGHT: Row =
        Row::other("to the light", "θ from the surface's normal, φ from its tangent toward its bitangent.");
    pub const TO_VIEWER: Row =
        Row::other("to the viewer", "θ from the surface's normal, φ from its tangent toward its bitangent.");
    pub const UVW: Row = Row::other("u, v, w", "(u, v, w) = −ω_i − ω_r, without unit.");
    pub const FOOTPRINT: Row = Row::other(
        "footprint",
        "Standard deviations of (u, v) that the pixel averages over, along its axes.",
    );
    pub const PERIOD: Row = Row::other(
        "period",
        "Period of the surface whose first order of 450, 550 and 650 nm goes from this light to this viewer: λ/|(u, v)|. \
         Order n comes from n times the period.",
    );
    pub const AZIMUTH: Row = Row::other(
        "azimuth",
        "Direction along which that period repeats, from the tangent toward the bitangent.",
    );
    pub const BRDF: Row = Row::other(
        "BRDF",
        "X, Y and Z [1/sr] for these directions by the f64 reference, not averaged over the footprint.",
    );
    pub const RADIANCE: Row =
        Row::other("radiance", "Linear sRGB of the pixel, all lights and the pigment together.");
    pub const REFERENCE: Row =
        Row::other("reference", "The radiance by the f64 reference, averaged over the same footprint.");
    pub const ERROR: Row = Row::other("error", "Relative difference of radiance and reference.");
    pub const SPECTRUM: Row = Row::other(
        "f [1/sr]",
        "The BRDF over the wavelength by the f64 reference, not averaged over the footprint.",
    );
    pub const COPY: Row = Row::other(
        "Copy for eval",
        "Copies the directions as CSV. `diffract eval --queries` answers them with the BRDF that is shown here.",
    );
}

/// Shows `row` with what `add` adds behind its label.
pub fn show(ui: &mut Ui, row: &Row, add: impl FnOnce(&mut Ui)) {
    numbered(ui, row, row.label, add);
}

/// As [`show`], under another label.
pub fn numbered(ui: &mut Ui, row: &Row, label: &str, add: impl FnOnce(&mut Ui)) {
    let height = ui.spacing().interact_size.y;
    let shown = ui.horizontal_top(|ui| {
        ui.allocate_ui_with_layout(vec2(LABEL, height), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(LABEL);
            ui.add(Label::new(RichText::new(label).color(style::FAINT)).selectable(false));
        });
        ui.horizontal_wrapped(add);
    });
    // Above what the row holds, because only what lies on top is hovered.
    let whole = ui.interact(shown.response.rect, shown.response.id.with("tip"), Sense::hover());
    whole.on_hover_text(row.help());
}

/// Shows `row` with a text.
pub fn value(ui: &mut Ui, row: &Row, text: impl Into<String>) {
    show(ui, row, |ui| {
        ui.label(text.into());
    });
}

/// A draggable number. A value from the command line may lie outside the range of the drag.
pub fn number<N: egui::emath::Numeric>(value: &mut N) -> DragValue<'_> {
    DragValue::new(value).clamp_existing_to_range(false)
}
