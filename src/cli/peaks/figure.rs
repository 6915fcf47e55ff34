//! Peaks as a labelled figure: wavelength against angle, and the period that follows from each wavelength.

use super::{Arguments, TangentAxis};
use crate::cli::captions;
use crate::figure::{Axis, AxisScale, ColorScale, Figure, Mark, MarkShape, Panel, Raster, palette};
use crate::measure::order_peaks::{FollowedBranch, OrderPeaks};
use crate::measure::peaks::{Peak, PeriodStatistics, WindowSpread};
use crate::measure::sweep::AngleSweep;
use crate::optics::geometry::sin_cos_degrees;
use crate::optics::grating;
use crate::surface::HeightField;

/// Names of the panels: the responses, and the period of each wavelength.
pub const PANELS: [&str; 2] = ["response", "periods"];
/// Largest size of a figure's map \[pixels\].
const FINEST: [usize; 2] = [1200, 800];
/// Decades of the colour scale.
const DECADES: f64 = 5.0;

/// Returns the figure of a sweep and the peaks found in it.
pub fn figure(
    arguments: &Arguments,
    field: &HeightField,
    sweep: &AngleSweep,
    found: &[OrderPeaks],
) -> Figure {
    Figure::new("")
        .row(vec![map(arguments, sweep, found), periods(arguments, found)])
        .panel_size(680.0, 470.0)
        .caption(caption(arguments, field, found))
}

/// Returns the response in false colour, with the peaks and the angles of the grating equation.
fn map(arguments: &Arguments, sweep: &AngleSweep, found: &[OrderPeaks]) -> Panel {
    let half = |step: f64| step / 2.0;
    let ends = |values: &[f64], half: f64| (values[0] - half, values[values.len() - 1] + half);
    let (left, right) = ends(&sweep.angles, half(arguments.angles.step()));
    let nanometres: Vec<f64> = sweep.wavelengths.iter().map(|x| x * 1e3).collect();
    let (low, high) = ends(&nanometres, half(arguments.wavelengths.step()));
    let plane = match arguments.axis {
        TangentAxis::X => "+x",
        TangentAxis::Y => "+y",
    };
    let x = Axis::linear(format!("view angle toward {plane} [°]"), left, right);
    let mut panel = Panel::new(x, Axis::linear("wavelength [nm]", low, high))
        .called(PANELS[0])
        .titled("Response")
        .over(raster(sweep));
    for (i, of) in found.iter().enumerate() {
        let line = Mark::Line { points: ridge(of), color: palette::SKY, width: 2.6, dashed: false };
        panel = if i == 0 { panel.named("largest response", line) } else { panel.mark(line) };
    }
    let mut named = false;
    let laws = found.iter().flat_map(|of| drawn_periods(arguments, of).into_iter().map(move |d| (of, d)));
    for (of, period) in laws {
        for side in [1, -1] {
            let points = law(arguments.theta_i, side * of.sought.order as i32, period, &sweep.wavelengths);
            let line = Mark::Line { points, color: palette::GREEN, width: 1.4, dashed: true };
            let name = match arguments.period {
                Some(given) => format!("grating equation, d = {:.1} nm as given", given * 1e3),
                None if of.branches.is_empty() => "grating equation with the mean period".to_owned(),
                None => "grating equation with the period of each branch".to_owned(),
            };
            panel = if named { panel.mark(line) } else { panel.named(name, line) };
            named = true;
        }
    }
    panel
}

/// Returns the periods \[µm\] whose grating equation is drawn: the given one, those of the branches, or the mean.
fn drawn_periods(arguments: &Arguments, of: &OrderPeaks) -> Vec<f64> {
    match arguments.period {
        Some(given) => vec![given],
        None if of.branches.is_empty() => of.statistics.mean.into_iter().collect(),
        None => of.branches.iter().filter_map(|followed| followed.branch.statistics.mean).collect(),
    }
}

/// Returns the angle of each wavelength's peak \[degrees, nm\], broken between different orders or branches.
fn ridge(found: &OrderPeaks) -> Vec<[f64; 2]> {
    /// Largest ratio of the periods of neighbouring wavelengths of one order.
    const SAME: f64 = 1.1;
    let mut points = Vec::with_capacity(found.peaks.len());
    let mut before: Option<(f64, Option<usize>)> = None;
    for (place, peak) in found.peaks.iter().enumerate() {
        let branch = found.branch_at(place);
        if let (Some((a, last)), Some(b)) = (before, peak.period)
            && (a.max(b) > SAME * a.min(b) || last != branch)
        {
            points.push([f64::NAN; 2]);
        }
        before = peak.period.map(|period| (period, branch)).or(before);
        points.push([peak.angle.unwrap_or(f64::NAN), peak.wavelength * 1e3]);
    }
    points
}

/// Returns the angle of each wavelength by the grating equation \[degrees, nm\]; NaN if the order does not propagate.
fn law(theta_i: f64, order: i32, period: f64, wavelengths: &[f64]) -> Vec<[f64; 2]> {
    let light = sin_cos_degrees(theta_i).0;
    let angle = |wavelength: f64| {
        grating::sin_view(wavelength, light, period, order).map_or(f64::NAN, |s| s.asin().to_degrees())
    };
    wavelengths.iter().map(|&wavelength| [angle(wavelength), wavelength * 1e3]).collect()
}

