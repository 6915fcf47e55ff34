//! For tests: drives the panel by input events, without a window or a device.

use super::frame::LoadedScene;
use super::inset::Inset;
use super::model::Model;
use super::view_settings::tests::settings;
use super::{hemisphere, layout, style, text_dump};
use egui::{Context, Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, RawInput, Rect, Vec2, vec2};
use std::collections::HashSet;
use std::sync::Arc;

/// Points per turn of the wheel, and turns from the top of the longest list to its bottom.
const TURN: f32 = 90.0;
const MOST_TURNS: usize = 14;

/// Text in the window.
#[derive(Clone, Debug)]
pub struct Text {
    pub text: String,
    pub rect: Rect,
    // Part of `rect` that is not cut off.
    pub seen: Rect,
}

impl Text {
    fn is_whole(&self) -> bool {
        self.seen.expand(1.0).contains_rect(self.rect)
    }
}

/// Window of the viewer that shows a plate, driven by input events.
pub struct Hand {
    pub model: Model,
    pub picture: Rect,
    /// Hemisphere inset, which otherwise comes from a device.
    pub inset: Option<Inset>,
    context: Context,
    size: Vec2,
    scale: f32,
    time: f64,
    texts: Vec<Text>,
}

impl Hand {
    /// Makes a window of `size` points at `scale` pixels per point.
    pub fn new(size: [f32; 2], scale: f32) -> Self {
        let (settings, scene) = settings();
        let loaded = Arc::new(LoadedScene::of(scene).unwrap());
        let context = Context::default();
        style::apply(&context);
        let mut hand = Self {
            model: Model::new(settings, loaded, 15.0, "a device".to_owned()),
            picture: Rect::NOTHING,
            inset: None,
            context,
            size: size.into(),
            scale,
            time: 0.0,
            texts: Vec::new(),
        };
        hand.rest();
        hand
    }

    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Runs a pass of the window with `events`.
    pub fn pass(&mut self, events: Vec<Event>) {
        self.time += 0.05;
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, self.size)),
            time: Some(self.time),
            events,
            ..RawInput::default()
        };
        input.viewports.entry(input.viewport_id).or_default().native_pixels_per_point = Some(self.scale);
        let (model, picture, inset) = (&mut self.model, &mut self.picture, &self.inset);
        let output = self.context.run_ui(input, |ui| {
            *picture = layout::show(ui, model);
            if let Some(inset) = inset {
                hemisphere::show(ui, *picture, inset, model);
            }
        });
        assert_eq!(output.pixels_per_point, self.scale);
        let window = Rect::from_min_size(Pos2::ZERO, self.size);
        self.texts.clear();
        for shape in output.shapes.iter().rev() {
            text_dump::collect(&shape.shape, &mut |text, rect| {
                let seen = rect.intersect(shape.clip_rect).intersect(window);
                self.texts.push(Text { text: text.to_owned(), rect, seen });
            });
        }
        output.drop_without_applying_deltas();
    }

    /// Runs passes until the window is at rest.
    pub fn rest(&mut self) {
        (0..6).for_each(|_| self.pass(Vec::new()));
    }

    /// Returns the texts equal to `text` that are at least partly visible.
    pub fn all(&self, text: &str) -> Vec<Text> {
        let is = |t: &&Text| t.text == text && t.seen.is_positive();
        self.texts.iter().filter(is).cloned().collect()
    }

    /// Returns true if `text` is visible as a whole.
    pub fn reads(&self, text: &str) -> bool {
        self.all(text).iter().any(Text::is_whole)
    }

    /// Returns true if a visible text contains `part`.
    pub fn says(&self, part: &str) -> bool {
        self.texts.iter().any(|t| t.text.contains(part) && t.seen.is_positive())
    }

    /// Returns the position of `text`.
    #[track_caller]
    pub fn position_of(&self, text: &str) -> Pos2 {
        let found = self.all(text);
        found.first().unwrap_or_else(|| panic!("no `{text}` in {:#?}", self.texts)).rect.center()
    }

    /// Moves the pointer and waits until a tooltip would be shown.
    pub fn point(&mut self, at: Pos2) {
        self.pass(vec![Event::PointerMoved(at)]);
        self.rest();
        self.time += 2.0;
        self.rest();
    }

    /// Presses and releases the left button.
    pub fn click(&mut self, at: Pos2) {
        self.drag(at, at);
    }

    /// Drags with the left button.
    pub fn drag(&mut self, from: Pos2, to: Pos2) {
        let button = |pos, pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.pass(vec![Event::PointerMoved(from)]);
        self.pass(vec![button(from, true)]);
        for step in [0.5, 1.0] {
            self.pass(vec![Event::PointerMoved(from.lerp(to, step))]);
        }
        self.pass(vec![button(to, false)]);
        self.rest();
    }

    /// Presses and releases the left button twice.
    pub fn double_click(&mut self, at: Pos2) {
        let button = |pressed| Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        // Long after any previous click, so that it is no triple click.
        self.time += 1.0;
        self.pass(vec![Event::PointerMoved(at)]);
        for pressed in [true, false, true, false] {
            self.pass(vec![button(pressed)]);
        }
        self.rest();
    }

    /// Types `text`.
    pub fn write(&mut self, text: &str) {
        self.pass(vec![Event::Text(text.to_owned())]);
        self.rest();
    }

    /// Clicks on `text`.
    #[track_caller]
    pub fn press(&mut self, text: &str) {
        let at = self.position_of(text);
        self.click(at);
    }

    /// Presses a key.
    pub fn key(&mut self, key: Key) {
        self.key_held(key, Modifiers::NONE);
    }

    /// Presses a key while `modifiers` are held.
    pub fn key_held(&mut self, key: Key, modifiers: Modifiers) {
        let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        self.pass(vec![Event::ModifiersChanged(modifiers), event(true)]);
        self.pass(vec![event(false), Event::ModifiersChanged(Modifiers::NONE)]);
        self.rest();
    }

    /// Turns the wheel at a point by `points`, downward positive.
    pub fn wheel(&mut self, at: Pos2, points: f32) {
        let turn = Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta: vec2(0.0, -points),
            phase: egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
        };
        self.pass(vec![Event::PointerMoved(at), turn]);
        self.rest();
    }

    /// Turns the wheel at a point from the top to the bottom. Returns the texts that are visible as a whole on the way.
    pub fn sweep(&mut self, at: Pos2) -> HashSet<String> {
        self.wheel(at, -1e4);
        let mut seen = HashSet::new();
        for _ in 0..MOST_TURNS {
            let whole = self.texts.iter().filter(|text| text.is_whole());
            seen.extend(whole.map(|text| text.text.clone()));
            self.wheel(at, TURN);
        }
        seen
    }

    /// Turns the wheel at a point until `text` is visible as a whole.
    #[track_caller]
    pub fn scroll_to(&mut self, text: &str, at: Pos2) {
        self.wheel(at, -1e4);
        for _ in 0..MOST_TURNS {
            if self.reads(text) {
                return;
            }
            self.wheel(at, TURN);
        }
        panic!("no `{text}`");
    }
}
