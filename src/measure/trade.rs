//! The trade between speed and accuracy: measured settings, the best of them, and what to take.

use crate::error::{Error, Result};
use crate::figure::{Axis, Figure, Mark, Panel, Scale, Shape, palette};
use serde::{Deserialize, Serialize};

/// One setting, measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What was drawn, on what: rows of other frames are not comparable.
    pub frame: String,
    /// The options to type.
    pub flags: String,
    /// Method, and basis where it has one.
    pub series: String,
    /// Terms of the expansion.
    pub terms: usize,
    /// Layers of the texture.
    pub layers: usize,
    /// How it reads between texels.
    pub kernel: String,
    /// Wavelengths a covered pixel.
    pub wavelengths: f64,
    /// Texture samples a covered pixel.
    pub samples: f64,
    /// Median frame on the wall \[ms\].
    pub frame_ms: f64,
    /// Fastest frame on the wall \[ms\].
    pub fastest_ms: f64,
    /// Median of all passes on the device \[ms\].
    pub gpu_ms: f64,
    /// Largest over smallest median of the series' thirds.
    pub spread: f64,
    /// ‖a − b‖/‖b‖ of linear RGB over the covered pixels.
    pub relative_l2: f64,
    /// 99th percentile over pixels of each one's own relative error.
    pub p99: f64,
    /// Mean FLIP of the displayed picture.
    pub flip: f64,
}

impl Row {
    /// Frames a second.
    pub fn fps(&self) -> f64 {
        1e3 / self.frame_ms
    }
}

/// Series of what others do: they are compared with, but never advised, because no option asks for them.
pub const GRATING: &str = "baseline: grating equation";
/// See [`GRATING`].
pub const THESIS: &str = "baseline: the thesis";

impl Row {
    /// Whether an option asks for it.
    fn is_own(&self) -> bool {
        self.series != GRATING && self.series != THESIS
    }
}

/// Whether each row is on the Pareto front: no other one is both as fast and as accurate, and better in one of them.
pub fn pareto(rows: &[Row]) -> Vec<bool> {
    let better = |a: &Row, b: &Row| {
        a.frame_ms <= b.frame_ms
            && a.relative_l2 <= b.relative_l2
            && (a.frame_ms < b.frame_ms || a.relative_l2 < b.relative_l2)
    };
    rows.iter()
        .map(|row| row.is_own() && !rows.iter().any(|other| other.is_own() && better(other, row)))
        .collect()
}

/// What to take: the fastest setting under each error, the most accurate one at each frame rate.
pub fn advice(rows: &[Row]) -> String {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.is_own()).collect();
    let mut lines = Vec::new();
    for error in [1e-1, 3e-2, 1e-2, 3e-3, 1e-3] {
        let fastest = rows
            .iter()
            .filter(|row| row.relative_l2 <= error)
            .min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms));
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

/// The setting for who asks for an error, a frame rate or both: the fastest that keeps the error, the most accurate that
/// keeps the rate. Where no setting keeps both, that is said, with the nearest on either side.
pub fn wanted(rows: &[Row], error: Option<f64>, fps: Option<f64>) -> String {
    let own = || rows.iter().filter(|row| row.is_own());
    let (error_kept, rate_kept) = (
        |row: &&Row| error.is_none_or(|e| row.relative_l2 <= e),
        |row: &&Row| fps.is_none_or(|f| row.fps() >= f),
    );
    let fastest = own().filter(error_kept).min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms));
    let finest = own().filter(rate_kept).min_by(|a, b| a.relative_l2.total_cmp(&b.relative_l2));
    let both = own().filter(error_kept).filter(rate_kept);
    // With a rate to keep, what is left over goes into accuracy; without one, into speed.
    let best = match fps {
        Some(_) => both.min_by(|a, b| a.relative_l2.total_cmp(&b.relative_l2)),
        None => both.min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms)),
    };
    let said = |row: &Row| format!("{} (error {:.1e}, {:.2} fps)", row.flags, row.relative_l2, row.fps());
    if let Some(row) = best {
        return format!("asked for: {}\n", said(row));
    }
    let side = |name: &str, row: Option<&Row>| match row {
        Some(row) => format!("; {name}: {}", said(row)),
        None => String::new(),
    };
    let nearest = [
        side("the fastest that keeps the error", fastest.filter(|_| error.is_some())),
        side("the most accurate that keeps the rate", finest.filter(|_| fps.is_some())),
    ];
    format!("asked for: no measured setting does it here{}\n", nearest.concat())
}

/// The rows as CSV.
///
/// # Errors
/// Never, where the rows are sound.
pub fn csv(rows: &[Row]) -> Result<String> {
    let bug = |e: &dyn std::fmt::Display| {
        Error::failed(format!("the table is no CSV ({e})"), "report this as a bug of diffract")
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|e| bug(&e))?;
    let bytes = writer.into_inner().map_err(|e| bug(&e))?;
    String::from_utf8(bytes).map_err(|e| bug(&e))
}

