//! Fields for numbers, which are dragged or typed with a unit. A typed number applies once it is finished: by Enter, or when
//! the field loses the focus. A text that is refused stays in its field, red, with the reason below.

use crate::error::Error;
use crate::units;
use crate::viewer::style;
use egui::emath::Numeric;
use egui::{Color32, DragValue, Id, Key, Response, RichText, Stroke, Ui, Widget};
use std::cell::{Cell, RefCell};
use std::ops::RangeInclusive;

/// Unit of a number on the panel.
pub struct Unit {
    /// Suffix of the number.
    suffix: &'static str,
    /// Reads a number with a unit.
    read: fn(&str) -> Result<f64, Error>,
}

/// No unit.
const PLAIN: Unit = Unit { suffix: "", read: not_a_number };
/// Degrees.
pub const DEGREES: Unit = Unit { suffix: "°", read: units::angle };
/// Nanometres.
pub const NANOMETRES: Unit = Unit { suffix: " nm", read: |text| Ok(units::length(text)? * 1e3) };
/// Micrometres.
pub const MICROMETRES: Unit = Unit { suffix: " µm", read: units::length };
/// Exposure values.
pub const STOPS: Unit = Unit { suffix: " EV", read: not_a_number };
/// Frames a second.
pub const FRAMES: Unit = Unit { suffix: " fps", read: not_a_number };
/// Watts.
pub const WATTS: Unit = Unit { suffix: " W", read: not_a_number };

fn not_a_number(text: &str) -> Result<f64, Error> {
    Err(Error::usage(format!("'{text}' is not a number"), "write a number as in 12 or 0.5"))
}

/// Returns a field for a plain number. A value from the command line may lie outside the range of the field.
pub fn number<N: Numeric>(value: &mut N) -> NumberField<'_> {
    quantity(value, &PLAIN)
}

/// Returns a field for a number with a unit. Typed numbers may have another unit of the same kind.
pub fn quantity<'a, N: Numeric>(value: &'a mut N, unit: &'static Unit) -> NumberField<'a> {
    NumberField {
        drag: DragValue::new(value).clamp_existing_to_range(false),
        form: NumberForm {
            suffix: unit.suffix,
            read: unit.read,
            range: f64::NEG_INFINITY..=f64::INFINITY,
            is_whole: N::INTEGRAL,
        },
        prefix: "",
    }
}

/// Field for a number.
#[must_use]
pub struct NumberField<'a> {
    drag: DragValue<'a>,
    form: NumberForm,
    prefix: &'static str,
}

impl NumberField<'_> {
    /// Sets the change of the number per point of a drag.
    pub fn speed(self, speed: f64) -> Self {
        Self { drag: self.drag.speed(speed), ..self }
    }

    /// Sets the range of numbers to accept.
    pub fn range<N: Numeric>(mut self, range: RangeInclusive<N>) -> Self {
        self.form.range = range.start().to_f64()..=range.end().to_f64();
        self
    }

    /// Sets the number of decimals.
    pub fn fixed_decimals(self, decimals: usize) -> Self {
        Self { drag: self.drag.fixed_decimals(decimals), ..self }
    }

    /// Sets the largest number of decimals.
    pub fn max_decimals(self, decimals: usize) -> Self {
        Self { drag: self.drag.max_decimals(decimals), ..self }
    }

    /// Sets the text before the number.
    pub fn prefix(self, prefix: &'static str) -> Self {
        Self { prefix, ..self }
    }

    /// Sets the text behind the number.
    pub fn suffix(mut self, suffix: &'static str) -> Self {
        self.form.suffix = suffix;
        self
    }
}

/// Form of the texts that a field accepts.
struct NumberForm {
    suffix: &'static str,
    read: fn(&str) -> Result<f64, Error>,
    range: RangeInclusive<f64>,
    is_whole: bool,
}

impl NumberForm {
    /// Parses `text`; a number without a unit is taken to be in that of the field. The error says what is accepted.
    fn parse(&self, text: &str) -> Result<f64, String> {
        let text = text.trim().replace('−', "-").replace(',', ".");
        let bare = text.strip_suffix(self.suffix.trim()).unwrap_or(&text).trim();
        let value = match units::number(bare) {
            Some(value) => value,
            None => (self.read)(&text).map_err(|error| error.in_words(|remedy| remedy.to_string().into()))?,
        };
        let (least, most) = (self.range.start(), self.range.end());
        match value {
            _ if !self.range.contains(&value) => {
                Err(format!("'{text}': write {least} to {most}{}", self.suffix))
            }
            _ if self.is_whole && value.fract() != 0.0 => Err(format!("'{text}': write a whole number")),
            value => Ok(value),
        }
    }
}

