//! Draws a panel: lays out its plot, then draws axes, marks and colour bar.

use super::axis::Axis;
use super::heading::Heading;
use super::layout::{Area, GAP, TICK, letters};
use super::marks;
use super::palette::{Color, ColorMap, FAINT, INK, PAPER, QUIET};
use super::panel::{Panel, PlotFrame};
use super::raster::{self, Raster};
use super::svg::{Anchor, Letters, Stroke, Svg};
use super::text::{Weight, width};
use crate::error::Result;
use std::f64::consts::PI;

/// Size of the letters of axis labels \[px\].
const LABEL: f64 = 13.0;
/// Width of a colour bar \[px\].
const BAR: f64 = 14.0;
/// Lengths of labelled and of unlabelled ticks \[px\].
const LONG: f64 = 5.0;
const SHORT: f64 = 3.0;
/// Width of the ring of angles around a hemisphere \[px\].
const RIM: f64 = TICK + GAP;
/// Length of an axis per labelled tick, along x and along y \[px\].
const PER_TICK: [f64; 2] = [85.0, 50.0];

/// Panel with its heading, laid out for its width.
pub(super) struct PanelLayout<'a> {
    panel: &'a Panel,
    heading: Heading<'a>,
    width: f64,
}

impl<'a> PanelLayout<'a> {
    /// Lays out `panel` for a width of `width` \[px\].
    pub(super) fn new(panel: &'a Panel, width: f64) -> Self {
        Self { panel, heading: Heading::new(panel, width), width }
    }

    /// Returns the height \[px\] at which nothing stays empty, and the plot has at most this `aspect`.
    pub(super) fn height(&self, aspect: f64) -> f64 {
        let tallest = aspect * self.width;
        let room = Area { at: [0.0; 2], size: [self.width, tallest] };
        let whole = match self.panel.frame {
            PlotFrame::Box { equal: false } => tallest,
            PlotFrame::Box { equal: true } => {
                let plot = inside_of_labels(self.panel, room);
                tallest - plot.size[1] + plot.size[0] * aspect_of(self.panel)
            }
            PlotFrame::Hemisphere => {
                let plot = inside_of_rim(self.panel, room);
                tallest - plot.size[1] + plot.size[0]
            }
        };
        self.heading.height + whole.min(tallest)
    }

    /// Draws the panel within `area`.
    pub(super) fn draw(&self, svg: &mut Svg, area: Area) -> Result<()> {
        let panel = self.panel;
        self.heading.draw(svg, area.at);
        let top = area.at[1] + self.heading.height;
        let room = Area { at: [area.at[0], top], size: [area.size[0], area.bottom() - top] };
        let plot = match panel.frame {
            PlotFrame::Box { equal: false } => inside_of_labels(panel, room),
            PlotFrame::Box { equal: true } => inside_of_labels(panel, room).shaped(aspect_of(panel)),
            PlotFrame::Hemisphere => inside_of_rim(panel, room).shaped(1.0),
        };
        if let Some(raster) = &panel.raster {
            picture(svg, raster, &panel.frame, plot)?;
        }
        match panel.frame {
            PlotFrame::Box { .. } => axes(svg, panel, plot),
            PlotFrame::Hemisphere => hemisphere(svg, panel, plot),
        }
        for (mark, _) in &panel.marks {
            marks::draw(svg, mark, panel, plot);
        }
        scale_bar(svg, panel, plot);
        match panel.raster.as_ref().and_then(|r| r.scale.as_ref()) {
            Some(scale) => {
                let shift = if panel.frame == PlotFrame::Hemisphere { 2.0 * RIM } else { 2.0 * GAP };
                let at = [plot.right() + shift, plot.at[1]];
                color_bar(svg, scale, Area { at, size: [BAR, plot.size[1]] })
            }
            None => Ok(()),
        }
    }
}

/// Returns height over width of a plot in which a length of x is as long as one of y.
fn aspect_of(panel: &Panel) -> f64 {
    (panel.y.high - panel.y.low).abs() / (panel.x.high - panel.x.low).abs()
}

/// Returns the part of `room` that angles, scale bar and colour bar leave for a hemisphere.
fn inside_of_rim(panel: &Panel, room: Area) -> Area {
    let below = if panel.scale_bar.is_some() { TICK + GAP } else { 0.0 };
    let size = [room.size[0] - 4.0 * RIM - bar_room(panel), room.size[1] - 2.0 * RIM - below];
    Area { at: [room.at[0] + 2.0 * RIM, room.at[1] + RIM], size }
}

