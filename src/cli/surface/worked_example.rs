//! Worked example of docs/PREPARING.md: a known surface, a simulated bad scan of it, and its recovery step by step. The page and its figure
//! are written from here; a test compares them.

use crate::cli::options::as_options;
use crate::figure::{Axis, ColorMap, ColorScale, Figure, FigureStyle, Panel, Raster};
use crate::notes::Notes;
use crate::random::Random;
use crate::surface::prepare::{PreparationStep, apply_all, describe};
use crate::surface::synth::{Spec, SurfaceKind, generate};
use crate::surface::tiling::Verdict;
use crate::surface::{HeightField, Statistics};
use crate::task::Task;
use std::fmt::Write;
use std::path::Path;

/// The steps in the order in which they help.
const STEPS: [&str; 7] = [
    "level polynomial:2",
    "destripe",
    "despike",
    "level rows-median",
    "rotate auto",
    "crop 15um",
    "tile blend:2um",
];

/// Returns skin whose fingers stand 7° askew, over 20 µm.
fn surface() -> HeightField {
    let spec = Spec {
        seed: 3,
        patch: Some([31.0; 2]),
        pixel_size: Some([0.1; 2]),
        ..Spec::new(SurfaceKind::Elaphe)
    };
    let steps = ["rotate 7deg", "crop 20um"].map(|text| PreparationStep::parse(text).unwrap());
    apply_all(generate(&spec).unwrap(), &steps, &Task::silent()).unwrap()
}

/// Returns a simulated bad scan of the surface: tilt and bow, an offset of each row, streaks, spikes, noise.
fn scan(surface: &HeightField) -> HeightField {
    let (columns, rows) = (surface.columns(), surface.rows());
    let mut random = Random::new(11);
    let mut heights = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        let offset = 0.03 * random.signed();
        for (column, h) in surface.row(row).iter().enumerate() {
            let (x, y) = (surface.x(column), surface.y(row));
            let bow = 0.02 * x - 0.013 * y + 0.000_8 * x * x;
            let noise = 0.002 * (random.signed() + random.signed());
            heights.push(h + bow + offset + noise);
        }
    }
    for _ in 0..6 {
        let row = 3 + (random.share() * (rows - 6) as f64) as usize;
        let first = (random.share() * columns as f64 / 2.0) as usize;
        heights[row * columns + first..row * columns + first + columns / 3]
            .iter_mut()
            .for_each(|h| *h += 0.35);
    }
    for _ in 0..30 {
        heights[(random.share() * (columns * rows) as f64) as usize] += 0.8;
    }
    HeightField::new(columns, rows, surface.pixel_size(), heights).unwrap()
}

/// Returns the field after none of the steps, the first, the first two …
fn stages(mut field: HeightField) -> Vec<HeightField> {
    let mut all = vec![field.clone()];
    for text in STEPS {
        field = PreparationStep::parse(text).unwrap().apply(&field).unwrap();
        all.push(field.clone());
    }
    all
}

fn name(stage: usize) -> String {
    if stage == 0 { "the scan".to_owned() } else { format!("`--{}`", STEPS[stage - 1]) }
}

/// Returns the RMS difference of two fields of one grid, each about its mean \[nm\].
fn difference(a: &HeightField, b: &HeightField) -> f64 {
    assert_eq!((a.columns(), a.rows()), (b.columns(), b.rows()));
    let differences: Vec<f64> = a.heights().iter().zip(b.heights()).map(|(a, b)| (a - b) * 1e3).collect();
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    (differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / differences.len() as f64).sqrt()
}

