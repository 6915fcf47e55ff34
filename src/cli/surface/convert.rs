//! `diffract surface convert`: one format to another, after preparation if steps are given.

use super::super::options::SurfaceOptions;
use super::report;
use crate::cli::captions;
use crate::cli::console::Console;
use crate::cli::progress::surface_task;
use crate::error::Result;
use crate::files::Files;
use crate::surface::files::Topography;
use crate::surface::files::write::{ScanFormat, rounding, write as write_surface};
use clap::Args;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Rounding of heights relative to their range from which a user is told: that of 16-bit codes, 1/2 of 1/65 535.
const NOTABLE_ROUNDING: f64 = 8e-6;

/// Arguments of `surface convert`.
#[derive(Args, Debug)]
#[command(after_help = "Example:
  diffract surface convert scan.spm -o scan.gsf      heights are in metres in every format
Samples that were not measured stay so (NaN). All formats but .npy note the preparation, which `surface info` reads.  .gsf and .tif hold 32-bit floats, .gwy, .npy, .txt and .x3p every digit.")]
pub struct Convert {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Output file: .gsf, .gwy, .npy, .tif, .txt or .x3p
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    surface: SurfaceOptions,
}

/// Reads the file and writes it in another format; preparation steps apply to heights whose gaps are filled.
pub fn run(arguments: &Convert, console: &Console) -> Result<()> {
    let path = &arguments.output;
    let format = ScanFormat::of(path)?;
    let name = arguments.surface_name.as_deref();
    Files::new().reads(arguments.surface.files(name)).writes([path]).check()?;
    let source = arguments.surface.source(name, None, "elaphe")?;
    let mut scan = arguments.surface.read(&source, console)?;
    if !source.prepare.is_empty() {
        scan = Topography::of(source.prepare(scan.into_field()?, &surface_task(console))?);
    }
    save(path, format, &scan, console)
}

/// Writes `scan` and prints the options that read it back.
pub(super) fn save(path: &Path, format: ScanFormat, scan: &Topography, console: &Console) -> Result<()> {
    write_surface(path, format, scan, captions::own_command(console))?;
    let lost = rounding(format, scan);
    if lost > NOTABLE_ROUNDING {
        console.say(&format_args!(
            "{}: 32-bit floats round the heights by up to {lost:.1e} of their range, because they stand on a large offset; --level mean takes the offset \
             away, and .gwy, .npy, .txt and .x3p hold every digit",
            path.display()
        ));
    }
    let hint = if format.has_scale() {
        String::new()
    } else {
        format!("; read it with {}", report::spacing_option(scan))
    };
    console.write(&format!("{}: {}{hint}\n", path.display(), report::size(scan)))
}
