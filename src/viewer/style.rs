//! Colours, sizes and spacing of the panel.

use egui::{Color32, Context, CornerRadius, FontFamily, FontId, Stroke, TextStyle, Theme, Visuals, vec2};

/// Background of the panel.
pub const PANEL: Color32 = Color32::from_rgb(24, 26, 30);
/// Background of graphs and fields.
pub const WELL: Color32 = Color32::from_rgb(15, 17, 20);
/// Lines of graphs and separators.
pub const GRID: Color32 = Color32::from_rgb(42, 46, 53);
/// Plain text.
pub const TEXT: Color32 = Color32::from_rgb(208, 212, 218);
/// Labels.
pub const FAINT: Color32 = Color32::from_rgb(140, 147, 158);
/// Headings and selected items.
pub const ACCENT: Color32 = Color32::from_rgb(94, 190, 196);
/// Band of the thesis' frame rates.
pub const BAND: Color32 = Color32::from_rgb(44, 40, 28);
/// Label of that band.
pub const BAND_TEXT: Color32 = Color32::from_rgb(150, 132, 88);
/// Faster than the thesis.
pub const GOOD: Color32 = Color32::from_rgb(82, 168, 128);
/// Frame rates of the thesis.
pub const FAIR: Color32 = Color32::from_rgb(206, 164, 82);
/// Slower than the thesis; errors.
pub const POOR: Color32 = Color32::from_rgb(210, 104, 92);
/// Background of text on the picture.
pub const GLASS: Color32 = Color32::from_rgba_premultiplied(10, 11, 13, 190);

/// Applies the colours and sizes to `context`.
pub fn apply(context: &Context) {
    context.set_theme(Theme::Dark);
    let mut visuals = Visuals::dark();
    visuals.panel_fill = PANEL;
    visuals.window_fill = PANEL;
    visuals.extreme_bg_color = WELL;
    visuals.faint_bg_color = WELL;
    visuals.selection.bg_fill = Color32::from_rgb(38, 92, 98);
    visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
    visuals.window_stroke = Stroke::new(1.0, GRID);
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, GRID);
    visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, TEXT);
    for widget in [
        &mut visuals.widgets.inactive,
        &mut visuals.widgets.hovered,
        &mut visuals.widgets.active,
        &mut visuals.widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(4);
    }
    visuals.widgets.inactive.weak_bg_fill = Color32::from_rgb(38, 41, 47);
    visuals.widgets.inactive.bg_fill = Color32::from_rgb(38, 41, 47);
    visuals.widgets.inactive.fg_stroke = Stroke::new(1.0, TEXT);
    visuals.widgets.hovered.weak_bg_fill = Color32::from_rgb(50, 54, 62);
    context.set_visuals_of(Theme::Dark, visuals);
    context.all_styles_mut(|style| {
        let font = |size| FontId::new(size, FontFamily::Proportional);
        style.text_styles.insert(TextStyle::Body, font(13.0));
        style.text_styles.insert(TextStyle::Button, font(13.0));
        style.text_styles.insert(TextStyle::Small, font(11.0));
        style.text_styles.insert(TextStyle::Heading, font(13.0));
        style.text_styles.insert(TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace));
        style.spacing.item_spacing = vec2(8.0, 5.0);
        style.spacing.interact_size.y = 20.0;
        style.spacing.slider_width = 120.0;
        style.spacing.scroll =
            egui::style::ScrollStyle { bar_width: 8.0, ..egui::style::ScrollStyle::solid() };
        style.animation_time = 0.0;
    });
}
