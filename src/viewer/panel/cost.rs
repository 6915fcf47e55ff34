//! Cost of the settings, and foot of the panel.

use super::number_field::{FRAMES, quantity};
use super::optics::percent;
use super::rows::{self, value};
use super::section;
use crate::render::source::Extent;
use crate::viewer::error_probe::ProbeStatus;
use crate::viewer::frame::Pace;
use crate::viewer::model::{Model, SaveAs};
use crate::viewer::{graph, style};
use egui::{Align, Layout, RichText, Ui};

/// Shows the graph of frame times and the numbers below it.
pub fn show(ui: &mut Ui, model: &mut Model) {
    section(ui, "What it costs", |ui| {
        graph::show(ui, &model.pacing.history, model.pacing.quality.budget());
        times_and_sizes(ui, model);
        errors(ui, model);
        rows::show(ui, &rows::FPS, |ui| {
            let fps = quantity(&mut model.pacing.fps, &FRAMES).speed(0.2).range(1.0..=240.0);
            ui.add(fps.max_decimals(1));
            ui.checkbox(&mut model.pacing.continuous, "continuous");
        });
    });
}

fn times_and_sizes(ui: &mut Ui, model: &Model) {
    let mib = |bytes: f64| format!("{:.0} MiB", bytes / f64::from(1 << 20));
    for (row, pace) in [(&rows::FRAME_MOVING, Pace::Moving), (&rows::FRAME_AT_REST, Pace::AtRest)] {
        let frame = model.pacing.history.summary(pace).map_or("none yet".to_owned(), |s| {
            let fps = 1e3 / s.p50.max(1e-3);
            format!("{} p50, {} p95, {fps:.1} fps", time(s.p50), time(s.p95))
        });
        value(ui, row, frame);
    }
    if let Some(full) = &model.sources.full {
        let Extent { layers, size: [width, height], bytes } = full.source().extent();
        value(ui, &rows::TEXTURE, format!("{layers} of {width} × {height} texels, {}", mib(bytes as f64)));
    }
    let cost = model.frame.as_ref().and_then(|e| e.cost);
    let terms = model.sources.full.as_ref().and_then(|full| full.source().terms());
    let counted = cost.map_or("not counted yet".to_owned(), |c| match terms {
        Some(terms) => format!("{:.0} a pixel, {terms} terms, {:.0} λ", c.samples, c.wavelengths),
        None => format!("{:.0} a pixel, of a colour table", c.samples),
    });
    value(ui, &rows::READS, counted);
    value(ui, &rows::MEMORY, format!("{} on the device", mib(model.device.memory as f64)));
}

fn errors(ui: &mut Ui, model: &mut Model) {
    if let Some(full) = &model.sources.full {
        let optics = full.optics();
        value(ui, &rows::BOUND, bound(&optics.terms, &optics.wavelengths, optics.tolerance));
    }
    let theory = model.sources.full.as_ref().and_then(|full| full.scalar_theory.as_ref());
    let limited = model.sources.full.as_ref().and_then(|full| full.source().energy()?.note());
    rows::show(ui, &rows::SCALAR_THEORY, |ui| match theory {
        Some(theory) => {
            let lines = [Some(theory.line().to_owned()), limited];
            let lines = lines.into_iter().flatten().collect::<Vec<_>>().join("\n");
            ui.add(egui::Label::new(theory.brief()).truncate()).on_hover_text(lines);
        }
        None => {
            ui.label("not looked up yet");
        }
    });
    rows::show(ui, &rows::MEASURED, |ui| match model.probe {
        Some(ProbeStatus::Done(e)) => {
            let [error, interval] = [e.relative_l2, e.relative_l2_interval].map(|x| x * 1e2);
            let text = format!("{error:.3} ± {interval:.3} % over {} pixels", e.pixels);
            let promised =
                model.sources.full.as_ref().and_then(|full| full.optics().promised_of_one_sample());
            match promised.filter(|promised| e.exceeds(*promised)) {
                Some(promised) => {
                    ui.label(format!("{text}: more than the {} that are promised", percent(promised)));
                }
                None => {
                    ui.label(text);
                }
            }
        }
        Some(ProbeStatus::Running(part)) => {
            ui.label(format!("against the f64 reference, {:.0} %", part * 1e2));
        }
        None => model.actions.measure |= ui.small_button("measure  [E]").clicked(),
    });
}

/// Formats a time in milliseconds, or in seconds from one second on.
fn time(milliseconds: f64) -> String {
    match milliseconds {
        ms if ms < 10.0 => format!("{ms:.1} ms"),
        ms if ms < 1000.0 => format!("{ms:.0} ms"),
        ms => format!("{:.1} s", ms * 1e-3),
    }
}

/// Formats the error bound of a setting: the tolerance, unless the user has set numbers that do not follow from it.
fn bound(terms: &Option<usize>, wavelengths: &Option<usize>, tolerance: f64) -> String {
    match (terms, wavelengths) {
        (None, None) => format!("{} (RMS, relative)", percent(tolerance)),
        (Some(_), None) => "none: terms are set by hand".to_owned(),
        _ => "none: wavelengths are set by hand".to_owned(),
    }
}

/// Shows the device and the buttons.
pub fn foot(ui: &mut Ui, model: &mut Model) {
    ui.add_space(3.0);
    if model.offers_last() {
        let go_on = ui.button("Continue the last window");
        let tip = "Return to the scene, the surface, the settings and the camera of the window that was closed last.";
        model.actions.go_on |= go_on.on_hover_text(tip).clicked();
    }
    let device = egui::Label::new(RichText::new(model.device.line()).small().color(style::FAINT)).truncate();
    ui.add(device).on_hover_text(rows::DEVICE.help());
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let save = ui.button("Save  [S]");
        if save.on_hover_text("Save the picture as PNG; with Shift + S as EXR, too.").clicked() {
            model.actions.save = Some(SaveAs::Png);
        }
        let reset = ui.button("Reset  [R]");
        model.actions.reset |= reset.on_hover_text("Return to the settings at the start.").clicked();
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let keys = ui.button("Keys  [F1]").on_hover_text("List all keys and gestures.");
            model.visible.help |= keys.clicked();
        });
    });
    ui.add_space(2.0);
}
