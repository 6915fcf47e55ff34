//! `diffract eval`: BRDF numbers for the directions of a CSV file.

use super::answer::{AskedOptics, AskedSurface, TableAnswer};
use super::console::{Console, source_name};
use super::evaluation::{self, WAVELENGTHS, check_single_wavelengths};
use super::options::{CacheOptions, ColourOptions, DeviceOptions, OpticsOptions, SurfaceOptions};
use super::progress::ProgressBar;
use super::{captions, prepare, write};
use crate::error::{Error, Result};
use crate::files::Files;
use crate::optics::geometry::{Pair, direction};
use crate::optics::spectrum::SHORTEST;
use crate::render::evaluator::Query;
use crate::setup::SourceSettings;
use crate::task::DIRECTIONS;
use crate::units;
use clap::Args;
use glam::DVec3;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Columns of every query file, in degrees.
const ANGLES: [&str; 4] = ["theta_i", "phi_i", "theta_r", "phi_r"];
/// Column with single wavelengths \[nm\].
const WAVELENGTH: &str = "wavelength";

/// Arguments of `eval`.
#[derive(Args, Debug)]
#[command(
    after_help = "The query file is CSV with the header theta_i,phi_i,theta_r,phi_r[,wavelength], degrees and nm.
The answer repeats its columns and adds brdf [1/sr] where there is a wavelength, X,Y,Z of the colour where there is none.

Examples:
  diffract eval blaze --queries q.csv --method reference
  diffract eval scan.png --pixel-size 48.83nm --height 434.7nm --queries q.csv -o answers.csv"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Directions to evaluate; - is stdin
    #[arg(long, value_name = "FILE")]
    queries: PathBuf,
    /// Output file, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the answer as JSON too: input, settings, and a row for each of the table
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    json: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

/// Evaluates the queries and writes the answers.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    Files::new()
        .reads([&arguments.queries])
        .reads(arguments.surface.files(arguments.surface_name.as_deref()).map(Path::new))
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .writes([&arguments.output, &arguments.json].into_iter().flatten())
        .check()?;
    let table = QueryTable::read(&arguments.queries, console)?;
    if table.single_wavelengths {
        check_single_wavelengths(arguments.optics.method())?;
        evaluation::check_no_spectrum(&arguments.colour)?;
    }
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe", console)?;
    let optics = arguments.optics.for_directions(&arguments.colour, &field, console)?;
    let mut values = vec![DVec3::ZERO; table.queries.len()];
    let shortest =
        table.queries.iter().map(|q| q.wavelength.unwrap_or(SHORTEST)).fold(f64::INFINITY, f64::min);
    for wavelength in table.queries.iter().filter_map(|query| query.wavelength) {
        optics.reflectance.check_wavelength(wavelength)?;
    }
    let asked = AskedOptics::new(&optics);
    let settings = SourceSettings { shortest, ..SourceSettings::new(optics) };
    let below = table.queries.iter().filter(|query| !query.pair.above_horizon()).count();
    if below > 0 {
        let all = table.queries.len();
        console.say(&format_args!(
            "{below} of {all} queries have a direction at or below the horizon (theta of 90 degrees and more): their BRDF is 0"
        ));
    }
    let groups = table.by_wavelength();
    prepare::for_each_window(console, &field, &settings, |brdf, share| {
        let bar = ProgressBar::over(console, DIRECTIONS, "a file of fewer queries", table.queries.len());
        for (wavelength, places) in &groups {
            let pairs: Vec<Pair> = places.iter().map(|&place| table.queries[place].pair).collect();
            let found = evaluation::ask(brdf, &pairs, *wavelength, &bar)?;
            places.iter().zip(found).for_each(|(&place, f)| values[place] += f * share);
        }
        Ok(())
    })?;
    let answered = table.answered(&values);
    let text = answered.text_between(table.separator)?;
    write::result(arguments.output.as_deref(), &text, console)?;
    let Some(path) = &arguments.json else { return Ok(()) };
    let name = arguments.surface.name(arguments.surface_name.as_deref());
    let notes = captions::notes(&field, console);
    write::json(path, &TableAnswer::new(AskedSurface::new(name, &field), asked, &answered, &notes))
}

/// Columns of the file, and the queries in them.
pub(super) struct QueryTable {
    /// Character between the cells: a comma, or a semicolon, beside which decimals may have commas.
    separator: u8,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    queries: Vec<Query>,
    single_wavelengths: bool,
}

