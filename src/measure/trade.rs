//! Speed against accuracy: measured settings, their Pareto front, and advice.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Measured speed and accuracy of a setting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Key of frame and device. Measurements with other keys are not comparable.
    pub frame: String,
    /// Command line options of the setting.
    pub flags: String,
    /// Method, and basis if it has one.
    pub series: String,
    /// Terms of the expansion.
    pub terms: usize,
    /// Layers of the texture.
    pub layers: usize,
    /// Interpolation between texels.
    pub kernel: String,
    /// Wavelengths per covered pixel.
    pub wavelengths: f64,
    /// Texture samples per covered pixel.
    pub samples: f64,
    /// Median frame time \[ms\].
    pub frame_ms: f64,
    /// Shortest frame time \[ms\].
    pub fastest_ms: f64,
    /// Median time on the device \[ms\].
    pub gpu_ms: f64,
    /// Largest over smallest of the medians of three parts of the series.
    pub spread: f64,
    /// Relative L2 error of linear RGB over the covered pixels: ‖a − b‖/‖b‖.
    pub relative_l2: f64,
    /// 99th percentile of the relative errors of single pixels.
    pub p99: f64,
    /// Mean FLIP of the displayed picture.
    pub flip: f64,
    /// Largest `relative_l2` that the setting promises; 0 if it promises none: baselines, and settings with a fixed
    /// number of terms or wavelengths.
    #[serde(default)]
    pub promised: f64,
}

impl Measurement {
    /// Returns the frames per second.
    pub fn fps(&self) -> f64 {
        1e3 / self.frame_ms
    }

    /// Returns true if the measured error exceeds the promised one.
    pub fn breaks_promise(&self) -> bool {
        self.promised > 0.0 && self.relative_l2 > self.promised
    }

    /// Returns true if its numbers are plausible; figures show them on logarithmic axes.
    fn is_sound(&self) -> bool {
        /// From a femtosecond to a century \[ms\].
        const TIMES: std::ops::RangeInclusive<f64> = 1e-12..=3e12;
        /// Range of all other numbers.
        const OTHERS: std::ops::RangeInclusive<f64> = 0.0..=1e15;
        [self.frame_ms, self.fastest_ms, self.gpu_ms].iter().all(|x| TIMES.contains(x))
            && [
                self.wavelengths,
                self.samples,
                self.spread,
                self.relative_l2,
                self.p99,
                self.flip,
                self.promised,
            ]
            .iter()
            .all(|x| OTHERS.contains(x))
    }
}

/// Series of the settings that answer what a pixel sees.
const TABLE: &str = "table";
/// Series of baselines. They are shown for comparison but never recommended, because no option selects them.
pub const GRATING: &str = "baseline: grating equation";
/// See [`GRATING`].
pub const THESIS: &str = "baseline: the thesis";

impl Measurement {
    /// Returns true for a setting of this program, false for a baseline.
    fn is_own(&self) -> bool {
        self.series != GRATING && self.series != THESIS
    }

    /// Returns true for a setting that can be recommended.
    fn is_advisable(&self) -> bool {
        self.is_own() && !self.breaks_promise()
    }

    /// Returns the question that the setting answers.
    fn question(&self) -> AnsweredQuestion {
        if self.series == TABLE { AnsweredQuestion::Mean } else { AnsweredQuestion::Window }
    }

    /// Returns true if the error is at most `error`, as far as two digits tell.
    fn keeps(&self, error: f64) -> bool {
        format!("{:.1e}", self.relative_l2).parse().is_ok_and(|rounded: f64| rounded <= error)
    }
}

/// AnsweredQuestion whose answer a setting approximates. Errors of settings are against the exact answer of their own question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnsweredQuestion {
    /// Mean over all coherence areas, which is what a pixel sees.
    Mean,
    /// Light through one window.
    Window,
}

impl AnsweredQuestion {
    /// Returns the question in words.
    fn name(self) -> &'static str {
        match self {
            Self::Mean => "what a pixel sees, the mean over all windows",
            Self::Window => "the light through one window",
        }
    }

    /// Returns the question that `rows` are asked: the mean, if a row answers it.
    fn asked(rows: &[Measurement]) -> Self {
        let is_mean = |row: &Measurement| row.is_own() && row.question() == Self::Mean;
        if rows.iter().any(is_mean) { Self::Mean } else { Self::Window }
    }
}

