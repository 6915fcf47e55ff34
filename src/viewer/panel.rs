//! The panel: what can be set, and what it costs.

use super::compare::Compare;
use super::judge::Verdict;
use super::model::Model;
use super::settings::Optics;
use super::{graph, style};
use crate::expansion::Basis;
use crate::render::color_table::Filter;
use crate::render::resources::Reads;
use crate::scene::scene_file::BUILT_IN;
use crate::scene::{Light, MAX_LIGHTS};
use crate::surface::synth::Kind;
use crate::surface::{Level, Source};
use egui::{Align, ComboBox, DragValue, Grid, Layout, RichText, ScrollArea, Ui};

/// Width of the panel in points.
pub const WIDTH: f32 = 336.0;
/// Width of the labels.
const LABEL: f32 = 92.0;

/// Shows the panel and changes `model` as the user says: what it costs stays in sight, the rest scrolls.
pub fn show(ui: &mut Ui, model: &mut Model) {
    ui.spacing_mut().item_spacing.y = 4.0;
    egui::Panel::bottom("costs").frame(egui::Frame::new()).show_separator_line(false).show(ui, |ui| {
        cost(ui, model);
        foot(ui, model);
    });
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        scene(ui, model);
        optics(ui, model);
        compare(ui, model);
        surface(ui, model);
        lights(ui, model);
    });
}

fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(7.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(text).color(style::ACCENT).strong());
        let rest = ui.available_rect_before_wrap();
        let y = rest.center().y + 1.0;
        ui.painter().hline(rest.x_range(), y, egui::Stroke::new(1.0, style::GRID));
    });
    ui.add_space(1.0);
}

/// A grid of labels and what belongs to them.
fn rows(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    Grid::new(name).num_columns(2).min_col_width(LABEL).max_col_width(WIDTH - LABEL - 44.0).show(ui, add);
}

fn row(ui: &mut Ui, label: &str, add: impl FnOnce(&mut Ui)) {
    ui.label(RichText::new(label).color(style::FAINT));
    ui.horizontal(add);
    ui.end_row();
}

fn value(ui: &mut Ui, label: &str, text: impl Into<String>) {
    row(ui, label, |ui| {
        ui.add(egui::Label::new(text.into()).truncate());
    });
}

fn choice<T: PartialEq + Copy>(ui: &mut Ui, id: &str, now: &mut T, all: &[(T, &str)], shown: &str) {
    ComboBox::from_id_salt(id).selected_text(shown).width(WIDTH - LABEL - 64.0).show_ui(ui, |ui| {
        for (item, name) in all {
            ui.selectable_value(now, *item, *name);
        }
    });
}

/// The end of a path, which is what tells files apart.
fn short(name: &str) -> &str {
    std::path::Path::new(name).file_name().and_then(|n| n.to_str()).unwrap_or(name)
}

fn scene(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Scene");
    rows(ui, "scene", |ui| {
        row(ui, "scene", |ui| {
            let mut chosen = None;
            ComboBox::from_id_salt("scene name")
                .selected_text(short(&model.settings.scene))
                .width(WIDTH - LABEL - 64.0)
                .show_ui(ui, |ui| {
                    for (name, _) in BUILT_IN {
                        if ui.selectable_label(model.settings.scene == name, name).clicked() {
                            chosen = Some(name.to_owned());
                        }
                    }
                });
            if chosen.is_some() {
                model.wants.open = chosen;
            }
        });
        row(ui, "exposure", |ui| {
            let exposure = &mut model.settings.exposure;
            ui.add(DragValue::new(exposure).speed(0.05).range(-20.0..=20.0).fixed_decimals(1).suffix(" EV"));
        });
        row(ui, "base colour", |ui| {
            let mut rgb = model.settings.base_color.to_array();
            if ui.color_edit_button_rgb(&mut rgb).changed() {
                // Four digits are more than a display shows, and short to write on a command line.
                model.settings.base_color = rgb.map(|c| (c * 1e4).round() / 1e4).into();
            }
            ui.label(RichText::new("pigment below the surface").small().color(style::FAINT));
        });
    });
}