impl QueryTable {
    fn read(path: &Path, console: &Console) -> Result<Self> {
        let text = console.read_text(path, "a CSV file of directions")?;
        Self::parse(&text).map_err(|e| e.at(source_name(path)))
    }

    /// Parses the text of a file.
    pub fn parse(text: &str) -> Result<Self> {
        let remedy = "write the header theta_i,phi_i,theta_r,phi_r with wavelength (nm) or not, then numbers";
        let bad = |line: u64, what: String| Error::input(format!("line {line}: {what}"), remedy);
        let text = text.strip_prefix('\u{feff}').unwrap_or(text); // spreadsheets write a byte order mark
        let separator = separator(text);
        let mut reader =
            csv::ReaderBuilder::new().delimiter(separator).trim(csv::Trim::All).from_reader(text.as_bytes());
        let fail =
            |e: csv::Error| bad(e.position().map_or(1, csv::Position::line), e.to_string()).caused_by(e);
        let header: Vec<String> = reader.headers().map_err(fail)?.iter().map(str::to_owned).collect();
        let column = |name: &str| match header.iter().filter(|h| *h == name).count() {
            0 | 1 => Ok(header.iter().position(|h| h == name)),
            _ => Err(bad(1, format!("the column {name} stands twice"))),
        };
        let mut angles = [0; 4];
        for (place, name) in angles.iter_mut().zip(ANGLES) {
            *place = column(name)?.ok_or_else(|| bad(1, format!("there is no column {name}")))?;
        }
        let wavelength_column = column(WAVELENGTH)?;
        if let Some(name) = header.iter().find(|name| resembles(name)) {
            return Err(Error::input(
                format!("line 1: the column `{name}` is not {WAVELENGTH}"),
                format!("do you mean `{WAVELENGTH}`? Otherwise rename the column"),
            ));
        }
        for answer in answers(wavelength_column.is_some()) {
            if header.iter().any(|name| name == answer) {
                return Err(Error::input(
                    format!("line 1: the column {answer} is one that the answer adds"),
                    "leave it out or rename it",
                ));
            }
        }
        let mut table = Self {
            separator,
            header: header.clone(),
            rows: Vec::new(),
            queries: Vec::new(),
            single_wavelengths: wavelength_column.is_some(),
        };
        for record in reader.records() {
            let record = record.map_err(fail)?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |column: usize| {
                let cell = record.get(column).unwrap_or_default();
                let plain = if separator == b';' { cell.replace(',', ".") } else { cell.to_owned() };
                plain.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| {
                    bad(line, format!("`{cell}` in {} is not a number{}", header[column], hint(cell)))
                })
            };
            let [theta_i, phi_i, theta_r, phi_r] = angles.map(number);
            let wavelength = wavelength_column.map(number).transpose()?;
            if wavelength.is_some_and(|nm| !(WAVELENGTHS.0..=WAVELENGTHS.1).contains(&(nm / 1e3))) {
                let cell = record.get(wavelength_column.unwrap_or_default()).unwrap_or_default();
                return Err(bad(line, format!("the wavelength {cell} nm is not within 10 to 100000 nm")));
            }
            let pair = Pair::new(direction(theta_i?, phi_i?), direction(theta_r?, phi_r?));
            table.queries.push(Query { pair, wavelength: wavelength.map(units::micrometres) });
            table.rows.push(record.iter().map(str::to_owned).collect());
        }
        if table.queries.is_empty() {
            return Err(bad(1, "there are no queries".to_owned()));
        }
        Ok(table)
    }

    /// Groups the rows by wavelength.
    fn by_wavelength(&self) -> Vec<(Option<f64>, Vec<usize>)> {
        let mut groups: BTreeMap<u64, (Option<f64>, Vec<usize>)> = BTreeMap::new();
        for (place, query) in self.queries.iter().enumerate() {
            let key = query.wavelength.map_or(0, f64::to_bits);
            groups.entry(key).or_insert((query.wavelength, Vec::new())).1.push(place);
        }
        groups.into_values().collect()
    }

    /// Returns the table with the answers: f, or XYZ.
    fn answered(&self, values: &[DVec3]) -> write::Csv {
        let mut table = write::Csv::new();
        let mut header = self.header.clone();
        header.extend(answers(self.single_wavelengths).iter().map(|name| (*name).to_owned()));
        table.row(header);
        for (row, v) in self.rows.iter().zip(values) {
            let mut cells = row.clone();
            cells.extend(
                v.to_array()[..answers(self.single_wavelengths).len()].iter().map(|x| format!("{x:e}")),
            );
            table.row(cells);
        }
        table
    }
}

