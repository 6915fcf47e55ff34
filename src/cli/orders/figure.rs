//! The efficiencies of a sweep as a labelled figure.

use super::Arguments;
use super::sweep::{PolarisedOrder, Sweep, SweepPoint, SweptQuantity};
use crate::cli::captions;
use crate::figure::{Axis, Figure, Mark, Panel, palette};
use crate::optics::reflectance::Reflectance;
use crate::surface::HeightField;
use std::collections::BTreeMap;

/// Names of the panels, by the polarisation of the light.
pub const PANELS: [&str; 3] = ["unpolarised", "te", "tm"];
/// Largest efficiency of an order that is drawn, over that of the brightest.
const FAINTEST: f64 = 0.02;
/// Space above the highest line, as a factor.
const HEADROOM: f64 = 1.05;

/// Returns the efficiencies of the brightest orders over the swept quantity: a row of panels for each wavelength, for unpolarised, TE and TM light.
pub fn figure(
    arguments: &Arguments,
    sweep: &Sweep,
    field: &HeightField,
    reflectance: &Reflectance,
    runs: &[Vec<SweepPoint>],
) -> Figure {
    let rows = runs.iter().map(|run| row(sweep, run));
    let figure = rows.fold(Figure::new(""), Figure::row);
    figure.panel_size(380.0, 300.0).caption(caption(arguments, sweep, field, reflectance))
}

/// Efficiency of an order in one of the panels; `None` where it is not drawn.
type Efficiency = fn(&PolarisedOrder) -> Option<f64>;

/// Returns the panels of one run.
fn row(sweep: &Sweep, run: &[SweepPoint]) -> Vec<Panel> {
    let panels: [(&str, &str, Efficiency); 3] = [
        (PANELS[0], "Unpolarised", |order| Some(order.mean.efficiency)),
        (PANELS[1], "TE", |order| order.polarised.map(|[te, _]| te)),
        (PANELS[2], "TM", |order| order.polarised.map(|[_, tm]| tm)),
    ];
    let drawn = brightest(run);
    let is_drawn = |order: &&PolarisedOrder| drawn.contains(&order.mean.numbers);
    let orders = || run.iter().flat_map(|point| &point.orders).filter(is_drawn);
    let largest = orders().flat_map(|order| panels.map(|(.., of)| of(order))).flatten().fold(0.0, f64::max);
    let wavelength = run.first().map(|point| point.conditions.wavelength);
    let fixed = match (sweep.quantity, wavelength) {
        (SweptQuantity::Angle | SweptQuantity::Height, Some(wavelength)) => {
            format!(", {} nm", super::rounded(wavelength * super::NM_PER_UM))
        }
        _ => String::new(),
    };
    let known = panels.into_iter().filter(|(.., of)| orders().any(|order| of(order).is_some()));
    known
        .map(|(name, title, of)| {
            let x = run.iter().map(|point| point.conditions.value(sweep.quantity));
            let (low, high) = x.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            let x = Axis::linear(sweep.quantity.label(), low, high.max(low + f64::MIN_POSITIVE));
            let y = Axis::linear("efficiency", 0.0, (HEADROOM * largest).max(f64::MIN_POSITIVE));
            let panel = Panel::new(x, y).called(name).titled(format!("{title}{fixed}"));
            drawn.iter().zip(palette::SERIES).fold(panel, |panel, (numbers, color)| {
                let line = Mark::line(line(sweep, run, *numbers, of), color);
                panel.named(name_of(*numbers), line)
            })
        })
        .collect()
}

/// Returns the orders that are drawn: those that are largest somewhere in unpolarised light, by their numbers.
fn brightest(run: &[SweepPoint]) -> Vec<[i64; 2]> {
    let mut largest: BTreeMap<[i64; 2], f64> = BTreeMap::new();
    for order in run.iter().flat_map(|point| &point.orders) {
        let found = largest.entry(order.mean.numbers).or_default();
        *found = found.max(order.mean.efficiency);
    }
    let mut by_size: Vec<([i64; 2], f64)> = largest.into_iter().collect();
    by_size.sort_by(|a, b| b.1.total_cmp(&a.1));
    let least = by_size.first().map_or(0.0, |(_, most)| FAINTEST * most);
    by_size.retain(|(_, most)| *most >= least);
    let mut kept: Vec<[i64; 2]> =
        by_size.into_iter().take(palette::SERIES.len()).map(|(numbers, _)| numbers).collect();
    kept.sort_unstable();
    kept
}

/// Returns the efficiency of an order over the sweep, broken where the order does not propagate.
fn line(sweep: &Sweep, run: &[SweepPoint], numbers: [i64; 2], of: Efficiency) -> Vec<[f64; 2]> {
    let at = |point: &SweepPoint| {
        let order = point.orders.iter().find(|order| order.mean.numbers == numbers);
        [point.conditions.value(sweep.quantity), order.and_then(of).unwrap_or(f64::NAN)]
    };
    run.iter().map(at).collect()
}

/// Returns the name of an order: m alone where n is 0.
fn name_of([m, n]: [i64; 2]) -> String {
    let signed = |number: i64| number.to_string().replace('-', "−");
    match n {
        0 => format!("order {}", signed(m)),
        _ => format!("order {}, {}", signed(m), signed(n)),
    }
}

fn caption(arguments: &Arguments, sweep: &Sweep, field: &HeightField, reflectance: &Reflectance) -> String {
    let name = arguments.surface.name(arguments.surface_name.as_deref());
    let [theta, phi] = arguments.light.map_or([0.0; 2], |light| [light.theta, light.phi]);
    let light = match sweep.quantity {
        SweptQuantity::Angle => format!("light in the plane φ = {phi}°"),
        _ => format!("light from θ = {theta}°, φ = {phi}°"),
    };
    format!(
        "{}; {light}; {reflectance}. Share of the light that an order takes; orders m along x and n along y.",
        captions::surface(&name, field)
    )
}
