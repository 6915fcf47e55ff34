//! Directions with footprints, their exact colours, and the colours of the table. The errors of a table are measured on them, and ports of the reading function
//! are tested on them.

use super::ExportSettings;
use super::description::MeasuredErrors;
use crate::brdf::albedo::Decimation;
use crate::brdf::mean::MeanBrdf;
use crate::brdf::tabulated::{SummedOrders, TabulatedMean};
use crate::error::{Error, Result};
use crate::filter::Covariance;
use crate::optics::color::xyz_to_linear_srgb;
use crate::optics::geometry::{Pair, direction};
use crate::optics::spectrum::SHORTEST;
use crate::random::Random;
use crate::table::{ColorTable, TableReader};
use crate::task::Task;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Directions of an export.
const DIRECTIONS: usize = 1000;
/// Stream of the random numbers that the directions follow.
const SEED: u64 = 42;
/// Largest polar angle \[degrees\].
const LARGEST_ANGLE: f64 = 80.0;
/// Every so many rows are within a few standard deviations of the specular direction, which random directions miss.
const SPECULAR_EVERY: usize = 10;
/// Columns of the file: unit vectors to the light and to the viewer, two vectors of (u, v) that span the footprint, and linear sRGB of f cos θ_i \[sr⁻¹\].
const COLUMNS: [&str; 16] = [
    "light_x", "light_y", "light_z", "viewer_x", "viewer_y", "viewer_z", "dx_u", "dx_v", "dy_u", "dy_v",
    "exact_r", "exact_g", "exact_b", "table_r", "table_g", "table_b",
];
/// Smallest colour that a direction's error is relative to, as a part of the median colour: between orders, and beyond the band limit of the samples,
/// surfaces are dark.
const FAINT: f64 = 1e-2;
/// Columns of a file of answers.
const ANSWER: [&str; 3] = ["r", "g", "b"];

/// Directions with a footprint and their colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConformanceRow {
    /// Light and viewer.
    pub pair: Pair,
    /// Two vectors of (u, v) that span the footprint: its covariance is dx dxᵀ + dy dyᵀ.
    pub footprint: [DVec2; 2],
    /// Linear sRGB of f cos θ_i \[sr⁻¹\] by the mean in f64.
    pub exact: DVec3,
    /// The same as the table has it.
    pub of_table: DVec3,
}

/// All rows of an export.
#[derive(Clone, Debug, PartialEq)]
pub struct Conformance {
    /// The rows.
    pub rows: Vec<ConformanceRow>,
}

impl Conformance {
    /// Evaluates `table` and the exact `mean` in the directions of `settings`.
    ///
    /// # Errors
    /// Too little memory for all orders; a cancelled task.
    pub fn new(
        mean: MeanBrdf,
        settings: &ExportSettings,
        table: &Arc<ColorTable>,
        task: &Task,
    ) -> Result<Self> {
        let asked = questions(settings.footprint, table.header.coherence_blur.sqrt());
        let pairs: Vec<_> = asked.iter().map(|(pair, [dx, dy])| (*pair, covariance(*dx, *dy))).collect();
        let reflectance = mean.reflectance.clone();
        let exact = TabulatedMean::new(mean, SHORTEST, task)?.limited(Decimation::Coarse);
        let exact = exact.xyz(&settings.illuminant, &pairs, SummedOrders::All, task)?;
        let reader = TableReader::new(Arc::clone(table));
        let read: Vec<DVec3> =
            pairs.par_iter().map(|(pair, footprint)| reader.xyz(pair, &reflectance, footprint)).collect();
        let row = |((pair, footprint), (exact, read)): ((Pair, [DVec2; 2]), (DVec3, DVec3))| ConformanceRow {
            pair,
            footprint,
            exact: xyz_to_linear_srgb(exact),
            of_table: xyz_to_linear_srgb(read),
        };
        Ok(Self { rows: asked.into_iter().zip(exact.into_iter().zip(read)).map(row).collect() })
    }

    /// Returns the errors of the table.
    pub fn errors(&self) -> MeasuredErrors {
        let errors = PortErrors::of(self.rows.iter().map(|row| (row.of_table, row.exact)));
        let PortErrors { relative_l2, own_rms, own_p99 } = errors;
        MeasuredErrors { directions: self.rows.len(), relative_l2, own_rms, own_p99 }
    }

    /// Returns the errors of `answers`, one for each row in order, against the table.
    pub fn errors_of(&self, answers: &[DVec3]) -> PortErrors {
        PortErrors::of(answers.iter().copied().zip(self.rows.iter().map(|row| row.of_table)))
    }