/// Returns the character between the cells of `text`: a semicolon if its header has some and no comma, as spreadsheets write where decimals have commas.
fn separator(text: &str) -> u8 {
    let header = text.lines().next().unwrap_or_default();
    if header.contains(';') && !header.contains(',') { b';' } else { b',' }
}

/// Returns what a `cell` that is no number may mean.
fn hint(cell: &str) -> &'static str {
    if cell.contains(',') { ", because decimals have points in a table with commas" } else { "" }
}

/// Returns true for a name that is probably a misspelt [`WAVELENGTH`].
fn resembles(name: &str) -> bool {
    /// Number of letters by which a misspelt name differs.
    const LETTERS: usize = 3;
    name != WAVELENGTH && strsim::damerau_levenshtein(&name.to_lowercase(), WAVELENGTH) <= LETTERS
}

/// Returns the names of the added columns.
fn answers(single_wavelengths: bool) -> &'static [&'static str] {
    if single_wavelengths { &["brdf"] } else { &["X", "Y", "Z"] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_are_read_in_any_column_order_and_answered_beside_their_own_columns() {
        let table =
            QueryTable::parse("name,phi_r,theta_r,theta_i,phi_i,wavelength\n\"a,b\",90,30,10,0,550\n")
                .unwrap();
        assert_eq!(table.queries[0].wavelength, Some(0.55));
        assert_eq!(table.queries[0].pair.view, direction(30.0, 90.0));
        let answer = table.answered(&[DVec3::splat(0.5)]).text().unwrap();
        assert_eq!(answer, "name,phi_r,theta_r,theta_i,phi_i,wavelength,brdf\n\"a,b\",90,30,10,0,550,5e-1\n");
        let colour = QueryTable::parse("theta_i,phi_i,theta_r,phi_r\n0,0,0,0\n").unwrap();
        assert!(
            colour.answered(&[DVec3::ONE]).text().unwrap().contains("phi_r,X,Y,Z\n0,0,0,0,1e0,1e0,1e0\n")
        );
    }

    #[test]
    fn semicolons_and_decimal_commas_are_read_and_answered_alike() {
        let table = QueryTable::parse("theta_i;phi_i;theta_r;phi_r;wavelength\n10,5;0;30;90;550\n").unwrap();
        assert_eq!(table.queries[0].pair.light, direction(10.5, 0.0));
        let answer = table.answered(&[DVec3::splat(0.5)]).text_between(table.separator).unwrap();
        assert!(answer.ends_with("\n10,5;0;30;90;550;5e-1\n"), "{answer}");
        let quoted = "theta_i,phi_i,theta_r,phi_r\n\"10,5\",0,30,90\n";
        assert!(QueryTable::parse(quoted).err().unwrap().to_string().contains("decimals have points"));
    }

    #[test]
    fn bad_rows_are_refused_by_line() {
        let error = |text: &str| QueryTable::parse(text).err().unwrap().to_string();
        let header = "theta_i,phi_i,theta_r,phi_r,wavelength";
        assert!(error(&format!("{header}\n0,0,0,0,550\n0,0,x,0,550\n")).contains("line 3"));
        assert!(error(&format!("{header}\n0,0,0,0,-550\n")).contains("-550"));
        assert!(error(&format!("{header}\n0,0,0,nan,550\n")).contains("nan"));
        assert!(error(&format!("{header}\n0,0,0\n")).contains("line 2"));
        assert!(error("theta_i,phi_i,theta_r\n0,0,0\n").contains("phi_r"));
        assert!(error(&format!("{header}\n")).contains("no queries"));
        assert!(error("").contains("theta_i"));
        assert!(error("theta_i,phi_i,theta_r,phi_r,wavelength,brdf\n0,0,0,0,550,1\n").contains("brdf"));
        assert!(error("theta_i,phi_i,theta_r,phi_r,Y\n0,0,0,0,1\n").contains("column Y"));
        let long = error(&format!("{header}\n0,0,0,0,1e308\n"));
        assert!(long.contains("1e308 nm") && long.len() < 200, "{long}");
    }
}