/// Returns the part of `room` that ticks, labels and colour bar leave for the plot.
fn inside_of_labels(panel: &Panel, room: Area) -> Area {
    let widest = widest_tick(&panel.y, room.size[1]);
    let left = widest + LONG + 0.5 * GAP + if panel.y.label.is_empty() { 0.0 } else { LABEL + GAP };
    let below = LONG + TICK + GAP + if panel.x.label.is_empty() { 0.0 } else { LABEL + GAP };
    let at = [room.at[0] + left, room.at[1] + 0.5 * TICK];
    let right = bar_room(panel).max(1.5 * TICK);
    Area { at, size: [room.size[0] - left - right, room.size[1] - below - 0.5 * TICK] }
}

fn widest_tick(axis: &Axis, length: f64) -> f64 {
    let ticks = axis.ticks(wanted(length, 1));
    ticks.iter().map(|t| width(&t.label, TICK, Weight::Regular)).fold(0.0, f64::max)
}

fn wanted(length: f64, axis: usize) -> usize {
    (length / PER_TICK[axis]).max(2.0) as usize
}

/// Returns the width of a colour bar beside the plot.
fn bar_room(panel: &Panel) -> f64 {
    panel
        .raster
        .as_ref()
        .and_then(|r| r.scale.as_ref())
        .map_or(0.0, |scale| 2.0 * GAP + BAR + LONG + widest_tick(&scale.axis, 300.0) + 2.0 * GAP + LABEL)
}

fn picture(svg: &mut Svg, raster: &Raster, frame: &PlotFrame, plot: Area) -> Result<()> {
    // Smooth when reduced; when enlarged, the pixels stay sharp.
    let smooth = raster.size[0] as f64 > plot.size[0] || raster.size[1] as f64 > plot.size[1];
    if *frame == PlotFrame::Hemisphere {
        let radius = plot.size[0] / 2.0;
        let (centre, png) = ([plot.at[0] + radius, plot.at[1] + radius], raster.beyond_rim().png()?);
        svg.clipped_to_circle(centre, radius, |svg| svg.image(plot.at, plot.size, &png, smooth));
    } else {
        svg.image(plot.at, plot.size, &raster.png()?, smooth);
    }
    Ok(())
}

/// Returns `letters`, or as much smaller ones that the line `text` is no longer than `length` \[px\].
fn fitting(text: &str, letters: Letters, length: f64) -> Letters {
    let needed = width(text, letters.size, letters.weight);
    Letters { size: letters.size * (length / needed).min(1.0), ..letters }
}

/// Draws grid, frame, ticks and labels of a box.
fn axes(svg: &mut Svg, panel: &Panel, plot: Area) {
    let [left, top] = plot.at;
    let (right, bottom) = (plot.right(), plot.bottom());
    let frame = Stroke::new(INK, 1.0);
    for tick in panel.x.ticks(wanted(plot.size[0], 0)) {
        let x = left + panel.x.share(tick.value) * plot.size[0];
        let long = !tick.label.is_empty();
        if long && panel.raster.is_none() {
            svg.line([x, top], [x, bottom], Stroke::new(FAINT, 1.0));
        }
        svg.line([x, bottom], [x, bottom + if long { LONG } else { SHORT }], frame);
        svg.text([x, bottom + LONG + TICK], &tick.label, letters(TICK, QUIET, Anchor::Middle), None);
    }
    for tick in panel.y.ticks(wanted(plot.size[1], 1)) {
        let y = bottom - panel.y.share(tick.value) * plot.size[1];
        let long = !tick.label.is_empty();
        if long && panel.raster.is_none() {
            svg.line([left, y], [right, y], Stroke::new(FAINT, 1.0));
        }
        svg.line([left - if long { LONG } else { SHORT }, y], [left, y], frame);
        let at = [left - LONG - 0.5 * GAP, y + 0.36 * TICK];
        svg.text(at, &tick.label, letters(TICK, QUIET, Anchor::End), None);
    }
    svg.frame(plot.at, plot.size, frame);
    let middle = letters(LABEL, INK, Anchor::Middle);
    let below = bottom + LONG + TICK + GAP + LABEL;
    let along_x = fitting(&panel.x.label, middle, plot.size[0]);
    svg.text([left + plot.size[0] / 2.0, below], &panel.x.label, along_x, None);
    let beside = left - LONG - 0.5 * GAP - widest_tick(&panel.y, plot.size[1]) - GAP;
    let upward = Letters { upward: true, ..fitting(&panel.y.label, middle, plot.size[1]) };
    svg.text([beside, top + plot.size[1] / 2.0], &panel.y.label, upward, None);
}