/// Returns a table of the statistics of each stage, and its difference from the same steps applied to the surface without defects.
fn table(stages: &[HeightField], clean: &[HeightField]) -> String {
    let mut table =
        "| after | samples | range | Sq | Sdq | from the clean surface | strongest period | seams |\n\
                     | --- | --- | --- | --- | --- | --- | --- | --- |\n"
            .to_owned();
    for (i, (field, clean)) in stages.iter().zip(clean).enumerate() {
        let s = Statistics::of(field, &Task::silent()).unwrap();
        let [low, high] = s.heights.range;
        let period = s
            .periods
            .first()
            .map_or("none".to_owned(), |p| format!("{:.2} µm at {:.1}°", p.length, p.direction));
        writeln!(
            table,
            "| {} | {} × {} | {:.0} nm | {:.1} nm | {:.2} | {:.1} nm | {period} | {:.2}, {:.2} |",
            name(i),
            field.columns(),
            field.rows(),
            (high - low) * 1e3,
            s.heights.sq * 1e3,
            s.slopes.sdq,
            difference(field, clean),
            s.tiling.ratio[0],
            s.tiling.ratio[1],
        )
        .unwrap();
    }
    table
}

fn picture(field: &HeightField, title: String) -> Panel {
    let [width, height] = field.patch_size();
    let values: Vec<f64> = field.heights().iter().map(|h| h * 1e3).collect();
    let mut sorted = values.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let cut = sorted.len() / 200;
    let axis = Axis::linear("nm", sorted[cut], sorted[sorted.len() - 1 - cut]);
    Panel::new(Axis::linear("", 0.0, width), Axis::linear("", 0.0, height))
        .to_scale()
        .over(Raster::values(field.columns(), &values, ColorScale { axis, map: ColorMap::Viridis }))
        .titled(title)
        .with_scale_bar(5.0, "5 µm")
}

fn figure(stages: &[HeightField]) -> Figure {
    let title = |i: usize| if i == 0 { "The scan".to_owned() } else { format!("--{}", STEPS[i - 1]) };
    let panels: Vec<Panel> = stages.iter().enumerate().map(|(i, field)| picture(field, title(i))).collect();
    panels.chunks(4).fold(Figure::new("").panel_size(205.0, 180.0), |figure, row| figure.row(row.to_vec()))
}

/// Returns the page with `table` in its place.
fn page(table: &str) -> String {
    let steps: Vec<PreparationStep> =
        STEPS.iter().map(|text| PreparationStep::parse(text).unwrap()).collect();
    let list = steps.iter().map(|step| format!("\"{step}\"")).collect::<Vec<_>>().join(", ");
    include_str!("worked_example.md")
        .replace("{table}", table.trim_end())
        .replace("{options}", &as_options(&steps))
        .replace("{list}", &list)
        .replace("{steps}", &describe(&steps))
}

#[test]
fn each_step_of_the_worked_example_brings_the_surface_nearer() {
    let surface = surface();
    let (stages, clean) = (stages(scan(&surface)), stages(surface));
    let distances: Vec<f64> = stages.iter().zip(&clean).map(|(a, b)| difference(a, b)).collect();
    for (i, pair) in distances[..=4].windows(2).enumerate() {
        assert!(pair[1] < pair[0], "{}: {distances:.1?} nm", name(i + 1));
    }
    assert!(distances[0] > 100.0 && distances[4] < 12.0, "{distances:.1?} nm");
    let last = Statistics::of(stages.last().unwrap(), &Task::silent()).unwrap();
    assert_eq!(last.tiling.verdict, Verdict::Tiles, "{:?}", last.tiling);
    assert!(last.periods[0].direction.abs() < 1.0, "{:?}", last.periods[0]);
    let written = table(&stages, &clean);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (path, picture) = (root.join("docs/PREPARING.md"), root.join("docs/images/preparing.png"));
    if std::env::var_os("DIFFRACT_BLESS").is_some() {
        std::fs::write(&path, page(&written)).unwrap();
        figure(&stages).save(&picture, &FigureStyle::default(), &Notes::default()).unwrap();
    }
    assert!(picture.is_file(), "docs/images/preparing.png is missing; DIFFRACT_BLESS=1 draws it");
    let there = std::fs::read_to_string(path).unwrap_or_default(); // missing or unreadable: it differs
    assert!(
        there == page(&written),
        "docs/PREPARING.md differs; DIFFRACT_BLESS=1 writes it anew:\n{written}"
    );
}
