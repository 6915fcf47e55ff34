//! `diffract export --html`: the words and the picture of the heights of a page.

use crate::cli::captions;
use crate::cli::surface::{describe, plot};
use crate::error::Result;
use crate::export::page::{self, PageBar, PagePictures, PageWords};
use crate::export::page_light::{PARTS, PageLight};
use crate::export::page_mesh::PageMesh;
use crate::export::page_still;
use crate::export::{ExportedMaterial, MaterialDescription};
use crate::figure::{Axis, ColorMap, ColorScale, Raster};
use crate::optics::validity::{LightColour, ScalarTheory};
use crate::output::{write_atomically, write_failed};
use crate::settings::Optics;
use crate::surface::statistics::plot_grid::PlotGrid;
use crate::surface::{HeightField, Statistics, SurfaceSource};
use crate::task::Task;
use std::io::Write;
use std::path::Path;

/// Publications whose method the program follows.
const CITATIONS: [&str; 3] = [
    "J. Stam, Diffraction Shaders, SIGGRAPH 99, 101–110, 1999. doi:10.1145/311535.311546",
    "M. Single, An Interactive Shader for Natural Diffraction Gratings, Bachelor’s thesis, University of Bern, 2014.",
    "D. S. Dhillon, J. Teyssier, M. Single, I. Gaponenko, M. C. Milinkovitch and M. Zwicker, Interactive Diffraction from Biological Nanostructures, Computer Graphics Forum 33 (8), \
     177–188, 2014. doi:10.1111/cgf.12425",
];

/// Longest side of the picture of the heights \[pixels\].
const MOST_PIXELS: usize = 560;

/// Surroundings of the page.
const SURROUNDINGS: &str = "studio";

/// Surface of a page with the settings of its light.
pub struct PageSubject<'a> {
    /// Source of the heights.
    pub source: &'a SurfaceSource,
    /// Prepared heights.
    pub field: &'a HeightField,
    /// Light and material.
    pub optics: &'a Optics,
    /// Words for the illuminant.
    pub illuminant: String,
    /// Mesh that shows it beside the page's own shapes.
    pub mesh: Option<&'a PageMesh>,
}

/// Writes the page of `material`, which `description` describes, to `path`.
pub fn write(
    path: &Path,
    subject: &PageSubject<'_>,
    material: &ExportedMaterial,
    description: &MaterialDescription,
    task: &Task,
) -> Result<()> {
    let grid = PlotGrid::of_heights(subject.field, MOST_PIXELS);
    let range = grid.core();
    let words = words(subject, description, range, task)?;
    let scale = ColorScale { axis: Axis::linear("", range[0], range[1]), map: ColorMap::Viridis };
    let relief = Raster::values(grid.size[0], &grid.values, scale);
    let light = PageLight::new(SURROUNDINGS)?;
    let sphere = page_still::sphere(&material.table, &subject.optics.reflectance, &light);
    let still = Raster::colors(page_still::SIDE, sphere);
    let pictures = PagePictures { relief: relief.png()?, still: still.png()? };
    let text =
        page::write(material, &words, &pictures, &light, subject.mesh).map_err(|e| e.at(path.display()))?;
    write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(|e| write_failed(path, e)))
}

/// Returns all texts of the page, where the colours of the heights have this `range` \[nm\].
fn words(
    subject: &PageSubject<'_>,
    description: &MaterialDescription,
    range: [f64; 2],
    task: &Task,
) -> Result<PageWords> {
    let PageSubject { source, field, optics, illuminant, mesh } = subject;
    let statistics = Statistics::of(field, task)?;
    let theory =
        ScalarTheory::of_field(field, &optics.reflectance, LightColour::Spectrum(&optics.illuminant))?;
    let lines = describe::lines(field, &statistics, &theory)?;
    let named = |wanted: &str| {
        let found = lines.iter().find(|(name, _)| *name == wanted);
        found.map_or_else(String::new, |(_, value)| value.clone())
    };
    let fact = |name: &str, value: String| (name.to_owned(), value);
    let name = Path::new(&source.name).file_name().unwrap_or(&source.name).to_string_lossy().into_owned();
    let drawn_on = mesh.map(|mesh| fact("mesh", format!("{} triangles", mesh.triangles)));
    let [width, height] = field.patch_size();
    let bar = plot::scale_bar(width);
    Ok(PageWords {
        lead: format!(
            "The colours that {} × {} heights on {width:.1} µm × {height:.1} µm give to light, computed by scalar wave optics and averaged over the coherence of the light and over \
             each pixel.",
            field.columns(),
            field.rows(),
        ),
        facts: vec![
            fact("Samples", typeset(&format!("{}, {} apart", named("samples"), named("spacing")))),
            fact("Heights", format!("{}, RMS {:.1} nm", named("height range"), statistics.heights.sq * 1e3)),
            fact("Dominant period", typeset(&named("dominant period"))),
            fact("Light", format!("{illuminant}, coherence {}", captions::coherence(&optics.coherence))),
            fact("Material", optics.reflectance.to_string()),
        ],
        more: lines.iter().map(|(name, value)| fact(name, typeset(value))).chain(drawn_on).collect(),
        trust: trust(description),
        citations: CITATIONS.map(str::to_owned).to_vec(),
        command: format!("{} --html page.html", description.command),
        made: format!(
            "Written by {}. The page holds everything that it shows and loads nothing.",
            description.program
        ),
        heights: range.map(|nm| format!("{nm:.0} nm")),
        bar: PageBar { text: format!("{bar} µm"), share: bar / width },
        directions: description.errors.directions,
        name,
    })
}

/// Returns `text` with µ, ° and × in place of the ASCII that a terminal gets.
fn typeset(text: &str) -> String {
    text.replace(" um", " µm").replace(" deg", "°").replace("1/um", "1/µm").replace(" x ", " × ")
}

/// Returns sentences about the errors of the table and of scalar theory.
fn trust(description: &MaterialDescription) -> Vec<String> {
    let MaterialDescription { errors, smallest_footprint, scalar_theory, .. } = description;
    vec![
        format!(
            "Colours of the table differ from the exact mean in {} random directions by {:.1} % of their root mean square.",
            errors.directions,
            100.0 * errors.relative_l2
        ),
        format!("Scalar theory: {scalar_theory}."),
        format!(
            "The table holds averages over standard deviations of (u, v) from {smallest_footprint:.3} on. A pixel that covers less is drawn as an average over that."
        ),
        format!(
            "The surroundings are the {SURROUNDINGS} of this program: {PARTS} directions, each averaged over its part, and a picture 128 pixels wide for what the surface mirrors. They cast no \
             shadows, and “all directions at once” leaves them out."
        ),
        "The matt layer, the surroundings and the shapes are added by the page; they are not measured."
            .to_owned(),
    ]
}
