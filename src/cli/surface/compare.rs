//! `diffract surface compare`: statistics and predicted colours of several height fields, a row for each.

use crate::cli::colour::readings::{AngleReading, Detector};
use crate::cli::colour::{angles, aperture, aspecular};
use crate::cli::console::Console;
use crate::cli::options::{
    CacheOptions, ColourOptions, DeviceOptions, FigureOptions, OpticsOptions, SurfaceOptions,
};
use crate::cli::progress::surface_task;
use crate::cli::{captions, write};
use crate::error::{Error, Result, cause};
use crate::figure::{Axis, AxisScale, Figure, FigureFormat, Mark, Panel, palette};
use crate::files::Files;
use crate::notes::{Notes, PreparationRecord};
use crate::optics::color_difference::ciede2000;
use crate::surface::files;
use crate::surface::statistics::height_spectrum::{SurfaceSpectrum, analysed_part};
use crate::surface::{HeightField, Statistics};
use clap::Args;
use glam::DVec3;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Nanometres in a micrometre.
const NM_PER_UM: f64 = 1e3;
/// Name of the panel of the figure.
const PANEL: &str = "spectra";
/// Most surfaces of one call.
const MOST_SURFACES: usize = 1000;

/// Arguments of `surface compare`.
#[derive(Args, Debug)]
#[command(
    after_help = "The answer is CSV, a row for each surface: columns and rows of samples, dx and dy [nm]; range, Sa and Sq [nm], Sdq, Sal [um]; period, its uncertainty \
[nm], its direction [degrees] and method, empty where none stands out; and for each direction of view the colour that a spectrophotometer would read, L, a and b of CIELAB, \
with dE, its difference from the first surface's by CIEDE2000. The preparation applies to every surface.

Examples:
  diffract surface compare male.gsf female.gsf --level plane -o compared.csv --plot spectra.svg
  diffract surface compare scans/ --level plane --destripe -o scans.csv"
)]
pub struct CompareArguments {
    /// Height fields: files, built-in names, or folders of files
    #[arg(required = true)]
    surfaces: Vec<OsString>,
    /// Direction of the light, in degrees from the normal, and from +x toward +y
    #[arg(long, value_name = "THETA[,PHI]", value_parser = angles, allow_hyphen_values = true, default_value = "45")]
    light: [f64; 2],
    /// Directions of view by their angle from the mirror direction toward the light, in degrees
    #[arg(
        long,
        value_name = "DEG[,DEG...]",
        value_delimiter = ',', value_parser = aspecular, allow_hyphen_values = true,
        default_value = "15,25,45,75,110"
    )]
    aspecular: Vec<f64>,
    /// Full angle of the cone of directions that the detector averages over, as in 2deg
    #[arg(long, value_name = "ANGLE", value_parser = aperture, default_value = "2deg")]
    aperture: f64,
    /// Output file, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw the spectra of the heights as SVG or PNG
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    figure: FigureOptions,
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

/// A surface and what was found of it.
struct ComparedSurface {
    name: String,
    samples: [usize; 2],
    pixel_size: [f64; 2],
    statistics: Statistics,
    readings: Vec<AngleReading>,
    prepared: PreparationRecord,
    /// |f| \[1/µm\] and the power density \[nm² µm²\] averaged over directions.
    spectrum: Vec<[f64; 2]>,
}