    /// Returns the rows as CSV.
    ///
    /// # Errors
    /// Never, because all cells are numbers.
    pub fn to_csv(&self) -> Result<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(COLUMNS).map_err(not_written)?;
        for row in &self.rows {
            let cells = row.numbers().map(|number| format!("{number:e}"));
            writer.write_record(cells).map_err(not_written)?;
        }
        let bytes = writer.into_inner().map_err(not_written)?;
        String::from_utf8(bytes).map_err(not_written)
    }

    /// Reads what [`Conformance::to_csv`] writes.
    ///
    /// # Errors
    /// Names the line that is no row.
    pub fn from_csv(text: &str) -> Result<Self> {
        let numbers = columns(text, COLUMNS)?;
        Ok(Self { rows: numbers.into_iter().map(ConformanceRow::of_numbers).collect() })
    }

    /// Reads a file of answers: the columns r, g and b in any order, other columns ignored, a row for each direction.
    ///
    /// # Errors
    /// Missing columns, cells that are no numbers, and another number of rows.
    pub fn answers(&self, text: &str) -> Result<Vec<DVec3>> {
        let answers = columns(text, ANSWER)?;
        if answers.len() != self.rows.len() {
            return Err(Error::input(
                format!("there are {} answers to {} directions", answers.len(), self.rows.len()),
                "answer every row of conformance.csv, in its order",
            ));
        }
        Ok(answers.into_iter().map(DVec3::from_array).collect())
    }
}

impl ConformanceRow {
    fn numbers(&self) -> [f64; COLUMNS.len()] {
        let Self { pair: Pair { light, view }, footprint: [dx, dy], exact, of_table } = self;
        [
            light.x, light.y, light.z, view.x, view.y, view.z, dx.x, dx.y, dy.x, dy.y, exact.x, exact.y,
            exact.z, of_table.x, of_table.y, of_table.z,
        ]
    }

    fn of_numbers(n: [f64; COLUMNS.len()]) -> Self {
        let three = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
        Self {
            pair: Pair::new(three(0), three(3)),
            footprint: [DVec2::new(n[6], n[7]), DVec2::new(n[8], n[9])],
            exact: three(10),
            of_table: three(13),
        }
    }
}

/// Errors of colours against others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PortErrors {
    /// ‖a − b‖/‖b‖ over all directions together.
    pub relative_l2: f64,
    /// RMS over directions of the error relative to the direction's own colour.
    pub own_rms: f64,
    /// 99th percentile of the same.
    pub own_p99: f64,
}

impl PortErrors {
    /// Errors that a right port keeps: texture units of GPUs interpolate with 8 bits between texels, and sums are of 32-bit floats.
    pub const RIGHT: Self = Self { relative_l2: 5e-3, own_rms: 1e-2, own_p99: 3e-2 };

    /// Returns the errors of pairs of a colour and what it should be. Directions fainter than [`FAINT`] of the median colour count as that bright.
    fn of(colours: impl Iterator<Item = (DVec3, DVec3)>) -> Self {
        let colours: Vec<(DVec3, DVec3)> = colours.collect();
        let mut sizes: Vec<f64> = colours.iter().map(|(_, expected)| expected.length()).collect();
        sizes.sort_by(f64::total_cmp);
        // No colours have no error: a default below is theirs.
        let faintest =
            (FAINT * sizes.get(sizes.len() / 2).copied().unwrap_or_default()).max(f64::MIN_POSITIVE);
        // A number that is not finite is as wrong as can be.
        let finite = |x: f64| if x.is_finite() { x } else { f64::INFINITY };
        let apart = |(found, expected): &(DVec3, DVec3)| finite((*found - *expected).length());
        let error: f64 = colours.iter().map(|pair| apart(pair).powi(2)).sum();
        let all: f64 = sizes.iter().map(|size| size * size).sum();
        let relative = |pair: &(DVec3, DVec3)| apart(pair) / pair.1.length().max(faintest);
        let mut relative: Vec<f64> = colours.iter().map(relative).collect();
        relative.sort_by(f64::total_cmp);
        let count = relative.len().max(1);
        Self {
            relative_l2: (error / all.max(f64::MIN_POSITIVE)).sqrt(),
            own_rms: (relative.iter().map(|e| e * e).sum::<f64>() / count as f64).sqrt(),
            own_p99: relative.get((count * 99 / 100).min(count - 1)).copied().unwrap_or_default(),
        }
    }

    /// True if every error is at most that of `limits`.
    pub fn within(&self, limits: &Self) -> bool {
        self.relative_l2 <= limits.relative_l2
            && self.own_rms <= limits.own_rms
            && self.own_p99 <= limits.own_p99
    }
}

/// Returns the covariance of the footprint that two vectors span.
fn covariance(dx: DVec2, dy: DVec2) -> Covariance {
    Covariance::of_footprint(dx, dy, 1.0)
}