/// Returns for each measurement if it is on the Pareto front of its question: no other is at least as fast and as accurate, and better
/// in one of the two.
pub fn pareto(rows: &[Measurement]) -> Vec<bool> {
    let better = |a: &Measurement, b: &Measurement| {
        a.question() == b.question()
            && a.frame_ms <= b.frame_ms
            && a.relative_l2 <= b.relative_l2
            && (a.frame_ms < b.frame_ms || a.relative_l2 < b.relative_l2)
    };
    rows.iter()
        .map(|row| row.is_advisable() && !rows.iter().any(|other| other.is_advisable() && better(other, row)))
        .collect()
}

/// Returns recommendations for each question that was measured: the fastest setting within each error, the most accurate one at each frame
/// rate.
pub fn advice(rows: &[Measurement]) -> String {
    let mut text = String::new();
    for question in [AnsweredQuestion::Mean, AnsweredQuestion::Window] {
        let of_question: Vec<&Measurement> =
            rows.iter().filter(|row| row.is_advisable() && row.question() == question).collect();
        if !of_question.is_empty() || question == AnsweredQuestion::asked(rows) {
            text += &format!("For {}:\n{}", question.name(), advice_of(&of_question));
        }
    }
    text
}

/// Returns the recommendations among `rows` of one question.
fn advice_of(rows: &[&Measurement]) -> String {
    let mut lines = Vec::new();
    for error in [1e-1, 3e-2, 1e-2, 3e-3, 1e-3] {
        let fastest =
            rows.iter().filter(|row| row.keeps(error)).min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms));
        lines.push(match fastest {
            Some(row) => format!(
                "error {error:.0e}: {} ({:.2} fps, measured error {:.1e})",
                row.flags,
                row.fps(),
                row.relative_l2
            ),
            None => format!("error {error:.0e}: none of the measured settings reaches it"),
        });
    }
    for fps in [15.0, 60.0] {
        let best =
            rows.iter().filter(|row| row.fps() >= fps).min_by(|a, b| a.relative_l2.total_cmp(&b.relative_l2));
        lines.push(match (best, rows.iter().max_by(|a, b| a.fps().total_cmp(&b.fps()))) {
            (Some(row), _) => {
                format!("{fps:.0} fps: {} (error {:.1e}, {:.1} fps)", row.flags, row.relative_l2, row.fps())
            }
            (None, Some(row)) => {
                format!("{fps:.0} fps: no setting is so fast here; the fastest makes {:.2} fps", row.fps())
            }
            (None, None) => format!("{fps:.0} fps: nothing was measured"),
        });
    }
    lines.join("\n") + "\n"
}

/// Returns the best setting of the question that `rows` are asked within `error`, at `fps`, or both: the fastest within the error, or the most accurate at
/// the frame rate. If none satisfies both, names the nearest on either side.
pub fn wanted(rows: &[Measurement], error: Option<f64>, fps: Option<f64>) -> String {
    let question = AnsweredQuestion::asked(rows);
    let advisable = || rows.iter().filter(|row| row.is_advisable() && row.question() == question);
    let (error_kept, rate_kept) = (
        |row: &&Measurement| error.is_none_or(|e| row.keeps(e)),
        |row: &&Measurement| fps.is_none_or(|f| row.fps() >= f),
    );
    let fastest = advisable().filter(error_kept).min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms));
    let finest = advisable().filter(rate_kept).min_by(|a, b| a.relative_l2.total_cmp(&b.relative_l2));
    let both = advisable().filter(error_kept).filter(rate_kept);
    // With a required frame rate, spare time is spent on accuracy; without one, the fastest is best.
    let best = match fps {
        Some(_) => both.min_by(|a, b| a.relative_l2.total_cmp(&b.relative_l2)),
        None => both.min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms)),
    };
    let said =
        |row: &Measurement| format!("{} (error {:.1e}, {:.2} fps)", row.flags, row.relative_l2, row.fps());
    if let Some(row) = best {
        return format!("asked for: {}\n", said(row));
    }
    let side = |name: &str, row: Option<&Measurement>| match row {
        Some(row) => format!("; {name}: {}", said(row)),
        None => String::new(),
    };
    let nearest = [
        side("the fastest that keeps the error", fastest.filter(|_| error.is_some())),
        side("the most accurate that keeps the rate", finest.filter(|_| fps.is_some())),
    ];
    format!("asked for: no measured setting does it here{}\n", nearest.concat())
}

