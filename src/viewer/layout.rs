//! Layout of the window: the panel, its handle, and the picture with its overlays.

use super::model::Model;
use super::{input, light_handles, overlay, panel, style};
use egui::{Color32, Margin, Rect, Sense, Stroke, Ui, pos2, vec2};

/// Largest fraction of the window's width for the panel.
const WIDEST: f32 = 0.6;

/// Part of the picture from which the panel's edge can be dragged [points].
const EDGE: f32 = 4.0;

/// Shows the panel and the overlays of the picture. Returns the picture's rectangle.
pub fn show(ui: &mut Ui, model: &mut Model) -> Rect {
    model.changes.begin(&model.settings);
    input::keys(ui, model);
    let frame =
        egui::Frame::new().fill(style::PANEL).inner_margin(Margin { left: 12, right: 6, top: 4, bottom: 4 });
    let widest = (ui.available_width() * WIDEST).max(panel::LEAST_WIDTH);
    let mut open = model.visible.panel;
    egui::Panel::right("panel")
        .default_size(panel::WIDTH.min(widest))
        .size_range(panel::LEAST_WIDTH..=widest)
        .frame(frame)
        .show_collapsible(ui, &mut open, |ui| panel::show(ui, model));
    model.visible.panel = open;
    let mut picture = ui.available_rect_before_wrap();
    picture.min = egui::Pos2::ZERO;
    // The panel's edge can be grabbed from both sides.
    let mut touched = picture;
    touched.max.x -= if model.visible.panel { EDGE } else { 0.0 };
    input::pointer(ui, touched, picture, model);
    light_handles::show(ui, touched, picture, model);
    overlay::show(ui, picture, model);
    handle(ui, picture, model);
    model.visible.typing = ui.ctx().text_edit_focused();
    let finished = !model.visible.typing && !ui.input(|i| i.pointer.any_down());
    model.changes.end(&model.settings, finished);
    picture
}

