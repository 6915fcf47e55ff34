//! Settings in words, for captions.

use super::options::OpticsOptions;
use crate::optics::coherence::{Coherence, Windows};
use crate::scene::Light;
use crate::setup::Method;
use crate::surface::HeightField;

/// A coherence as the command line has it.
pub fn coherence(coherence: &Coherence) -> String {
    match coherence {
        Coherence::Gaussian { length } => format!("gaussian {} µm", rounded(*length)),
        Coherence::Repeats([n, m]) => format!("{n}×{m} repeats"),
    }
}

/// Method, and what it depends on.
pub fn optics(options: &OpticsOptions) -> String {
    let by = match options.method() {
        Method::Reference => "direct sum (reference)".to_owned(),
        method => {
            let name = clap::ValueEnum::to_possible_value(&method)
                .map_or_else(String::new, |v| v.get_name().to_owned());
            // A table is baked from a basis of its own.
            let basis = options.basis.filter(|_| method == Method::Spectral);
            let basis = basis.map_or_else(String::new, |basis| format!(", {} basis", basis.name()));
            format!("method {name}{basis}, tolerance {}", options.tolerance())
        }
    };
    let windows = match options.windows() {
        Windows::All => ", mean over all windows".to_owned(),
        Windows::Grid([1, 1]) => String::new(),
        Windows::Grid([n, m]) => format!(", {n}×{m} windows"),
    };
    format!("{by}; coherence {}{windows}; refractive index {}", coherence(&options.coherence), options.ior)
}

/// What a surface measures.
pub fn surface(name: &str, field: &HeightField) -> String {
    let [width, height] = field.patch_size().map(rounded);
    let [dx, dy] = field.pixel_size().map(|d| (d * 1e4).round() / 10.0);
    let (low, high) = field.range();
    let spacing = if dx == dy { format!("{dx} nm") } else { format!("{dx} × {dy} nm") };
    format!(
        "{name}, a patch of {width} × {height} µm, samples {spacing} apart, {} nm high",
        rounded((high - low) * 1e3)
    )
}

/// Where lights stand.
pub fn lights(lights: &[Light]) -> String {
    let one = |light: &Light| {
        let strength =
            if light.intensity == 1.0 { String::new() } else { format!(", intensity {}", light.intensity) };
        format!("θ\u{a0}=\u{a0}{}°, φ\u{a0}=\u{a0}{}°{strength}", rounded(light.theta), rounded(light.phi))
    };
    lights.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// Begins `text` with a capital.
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// To what fits into a sentence.
fn rounded(x: f64) -> f64 {
    (x * 1e2).round() / 1e2
}