/// Draws rings of polar angle and spokes of azimuth over the disc that fills `plot`.
fn hemisphere(svg: &mut Svg, panel: &Panel, plot: Area) {
    let radius = plot.size[0] / 2.0;
    let centre = [plot.at[0] + radius, plot.at[1] + radius];
    let quiet = Stroke { opacity: 0.35, ..Stroke::new(Color([0xa8, 0xb0, 0xb8]), 0.8) };
    for theta in [15.0f64, 30.0, 45.0, 60.0, 75.0] {
        svg.circle(centre, radius * theta.to_radians().sin(), None, quiet);
    }
    for spoke in 0..12 {
        let (sin, cos) = (f64::from(spoke) * PI / 6.0).sin_cos();
        let from = [centre[0] + 0.06 * radius * cos, centre[1] - 0.06 * radius * sin];
        svg.line(from, [centre[0] + radius * cos, centre[1] - radius * sin], quiet);
        let out = radius + GAP;
        let anchor = if cos > 0.1 {
            Anchor::Start
        } else if cos < -0.1 {
            Anchor::End
        } else {
            Anchor::Middle
        };
        let at = [centre[0] + out * cos, centre[1] - out * sin + TICK * (0.36 - 0.3 * sin)];
        svg.text(at, &format!("{}°", spoke * 30), letters(TICK, QUIET, anchor), None);
    }
    svg.circle(centre, radius, None, Stroke::new(INK, 1.2));
    // At an angle without labels of the axes.
    let (sin, cos) = (75f64).to_radians().sin_cos();
    let light =
        panel.raster.as_ref().and_then(|r| r.scale.as_ref()).is_some_and(|s| s.map == ColorMap::Difference);
    // Over the raster, whose colours are those of every theme.
    let (dark, bright) = (Color([0x16, 0x18, 0x1b]), Color([0xfa, 0xfa, 0xfa]));
    let (color, halo) = if light { (dark, bright) } else { (bright, dark) };
    for theta in [30.0f64, 60.0] {
        let out = radius * theta.to_radians().sin();
        let at = [centre[0] + out * cos, centre[1] - out * sin + 0.36 * TICK];
        let text = letters(TICK - 1.0, color, Anchor::Middle);
        svg.text(at, &format!("{theta}°"), text, Some(halo));
    }
}

/// Draws the scale bar: in the lower left corner of a box, below a hemisphere.
fn scale_bar(svg: &mut Svg, panel: &Panel, plot: Area) {
    let Some((length, label)) = &panel.scale_bar else { return };
    let long = length / (panel.x.high - panel.x.low).abs() * plot.size[0];
    if panel.frame == PlotFrame::Hemisphere {
        let [x, y] = [plot.at[0] - 2.0 * RIM, plot.bottom() + RIM + 0.5 * TICK];
        svg.line([x, y], [x + long, y], Stroke::new(INK, 3.0));
        svg.text([x + long + GAP, y + 0.36 * TICK], label, letters(TICK, INK, Anchor::Start), None);
        return;
    }
    let [x, y] = [plot.at[0] + 2.0 * GAP, plot.bottom() - 2.0 * GAP];
    if panel.raster.is_some() {
        svg.line([x - 1.0, y], [x + long + 1.0, y], Stroke::new(PAPER, 5.0));
    }
    svg.line([x, y], [x + long, y], Stroke::new(INK, 3.0));
    svg.text([x, y - GAP], label, letters(TICK, INK, Anchor::Start), Some(PAPER));
}

fn color_bar(svg: &mut Svg, scale: &raster::ColorScale, area: Area) -> Result<()> {
    svg.image(area.at, area.size, &raster::bar(scale).png()?, true);
    svg.frame(area.at, area.size, Stroke::new(INK, 0.8));
    for tick in scale.axis.ticks(wanted(area.size[1], 1)) {
        if tick.label.is_empty() && !raster::is_log(scale) {
            continue;
        }
        let y = area.bottom() - scale.axis.share(tick.value) * area.size[1];
        let long = if tick.label.is_empty() { SHORT } else { LONG };
        svg.line([area.right(), y], [area.right() + long, y], Stroke::new(INK, 0.8));
        let at = [area.right() + LONG + 0.5 * GAP, y + 0.36 * TICK];
        svg.text(at, &tick.label, letters(TICK, QUIET, Anchor::Start), None);
    }
    let widest = widest_tick(&scale.axis, area.size[1]);
    let at = [area.right() + LONG + widest + 1.5 * GAP + 0.7 * LABEL, area.at[1] + area.size[1] / 2.0];
    let middle = fitting(&scale.axis.label, letters(LABEL, INK, Anchor::Middle), area.size[1]);
    let upward = Letters { upward: true, ..middle };
    svg.text(at, &scale.axis.label, upward, None);
    Ok(())
}
