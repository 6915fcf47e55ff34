//! Writes every text of the window with its position, so that tests can find a button and press it.
//!
//! If `DIFFRACT_WORDS` names a file, the file contains a line for each text, the last drawn first: x and y of its
//! centre in pixels from the upper left, and the text.

use egui::Shape;
use egui::epaint::ClippedShape;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Name of the environment variable.
const VARIABLE: &str = "DIFFRACT_WORDS";

/// File and its contents.
pub struct TextDump {
    path: PathBuf,
    written: String,
}

impl TextDump {
    /// Returns the dump to the file named in the environment, if any.
    pub fn from_environment() -> Option<Self> {
        let path = std::env::var_os(VARIABLE).filter(|path| !path.is_empty())?;
        Some(Self { path: path.into(), written: String::new() })
    }

    /// Writes the texts of `shapes`, at `scale` pixels per point, if they have changed.
    pub fn write(&mut self, shapes: &[ClippedShape], scale: f32) {
        let mut texts = String::new();
        for ClippedShape { clip_rect, shape } in shapes.iter().rev() {
            collect(shape, &mut |text, rect| {
                let at = rect.center();
                if clip_rect.contains(at) {
                    let line = text.replace('\n', " ");
                    let _ = writeln!(texts, "{:.0} {:.0} {line}", at.x * scale, at.y * scale); // writing to a String cannot fail
                }
            });
        }
        if texts != self.written {
            let draft = self.path.with_extension("draft");
            // Renamed into place, so that readers never see a partial file. If it cannot be written, the test that
            // waits for it fails.
            if std::fs::write(&draft, &texts).and_then(|()| std::fs::rename(&draft, &self.path)).is_ok() {
                self.written = texts;
            }
        }
    }
}

/// Calls `add` with each text in `shape` and its rectangle.
pub fn collect(shape: &Shape, add: &mut dyn FnMut(&str, egui::Rect)) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, add)),
        Shape::Text(text) => {
            add(text.galley.text(), text.galley.rect.translate(text.pos.to_vec2()));
        }
        _ => {}
    }
}
