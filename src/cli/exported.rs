//! Settings of an export, and its table in the place of one that is baked.

use crate::brdf::energy_map::EnergyMap;
use crate::error::{Error, Remedy, Result};
use crate::export::{ExportReader, MaterialDescription};
use crate::render::source::{Source, Table};
use crate::settings::Method;
use crate::setup::SourceSettings;
use crate::surface::HeightField;
use crate::table::ColorTable;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Table of an export.
pub struct ExportedTable {
    folder: PathBuf,
    description: MaterialDescription,
    table: Arc<ColorTable>,
}

impl ExportedTable {
    /// Reads the export in `folder`.
    ///
    /// # Errors
    /// Fails for an export that is truncated, damaged or of a newer version.
    pub fn open(folder: &Path) -> Result<Self> {
        let reader = ExportReader::open(folder)?;
        let table = Arc::new(reader.table()?);
        Ok(Self { folder: folder.to_owned(), description: reader.description, table })
    }

    /// Returns the table as the source of `field` under `settings`.
    ///
    /// # Errors
    /// Fails for settings that are not those of the export.
    pub fn source(&self, field: &HeightField, settings: &SourceSettings) -> Result<Source> {
        settings.optics.check()?;
        if settings.optics.method != Method::Table {
            return Err(Error::usage("an export is a colour table", Remedy::TableMethod));
        }
        let asked = settings.optics.export_settings(settings.footprints.shorter)?;
        self.description.check(field, &asked).map_err(|e| e.at(self.folder.display()))?;
        let energy = self.table.header.energy.as_deref().and_then(EnergyMap::of_points).map(Arc::new);
        Ok(Source::Table(Table { table: self.table.clone(), energy }))
    }
}