/// Text that a field has refused.
#[derive(Clone)]
struct RefusedText {
    text: String,
    why: String,
    // Value of the field, which has stayed. Once it changes, the text is outdated.
    value: f64,
}

/// Number of the pass in which Escape ended the editing of a field. The toolkit would apply the text in the next one.
#[derive(Clone, Copy)]
struct CancelledPass(u64);

impl Widget for NumberField<'_> {
    fn ui(self, ui: &mut Ui) -> Response {
        let Self { drag, form, prefix } = self;
        let id = ui.next_auto_id();
        let refused: Option<RefusedText> = ui.data(|data| data.get_temp(id));
        let pass = ui.ctx().cumulative_pass_nr();
        let cancelled: Option<CancelledPass> = ui.data(|data| data.get_temp(id));
        let was_cancelled = cancelled.is_some_and(|cancelled| pass <= cancelled.0 + 1);
        let (shown, value) = (RefCell::new(String::new()), Cell::new(0.0));
        // The error of a finished text, or none of one that is accepted.
        let finished = RefCell::new(None);
        let plain = ui.style().number_formatter.clone();
        let drag = drag.range(form.range.clone()).update_while_editing(false);
        let drag = drag.custom_formatter(|number, decimals| {
            value.set(number);
            let text = match &refused {
                Some(refused) if refused.value == number => refused.text.clone(),
                _ => plain.format(number, decimals),
            };
            shown.replace(text.clone());
            text
        });
        let drag = drag.custom_parser(|text| {
            // The shown text is rounded, so that leaving it as it is changes nothing.
            if was_cancelled || refused.is_none() && text == *shown.borrow() {
                return None;
            }
            let parsed = form.parse(text);
            finished.replace(Some(parsed.as_ref().err().map(|why| (text.to_owned(), why.clone()))));
            parsed.ok()
        });
        let outside = ui.visuals().clone();
        if refused.is_some() {
            redden(ui);
        }
        // An empty text would be a part of the field, too.
        let is_shown = |text: &str| refused.is_none() && !text.is_empty();
        let drag = if is_shown(prefix) { drag.prefix(prefix) } else { drag };
        let drag = if is_shown(form.suffix) { drag.suffix(form.suffix) } else { drag };
        let response = ui.add(drag);
        *ui.visuals_mut() = outside;
        let cancels = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Escape));
        if cancels {
            ui.data_mut(|data| data.insert_temp(id, CancelledPass(pass)));
        }
        match finished.into_inner() {
            Some(Some((text, why))) => {
                let refused = RefusedText { text, why, value: value.get() };
                ui.data_mut(|data| data.insert_temp(id, refused));
            }
            Some(None) => forget(ui, id),
            None if cancels || refused.as_ref().is_some_and(|refused| refused.value != value.get()) => {
                forget(ui, id);
            }
            None => {}
        }
        reason(ui, refused.as_ref());
        response
    }
}

fn forget(ui: &Ui, id: Id) {
    ui.data_mut(|data| data.remove::<RefusedText>(id));
}

/// Draws the following fields red.
fn redden(ui: &mut Ui) {
    let visuals = ui.visuals_mut();
    visuals.override_text_color = Some(style::POOR);
    visuals.selection.stroke.color = style::POOR;
    let widgets = &mut visuals.widgets;
    for state in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active] {
        state.bg_stroke = Stroke::new(1.0, style::POOR);
        state.weak_bg_fill = Color32::from_rgb(60, 28, 26);
    }
}

