//! Settings as text for the captions of figures.

use super::console::Console;
use super::options::OpticsOptions;
use crate::notes::Notes;
use crate::optics::coherence::{Coherence, Windows};
use crate::optics::reflectance::Reflectance;
use crate::optics::validity::{LightColour, ScalarTheory};
use crate::picture_file::quoted;
use crate::scene::FarLight;
use crate::settings::Method;
use crate::surface::HeightField;
use std::ffi::OsString;

/// Returns the notes of a result of this run from `field`.
pub fn notes(field: &HeightField, console: &Console) -> Notes {
    Notes::new(own_command(console), field.prepared())
}

/// Returns the notes of a picture that this run draws of `field`, which reflects by `reflectance`, in light of this colour.
pub fn picture_notes(
    console: &Console,
    field: &HeightField,
    reflectance: &Reflectance,
    colour: LightColour<'_>,
) -> Notes {
    notes(field, console).with_scalar_theory(ScalarTheory::note(field, reflectance, colour))
}

/// Returns the command of this run, as a shell takes it, without the names of results.
pub fn own_command(console: &Console) -> String {
    command(console.words(), None)
}

/// Returns `notes` for picture number `frame` of a sequence, with the text `more` under the name `name`.
pub fn notes_of_frame(console: &Console, notes: &Notes, frame: u32, name: &str, more: String) -> Notes {
    let mut noted = notes.clone();
    noted.command = command(console.words(), Some(frame));
    noted.more.push((name.to_owned(), more));
    noted
}

/// Returns the command `words` (the program's name first), as a shell takes it, without the options that name results: the notes of a
/// picture do not depend on the name of its file. For a sequence, the command draws picture number `frame` alone.
fn command(words: &[OsString], frame: Option<u32>) -> String {
    let mut kept = vec!["diffract".to_owned()];
    let mut words = words.iter().skip(1).map(|word| word.to_string_lossy().into_owned());
    while let Some(word) = words.next() {
        let name = word.split('=').next().unwrap_or_default();
        if ["-o", "--output", "--plot", "--json", "--spectrum", "--html", "--cache-size", "--frames"]
            .contains(&name)
        {
            // The value is the next word unless it stands in this one. `surface info` writes its JSON to stdout.
            let has_value = name != "--json" || !kept.iter().any(|word| word == "info");
            if name == word && has_value {
                words.next();
            }
        } else if !word.starts_with("-o") {
            kept.push(quoted(&word));
        }
    }
    if let Some(frame) = frame {
        // Behind two hyphens there are no options any more.
        let end = kept.iter().position(|word| word == "--").unwrap_or(kept.len());
        kept.insert(end, format!("--frames {frame}..{}", frame + 1));
    }
    kept.join(" ")
}

/// Describes the coherence.
pub fn coherence(coherence: &Coherence) -> String {
    match coherence {
        Coherence::Gaussian { length } => format!("gaussian {} µm", rounded(*length)),
        Coherence::Repeats([n, m]) => format!("{n}×{m} repeats"),
    }
}

/// Describes the method with its settings, the coherence and the refractive index.
pub fn optics(options: &OpticsOptions) -> String {
    let method = match options.method() {
        Method::Reference => "direct sum (reference)".to_owned(),
        method => {
            let name = clap::ValueEnum::to_possible_value(&method)
                .map_or_else(String::new, |v| v.get_name().to_owned());
            // The basis of a colour table is fixed.
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
    let surface = options.reflectance(None);
    format!("{method}; coherence {}{windows}; {surface}", coherence(&options.coherence))
}

/// Describes a surface: name, size, sample spacing, height and preparation.
pub fn surface(name: &str, field: &HeightField) -> String {
    let [width, height] = field.patch_size().map(rounded);
    let [dx, dy] = field.pixel_size().map(|d| (d * 1e4).round() / 10.0);
    let (low, high) = field.range();
    let spacing = if dx == dy { format!("{dx} nm") } else { format!("{dx} × {dy} nm") };
    format!(
        "{name}, a patch of {width} × {height} µm, samples {spacing} apart, {} nm high, prepared by: {}",
        rounded((high - low) * 1e3),
        field.prepared()
    )
}

/// Describes the directions and intensities of lights.
pub fn lights(lights: &[FarLight]) -> String {
    let one = |light: &FarLight| {
        let strength =
            if light.intensity == 1.0 { String::new() } else { format!(", intensity {}", light.intensity) };
        format!("θ\u{a0}=\u{a0}{}°, φ\u{a0}=\u{a0}{}°{strength}", rounded(light.theta), rounded(light.phi))
    };
    lights.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// Returns `text` as a sentence: a capital letter first, a full stop last.
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// Rounds to two decimals.
fn rounded(x: f64) -> f64 {
    (x * 1e2).round() / 1e2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_of_a_picture_is_without_its_file_and_quoted() {
        let of = |line: &str, frame| command(&line.split(' ').map(OsString::from).collect::<Vec<_>>(), frame);
        let said = |line: &str| of(line, None);
        let plain = "diffract render sphere --size 8x6";
        for line in [
            "/usr/bin/diffract render sphere --size 8x6 -o a.png",
            "diffract render -o a.png sphere --size 8x6",
            "diffract render -o=a.png sphere --size 8x6 --cache-size 1MB",
            "diffract render -oa.png sphere --size 8x6",
            "diffract render --output=a.png sphere --size 8x6",
            "diffract render --output a.png sphere --size 8x6",
        ] {
            assert_eq!(said(line), plain, "{line}");
        }
        assert_eq!(said("diffract render it's.toml"), "diffract render 'it'\\''s.toml'");
        let one = of("diffract render --frames 0..9 --turntable 9 -o a.png sphere", Some(3));
        assert_eq!(one, "diffract render --turntable 9 sphere --frames 3..4");
        let one = of("diffract render --frames=0..9 --turntable=9 -o a.png -- sphere", Some(3));
        assert_eq!(one, "diffract render --turntable=9 --frames 3..4 -- sphere");
    }
}