/// Returns the directions and footprints of an export whose smallest footprint is `smallest` in light whose coherence averages over the standard deviation
/// `coherence`. An export of single directions has single directions in every other row.
fn questions(smallest: f64, coherence: f64) -> Vec<(Pair, [DVec2; 2])> {
    let mut random = Random::new(SEED);
    let base = if smallest > 0.0 { smallest } else { coherence };
    (0..DIRECTIONS)
        .map(|i| {
            let mut any = || direction(LARGEST_ANGLE * random.share(), 360.0 * random.share());
            let (light, other) = (any(), any());
            // Up to eight times the smallest footprint, up to four times as long as wide, in any orientation.
            let narrow = base * (3.0 * random.share()).exp2();
            let long = narrow * (2.0 * random.share()).exp2();
            let axis = DVec2::from_angle(TAU * random.share());
            let is_single = smallest == 0.0 && i % 2 == 0;
            let (narrow, long) = if is_single { (0.0, 0.0) } else { (narrow, long) };
            let off = DVec2::new(random.signed(), random.signed()) * (2.0 * base.hypot(long));
            let view = if i % SPECULAR_EVERY == 0 { beside_specular(light, off) } else { other };
            (Pair::new(light, view), [axis * long, axis.perp() * narrow])
        })
        .collect()
}

/// Returns the direction `off` beside the specular direction of `light`, above the horizon.
fn beside_specular(light: DVec3, off: DVec2) -> DVec3 {
    /// Sine of the largest polar angle.
    const LARGEST_SINE: f64 = 0.98;
    let tangential = (off - light.truncate()).clamp_length_max(LARGEST_SINE);
    tangential.extend((1.0 - tangential.length_squared()).sqrt())
}

/// Returns the error for directions that are no CSV.
fn not_written(cause: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::bug(format!("the directions cannot be written ({cause})")).caused_by(cause)
}