/// Measures the surfaces and writes them.
pub fn run(arguments: &CompareArguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    arguments.plot.as_deref().map(FigureFormat::of).transpose()?;
    let style = arguments.figure.style(arguments.plot.is_some(), &[PANEL])?;
    if arguments.surface.surface.is_some() {
        return Err(Error::usage("the surfaces are arguments here", "leave --surface away, and name them"));
    }
    let surfaces = listed(&arguments.surfaces)?;
    let files = surfaces.iter().filter_map(|(name, _)| arguments.surface.files(Some(name)));
    Files::new()
        .reads(files)
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .writes([&arguments.output, &arguments.plot].into_iter().flatten())
        .check()?;
    let asked: Vec<AngleReading> =
        arguments.aspecular.iter().map(|angle| AngleReading::aspecular(arguments.light, *angle)).collect();
    if let Some(below) = asked.iter().find(|reading| reading.theta_r.abs() >= 90.0) {
        return Err(Error::usage(
            format!("the direction {} is below the horizon", below.name()),
            "give --aspecular angles less than 90 degrees from the angle of the light",
        ));
    }
    let mut compared = Vec::new();
    for (name, of_folder) in &surfaces {
        match arguments.surface.load(Some(name), None, "", console) {
            Ok(field) => compared.push(ComparedSurface::of(arguments, name, &field, &asked, console)?),
            // A folder may hold other files, too.
            Err(e) if *of_folder && surfaces.len() > 1 => {
                console.say(&format_args!("left out: {}", e.at(name.to_string_lossy())));
            }
            Err(e) => return Err(e),
        }
    }
    if compared.is_empty() {
        return Err(Error::input(
            "none of the files is a height field",
            "name files that `diffract surface info` reads",
        ));
    }
    write::result(arguments.output.as_deref(), &table(&compared)?, console)?;
    let notes = Notes::new(captions::own_command(console), &preparation(&compared));
    arguments.plot.as_deref().map_or(Ok(()), |path| figure(&compared).save(path, &style, &notes))
}

/// Returns the preparation that all surfaces have, or that of each with its name.
fn preparation(compared: &[ComparedSurface]) -> PreparationRecord {
    let mut records = compared.iter().map(|surface| &surface.prepared);
    match records.next() {
        Some(first) if records.all(|record| record == first) => first.clone(),
        _ => {
            let mut each = PreparationRecord::default();
            compared.iter().for_each(|surface| each.push(format!("{}: {}", surface.name, surface.prepared)));
            each
        }
    }
}

/// Returns the surfaces that are `named`, with the files of folders in alphabetical order, and true for those.
fn listed(named: &[OsString]) -> Result<Vec<(OsString, bool)>> {
    let mut all = Vec::new();
    for name in named {
        let path = Path::new(name);
        if !path.is_dir() {
            all.push((name.clone(), false));
            continue;
        }
        let unread =
            |e: std::io::Error| Error::files(cause(&e), "check the path").caused_by(e).at(path.display());
        let mut files = Vec::new();
        for entry in path.read_dir().map_err(unread)? {
            files.push(entry.map_err(unread)?.path());
        }
        let is_scan = |file: &PathBuf| {
            let extension = file.extension().and_then(|e| e.to_str());
            file.is_file() && extension.is_some_and(files::is_extension)
        };
        files.retain(is_scan);
        files.sort();
        if files.is_empty() {
            return Err(Error::input("the folder holds no height fields", "name another folder, or files")
                .at(path.display()));
        }
        all.extend(files.into_iter().map(|file| (file.into_os_string(), true)));
    }
    if all.len() > MOST_SURFACES {
        return Err(Error::usage(
            format!("{} surfaces are too many", all.len()),
            format!("name at most {MOST_SURFACES}"),
        ));
    }
    Ok(all)
}

impl ComparedSurface {
    /// Measures the surface `name`, and answers the readings that are `asked`.
    fn of(
        arguments: &CompareArguments,
        name: &OsStr,
        field: &HeightField,
        asked: &[AngleReading],
        console: &Console,
    ) -> Result<Self> {
        let optics = arguments.optics.for_directions(&arguments.colour, field, console)?;
        let detector = Detector { aperture: arguments.aperture, wavelengths: &[] };
        let mut readings = asked.to_vec();
        detector.read(&mut readings, field, optics, console)?;
        Ok(Self {
            name: name.to_string_lossy().into_owned(),
            samples: [field.columns(), field.rows()],
            pixel_size: field.pixel_size(),
            statistics: Statistics::of(field, &surface_task(console))?,
            readings,
            prepared: field.prepared().clone(),
            spectrum: radial(field)?,
        })
    }