fn surface(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Surface");
    rows(ui, "surface", |ui| {
        let source = &mut model.settings.surface;
        let kind = Kind::from_name(&source.name);
        row(ui, "height field", |ui| {
            let mut chosen = None;
            ComboBox::from_id_salt("surface name")
                .selected_text(short(&source.name))
                .width(WIDTH - LABEL - 64.0)
                .show_ui(ui, |ui| {
                    for other in Kind::ALL {
                        if ui.selectable_label(kind == Some(other), other.name()).clicked() {
                            chosen = Some(other);
                        }
                    }
                });
            if let Some(kind) = chosen.filter(|k| Some(*k) != kind) {
                *source = Source {
                    name: kind.name().to_owned(),
                    pixel_size: None,
                    height: None,
                    level: Level::None,
                    seed: 1,
                };
            }
        });
        if kind.is_none() {
            units(ui, source);
        } else if matches!(kind, Some(Kind::Elaphe | Kind::Xenopeltis)) {
            row(ui, "seed", |ui| {
                ui.add(DragValue::new(&mut source.seed).range(0..=9999));
            });
        }
        row(ui, "level", |ui| {
            for level in [Level::None, Level::Mean, Level::Plane] {
                ui.selectable_value(&mut source.level, level, level.name());
            }
        });
        row(ui, "coherence", |ui| {
            let length = &mut model.settings.coherence;
            ui.add(DragValue::new(length).speed(0.5).range(1.0..=200.0).fixed_decimals(1).suffix(" µm"));
        });
        row(ui, "index", |ui| {
            let ior = &mut model.settings.ior;
            ui.add(DragValue::new(ior).speed(0.01).range(1.0..=4.0).fixed_decimals(2));
        });
    });
    ui.label(
        RichText::new("Drop a height image, a scene or an OBJ mesh on the window.")
            .small()
            .color(style::FAINT),
    );
}

/// Units of a file that carries none.
fn units(ui: &mut Ui, source: &mut Source) {
    row(ui, "sample", |ui| {
        let mut nm = source.pixel_size.unwrap_or([0.1; 2]).map(|um| um * 1e3);
        let mut changed = false;
        for n in &mut nm {
            let field = DragValue::new(n).speed(0.1).range(1.0..=10_000.0).max_decimals(4).suffix(" nm");
            changed |= ui.add(field).changed();
        }
        if changed {
            source.pixel_size = Some(nm.map(|nm| nm * 1e-3));
        }
    });
    row(ui, "full height", |ui| {
        let mut nm = source.height.unwrap_or(0.5) * 1e3;
        if ui
            .add(DragValue::new(&mut nm).speed(1.0).range(0.1..=100_000.0).max_decimals(4).suffix(" nm"))
            .changed()
        {
            source.height = Some(nm * 1e-3);
        }
    });
}