/// Shows the handle beside the panel that hides and shows it.
fn handle(ui: &mut Ui, picture: Rect, model: &mut Model) {
    let size = vec2(overlay::HANDLE, 44.0);
    let rect = Rect::from_min_size(picture.right_bottom() - size - vec2(0.0, 12.0), size);
    let handle = ui.interact(rect, ui.id().with("panel handle"), Sense::click());
    let color = if handle.hovered() { style::ACCENT } else { style::TEXT };
    ui.painter().rect_filled(rect, 4.0, style::GLASS);
    let (x, y) = (rect.center().x, rect.center().y);
    let tip = if model.visible.panel { 3.0 } else { -3.0 };
    let arrow = vec![pos2(x + tip, y), pos2(x - tip, y - 6.0), pos2(x - tip, y + 6.0)];
    ui.painter().add(egui::Shape::convex_polygon(arrow, color, Stroke::new(0.0, Color32::TRANSPARENT)));
    if handle.on_hover_text("Hide or show the panel.  [P]\nDrag its edge to make it narrower.").clicked() {
        model.visible.panel ^= true;
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::coherence::{Coherence, Windows};
    use crate::viewer::compare::Compare;
    use crate::viewer::hand::Hand;
    use crate::viewer::input;
    use crate::viewer::panel::LEAST_WIDTH;
    use crate::viewer::panel::rows::{ALL, SettingRow};
    use egui::{Key, Modifiers, Pos2, pos2, vec2};

    const LARGE: [f32; 2] = [900.0, 1400.0];

    /// Returns the middle of the panel.
    fn panel(hand: &Hand, size: [f32; 2]) -> Pos2 {
        pos2(0.5 * (hand.picture.right() + size[0]), 0.4 * size[1])
    }

    /// Sets the model to configuration `number`; all configurations together show every row.
    fn set(hand: &mut Hand, number: usize) {
        let settings = &mut hand.model.settings;
        match number {
            0 => {
                settings.optics.windows = Windows::ONE;
                hand.model.comparison.mode = Compare::Beside;
                hand.model.comparison.surface = Some(settings.surface.clone());
            }
            1 => {
                settings.optics.windows = Windows::All;
                settings.surface.name = "scan.png".into();
            }
            _ => {
                settings.optics.coherence = Coherence::Repeats([3, 3]);
                settings.surface =
                    crate::surface::SurfaceSource::built_in(crate::surface::synth::SurfaceKind::Elaphe);
            }
        }
        hand.rest();
    }

    /// Returns the text that the panel shows for `row`.
    fn label(hand: &Hand, row: &SettingRow) -> String {
        match row.label {
            "light" => "light 1".to_owned(),
            "spectrum of a light" => "λ".to_owned(),
            "device" => hand.model.device.line(),
            other => other.to_owned(),
        }
    }

    /// Returns true if `row` needs a device.
    fn needs_a_device(row: &SettingRow) -> bool {
        ["texture", "error bound"].contains(&row.label)
    }

    #[test]
    fn escape_closes_what_is_innermost_and_only_then_the_window() {
        let mut hand = Hand::new(LARGE, 1.0);
        hand.press("taylor");
        assert!(hand.reads("optimal"), "the list is open");
        hand.key(Key::Escape);
        assert!(!hand.reads("optimal") && !hand.model.actions.close);

        let beside = hand.position_of("base colour") + vec2(75.0, 0.0);
        hand.click(beside);
        assert!(egui::Popup::is_any_open(hand.context()), "the colours are open");
        hand.key(Key::Escape);
        assert!(!egui::Popup::is_any_open(hand.context()) && !hand.model.actions.close);

        let exposure = hand.model.settings.exposure;
        let beside = hand.position_of("exposure") + vec2(95.0, 0.0);
        hand.click(beside);
        assert!(hand.model.visible.typing);
        hand.key(Key::Num9);
        hand.key(Key::Escape);
        assert!(!hand.model.visible.typing && !hand.model.actions.close);
        assert_eq!(hand.model.settings.exposure, exposure);

        hand.key(Key::F1);
        assert!(hand.reads("left drag"));
        hand.key(Key::Escape);
        assert!(!hand.reads("left drag") && !hand.model.actions.close);

        hand.key(Key::C);
        hand.key(Key::Escape);
        assert!(hand.model.comparison.mode == Compare::Alone && !hand.model.actions.close);
        hand.key(Key::Escape);
        assert!(hand.model.actions.close);
    }

    #[test]
    fn everything_can_be_reached_in_small_windows() {
        for (size, scale) in
            [([640.0, 480.0], 1.0), ([640.0, 480.0], 1.5), ([640.0, 480.0], 2.0), ([500.0, 400.0], 1.0)]
        {
            let mut seen: Vec<&str> = Vec::new();
            let mut hand = Hand::new(size, scale);
            assert!(hand.picture.width() > 0.35 * size[0] && hand.picture.height() == size[1]);
            for number in 0..3 {
                set(&mut hand, number);
                let reached = hand.sweep(panel(&hand, size));
                for row in ALL {
                    if reached.contains(&label(&hand, row)) {
                        seen.push(row.label);
                    }
                }
                for heading in ["Scene", "Optics", "Compare", "Surface", "Lights", "What it costs"] {
                    assert!(reached.contains(heading), "{heading} in {size:?}");
                }
            }
            let missing: Vec<&str> =
                ALL.iter().filter(|row| !needs_a_device(row)).map(|row| row.label).collect();
            let missing: Vec<&&str> = missing.iter().filter(|label| !seen.contains(label)).collect();
            assert!(missing.is_empty(), "{missing:?} in {size:?} at {scale}");
            for button in ["Save  [S]", "Reset  [R]", "Keys  [F1]"] {
                assert!(hand.reads(button), "{button} in {size:?}");
            }
            hand.key(Key::F1);
            let reached = hand.sweep(pos2(0.5 * size[0], 0.5 * size[1]));
            for (key, what) in input::list() {
                assert!(reached.contains(&key) && reached.contains(what), "{key}: {what} in {size:?}");
            }
        }
    }

    #[test]
    fn sections_close_and_open_again() {
        for size in [LARGE, [640.0, 480.0]] {
            let mut hand = Hand::new(size, 1.0);
            for (heading, row) in
                [("Scene", "exposure"), ("What it costs", "frame, moving"), ("Lights", "light 1")]
            {
                let at = panel(&hand, size);
                assert!(hand.sweep(at).contains(row));
                hand.scroll_to(heading, at);
                hand.press(heading);
                assert!(!hand.sweep(at).contains(row), "{row} is closed");
                hand.scroll_to(heading, at);
                hand.press(heading);
                assert!(hand.sweep(at).contains(row), "{row} is open");
            }
        }
    }

    #[test]
    fn the_panel_is_hidden_by_its_handle_and_narrowed_by_its_edge() {
        let mut hand = Hand::new([640.0, 480.0], 1.0);
        let width = hand.picture.width();
        let handle = |hand: &Hand| hand.picture.right_bottom() - vec2(8.0, 30.0);
        hand.click(handle(&hand));
        assert!(!hand.model.visible.panel && hand.picture.width() == 640.0);
        hand.click(handle(&hand));
        assert!(hand.model.visible.panel && hand.picture.width() == width);
        let edge = pos2(hand.picture.right(), 100.0);
        hand.drag(edge, edge + vec2(60.0, 0.0));
        assert!((hand.picture.width() - width - 60.0).abs() < 4.0, "{} {width}", hand.picture.width());
        assert!(640.0 - hand.picture.width() >= LEAST_WIDTH);
    }

    #[test]
    fn every_row_and_button_has_a_tip() {
        let mut seen: Vec<&str> = Vec::new();
        let mut hand = Hand::new(LARGE, 1.0);
        for number in 0..3 {
            set(&mut hand, number);
            for row in ALL {
                let label = label(&hand, row);
                let Some(text) = hand.all(&label).first().cloned() else { continue };
                // Most rows have a control beside the label; these are a button or a line of text.
                let alone =
                    ["add a light", "add a lamp", "spectrum of a light", "device"].contains(&row.label);
                let beside = pos2(text.rect.left() + 112.0, text.rect.center().y);
                for at in [text.rect.center(), beside].into_iter().take(if alone { 1 } else { 2 }) {
                    hand.point(at);
                    assert!(hand.says(row.tip), "{label} at {at}, the panel from {}", hand.picture.right());
                    assert!(row.option.is_none_or(|option| hand.says(option)), "{label}");
                    hand.point(pos2(20.0, 300.0));
                }
                seen.push(row.label);
            }
        }
        for row in ALL.iter().filter(|row| !needs_a_device(row)) {
            assert!(seen.contains(&row.label), "{}", row.label);
        }
        for (button, tip) in
            [("Save  [S]", "PNG"), ("Reset  [R]", "at the start"), ("Keys  [F1]", "gestures")]
        {
            hand.point(hand.position_of(button));
            assert!(hand.says(tip), "{button}");
        }
    }

    #[test]
    fn what_is_automatic_is_ticked() {
        let mut hand = Hand::new(LARGE, 1.0);
        assert_eq!(hand.model.settings.optics.terms, None);
        let ticks = hand.all("automatic");
        assert_eq!(ticks.len(), 2, "terms and wavelengths");
        let terms = ticks.iter().map(|t| t.rect.center()).min_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
        hand.click(terms);
        assert_eq!(hand.model.settings.optics.terms, Some(10));
        hand.click(terms);
        assert_eq!(hand.model.settings.optics.terms, None);
    }

    #[test]
    fn surfaces_of_files_are_in_the_list_with_their_units() {
        let mut hand = Hand::new(LARGE, 1.0);
        let file = crate::surface::SurfaceSource {
            name: "scans/skin.png".into(),
            pixel_size: Some([0.25; 2]),
            ..hand.model.settings.surface.clone()
        };
        hand.model.settings.surface = file.clone();
        hand.model.remember_surface();
        hand.rest();
        hand.press("skin.png");
        hand.press("sinusoid");
        assert_eq!(hand.model.settings.surface.name, "sinusoid");
        hand.press("sinusoid");
        hand.press("skin.png");
        assert_eq!(hand.model.settings.surface, file);
    }

    #[test]
    fn settings_and_drags_are_undone_and_redone() {
        let mut hand = Hand::new(LARGE, 1.0);
        let start = hand.model.settings.clone();
        hand.press("LED");
        let lit = hand.model.settings.clone();
        hand.drag(pos2(100.0, 300.0), pos2(200.0, 340.0));
        let turned = hand.model.settings.clone();
        assert!(start != lit && lit.camera != turned.camera);
        hand.key_held(Key::Z, Modifiers::COMMAND);
        assert!(hand.model.settings == lit, "a drag is one change");
        hand.key_held(Key::Z, Modifiers::COMMAND);
        assert!(hand.model.settings == start);
        hand.key_held(Key::Y, Modifiers::COMMAND);
        hand.key_held(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT);
        assert!(hand.model.settings == turned);
    }

    #[test]
    fn the_picture_and_what_it_is_compared_with_are_swapped_without_a_line() {
        let mut hand = Hand::new(LARGE, 1.0);
        hand.model.comparison.split = 0.3;
        let part = |hand: &Hand| hand.model.comparison.own_part();
        assert_eq!(part(&hand), 1.0);
        hand.key(Key::X);
        assert_eq!(part(&hand), 0.0);
        assert!(hand.reads("B: not ready yet"));
        hand.key(Key::X);
        assert_eq!(part(&hand), 1.0);
        assert!(hand.says("A: taylor, 1 %"));
        hand.key(Key::C);
        assert_eq!(part(&hand), 0.3, "the line is where it was");
        assert!(hand.says("not ready yet") && !hand.says("B: "));
        hand.key(Key::C);
        assert!(hand.reads("1: noticeable"), "the scale of ΔE");
        for _ in 0..2 {
            hand.key(Key::C);
        }
        assert_eq!(part(&hand), 1.0);
        hand.key(Key::C);
        assert_eq!(part(&hand), 0.3);
    }

    #[test]
    fn another_surface_is_compared_with_and_levelled_alone() {
        let mut hand = Hand::new(LARGE, 1.0);
        let before = hand.model.settings.clone();
        hand.press("split");
        hand.press("same");
        hand.press("xenopeltis");
        let planes = hand.all("plane");
        let upper = planes.iter().map(|t| t.rect.center()).min_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
        hand.click(upper);
        let other = hand.model.comparison.surface.clone().unwrap();
        assert_eq!(
            (other.name.to_str(), other.level()),
            (Some("xenopeltis"), crate::surface::Levelling::Plane)
        );
        assert_eq!(hand.model.settings, before, "the picture's own surface stays");
        hand.press("xenopeltis");
        hand.press("same");
        assert_eq!(hand.model.comparison.surface, None);
    }

    #[test]
    fn a_single_setting_is_reset_by_its_label() {
        let mut hand = Hand::new(LARGE, 1.0);
        let start = hand.model.settings.clone();
        hand.model.settings.exposure += 1.5;
        hand.model.settings.surroundings.rotation = 40.0;
        hand.rest();
        hand.double_click(hand.position_of("surroundings"));
        assert_eq!(hand.model.settings.surroundings, start.surroundings);
        assert_eq!(hand.model.settings.exposure, start.exposure + 1.5, "another setting stays");
        hand.double_click(hand.position_of("exposure"));
        assert_eq!(hand.model.settings.exposure, start.exposure);
        assert_eq!(hand.model.settings, start);
        hand.double_click(hand.position_of("exposure"));
        assert!(hand.model.settings == start, "nothing to reset");
        hand.key_held(Key::Z, Modifiers::COMMAND);
        assert_eq!(hand.model.settings.exposure, start.exposure + 1.5, "a reset can be undone");
        // The settings of the comparison are reset without changing those of the picture.
        hand.model.settings.optics.tolerance = 0.05;
        hand.model.comparison.mode = Compare::Beside;
        hand.rest();
        let labels = hand.all("tolerance");
        let lower = labels.iter().map(|t| t.rect.center()).max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
        hand.double_click(lower);
        assert_eq!((labels.len(), hand.model.settings.optics.tolerance), (2, 0.05));
    }

    #[test]
    fn numbers_are_typed_with_units() {
        let mut hand = Hand::new(LARGE, 1.0);
        let beside = hand.position_of("length") + vec2(95.0, 0.0);
        hand.click(beside);
        assert!(hand.model.visible.typing);
        hand.key_held(Key::A, Modifiers::COMMAND);
        hand.write("0.04mm");
        hand.key(Key::Enter);
        assert_eq!(hand.model.settings.optics.coherence, Coherence::Gaussian { length: 40.0 });
    }

    #[test]
    fn f_frames_the_mesh() {
        let mut hand = Hand::new([640.0, 480.0], 1.0);
        hand.key(Key::F);
        assert!(hand.model.actions.frame);
    }
}