    /// Returns the cells of a row, with differences of colours from those of `first`.
    fn cells(&self, first: &Self) -> Vec<String> {
        let mut cells = vec![self.name.clone()];
        cells.extend(self.samples.map(|count| count.to_string()));
        cells.extend(self.pixel_size.map(nanometres));
        let Statistics { heights, slopes, texture, periods, .. } = &self.statistics;
        let [low, high] = heights.range;
        cells.extend([high - low, heights.sa, heights.sq].map(nanometres));
        cells.push(format!("{:.5}", slopes.sdq));
        cells.push(texture.sal.map_or_else(String::new, |sal| format!("{sal:.4}")));
        cells.extend(match periods.first() {
            Some(period) => [
                nanometres(period.length),
                period.length_spread.map_or_else(String::new, nanometres),
                format!("{:.2}", period.direction),
                period.method.name().to_owned(),
            ],
            None => Default::default(),
        });
        for (reading, other) in self.readings.iter().zip(&first.readings) {
            let difference = ciede2000(DVec3::from(reading.lab), DVec3::from(other.lab));
            cells.extend(reading.lab.iter().chain([&difference]).map(|x| format!("{x:.3}")));
        }
        cells
    }
}

/// Returns a length \[µm\] in nanometres.
fn nanometres(length: f64) -> String {
    format!("{:.4}", length * NM_PER_UM)
}

/// Returns |f| \[1/µm\] and the power density \[nm² µm²\] of the heights, averaged over directions.
fn radial(field: &HeightField) -> Result<Vec<[f64; 2]>> {
    let spectrum = SurfaceSpectrum::windowed(&analysed_part(field))?;
    Ok(spectrum.radial().iter().map(|[f, power]| [*f, power * NM_PER_UM * NM_PER_UM]).collect())
}

/// Returns the CSV: a row for each surface.
fn table(compared: &[ComparedSurface]) -> Result<String> {
    let mut table = write::Csv::new();
    let fixed = [
        "surface",
        "columns",
        "rows",
        "dx",
        "dy",
        "range",
        "Sa",
        "Sq",
        "Sdq",
        "Sal",
        "period",
        "period_spread",
        "direction",
        "method",
    ];
    let Some(first) = compared.first() else { return table.text() };
    let of_reading =
        |reading: &AngleReading| ["L", "a", "b", "dE"].map(|what| format!("{what}_{}", reading.name()));
    table.row(fixed.map(str::to_owned).into_iter().chain(first.readings.iter().flat_map(of_reading)));
    for surface in compared {
        table.row(surface.cells(first));
    }
    table.text()
}

/// Returns the spectra of the heights in one panel.
fn figure(compared: &[ComparedSurface]) -> Figure {
    /// Decades below the largest power that are drawn.
    const DECADES: i32 = 10;
    let all = || compared.iter().flat_map(|surface| &surface.spectrum);
    let most = all().map(|[_, power]| *power).fold(f64::MIN_POSITIVE, f64::max);
    let least = most * 0.1f64.powi(DECADES);
    let x = Axis::fit("|f| [1/µm]", AxisScale::Log, all().map(|[f, _]| *f));
    let y = Axis::fit("power density [nm² µm²]", AxisScale::Log, all().map(|[_, power]| power.max(least)));
    let panel = Panel::new(x, y).called(PANEL).titled("Spectrum averaged over directions");
    let panel =
        compared.iter().zip(palette::SERIES.into_iter().cycle()).fold(panel, |panel, (surface, color)| {
            panel.named(surface.name.clone(), Mark::line(surface.spectrum.clone(), color))
        });
    Figure::new("").row(vec![panel]).panel_size(700.0, 480.0)
}