/// Returns the numbers of the columns `names` of a CSV file.
fn columns<const N: usize>(text: &str, names: [&str; N]) -> Result<Vec<[f64; N]>> {
    let bad = |line: u64, what: String| {
        Error::input(
            format!("line {line}: {what}"),
            format!("give a CSV file with the columns {}", names.join(",")),
        )
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let fail = |e: csv::Error| bad(e.position().map_or(1, csv::Position::line), e.to_string()).caused_by(e);
    let header = reader.headers().map_err(fail)?.clone();
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let found = header.iter().position(|title| title == name);
        *place = found.ok_or_else(|| bad(1, format!("there is no column {name}")))?;
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(fail)?;
        let mut row = [0.0; N];
        for (number, place) in row.iter_mut().zip(places) {
            // Each record has as many cells as the header: `csv` refuses others.
            let cell = record.get(place).unwrap_or_default();
            let line = record.position().map_or(0, csv::Position::line);
            *number = cell.parse().map_err(|_| bad(line, format!("`{cell}` is not a number")))?;
        }
        rows.push(row);
    }
    Ok(rows)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::export::ExportedMaterial;
    use crate::optics::material::Material;
    use crate::optics::polarisation::Polarisation;
    use crate::optics::reflectance::Reflectance;
    use crate::optics::spectrum::Illuminant;
    use crate::spectra::power::Beyond;
    use crate::surface::HeightField;
    use std::sync::LazyLock;

    pub(in crate::internals::export) fn small_settings() -> ExportSettings {
        ExportSettings {
            sigma: 2.0,
            beyond: Beyond::Copies,
            illuminant: Illuminant::D65,
            reflectance: 1.5.into(),
            tolerance: 2e-2,
            wavelengths: None,
            footprint: 0.04,
            most_bytes: None,
        }
    }

    pub(in crate::internals::export) fn small_field() -> HeightField {
        let heights = (0..48 * 40).map(|i| 0.15 * (f64::from(i) * 0.618_034).fract()).collect();
        HeightField::new(48, 40, [0.09, 0.09], heights).unwrap()
    }

    pub(in crate::internals::export) fn small_table() -> (Conformance, Arc<ColorTable>) {
        static MADE: LazyLock<(Conformance, Arc<ColorTable>)> = LazyLock::new(|| {
            let made = ExportedMaterial::new(&small_field(), &small_settings(), &Task::silent()).unwrap();
            (made.conformance, made.table)
        });
        MADE.clone()
    }

    #[test]
    fn the_table_keeps_its_tolerance_against_the_exact_mean() {
        let (conformance, _) = small_table();
        let errors = conformance.errors();
        eprintln!("{errors:?}");
        assert_eq!(errors.directions, DIRECTIONS);
        assert!(errors.relative_l2 > 0.0 && errors.relative_l2 <= small_settings().tolerance, "{errors:?}");
        // 0.054 is measured: directions a hundred times fainter than the median count as that bright, and linear interpolation beside bright orders errs by their slope.
        assert!(errors.own_rms <= 0.067, "{errors:?}");
    }

    #[test]
    fn averages_of_polarised_light_over_footprints_keep_the_tolerance() {
        let glass = Material::from_name_or_file("glass").unwrap();
        for polarisation in Polarisation::ALL {
            let reflectance = Reflectance::of_material(glass.clone(), None).polarised(polarisation);
            let settings = ExportSettings { reflectance, ..small_settings() };
            let made = ExportedMaterial::new(&small_field(), &settings, &Task::silent()).unwrap();
            let errors = made.conformance.errors();
            eprintln!("{polarisation:?}: {errors:?}");
            // TM light has no reflection at Brewster's angle, which a footprint may reach from others.
            assert!(errors.relative_l2 <= settings.tolerance, "{polarisation:?}: {errors:?}");
        }
    }

    #[test]
    fn a_table_of_fewer_bytes_serves_larger_footprints() {
        let (_, whole) = small_table();
        let most = whole.bytes() as u64 / 3;
        let settings = ExportSettings { most_bytes: Some(most), ..small_settings() };
        let made = ExportedMaterial::new(&small_field(), &settings, &Task::silent()).unwrap();
        assert!(
            made.table.bytes() as u64 <= most && made.table.bytes() as u64 > most / 4,
            "{}",
            made.table.bytes()
        );
        assert!(made.table.header.grid.finest > settings.footprint);
        assert!(made.conformance.errors().relative_l2 <= settings.tolerance);
        let none = ExportSettings { most_bytes: Some(10), ..small_settings() };
        assert!(ExportedMaterial::new(&small_field(), &none, &Task::silent()).is_err());
    }

    #[test]
    fn rows_come_back_from_csv_as_they_went() {
        let (conformance, _) = small_table();
        assert_eq!(Conformance::from_csv(&conformance.to_csv().unwrap()).unwrap(), conformance);
        assert!(Conformance::from_csv("a,b\n1,2\n").unwrap_err().to_string().contains("no column light_x"));
    }

    #[test]
    fn a_right_port_passes_and_ports_with_one_mistake_do_not() {
        let (conformance, table) = small_table();
        let reader = TableReader::new(Arc::clone(&table));
        let errors = |pair: &dyn Fn(&Pair) -> Pair,
                      footprint: &dyn Fn([DVec2; 2]) -> [DVec2; 2],
                      factor: &dyn Fn(&Pair) -> f64| {
            let answer = |row: &ConformanceRow| {
                let [dx, dy] = footprint(row.footprint);
                let xyz = reader.xyz(&pair(&row.pair), &1.5.into(), &covariance(dx, dy));
                (xyz_to_linear_srgb(xyz) * factor(&row.pair)).as_vec3().as_dvec3()
            };
            conformance.errors_of(&conformance.rows.iter().map(answer).collect::<Vec<_>>())
        };
        let (same, whole, one) = (|pair: &Pair| *pair, |footprint| footprint, |_: &Pair| 1.0);
        let right = errors(&same, &whole, &one);
        assert!(right.within(&PortErrors::RIGHT), "{right:?}");
        let flipped = |v: DVec3| DVec3::new(v.x, -v.y, v.z);
        let mistakes = [
            errors(&|pair| Pair::new(flipped(pair.light), flipped(pair.view)), &whole, &one),
            errors(&same, &|[dx, dy]| [dx * 2.0, dy * 2.0], &one),
            errors(&same, &|[dx, dy]| [dx.perp(), dy.perp()], &one),
            errors(&same, &whole, &|pair| 1.0 / pair.light.z),
            errors(&same, &whole, &|_| 1.03),
            errors(&same, &whole, &|_| f64::NAN),
        ];
        for (i, mistake) in mistakes.iter().enumerate() {
            assert!(!mistake.within(&PortErrors::RIGHT), "mistake {i}: {mistake:?}");
        }
    }

    #[test]
    fn answers_are_read_in_any_column_order_and_counted() {
        let (conformance, _) = small_table();
        let rows: String = (0..DIRECTIONS).map(|i| format!("x,{i},2,1\n")).collect();
        let answers = conformance.answers(&format!("name,b,g,r\n{rows}")).unwrap();
        assert_eq!(answers[7], DVec3::new(1.0, 2.0, 7.0));
        assert!(conformance.answers("r,g,b\n1,2,3\n").unwrap_err().to_string().contains("1 answers to 1000"));
        assert!(conformance.answers("r,g\n1,2\n").is_err() && conformance.answers("r,g,b\n1,2,x\n").is_err());
    }
}