/// Formats the measurements as CSV.
///
/// # Errors
/// Fails only on a bug.
pub fn csv(rows: &[Measurement]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(no_csv)?;
    let bytes = writer.into_inner().map_err(no_csv)?;
    String::from_utf8(bytes).map_err(no_csv)
}

/// Returns the error for measurements that are no CSV.
fn no_csv(cause: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::bug(format!("the table is no CSV ({cause})")).caused_by(cause)
}

/// Reads the measurements of `frame` from a CSV of [`csv()`]. Unreadable lines are skipped.
pub fn from_csv(text: &str, frame: &str) -> Vec<Measurement> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader
        .deserialize()
        .filter_map(|row: std::result::Result<Measurement, _>| row.ok()) // damaged, or of an earlier version: measured again
        .filter(|row| row.frame == frame && row.is_sound())
        .collect()
}

/// Formats the measurements as a Markdown table, the fastest first.
pub fn markdown(rows: &[Measurement], heading: &str, impossible: &[(String, String)]) -> String {
    let front = pareto(rows);
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&a, &b| rows[a].frame_ms.total_cmp(&rows[b].frame_ms));
    let mut text = format!(
        "# Speed against accuracy\n\n{heading}\n\n| setting | frame | fps | error (L2) | p99 | FLIP | samples a pixel | \
         on the front |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n"
    );
    for i in order {
        let row = &rows[i];
        text += &format!(
            "| `{}` | {:.1} ms | {:.2} | {:.1e} | {:.1e} | {:.1e} | {:.0} | {} |\n",
            row.flags,
            row.frame_ms,
            row.fps(),
            row.relative_l2,
            row.p99,
            row.flip,
            row.samples,
            match (front[i], row.is_own()) {
                _ if row.breaks_promise() => "no: its error exceeds what it promises",
                (true, _) => "yes",
                (false, true) => "",
                (false, false) => "no: for comparison",
            }
        );
    }
    if !impossible.is_empty() {
        text += "\nNot possible here:\n\n";
        for (flags, why) in impossible {
            text += &format!("- `{flags}`: {why}\n");
        }
    }
    text + "\n## Advice\n\n" + &in_list(&advice(rows))
}