fn optics(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Optics");
    rows(ui, "optics", |ui| {
        setting(ui, "own", &mut model.settings.optics);
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

/// Method, tolerance and what else the method knows of one setting.
fn setting(ui: &mut Ui, id: &str, optics: &mut Optics) {
    row(ui, "method", |ui| {
        for method in [Reads::Layers, Reads::Table] {
            ui.selectable_value(&mut optics.method, method, method.method());
        }
    });
    match optics.method {
        Reads::Layers => row(ui, "basis", |ui| {
            let all = Basis::ALL.map(|b| (b, b.name()));
            let shown = optics.basis.name();
            choice(ui, &format!("{id} basis"), &mut optics.basis, &all, shown);
        }),
        Reads::Table => {
            row(ui, "a pixel is", |ui| {
                ui.selectable_value(&mut optics.filter, Filter::Point, "its centre");
                ui.selectable_value(&mut optics.filter, Filter::Pixel, "all it sees");
            });
            row(ui, "windows", |ui| {
                for n in &mut optics.windows {
                    ui.add(DragValue::new(n).speed(0.1).range(1..=16));
                }
            });
        }
    }
    row(ui, "tolerance", |ui| {
        let all = [1e-1, 5e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 1e-4].map(|t| (t, percent(t)));
        let all: Vec<(f64, &str)> = all.iter().map(|(t, name)| (*t, name.as_str())).collect();
        let shown = percent(optics.tolerance);
        choice(ui, &format!("{id} tolerance"), &mut optics.tolerance, &all, &shown);
    });
    if optics.method == Reads::Layers {
        named(ui, "terms", &mut optics.terms, 10, 1..=64);
    }
    named(ui, "wavelengths", &mut optics.wavelengths, 32, 4..=512);
}

/// A number that follows from the tolerance unless the user names it.
fn named(
    ui: &mut Ui,
    label: &str,
    number: &mut Option<usize>,
    first: usize,
    range: std::ops::RangeInclusive<usize>,
) {
    row(ui, label, |ui| {
        let mut own = number.is_some();
        if ui.checkbox(&mut own, "").changed() {
            *number = own.then_some(first);
        }
        match number {
            Some(n) => {
                ui.add(DragValue::new(n).speed(0.2).range(range));
            }
            None => {
                ui.label(RichText::new("from the tolerance").color(style::FAINT));
            }
        }
    });
}

fn percent(part: f64) -> String {
    format!("{} %", (part * 1e6).round() / 1e4)
}

fn lights(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Lights");
    let lights = &mut model.settings.lights;
    let mut removed = None;
    let several = lights.len() > 1;
    Grid::new("lights").num_columns(4).min_col_width(60.0).show(ui, |ui| {
        for (index, light) in lights.iter_mut().enumerate() {
            ui.add(
                DragValue::new(&mut light.theta)
                    .speed(0.3)
                    .range(0.0..=90.0)
                    .fixed_decimals(1)
                    .prefix("θ ")
                    .suffix("°"),
            );
            ui.add(
                DragValue::new(&mut light.phi)
                    .speed(0.5)
                    .range(-360.0..=360.0)
                    .fixed_decimals(1)
                    .prefix("φ ")
                    .suffix("°"),
            );
            ui.add(
                DragValue::new(&mut light.intensity)
                    .speed(0.02)
                    .range(0.01..=1000.0)
                    .fixed_decimals(2)
                    .prefix("× "),
            );
            if several && ui.small_button("remove").clicked() {
                removed = Some(index);
            }
            ui.end_row();
        }
    });
    if let Some(index) = removed {
        lights.remove(index);
    }
    if lights.len() < MAX_LIGHTS && ui.small_button("add a light").clicked() {
        let phi = lights.last().map_or(0.0, |l| (l.phi + 90.0) % 360.0);
        lights.push(Light { theta: 40.0, phi, intensity: 1.0 });
    }
}

fn compare(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Compare");
    rows(ui, "compare", |ui| {
        row(ui, "show", |ui| {
            for compare in Compare::ALL {
                ui.selectable_value(&mut model.compare, compare, compare.name());
            }
        });
        if model.compare != Compare::Alone {
            setting(ui, "other", &mut model.other);
        }
    });
}

fn cost(ui: &mut Ui, model: &mut Model) {
    heading(ui, "What it costs");
    graph::show(ui, &model.history, model.pace.budget());
    let mib = |bytes: f64| format!("{:.0} MiB", bytes / f64::from(1 << 20));
    rows(ui, "cost", |ui| {
        let frame = model.history.summary().map_or("none yet".to_owned(), |s| {
            let fps = 1e3 / s.p50.max(1e-3);
            format!("{} p50, {} p95, {fps:.1} fps", time(s.p50), time(s.p95))
        });
        value(ui, "frame", frame);
        if let Some(own) = &model.own {
            let (count, [width, height], bytes) = own.made.texture();
            let text = format!("{count} of {width} × {height} texels, {}", mib(bytes as f64));
            value(ui, "layers", text);
        }
        let cost = model.exhibit.as_ref().and_then(|e| e.cost);
        let terms = model.own.as_ref().and_then(|own| own.made.terms());
        let counted = cost.map_or("not counted yet".to_owned(), |c| match terms {
            Some(terms) => format!("{:.0} a pixel, {terms} terms, {:.0} λ", c.samples, c.wavelengths),
            None => format!("{:.0} a pixel, of a colour table", c.samples),
        });
        value(ui, "samples", counted);
        value(ui, "memory", format!("{} on the device", mib(model.memory as f64)));
        if let Some(own) = &model.own {
            let shading = &own.shading;
            value(ui, "error bound", bound(&shading.terms, &shading.wavelengths, shading.tolerance));
        }
        row(ui, "measured", |ui| match model.verdict {
            Some(Verdict::Found(e)) => {
                let [error, interval] = [e.relative_l2, e.relative_l2_interval].map(|x| x * 1e2);
                ui.label(format!("{error:.3} ± {interval:.3} % over {} pixels", e.pixels));
            }
            Some(Verdict::Working(part)) => {
                ui.label(format!("against the f64 reference, {:.0} %", part * 1e2));
            }
            None => {
                model.wants.measure |= ui.small_button("against the f64 reference  [E]").clicked();
            }
        });
        row(ui, "budget", |ui| {
            ui.add(
                DragValue::new(&mut model.fps).speed(0.2).range(1.0..=240.0).max_decimals(1).suffix(" fps"),
            );
            ui.checkbox(&mut model.continuous, "continuous");
        });
    });
}

/// Milliseconds, or seconds where they are many.
fn time(milliseconds: f64) -> String {
    match milliseconds {
        ms if ms < 10.0 => format!("{ms:.1} ms"),
        ms if ms < 1000.0 => format!("{ms:.0} ms"),
        ms => format!("{:.1} s", ms * 1e-3),
    }
}

/// The bound of a setting: the tolerance, unless the user has named numbers that it does not decide.
fn bound(terms: &Option<usize>, wavelengths: &Option<usize>, tolerance: f64) -> String {
    match (terms, wavelengths) {
        (None, None) => format!("{} (RMS, relative)", percent(tolerance)),
        (Some(_), None) => "none: terms are named".to_owned(),
        _ => "none: wavelengths are named".to_owned(),
    }
}

fn foot(ui: &mut Ui, model: &mut Model) {
    ui.add_space(3.0);
    let device = format!("{}; presents by {}", model.device, model.present);
    ui.add(egui::Label::new(RichText::new(device).small().color(style::FAINT)).truncate());
    ui.horizontal(|ui| {
        if ui.button("Save  [S]").clicked() {
            model.wants.save = Some(false);
        }
        model.wants.reset |= ui.button("Reset  [R]").clicked();
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            model.help |= ui.button("Keys  [F1]").clicked();
        });
    });
    ui.add_space(2.0);
}
