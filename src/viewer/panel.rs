//! Panel: settings and their cost.

mod cost;
mod number_field;
mod optics;
pub(super) mod rows;
mod scene;
mod surface_rows;

use super::model::Model;
use super::style;
use egui::scroll_area::ScrollBarVisibility;
use egui::{CollapsingHeader, RichText, ScrollArea, Ui};

/// Width of the panel until the user drags its edge [points].
pub const WIDTH: f32 = 336.0;
/// Minimum width of the panel [points].
pub const LEAST_WIDTH: f32 = 220.0;
/// Height from which the costs stay visible below the other sections instead of scrolling with them [points].
const TALL: f32 = 700.0;

/// Shows the panel and applies the user's changes to `model`.
pub fn show(ui: &mut Ui, model: &mut Model) {
    ui.spacing_mut().item_spacing.y = 4.0;
    let tall = ui.available_height() >= TALL;
    egui::Panel::bottom("foot").frame(egui::Frame::new()).show_separator_line(false).show(ui, |ui| {
        if tall {
            cost::show(ui, model);
        }
        cost::foot(ui, model);
    });
    let scrolled = ScrollArea::vertical().auto_shrink([false, false]);
    let start = model.start();
    scrolled.scroll_bar_visibility(ScrollBarVisibility::AlwaysVisible).show(ui, |ui| {
        rows::offer_resets(ui, &model.settings, &start);
        scene::show(ui, model);
        optics::show(ui, model);
        scene::compare(ui, model);
        surface_rows::show(ui, model);
        scene::lights(ui, model);
        if !tall {
            cost::show(ui, model);
        }
        rows::reset(ui, &mut model.settings, &start);
    });
}

/// Shows a section with a heading that opens and closes it.
fn section(ui: &mut Ui, title: &str, add: impl FnOnce(&mut Ui)) {
    section_opened(ui, title, false, add);
}

/// Shows a section as [`section`] does; `opens`: it opens now if it is closed.
fn section_opened(ui: &mut Ui, title: &str, opens: bool, add: impl FnOnce(&mut Ui)) {
    ui.add_space(3.0);
    let title = RichText::new(title).color(style::ACCENT).strong();
    CollapsingHeader::new(title).default_open(true).open(opens.then_some(true)).show_unindented(ui, add);
}

/// Returns the file name of a path.
fn short(name: &str) -> &str {
    std::path::Path::new(name).file_name().and_then(|n| n.to_str()).unwrap_or(name)
}