/// The rows of a CSV of [`csv()`] that belong to `frame`; what cannot be read counts as not measured.
pub fn rows_of(text: &str, frame: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader
        .deserialize()
        .filter_map(|row: std::result::Result<Row, _>| row.ok())
        .filter(|row| row.frame == frame)
        .collect()
}

/// The rows as a Markdown table, the fastest first.
pub fn markdown(rows: &[Row], heading: &str, impossible: &[(String, String)]) -> String {
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
    text + "\n## Advice\n\n" + &advice(rows).lines().map(|line| format!("- {line}\n")).collect::<String>()
}

/// Frame time against error, with the Pareto front and the thesis' own shader.
pub fn figure(rows: &[Row], title: &str, caption: &str) -> Figure {
    const SHAPES: [Shape; 5] = [Shape::Disc, Shape::Square, Shape::Triangle, Shape::Diamond, Shape::Ring];
    let place = |row: &Row| [row.frame_ms, row.relative_l2];
    let fit = |label: &str, values: Vec<f64>| Axis::fit(label, Scale::Log, values);
    let mut panel = Panel::new(
        fit("frame time [ms]", rows.iter().map(|r| r.frame_ms).collect()),
        fit("relative L2 error of linear RGB", rows.iter().map(|r| r.relative_l2).collect()),
    );
    let mut front: Vec<[f64; 2]> =
        rows.iter().zip(pareto(rows)).filter(|(_, on)| *on).map(|(row, _)| place(row)).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    panel = panel.named("Pareto front", Mark::line(front, palette::QUIET));
    let mut series: Vec<&str> = Vec::new();
    for row in rows {
        // The thesis gets a mark of its own.
        if row.series != THESIS && !series.contains(&row.series.as_str()) {
            series.push(&row.series);
        }
    }
    for (i, name) in series.iter().enumerate() {
        let points = rows.iter().filter(|r| r.series == **name).map(place).collect();
        let color = palette::SERIES[i % palette::SERIES.len()];
        panel = panel.named(*name, Mark::points(points, color, SHAPES[i % SHAPES.len()]));
    }
    if let Some(thesis) = rows.iter().find(|row| row.series == THESIS) {
        let ring = Mark::Points {
            points: vec![place(thesis)],
            color: palette::INK,
            shape: Shape::Ring,
            radius: 9.0,
        };
        panel = panel.named("the thesis: 37 terms, 81 wavelengths, 3 × 3 reads", ring);
    }
    Figure::new(title).row(vec![panel]).caption(caption).panel_size(760.0, 520.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(flags: &str, frame_ms: f64, relative_l2: f64) -> Row {
        Row {
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
        }
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let rows = [row("a", 1.0, 1e-1), row("b", 2.0, 1e-2), row("c", 3.0, 2e-2), row("d", 2.0, 1e-2)];
        assert_eq!(pareto(&rows), [true, true, false, true]);
        let other = Row { series: GRATING.into(), ..row("e", 0.1, 1e-9) };
        let with_other = [&rows[..], &[other]].concat();
        assert_eq!(pareto(&with_other), [true, true, false, true, false]);
        assert_eq!(advice(&with_other), advice(&rows));
    }

    #[test]
    fn advice_names_the_fastest_under_an_error_and_the_best_at_a_rate() {
        let rows = [row("--a", 10.0, 5e-2), row("--b", 60.0, 2e-3), row("--c", 500.0, 5e-4)];
        let said = advice(&rows);
        let lines: Vec<&str> = said.lines().collect();
        assert!(lines[0].contains("--a") && lines[1].contains("--b") && lines[4].contains("--c"), "{said}");
        assert!(lines[5].starts_with("15 fps: --b") && lines[6].starts_with("60 fps: --a"), "{said}");
        assert!(advice(&rows[2..]).contains("no setting is so fast here"));
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
        assert_eq!(rows_of(&text, "f"), rows);
        assert!(rows_of(&text, "g").is_empty());
        let half = &text[..text.len() - 20];
        assert_eq!(rows_of(half, "f"), rows[..1]);
        let page = markdown(&rows, "A machine.", &[("--c".into(), "no".into())]);
        assert!(
            page.contains("| `--a` | 10.1 ms") && page.contains("`--c`: no") && page.contains("## Advice")
        );
    }

    #[test]
    fn the_figure_marks_the_thesis() {
        let rows = [row("--a", 10.0, 5e-2), Row { series: THESIS.into(), ..row("its sum", 900.0, 2e-3) }];
        let svg = figure(&rows, "Speed", "One machine.").svg().unwrap();
        assert!(svg.contains("thesis") && svg.contains("Pareto"));
    }
}