/// Formats lines of advice as lists below their questions.
fn in_list(advice: &str) -> String {
    let line = |line: &str| match line.strip_suffix(':') {
        Some(question) => format!("\n{question}:\n\n"),
        None => format!("- {line}\n"),
    };
    advice.lines().map(line).collect::<String>().trim_start().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(flags: &str, frame_ms: f64, relative_l2: f64) -> Measurement {
        Measurement {
            frame: "f".into(),
            flags: flags.into(),
            series: "spectral, taylor".into(),
            terms: 4,
            layers: 2,
            kernel: "bspline".into(),
            wavelengths: 30.0,
            samples: 100.0,
            frame_ms,
            fastest_ms: frame_ms,
            gpu_ms: frame_ms,
            spread: 1.0,
            relative_l2,
            p99: relative_l2,
            flip: 0.0,
            promised: 0.0,
        }
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let rows = [row("a", 1.0, 1e-1), row("b", 2.0, 1e-2), row("c", 3.0, 2e-2), row("d", 2.0, 1e-2)];
        assert_eq!(pareto(&rows), [true, true, false, true]);
        let other = Measurement { series: GRATING.into(), ..row("e", 0.1, 1e-9) };
        let with_other = [&rows[..], &[other]].concat();
        assert_eq!(pareto(&with_other), [true, true, false, true, false]);
        assert_eq!(advice(&with_other), advice(&rows));
    }

    #[test]
    fn a_setting_that_breaks_its_promise_is_marked_and_never_recommended() {
        let broken = Measurement { promised: 1e-2, ..row("--broken", 1.0, 1.1e-2) };
        let kept = Measurement { promised: 2e-2, ..row("--kept", 2.0, 1.1e-2) };
        let rows = [broken, kept];
        assert_eq!(pareto(&rows), [false, true]);
        assert!(!advice(&rows).contains("--broken") && advice(&rows).contains("--kept"));
        assert!(wanted(&rows, Some(1e-1), None).contains("--kept"));
        let page = markdown(&rows, "A machine.", &[]);
        let line = |flags: &str| page.lines().find(|line| line.starts_with(&format!("| `{flags}`"))).unwrap();
        assert!(line("--broken").contains("exceeds what it promises") && line("--kept").ends_with("| yes |"));
    }

    #[test]
    fn advice_names_the_fastest_under_an_error_and_the_best_at_a_rate() {
        let rows = [row("--a", 10.0, 5e-2), row("--b", 60.0, 2e-3), row("--c", 500.0, 5e-4)];
        let said = advice(&rows);
        let lines: Vec<&str> = said.lines().collect();
        assert!(lines[1].contains("--a") && lines[2].contains("--b") && lines[5].contains("--c"), "{said}");
        assert!(lines[6].starts_with("15 fps: --b") && lines[7].starts_with("60 fps: --a"), "{said}");
        assert!(advice(&rows[2..]).contains("no setting is so fast here"));
    }

    #[test]
    fn a_setting_that_answers_another_question_is_no_advice() {
        let window = row("--windows 1x1 --basis optimal", 5.0, 2.3e-3);
        let table =
            |flags, frame_ms, error| Measurement { series: TABLE.into(), ..row(flags, frame_ms, error) };
        let rows = [window.clone(), table("--method table", 8.0, 1.04e-2), table("--other", 9.0, 1.06e-2)];
        // 1.04e-2 is 1.0e-2 in the table, 1.06e-2 is 1.1e-2.
        assert!(wanted(&rows, Some(1e-2), None).starts_with("asked for: --method table (error 1.0e-2"));
        assert!(wanted(&rows[2..], Some(1e-2), None).contains("no measured setting"));
        let said = advice(&rows);
        let (mean, window_s) = said.split_once("For the light through one window:\n").unwrap();
        assert!(mean.starts_with("For what a pixel sees") && !mean.contains("--windows"), "{said}");
        assert!(window_s.contains("error 1e-2: --windows 1x1"), "{said}");
        assert_eq!(pareto(&rows), [true, true, false], "questions do not compete");
        // One window alone is what is asked for.
        assert!(wanted(&[window], Some(1e-2), None).starts_with("asked for: --windows 1x1"));
    }

    #[test]
    fn what_is_asked_for_is_kept_or_refused_with_the_nearest() {
        let rows = [row("--a", 10.0, 5e-2), row("--b", 60.0, 2e-3), row("--c", 500.0, 5e-4)];
        assert!(wanted(&rows, Some(1e-2), None).starts_with("asked for: --b "));
        assert!(wanted(&rows, None, Some(1.0)).starts_with("asked for: --c "));
        assert!(wanted(&rows, Some(1e-2), Some(1.0)).starts_with("asked for: --c "));
        assert!(wanted(&rows, Some(1e-2), Some(10.0)).starts_with("asked for: --b "));
        let neither = wanted(&rows, Some(1e-3), Some(50.0));
        assert!(
            neither.contains("no measured setting") && neither.contains("--c") && neither.contains("--a"),
            "{neither}"
        );
        assert_eq!(wanted(&rows, None, Some(1e6)), "asked for: no measured setting does it here\n");
    }

    #[test]
    fn a_table_is_read_back_bit_by_bit_and_other_frames_are_left_out() {
        let rows = vec![row("--a", 10.123_456_789, 5e-2 / 3.0), row("--b \"x,y\"", 60.0, 2e-3)];
        let text = csv(&rows).unwrap();
        assert_eq!(from_csv(&text, "f"), rows);
        assert!(from_csv(&text, "g").is_empty());
        for number in ["NaN", "inf", "-1.0", "0.0", "1e300"] {
            let changed = text.replace("10.123456789", number);
            assert!(changed != text && from_csv(&changed, "f") == rows[1..], "{number}");
        }
        let half = &text[..text.len() - 20];
        assert_eq!(from_csv(half, "f"), rows[..1]);
        let page = markdown(&rows, "A machine.", &[("--c".into(), "no".into())]);
        assert!(
            page.contains("| `--a` | 10.1 ms") && page.contains("`--c`: no") && page.contains("## Advice")
        );
    }
}
