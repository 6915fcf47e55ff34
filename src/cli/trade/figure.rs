//! The plot of `trade`: frame time against error.

use crate::figure::{Axis, AxisScale, Figure, Mark, MarkShape, Panel, palette};
use crate::measure::trade::{Measurement, THESIS, pareto};

/// Name of the panel.
pub const PANELS: [&str; 1] = ["trade"];

/// Draws frame time against error, with the Pareto front and the baselines.
pub fn figure(rows: &[Measurement], title: &str, caption: &str) -> Figure {
    const SHAPES: [MarkShape; 5] =
        [MarkShape::Disc, MarkShape::Square, MarkShape::Triangle, MarkShape::Diamond, MarkShape::Ring];
    let place = |row: &Measurement| [row.frame_ms, row.relative_l2];
    let fit = |label: &str, values: Vec<f64>| Axis::fit(label, AxisScale::Log, values);
    let mut panel = Panel::new(
        fit("frame time [ms]", rows.iter().map(|r| r.frame_ms).collect()),
        fit("relative L2 error of linear RGB", rows.iter().map(|r| r.relative_l2).collect()),
    )
    .called(PANELS[0]);
    let mut front: Vec<[f64; 2]> =
        rows.iter().zip(pareto(rows)).filter(|(_, on)| *on).map(|(row, _)| place(row)).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    panel = panel.named("Pareto front", Mark::line(front, palette::QUIET));
    let mut series: Vec<&str> = Vec::new();
    for row in rows {
        // The thesis has a different mark.
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
            shape: MarkShape::Ring,
            radius: 9.0,
        };
        panel = panel.named("the thesis: 37 terms, 81 wavelengths, 3 × 3 reads", ring);
    }
    Figure::new(title).row(vec![panel]).caption(caption).panel_size(760.0, 520.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::FigureStyle;
    use crate::notes::Notes;

    #[test]
    fn the_figure_marks_the_thesis() {
        let measured = |series: &str, frame_ms, relative_l2| Measurement {
            series: series.to_owned(),
            frame_ms,
            relative_l2,
            ..Measurement::default()
        };
        let rows = [measured("spectral, taylor", 10.0, 5e-2), measured(THESIS, 900.0, 2e-3)];
        let svg =
            figure(&rows, "Speed", "One machine.").svg(&FigureStyle::default(), &Notes::default()).unwrap();
        assert!(svg.contains("thesis") && svg.contains("Pareto"));
    }
}
