//! Rows of scene, lights and comparison.

use super::number_field::{DEGREES, STOPS, WATTS, number, quantity};
use super::{optics, rows, section, short, surface_rows};
use crate::optics::color::Tone;
use crate::optics::spectrum::BUILT_IN as BUILT_IN_SPECTRA;
use crate::optics::spectrum::Illuminant;
use crate::scene::environment::Placement;
use crate::scene::lamp::{Lamp, LampShape, Strength};
use crate::scene::scene_file::BUILT_IN;
use crate::scene::{Emitter, FarLight, Light, Room};
use crate::viewer::compare::Compare;
use crate::viewer::model::Model;
use crate::viewer::view_settings::ViewSettings;
use egui::{ComboBox, Ui};

/// Shows scene, exposure, tone mapping and pigment.
pub fn show(ui: &mut Ui, model: &mut Model) {
    section(ui, "Scene", |ui| {
        rows::show(ui, &rows::SCENE, |ui| {
            let shown = &model.settings.scene;
            let list = ComboBox::from_id_salt("scene name").selected_text(short(shown)).truncate();
            list.width(ui.available_width()).show_ui(ui, |ui| {
                for (name, _) in BUILT_IN {
                    if ui.selectable_label(shown == name, name).clicked() {
                        model.actions.open = Some(name.to_owned());
                    }
                }
            });
        });
        rows::show(ui, &rows::FILE, |ui| file(ui, model));
        rows::show(ui, &rows::EXPOSURE, |ui| {
            let exposure = &mut model.settings.exposure;
            ui.add(quantity(exposure, &STOPS).speed(0.05).range(-20.0..=20.0).fixed_decimals(1));
        });
        rows::show(ui, &rows::TONE, |ui| {
            for other in Tone::ALL {
                ui.selectable_value(&mut model.settings.tone, other, other.name());
            }
        });
        rows::show(ui, &rows::SAMPLES, |ui| {
            ui.add(number(&mut model.settings.samples).speed(0.2).range(1..=4096));
        });
        base_color(ui, &mut model.settings);
        turntable(ui, model);
    });
}

/// Shows the buttons that open and save, and the recently opened files.
fn file(ui: &mut Ui, model: &mut Model) {
    ui.spacing_mut().item_spacing.x = 4.0;
    if ui.small_button("open").clicked() {
        model.file_choice.open();
    }
    if ui.small_button("save").clicked() {
        model.file_choice.save_scene();
    }
    let recent = model.file_choice.recent();
    ui.add_enabled_ui(!recent.is_empty(), |ui| {
        ui.menu_button("recent", |ui| {
            for path in &recent {
                if ui.button(short(path)).on_hover_text(path).clicked() {
                    model.actions.open = Some(path.clone());
                }
            }
        });
    });
}

/// Shows the number of pictures of a turntable, and the button that starts or stops its recording.
fn turntable(ui: &mut Ui, model: &mut Model) {
    rows::show(ui, &rows::TURNTABLE, |ui| {
        let count = number(&mut model.turntable).speed(0.5).range(2..=10_000).suffix(" pictures");
        ui.add_enabled(model.recording.is_none(), count);
        let name = if model.recording.is_some() { "stop" } else { "record" };
        model.actions.record |= ui.small_button(name).clicked();
    });
}

fn base_color(ui: &mut Ui, settings: &mut ViewSettings) {
    rows::show(ui, &rows::BASE_COLOR, |ui| {
        let mut rgb = settings.base_color.to_array();
        if ui.color_edit_button_rgb(&mut rgb).changed() {
            // Rounded to four digits: finer than a display, and short on a command line.
            settings.base_color = rgb.map(|c| (c * 1e4).round() / 1e4).into();
        }
    });
}

/// Shows the lights.
pub fn lights(ui: &mut Ui, model: &mut Model) {
    section(ui, "Lights", |ui| {
        let surrounded = model.loaded.scene.environment.is_some();
        let bounds = model.loaded.scene.bounds();
        let room = Room { centre: bounds.centre.as_dvec3(), unit: model.loaded.scene.unit };
        let lights = &mut model.settings.lights;
        let several = lights.len() > 1;
        let mut removed = None;
        for (index, light) in lights.iter_mut().enumerate() {
            rows::numbered(ui, &rows::LIGHT, &format!("light {}", index + 1), |ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                match &mut light.emitter {
                    Emitter::Far(light) => angles(ui, light),
                    Emitter::Lamp(lamp) => place(ui, lamp, &room, bounds.radius.into()),
                }
                spectrum(ui, &mut light.spectrum);
                if several && ui.small_button("✖").on_hover_text("Removes this light.").clicked() {
                    removed = Some(index);
                }
            });
        }
        if let Some(index) = removed {
            lights.remove(index);
        }
        if surrounded {
            surroundings(ui, &mut model.settings.surroundings);
        }
        let radius = f64::from(bounds.radius);
        let far = || {
            let phi = match lights.last().map(|light| light.emitter) {
                Some(Emitter::Far(last)) => (last.phi + 90.0) % 360.0,
                _ => 0.0,
            };
            Light::point(40.0, phi, 1.0)
        };
        // A lamp of a third of the scene's size, above the scene.
        let lamp = || {
            let digits = 10f64.powf(2.0 - radius.log10().floor());
            let round = |x: f64| (x * digits).round() / digits;
            let middle =
                (room.centre + glam::DVec3::new(0.0, -1.0, 1.5) * radius).to_array().map(round).into();
            let shape = LampShape::Sphere { diameter: round(0.3 * radius) };
            Lamp { shape, middle, strength: Strength::Suited }.into()
        };
        let new: [(&rows::SettingRow, &dyn Fn() -> Light); 2] =
            [(&rows::ADD_LIGHT, &far), (&rows::ADD_LAMP, &lamp)];
        let mut added = None;
        ui.horizontal(|ui| {
            for (row, make) in new {
                if ui.small_button(row.label).on_hover_text(row.help()).clicked() {
                    added = Some(make());
                }
            }
        });
        lights.extend(added);
    });
}

