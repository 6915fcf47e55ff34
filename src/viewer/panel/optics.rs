//! The rows of the optics.

use super::{choice, heading, number, row, rows};
use crate::expansion::Basis;
use crate::optics::coherence::{Coherence, Windows};
use crate::setup::Method;
use crate::viewer::model::Model;
use crate::viewer::settings::OpticsSettings;
use crate::viewer::style;
use egui::{RichText, Ui};

/// Shows the user's own setting and the spectrum of the light.
pub fn show(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Optics");
    rows(ui, "optics", |ui| {
        setting(ui, "own", &mut model.settings.optics, model.settings.coherence);
        row(ui, "illuminant", |ui| {
            for name in ["d65", "a", "e"] {
                let chosen = model.settings.illuminant == name;
                if ui.selectable_label(chosen, name.to_uppercase()).clicked() {
                    model.settings.illuminant = name.to_owned();
                }
            }
        });
    });
}

/// Shows the rows of one setting; they depend on its method.
pub fn setting(ui: &mut Ui, id: &str, optics: &mut OpticsSettings, coherence: Coherence) {
    let finite = matches!(coherence, Coherence::Repeats(_));
    if !finite {
        row(ui, "windows", |ui| {
            ui.selectable_value(&mut optics.windows, Windows::All, "mean");
            ui.selectable_value(&mut optics.windows, Windows::ONE, "one");
        });
    }
    if !finite && optics.windows == Windows::All {
        row(ui, "method", |ui| {
            for method in [Method::Table, Method::Spectral] {
                ui.selectable_value(&mut optics.method, method, method.name());
            }
        });
    } else {
        row(ui, "basis", |ui| {
            let all = Basis::ALL.map(|b| (b, b.name()));
            let shown = optics.basis.name();
            choice(ui, &format!("{id} basis"), &mut optics.basis, &all, shown);
        });
    }
    row(ui, "tolerance", |ui| {
        let all = [1e-1, 5e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 1e-4].map(|t| (t, percent(t)));
        let all: Vec<(f64, &str)> = all.iter().map(|(t, name)| (*t, name.as_str())).collect();
        let shown = percent(optics.tolerance);
        choice(ui, &format!("{id} tolerance"), &mut optics.tolerance, &all, &shown);
    });
    if finite || optics.windows != Windows::All {
        named(ui, "terms", &mut optics.terms, 10, 1..=64);
    }
    match coherence {
        Coherence::Gaussian { .. } => named(ui, "wavelengths", &mut optics.wavelengths, 32, 4..=512),
        Coherence::Repeats(_) => row(ui, "wavelengths", |ui| {
            ui.label(RichText::new("where the orders are").color(style::FAINT));
        }),
    }
}

/// A number that follows from the tolerance unless the user sets it; `first` is the value to start with.
fn named(
    ui: &mut Ui,
    label: &str,
    named: &mut Option<usize>,
    first: usize,
    range: std::ops::RangeInclusive<usize>,
) {
    row(ui, label, |ui| {
        let mut own = named.is_some();
        let text =
            if own { RichText::default() } else { RichText::new("from the tolerance").color(style::FAINT) };
        if ui.checkbox(&mut own, text).changed() {
            *named = own.then_some(first);
        }
        if let Some(n) = named {
            ui.add(number(n).speed(0.2).range(range));
        }
    });
}

/// A fraction in percent.
pub fn percent(part: f64) -> String {
    format!("{} %", (part * 1e6).round() / 1e4)
}
