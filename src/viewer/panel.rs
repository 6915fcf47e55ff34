//! The panel: settings and their cost.

mod cost;
mod optics;
mod surface;

use super::compare::Compare;
use super::model::Model;
use super::style;
use crate::optics::color::Tone;
use crate::scene::scene_file::BUILT_IN;
use crate::scene::{Light, MAX_LIGHTS};
use egui::{ComboBox, DragValue, Grid, RichText, ScrollArea, Ui};

/// Width of the panel in points.
pub const WIDTH: f32 = 336.0;
/// Width of the labels.
const LABEL: f32 = 92.0;

/// Shows the panel and applies the user's changes to `model`. The costs stay in sight, the rest scrolls.
pub fn show(ui: &mut Ui, model: &mut Model) {
    ui.spacing_mut().item_spacing.y = 4.0;
    egui::Panel::bottom("costs").frame(egui::Frame::new()).show_separator_line(false).show(ui, |ui| {
        cost::show(ui, model);
        cost::foot(ui, model);
    });
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        scene(ui, model);
        optics::show(ui, model);
        compare(ui, model);
        surface::show(ui, model);
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

/// A grid of labelled rows.
fn rows(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    Grid::new(name).num_columns(2).min_col_width(LABEL).max_col_width(WIDTH - LABEL - 44.0).show(ui, add);
}

/// A draggable number. A value from the command line may lie outside the range of the drag.
fn number<N: egui::emath::Numeric>(value: &mut N) -> DragValue<'_> {
    DragValue::new(value).clamp_existing_to_range(false)
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

/// The file name of a path.
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
                model.actions.open = chosen;
            }
        });
        row(ui, "exposure", |ui| {
            let exposure = &mut model.settings.exposure;
            ui.add(number(exposure).speed(0.05).range(-20.0..=20.0).fixed_decimals(1).suffix(" EV"));
        });
        row(ui, "tone", |ui| {
            let tone = &mut model.settings.tone;
            for other in Tone::ALL {
                ui.selectable_value(tone, other, other.name());
            }
        });
        row(ui, "base colour", |ui| {
            let mut rgb = model.settings.base_color.to_array();
            if ui.color_edit_button_rgb(&mut rgb).changed() {
                // Rounded to four digits, which is finer than a display and short on a command line.
                model.settings.base_color = rgb.map(|c| (c * 1e4).round() / 1e4).into();
            }
            ui.label(RichText::new("pigment below the surface").small().color(style::FAINT));
        });
    });
}

fn lights(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Lights");
    let lights = &mut model.settings.lights;
    let mut removed = None;
    let several = lights.len() > 1;
    Grid::new("lights").num_columns(4).min_col_width(60.0).show(ui, |ui| {
        for (index, light) in lights.iter_mut().enumerate() {
            ui.add(
                number(&mut light.theta)
                    .speed(0.3)
                    .range(0.0..=90.0)
                    .fixed_decimals(1)
                    .prefix("θ ")
                    .suffix("°"),
            );
            ui.add(
                number(&mut light.phi)
                    .speed(0.5)
                    .range(-360.0..=360.0)
                    .fixed_decimals(1)
                    .prefix("φ ")
                    .suffix("°"),
            );
            ui.add(
                number(&mut light.intensity).speed(0.02).range(0.01..=1000.0).fixed_decimals(2).prefix("× "),
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
        lights.push(Light { theta: 40.0, phi, intensity: 1.0, size: 0.0 });
    }
}

fn compare(ui: &mut Ui, model: &mut Model) {
    heading(ui, "Compare");
    rows(ui, "compare", |ui| {
        row(ui, "show", |ui| {
            for compare in Compare::ALL {
                ui.selectable_value(&mut model.comparison.mode, compare, compare.name());
            }
        });
        if model.comparison.mode != Compare::Alone {
            optics::setting(ui, "other", &mut model.comparison.optics, model.settings.coherence);
        }
    });
}
