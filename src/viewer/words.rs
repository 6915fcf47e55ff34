//! Every word that the window shows and where it stands, for tests that look for a button and press it.
//!
//! Where `DIFFRACT_WORDS` names a file, it holds a line for each text on the panel and on the picture, from the last to the
//! first that was drawn: pixels from the left and from the top to its middle, and the text.

use egui::Shape;
use egui::epaint::ClippedShape;
use std::fmt::Write as _;
use std::path::PathBuf;

/// The name of the variable.
const VARIABLE: &str = "DIFFRACT_WORDS";

/// The file, and what it holds.
pub struct Words {
    path: PathBuf,
    written: String,
}

impl Words {
    /// Where the environment asks for it.
    pub fn from_environment() -> Option<Self> {
        let path = std::env::var_os(VARIABLE).filter(|path| !path.is_empty())?;
        Some(Self { path: path.into(), written: String::new() })
    }

    /// Writes what `shapes` say, `scale` pixels to a point, unless the file says it already.
    pub fn tell(&mut self, shapes: &[ClippedShape], scale: f32) {
        let mut words = String::new();
        for ClippedShape { clip_rect, shape } in shapes.iter().rev() {
            collect(shape, &mut |text, at| {
                if clip_rect.contains(at) {
                    let line = text.replace('\n', " ");
                    let _ = writeln!(words, "{:.0} {:.0} {line}", at.x * scale, at.y * scale); // a String takes all
                }
            });
        }
        if words != self.written {
            let draft = self.path.with_extension("draft");
            // Readers see one state or the other. A file that cannot be written fails the test that waits for it.
            if std::fs::write(&draft, &words).and_then(|()| std::fs::rename(&draft, &self.path)).is_ok() {
                self.written = words;
            }
        }
    }
}

/// Gives `say` each text in `shape` and the middle of it.
fn collect(shape: &Shape, say: &mut dyn FnMut(&str, egui::Pos2)) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, say)),
        Shape::Text(text) => {
            say(text.galley.text(), text.galley.rect.translate(text.pos.to_vec2()).center());
        }
        _ => {}
    }
}