/// Returns the responses, the largest wavelength on top. Finer responses are reduced to the largest of each block: a peak can be a single
/// cell wide.
fn raster(sweep: &AngleSweep) -> Raster {
    let size = [sweep.angles.len(), sweep.wavelengths.len()];
    let shown = [size[0].min(FINEST[0]), size[1].min(FINEST[1])];
    let mut values = vec![0.0f64; shown[0] * shown[1]];
    for (row, responses) in sweep.responses.chunks(size[0]).enumerate() {
        let from_top = shown[1] - 1 - row * shown[1] / size[1];
        for (column, f) in responses.iter().enumerate() {
            let cell = &mut values[from_top * shown[0] + column * shown[0] / size[0]];
            *cell = cell.max(*f);
        }
    }
    let scale = ColorScale::decades("BRDF [sr⁻¹]", DECADES, &values);
    Raster::values(shown[0], &values, scale)
}

/// Periods of an order or of one of its branches, as drawn in the panel.
struct Series {
    name: String,
    /// Wavelength and period \[nm\].
    points: Vec<[f64; 2]>,
    statistics: PeriodStatistics,
}

impl Series {
    fn new<'a>(
        name: String,
        peaks: impl Iterator<Item = &'a Peak>,
        statistics: PeriodStatistics,
        spread: Option<WindowSpread>,
    ) -> Self {
        let name = match spread.and_then(|spread| spread.half_interval) {
            Some(half) => format!("{name}, mean within {:.1} nm (95 %, windows)", half * 1e3),
            None => name,
        };
        let points = peaks.filter_map(|p| p.period.map(|d| [p.wavelength * 1e3, d * 1e3])).collect();
        Self { name, points, statistics }
    }

    /// Returns one series of the order, or one of each of its branches.
    fn of(found: &OrderPeaks) -> Vec<Self> {
        let order = format!("order {}", found.sought.order);
        if found.branches.is_empty() {
            return vec![Self::new(order, found.peaks.iter(), found.statistics, found.spread)];
        }
        let one = |(number, FollowedBranch { branch, spread, .. }): (usize, &FollowedBranch)| {
            let name = format!("{order}, branch {}", number + 1);
            Self::new(name, branch.peaks.iter().flatten(), branch.statistics, *spread)
        };
        found.branches.iter().enumerate().map(one).collect()
    }
}

/// Returns the panel of the period at each wavelength, with the mean and the standard deviation.
fn periods(arguments: &Arguments, found: &[OrderPeaks]) -> Panel {
    let series: Vec<Series> = found.iter().flat_map(Series::of).collect();
    let all = || series.iter().flat_map(|one| &one.points);
    let given = arguments.period.map(|d| d * 1e3);
    let x = Axis::fit("wavelength [nm]", AxisScale::Linear, all().map(|p| p[0]));
    let y = Axis::fit("period [nm]", AxisScale::Linear, all().map(|p| p[1]).chain(given));
    let mut panel = Panel::new(x.clone(), y).called(PANELS[1]).titled("Period that each wavelength says");
    let is_alone = series.len() == 1;
    for (one, color) in series.into_iter().zip(palette::SERIES.into_iter().cycle()) {
        if let (Some(mean), Some(deviation)) = (one.statistics.mean, one.statistics.deviation) {
            let (mean, deviation) = (mean * 1e3, deviation * 1e3);
            let edge = |x: f64| [x, mean - deviation, mean + deviation];
            if is_alone {
                panel = panel.mark(Mark::Band { points: vec![edge(x.low), edge(x.high)], color });
            }
            panel = panel.mark(Mark::dashed(vec![[x.low, mean], [x.high, mean]], color));
        }
        let dots = Mark::Points { points: one.points, color, shape: MarkShape::Disc, radius: 2.2 };
        panel = panel.named(one.name, dots);
    }
    match given {
        Some(d) => panel.named("given", Mark::line(vec![[x.low, d], [x.high, d]], palette::INK)),
        None => panel,
    }
}

fn caption(arguments: &Arguments, field: &HeightField, found: &[OrderPeaks]) -> String {
    let name = arguments.surface.name(arguments.surface_name.as_deref());
    let told = |of: &OrderPeaks| format!("Order {}: {}.", of.sought.order, of.lines().join("; "));
    let lines: Vec<String> = found.iter().map(told).collect();
    let periods = match found {
        [only] if only.branches.is_empty() => "the dashed line is the mean, the band the standard deviation",
        _ => "dashed lines are the means",
    };
    format!(
        "{}; light from θ = {}° in the plane of N and {}. {} Periods: {periods}.\n{}",
        captions::surface(&name, field),
        arguments.theta_i.to_string().replace('-', "−"),
        arguments.axis.name(),
        captions::sentence(&captions::optics(&arguments.optics)),
        lines.join(" ")
    )
}