/// Shows why a text was refused. Takes one identifier in any case, so that those of the following fields stay.
fn reason(ui: &mut Ui, refused: Option<&RefusedText>) {
    match refused {
        Some(RefusedText { why, .. }) => {
            ui.end_row();
            ui.scope(|ui| ui.label(RichText::new(why).small().color(style::POOR)));
        }
        None => ui.skip_ahead_auto_ids(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::hand::Hand;
    use egui::{pos2, vec2};

    fn form(unit: &Unit) -> NumberForm {
        NumberForm { suffix: unit.suffix, read: unit.read, range: -1e3..=1e3, is_whole: false }
    }

    #[test]
    fn numbers_are_typed_in_any_unit_of_their_kind() {
        type Case = (&'static str, Option<f64>);
        let cases: [(&Unit, &[Case]); 4] = [
            (
                &NANOMETRES,
                &[
                    ("450", Some(450.0)),
                    ("0.45um", Some(450.0)),
                    ("0,07um", Some(70.0)),
                    (" 450 nm", Some(450.0)),
                    ("450 s", None),
                    ("7cm", None),
                    ("banana", None),
                    ("", None),
                    ("2 um", None),
                ],
            ),
            (
                &MICROMETRES,
                &[("65", Some(65.0)), ("0.1mm", Some(100.0)), ("200nm", Some(0.2)), ("1,5 µm", Some(1.5))],
            ),
            (
                &DEGREES,
                &[("-12.5", Some(-12.5)), ("−12.5°", Some(-12.5)), ("30deg", Some(30.0)), ("x", None)],
            ),
            (&STOPS, &[("2 EV", Some(2.0)), ("-1.5", Some(-1.5)), ("1 nm", None), ("nan", None)]),
        ];
        for (unit, cases) in cases {
            for (text, number) in cases {
                let read = form(unit).parse(text).ok();
                let same = match (read, number) {
                    (Some(a), Some(b)) => (a - b).abs() < 1e-9,
                    (a, b) => a.is_none() && b.is_none(),
                };
                assert!(same, "{text}: {read:?} where {number:?} was meant");
            }
        }
        let half_turn = form(&DEGREES).parse("3.14159265rad").unwrap();
        assert!((half_turn - 180.0).abs() < 1e-6);
        let whole = NumberForm { is_whole: true, ..form(&PLAIN) };
        assert!(whole.parse("3").is_ok() && whole.parse("3.5").unwrap_err().contains("whole"));
    }

    #[test]
    fn a_number_applies_once_it_is_finished_and_a_red_field_says_why_it_does_not() {
        let mut hand = Hand::new([900.0, 1400.0], 1.0);
        hand.model.settings.surface.name = "scan.png".into();
        hand.model.settings.surface.pixel_size = Some([0.2; 2]);
        hand.model.settings.surface.height = Some(0.4);
        hand.rest();
        let nanometres = |hand: &Hand| hand.model.settings.surface.pixel_size.unwrap().map(|x| x * 1e3);
        let at = hand.position_of("sample spacing") + vec2(85.0, 0.0);
        let type_in = |hand: &mut Hand, at, text: &str| {
            hand.click(at);
            assert!(hand.model.visible.typing, "{text}");
            for letter in text.chars() {
                let before = nanometres(hand);
                hand.write(&letter.to_string());
                assert_eq!(nanometres(hand), before, "no prefix of {text} applies");
            }
            hand.key(Key::Enter);
        };
        type_in(&mut hand, at, "0,07um");
        assert!((nanometres(&hand)[0] - 70.0).abs() < 1e-9 && nanometres(&hand)[1] == 200.0);
        for (text, why) in
            [("7cm", "not a number with a unit"), ("banana", "banana"), ("3mm", "write 1 to 10000 nm")]
        {
            type_in(&mut hand, at, text);
            assert!((nanometres(&hand)[0] - 70.0).abs() < 1e-9, "{text}");
            assert!(hand.reads(text) && hand.says(why), "{text}");
        }
        // Escape leaves the old value.
        hand.click(at);
        hand.write("90");
        hand.key(Key::Escape);
        assert!((nanometres(&hand)[0] - 70.0).abs() < 1e-9);
        assert!(!hand.reads("3mm") && !hand.says("write 1 to") && !hand.model.actions.close);
        type_in(&mut hand, at, "banana");
        // The other field keeps the focus that it takes from a refused one.
        let height = hand.position_of("full height") + vec2(85.0, 0.0);
        hand.click(height);
        assert!(hand.model.visible.typing && hand.reads("banana"));
        hand.write("600");
        hand.click(pos2(100.0, 1300.0));
        assert_eq!(hand.model.settings.surface.height, Some(0.6));
        type_in(&mut hand, at, "80 nm");
        assert!(!hand.says("banana") && (nanometres(&hand)[0] - 80.0).abs() < 1e-9);
    }
}
