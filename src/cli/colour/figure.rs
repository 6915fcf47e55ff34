//! Colours by angle as a labelled figure: where they lie in CIELAB, how light they are, and their spectra.

use super::Arguments;
use super::readings::AngleReading;
use crate::cli::captions;
use crate::figure::{Axis, AxisScale, Color, Figure, Mark, MarkShape, Panel, palette};
use crate::surface::HeightField;
use std::f64::consts::PI;

/// Names of the panels.
const PANELS: [&str; 3] = ["chroma", "lightness", "spectra"];
/// Half the width of a chip of colour \[px\].
const CHIP: f64 = 8.0;
/// Least half width of the plane of a* and b*: smaller chroma is hardly seen.
const LEAST_CHROMA: f64 = 10.0;
/// Space above the lightest chip, as a factor.
const HEADROOM: f64 = 1.05;
/// Space around the outermost chips, as a factor.
const MARGIN: f64 = 1.25;

/// Returns the names of the panels of a figure with or without spectra.
pub fn panels(has_spectra: bool) -> &'static [&'static str] {
    if has_spectra { &PANELS } else { &PANELS[..2] }
}

/// Readings of a surface and how they were made.
pub struct ColourFigure<'a> {
    pub arguments: &'a Arguments,
    pub field: &'a HeightField,
    pub readings: &'a [AngleReading],
    /// Wavelengths of the spectra \[µm\]; none without spectra.
    pub wavelengths: &'a [f64],
    /// BRDF \[sr⁻¹\] by wavelength and reading.
    pub spectra: &'a [Vec<f64>],
}

impl ColourFigure<'_> {
    /// Returns the figure.
    pub fn draw(&self) -> Figure {
        let mut panels = vec![self.chroma(), self.lightness()];
        if !self.wavelengths.is_empty() {
            panels.push(self.spectra());
        }
        Figure::new("").row(panels).panel_size(400.0, 400.0).caption(self.caption())
    }

    /// Returns the chips in the plane of a* and b*.
    fn chroma(&self) -> Panel {
        let largest = self.readings.iter().flat_map(|r| [r.lab[1].abs(), r.lab[2].abs()]);
        let end = MARGIN * largest.fold(LEAST_CHROMA, f64::max);
        let axis = |label: &str| Axis::linear(label, -end, end);
        let panel = Panel::new(axis("a*, from green to red"), axis("b*, from blue to yellow"))
            .called(PANELS[0])
            .titled("Hue and chroma");
        self.with_chips(panel.to_scale(), |reading, _| [reading.lab[1], reading.lab[2]])
    }

    /// Returns the chips by lightness.
    fn lightness(&self) -> Panel {
        let is_aspecular = self.readings.iter().all(|reading| reading.aspecular.is_some());
        let x = move |reading: &AngleReading, place: usize| {
            if is_aspecular { reading.aspecular.unwrap_or_default() } else { place as f64 + 1.0 }
        };
        let label = if is_aspecular { "aspecular angle [°]" } else { "number of the direction" };
        let places = self.readings.iter().enumerate().map(|(place, reading)| x(reading, place));
        let most = self.readings.iter().map(|reading| reading.lab[0]).fold(100.0, f64::max);
        let panel =
            Panel::new(Axis::fit(label, AxisScale::Linear, places), Axis::linear("L*", 0.0, HEADROOM * most));
        self.with_chips(panel.called(PANELS[1]).titled("Lightness"), |reading, place| {
            [x(reading, place), reading.lab[0]]
        })
    }

    /// Returns `panel` with a chip for each reading, where `at` puts it.
    fn with_chips(&self, panel: Panel, at: impl Fn(&AngleReading, usize) -> [f64; 2]) -> Panel {
        self.readings.iter().enumerate().fold(panel, |panel, (place, reading)| {
            let points = vec![at(reading, place)];
            let color = Color(reading.display);
            panel.named(reading.name(), Mark::Points { points, color, shape: MarkShape::Chip, radius: CHIP })
        })
    }

    /// Returns the radiance factors.
    fn spectra(&self) -> Panel {
        let nanometres: Vec<f64> = self.wavelengths.iter().map(|wavelength| 1e3 * wavelength).collect();
        let all = self.spectra.iter().flatten().map(|f| PI * f);
        let x = Axis::fit("wavelength [nm]", AxisScale::Linear, nanometres.iter().copied());
        let y = Axis::fit("radiance factor", AxisScale::Linear, all.chain([0.0]));
        let panel = Panel::new(x, y).called(PANELS[2]).titled("Spectra");
        let colors = palette::SERIES.into_iter().cycle();
        self.readings.iter().zip(colors).enumerate().fold(panel, |panel, (place, (reading, color))| {
            let points = nanometres.iter().zip(self.spectra).map(|(nm, f)| [*nm, PI * f[place]]);
            panel.named(reading.name(), Mark::line(points.collect(), color))
        })
    }

    fn caption(&self) -> String {
        let arguments = self.arguments;
        let name = arguments.surface.name(arguments.surface_name.as_deref());
        let aperture = match arguments.aperture {
            0.0 => String::new(),
            degrees => format!(", read through an aperture of {degrees}°"),
        };
        format!(
            "{}{aperture}. CIELAB under the illuminant {}, CIE 1931 2° observer; chips as a display shows them. {}",
            captions::surface(&name, self.field),
            arguments.colour.illuminant.to_string_lossy(),
            captions::sentence(&captions::optics(&arguments.optics))
        )
    }
}
