//! `diffract export`: a surface's material for other programs.

mod page;

use self::page::PageSubject;
use super::console::Console;
use super::options::{ColourOptions, OpticsOptions, SurfaceOptions, real};
use super::progress::{LESS_WORK, ProgressBar, surface_task};
use super::{captions, prepare, write};
use crate::brdf::energy_map::EnergyMap;
use crate::error::{Error, Remedy, Result};
use crate::export::page::MOST_PAGE_TEXELS;
use crate::export::page_mesh::PageMesh;
use crate::export::{
    ExportReader, ExportSettings, ExportedMaterial, LARGEST_FOOTPRINT, MaterialDescription, MeasuredErrors,
    PortErrors, check_target, write as write_export,
};
use crate::files::Files;
use crate::input;
use crate::optics::spectrum::SHORTEST;
use crate::scene::SceneOverrides;
use crate::settings::{Method, Optics};
use crate::table::TableHeader;
use crate::units;
use clap::Args;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Range of footprints.
const FOOTPRINTS: (f64, f64) = (0.0, LARGEST_FOOTPRINT);

/// Arguments of `export`.
#[derive(Args, Debug)]
#[command(
    after_help = "The folder holds the colour table of the surface (table.ktx2, and the same as a plain image, table2d.exr), its functions \
of |w| (table.json), material.json with units, signs, settings, measured errors and check sums, and conformance.csv: 1000 \
directions with footprints, their exact colours and those of the table. A port of the reading function is tested by \
--check and --answers, a CSV file with the columns r, g and b, a row for each row of conformance.csv.

Examples:
  diffract export elaphe -o skin --footprint 0.02 --tolerance 2e-2
  diffract export elaphe --html elaphe.html            a page for any browser, which loads nothing
  diffract export elaphe --html snake.html --mesh snake
  diffract export blaze -o blaze --coherence gaussian:16um --material aluminium
  diffract export --check skin --answers mine.csv"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Folder of the export, which is new, empty or a former export
    #[arg(short, long, value_name = "FOLDER", required_unless_present_any = ["check", "html", "json"])]
    output: Option<PathBuf>,
    /// Page that shows the material in a browser with WebGL 2: one file of at most 10 MB, which loads nothing. It holds at most 6.7 MB of texels
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Mesh that the page shows beside its sphere, disc and plate: a built-in scene (snake, plate, sphere, disc, cd, skin), a mesh (.obj, .gltf, .glb, .ply, .stl), or a
    /// scene file (.toml), whose first object it is. It takes at most 5 of the 6.7 MB: about 300000 triangles
    #[arg(long, value_name = "SCENE", requires = "html", hide_short_help = true)]
    mesh: Option<OsString>,
    /// Smallest footprint that the table serves, as a standard deviation of (u, v); 0 for single directions. Larger footprints take a smaller table
    #[arg(long, value_name = "SIGMA", value_parser = footprint, allow_hyphen_values = true, default_value = "0.02")]
    footprint: f64,
    /// Largest size of the texels, as in 8MB: the smallest footprint grows until the table fits
    #[arg(long, value_name = "SIZE", value_parser = units::bytes, allow_hyphen_values = true)]
    budget: Option<u64>,
    /// Write the description of the material as JSON too, as `material.json` has it
    #[arg(long, value_name = "FILE", hide_short_help = true, conflicts_with = "check")]
    json: Option<PathBuf>,
    /// Check an export instead: its version, check sums and numbers
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["output", "html", "surface_name"])]
    check: Option<PathBuf>,
    /// Compare these answers of a port with the table
    #[arg(long, value_name = "FILE", requires = "check", conflicts_with = "output", hide_short_help = true)]
    answers: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
}

fn footprint(text: &str) -> Result<f64> {
    real(text, FOOTPRINTS, "footprint")
}

/// Exports, or checks an export.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    if let Some(folder) = &arguments.check {
        return check(folder, arguments.answers.as_deref(), console);
    }
    let files = Files::new()
        .reads(arguments.surface.files(arguments.surface_name.as_deref()))
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .reads(&arguments.mesh)
        .writes([&arguments.html, &arguments.json].into_iter().flatten());
    files.check()?;
    if let Some(folder) = &arguments.output {
        check_target(folder)?;
    }
    let mesh = arguments.mesh.as_deref().map(|name| page_mesh(name, &files, console)).transpose()?;
    let most_bytes = most_texels(arguments, mesh.as_ref().map_or(0, |mesh| mesh.bytes.len()))?;
    if arguments.optics.method.is_some_and(|method| method != Method::Table) {
        return Err(Error::usage("an export is a colour table", Remedy::TableMethod));
    }
    let source = arguments.surface.source(arguments.surface_name.as_deref(), None, "elaphe")?;
    let field =
        source.prepare(arguments.surface.read(&source, console)?.into_field()?, &surface_task(console))?;
    let optics = arguments.optics.for_directions(&arguments.colour, &field, console)?;
    let optics = Optics { method: Method::Table, ..optics }.checked()?;
    let settings = ExportSettings { most_bytes, ..optics.export_settings(arguments.footprint)? };
    prepare::warn_of_coarse_samples(console, &field, SHORTEST);
    let bar = ProgressBar::new(console, "orders", LESS_WORK);
    let material = ExportedMaterial::new(&field, &settings, &bar.task())?;
    drop(bar);
    let mut description =
        MaterialDescription::new(&field, &settings, &material, captions::own_command(console))?;
    if let Some(folder) = &arguments.output {
        write_export(folder, &material, &mut description)?;
    }
    if let Some(path) = &arguments.html {
        let name = &arguments.colour.illuminant;
        let illuminant = if arguments.colour.files().is_some() {
            name.to_string_lossy().into_owned()
        } else {
            name.to_string_lossy().to_uppercase()
        };
        let subject =
            PageSubject { source: &source, field: &field, optics: &optics, illuminant, mesh: mesh.as_ref() };
        page::write(path, &subject, &material, &description, &surface_task(console))?;
    }
    if let Some(path) = &arguments.json {
        write::json(path, &description)?;
    }
    console.write(&(summary(&description) + &limit_line(&material.table.header)))
}