/// Shows rotation and exposure of the surroundings.
fn surroundings(ui: &mut Ui, placement: &mut Placement) {
    rows::show(ui, &rows::SURROUNDINGS, |ui| {
        let rotation = quantity(&mut placement.rotation, &DEGREES).speed(0.5).range(-360.0..=360.0);
        ui.add(rotation.fixed_decimals(1));
        let exposure = quantity(&mut placement.exposure, &STOPS).speed(0.05).range(-20.0..=20.0);
        ui.add(exposure.fixed_decimals(1));
    });
}

/// Shows the spectrum of a light and a list of others.
fn spectrum(ui: &mut Ui, spectrum: &mut Option<Illuminant>) {
    let is_built_in = |illuminant: &Illuminant| illuminant.file().is_none();
    let name = match spectrum {
        None => "λ".to_owned(),
        Some(illuminant) if is_built_in(illuminant) => illuminant.name().to_uppercase(),
        Some(illuminant) => short(&illuminant.name()).to_owned(),
    };
    let mut chosen = None;
    let list = ui.menu_button(name, |ui| {
        let button =
            |ui: &mut Ui, is_chosen: bool, name: String| ui.selectable_label(is_chosen, name).clicked();
        if button(ui, spectrum.is_none(), "as the illuminant".to_owned()) {
            chosen = Some(None);
        }
        for name in BUILT_IN_SPECTRA {
            let choice = Illuminant::built_in(name);
            if button(ui, choice.is_some() && choice == *spectrum, name.to_uppercase()) {
                chosen = Some(choice);
            }
        }
        if chosen.is_some() {
            ui.close();
        }
    });
    list.response.on_hover_text(rows::LIGHT_SPECTRUM.help());
    *spectrum = chosen.unwrap_or_else(|| spectrum.take());
}

fn place(ui: &mut Ui, lamp: &mut Lamp, room: &Room, radius: f64) {
    let [x, y, z] = &mut lamp.middle.as_mut();
    for (name, value) in [("x ", x), ("y ", y), ("z ", z)] {
        ui.add(number(value).speed(0.005 * radius).range(-1e6..=1e6).max_decimals(4).prefix(name));
    }
    let sizes: &mut [(&'static str, &mut f64)] = match &mut lamp.shape {
        LampShape::Sphere { diameter } => &mut [("⌀ ", diameter)],
        LampShape::Rectangle { size: [width, height], .. } => &mut [("w ", width), ("h ", height)],
    };
    for (name, value) in sizes {
        ui.add(number(*value).speed(0.002 * radius).range(1e-6..=1e6).max_decimals(4).prefix(name));
    }
    if let Strength::Power(power) = &mut lamp.strength {
        let speed = 0.01 * *power;
        ui.add(quantity(power, &WATTS).speed(speed).range(1e-6..=1e12));
        return;
    }
    let mut radiance = lamp.radiance(room);
    let value = number(&mut radiance).speed(0.01 * lamp.radiance(room)).range(1e-6..=1e12);
    if ui.add(value.prefix("L ")).changed() {
        lamp.strength = Strength::Radiance(radiance);
    }
}

fn angles(ui: &mut Ui, light: &mut FarLight) {
    let theta = quantity(&mut light.theta, &DEGREES).speed(0.3).range(0.0..=90.0).fixed_decimals(1);
    ui.add(theta.prefix("θ "));
    let phi = quantity(&mut light.phi, &DEGREES).speed(0.5).range(-360.0..=360.0).fixed_decimals(1);
    ui.add(phi.prefix("φ "));
    let intensity = number(&mut light.intensity).speed(0.02).range(0.01..=1000.0).fixed_decimals(2);
    ui.add(intensity.prefix("× "));
}

/// Shows the settings of the comparison.
pub fn compare(ui: &mut Ui, model: &mut Model) {
    section(ui, "Compare", |ui| {
        rows::show(ui, &rows::COMPARE, |ui| {
            for compare in Compare::ALL {
                if ui.selectable_label(model.comparison.mode == compare, compare.name()).clicked() {
                    (model.comparison.mode, model.comparison.whole) = (compare, None);
                }
            }
        });
        if model.comparison.mode != Compare::Alone {
            other_surface(ui, model);
            rows::without_reset(ui, |ui| {
                optics::setting(ui, "other", &mut model.comparison.optics, model.settings.optics.coherence);
            });
        }
    });
}

/// Shows the surface of the comparison.
fn other_surface(ui: &mut Ui, model: &mut Model) {
    let other = &mut model.comparison.surface;
    rows::show(ui, &rows::OTHER_SURFACE, |ui| surface_rows::other(ui, other, &model.files));
    if let Some(other) = other {
        rows::show(ui, &rows::OTHER_LEVEL, |ui| surface_rows::level(ui, other));
    }
}