/// Returns the line that says by how much the theory was limited; empty where little.
fn limit_line(header: &TableHeader) -> String {
    let energy = header.energy.as_deref().and_then(EnergyMap::of_points);
    energy.and_then(|energy| energy.note()).map_or_else(String::new, |note| format!("{note}\n"))
}

/// Opens the first object of the scene or mesh called `name`, and checks that none of its files is one of those that are written.
fn page_mesh(name: &OsStr, files: &Files, console: &Console) -> Result<PageMesh> {
    let scene = prepare::scene(console, name, &SceneOverrides::default())?;
    files.clone().reads(&scene.files).check()?;
    let object = scene.main_object();
    PageMesh::new(&object.mesh, &object.grooves).map_err(|e| e.at(name.display()))
}

/// Returns the most bytes of texels: the user's, or those that a page holds beside a mesh of `mesh` bytes.
fn most_texels(arguments: &Arguments, mesh: usize) -> Result<Option<u64>> {
    if arguments.html.is_none() {
        return Ok(arguments.budget);
    }
    let most = MOST_PAGE_TEXELS - mesh as u64;
    let budget = arguments.budget.unwrap_or(most);
    if budget > most {
        let beside = if mesh > 0 { " beside this mesh" } else { "" };
        // Rounded down.
        let most = (most / 100_000) as f64 / 10.0;
        return Err(Error::usage(
            format!("a page of 10 MB holds no more than {most:.1} MB of texels{beside}"),
            format!("use --budget {most:.1}MB or less, or export a folder without --html"),
        ));
    }
    Ok(Some(budget))
}

/// Returns size and errors in a line.
fn summary(description: &MaterialDescription) -> String {
    const MB: f64 = 1e6;
    let MaterialDescription { table_bytes, smallest_footprint, errors, .. } = description;
    let MeasuredErrors { directions, relative_l2, own_rms, own_p99 } = *errors;
    format!(
        "{:.2} MB of texels for footprints from {smallest_footprint:.3} on; against the exact mean of {directions} directions: {}\n",
        *table_bytes as f64 / MB,
        in_words(&PortErrors { relative_l2, own_rms, own_p99 })
    )
}

/// Returns what each error is a part of, in words.
fn in_words(errors: &PortErrors) -> String {
    let PortErrors { relative_l2, own_rms, own_p99 } = *errors;
    format!(
        "colours err by {} of the RMS colour (relative L2); each direction by {} of its colour (RMS), 99 of 100 by at most {}, most where it is dark",
        percent(relative_l2),
        percent(own_rms),
        percent(own_p99)
    )
}

/// Returns a share in percent, to two digits below 100 %.
fn percent(share: f64) -> String {
    const DIGITS: f64 = 2.0;
    let percent = 100.0 * share;
    let decimals = (DIGITS - 1.0 - percent.max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{percent:.decimals$} %")
}

/// Checks the export in `folder`, and a file of answers.
fn check(folder: &Path, answers: Option<&Path>, console: &Console) -> Result<()> {
    let reader = ExportReader::open(folder)?;
    let conformance = reader.check()?;
    let Some(path) = answers else {
        let limited = limit_line(&reader.table()?.header);
        // From the directions themselves, not as the description has them.
        let found = MaterialDescription { errors: conformance.errors(), ..reader.description };
        return console.write(&format!("sound: {}{limited}", summary(&found)));
    };
    let text = input::read_text(path, "a CSV file of answers")?;
    let errors = conformance
        .answers(&text)
        .map(|answers| conformance.errors_of(&answers))
        .map_err(|e| e.at(path.display()))?;
    let found = in_words(&errors);
    if errors.within(&PortErrors::RIGHT) {
        return console.write(&format!("right: against the table, {found}\n"));
    }
    let PortErrors { relative_l2, own_rms, own_p99 } = PortErrors::RIGHT;
    let [all, each, most] = [relative_l2, own_rms, own_p99].map(percent);
    Err(Error::input(
        format!("the answers are not those of the table: {found}; {all}, {each} and {most} are allowed"),
        "compare them with the columns table_r, table_g and table_b of conformance.csv row by row",
    )
    .at(path.display()))
}
