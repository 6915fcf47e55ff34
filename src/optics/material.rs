//! Materials: complex refractive indices n + ik over the visible range.

use super::material_table;
use super::spectrum::{LONGEST, NM_PER_UM, SHORTEST, SpectralTable};
use crate::error::{Error, Result};
use rustfft::num_complex::Complex64;
use serde::Serialize;
use std::ffi::OsStr;
use std::path::Path;

/// Number that is larger than n and k of every material in visible light.
pub const LARGEST_INDEX: f64 = 100.0;
/// Built-in materials; `assets/materials/README.md` names the sources.
pub const BUILT_IN: [&str; 8] =
    ["glass", "keratin", "aluminium", "silver", "gold", "copper", "nickel", "silicon"];

/// Built-in materials that are tables.
const TABLES: [(&str, &str); 6] = [
    ("aluminium", include_str!("../../assets/materials/aluminium.csv")),
    ("silver", include_str!("../../assets/materials/silver.csv")),
    ("gold", include_str!("../../assets/materials/gold.csv")),
    ("copper", include_str!("../../assets/materials/copper.csv")),
    ("nickel", include_str!("../../assets/materials/nickel.csv")),
    ("silicon", include_str!("../../assets/materials/silicon.csv")),
];

/// Material with a complex refractive index.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Material {
    /// Built-in name, or the file that the table was read from.
    pub name: String,
    index: Index,
}

/// Formula or table of n + ik over the wavelength.
#[derive(Clone, Debug, PartialEq, Serialize)]
enum Index {
    /// Constant over the wavelength.
    Constant(f64),
    /// n² = 1 + Σ B λ²/(λ² − C), λ in µm: pairs of B and C \[µm²\].
    Sellmeier([[f64; 2]; 3]),
    /// n = A + B/λ², λ in µm.
    Cauchy([f64; 2]),
    /// n and k over the wavelength \[nm\].
    Table(SpectralTable<2>),
}

/// Schott N-BK7: coefficients of the data sheet.
const BK7: [[f64; 2]; 3] =
    [[1.039_612_12, 0.006_000_698_67], [0.231_792_344, 0.020_017_914_4], [1.010_469_45, 103.560_653]];
/// Range of wavelengths that the data sheet of N-BK7 tabulates \[µm\].
const SELLMEIER_RANGE: [f64; 2] = [0.31, 2.325];
/// Keratin (Leertouwer, Wilts, Stavenga 2011).
const KERATIN: [f64; 2] = [1.532, 0.005_890];
/// Range of wavelengths of keratin's formula, which was measured in visible light \[µm\].
const CAUCHY_RANGE: [f64; 2] = [SHORTEST, LONGEST];

impl Material {
    /// Returns a transparent material of refractive index `n` at all wavelengths.
    pub fn constant(n: f64) -> Self {
        Self { name: n.to_string(), index: Index::Constant(n) }
    }

    /// Returns a built-in material by name, or reads a CSV file of wavelength \[nm or µm\], n and k in the forms of `material_table`; without k the material
    /// absorbs nothing. The first and the last index of a table hold over the rest of 380 to 780 nm, and that of a single wavelength over all of it, as
    /// [`Self::note`] tells.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is no such table, holds no visible wavelength of several, or has values that no material has.
    pub fn from_name_or_file(name: impl AsRef<OsStr>) -> Result<Self> {
        let name = name.as_ref();
        let known = |known_name: &str| {
            name.eq_ignore_ascii_case(known_name)
                || known_name == "aluminium" && name.eq_ignore_ascii_case("aluminum")
        };
        if known("glass") {
            return Ok(Self::named("glass", Index::Sellmeier(BK7)));
        }
        if known("keratin") {
            return Ok(Self::named("keratin", Index::Cauchy(KERATIN)));
        }
        match TABLES.iter().find(|(known_name, _)| known(known_name)) {
            Some((known_name, text)) => Self::from_text(known_name, text),
            None => Self::from_file(Path::new(name)),
        }
    }

    /// Returns true if `name` is a built-in material.
    pub fn is_built_in(name: impl AsRef<OsStr>) -> bool {
        let name = name.as_ref();
        BUILT_IN.iter().chain(&["aluminum"]).any(|known| name.eq_ignore_ascii_case(known))
    }

    fn named(name: &str, index: Index) -> Self {
        Self { name: name.to_owned(), index }
    }

    fn from_file(path: &Path) -> Result<Self> {
        let text = crate::input::read_text(
            path,
            &format!("{} or a CSV file of wavelength in nm or µm, n and k", BUILT_IN.join(", ")),
        )?;
        Self::from_text(&path.to_string_lossy(), &text).map_err(|e| e.at(path.display()))
    }

    /// Parses the text of a CSV file of wavelength, n and k as the material `name`.
    ///
    /// # Errors
    /// Same as [`Self::from_name_or_file`].
    pub fn from_text(name: &str, text: &str) -> Result<Self> {
        let table = material_table::read(text)?;
        let [first, last] = table.ends();
        let is_visible = first < NM_PER_UM * LONGEST && last > NM_PER_UM * SHORTEST;
        if !is_visible && first < last {
            return Err(Error::input(
                format!("the refractive index is given from {first} to {last} nm"),
                "give it from 380 to 780 nm",
            ));
        }
        let sane = |[n, k]: [f64; 2]| n > 0.0 && n <= LARGEST_INDEX && (0.0..=LARGEST_INDEX).contains(&k);
        if !table.all(sane) {
            return Err(Error::input(
                "a refractive index is not within 0 to 100, or an extinction coefficient is negative",
                "give n above 0 and k of at least 0, as in n + ik",
            ));
        }
        Ok(Self::named(name, Index::Table(table)))
    }

    /// Returns the refractive index if it is real and the same at all wavelengths.
    pub fn constant_index(&self) -> Option<f64> {
        if let Index::Constant(n) = self.index { Some(n) } else { None }
    }

    /// Returns a note on wavelengths for which the table has no index, and gets that of an end; `None` if there are none.
    pub fn note(&self) -> Option<String> {
        let Index::Table(table) = &self.index else { return None };
        let [first, last] = table.ends();
        let covers = first <= NM_PER_UM * SHORTEST && last >= NM_PER_UM * LONGEST;
        (!covers).then(|| {
            let given = if first < last {
                format!("is given from {first} to {last} nm, and its ends hold")
            } else {
                format!("is given at {first} nm alone, and holds")
            };
            format!("{}: the refractive index {given} for the rest of 380 to 780 nm", self.name)
        })
    }

    /// Returns the shortest and the longest wavelength for which the index is known or held \[µm\].
    pub fn range(&self) -> [f64; 2] {
        match &self.index {
            Index::Constant(_) => [0.0, f64::INFINITY],
            Index::Sellmeier(_) => SELLMEIER_RANGE,
            Index::Cauchy(_) => CAUCHY_RANGE,
            Index::Table(table) => {
                let [first, last] = table.ends().map(|nm| nm / NM_PER_UM);
                [first.min(SHORTEST), last.max(LONGEST)]
            }
        }
    }

    /// Fails unless the index is known at `wavelength` \[µm\].
    ///
    /// # Errors
    /// A wavelength beyond the table or the range of the formula.
    pub fn check_wavelength(&self, wavelength: f64) -> Result<()> {
        /// Rounding of a wavelength that went through another unit.
        const ROUNDING: f64 = 1e-9;
        let [first, last] = self.range();
        if (first * (1.0 - ROUNDING)..=last * (1.0 + ROUNDING)).contains(&wavelength) {
            return Ok(());
        }
        Err(Error::usage(
            format!(
                "the refractive index of {} is known from {:.0} to {:.0} nm, and not at {:.1} nm",
                self.name,
                first * NM_PER_UM,
                last * NM_PER_UM,
                wavelength * NM_PER_UM
            ),
            "take another wavelength, a table of the material that holds it, or one refractive index",
        ))
    }

    /// Returns n + ik at `wavelength` \[µm\].
    pub fn index(&self, wavelength: f64) -> Complex64 {
        let squared = wavelength * wavelength;
        match &self.index {
            Index::Constant(n) => (*n).into(),
            Index::Sellmeier(terms) => {
                let sum: f64 = terms.iter().map(|[b, c]| b * squared / (squared - c)).sum();
                (1.0 + sum).sqrt().into()
            }
            Index::Cauchy([a, b]) => (a + b / squared).into(),
            Index::Table(table) => {
                // The ends hold beyond the table.
                let [first, last] = table.ends();
                let [n, k] = table.at((wavelength * NM_PER_UM).clamp(first, last));
                Complex64::new(n, k)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_material_has_its_published_index() {
        // Schott's data sheet: n_d = 1.51680 at 587.6 nm, n_F = 1.52238 at 486.1 nm; the rest are rows of the papers' tables.
        for (name, wavelength, n, k) in [
            ("glass", 0.587_562, 1.516_80, 0.0),
            ("glass", 0.486_133, 1.522_38, 0.0),
            ("keratin", 0.5, 1.532 + 0.005_89 / 0.25, 0.0),
            ("aluminium", 0.563_57, 1.0728, 6.7839),
            ("silver", 0.5486, 0.06, 3.586),
            ("gold", 0.5486, 0.43, 2.455),
            ("copper", 0.5486, 1.02, 2.577),
            ("nickel", 0.549, 1.92, 3.61),
            ("silicon", 0.5391, 4.123, 0.048),
        ] {
            let found = Material::from_name_or_file(name).unwrap().index(wavelength);
            assert!((found - Complex64::new(n, k)).norm() < 1e-5, "{name}: {found}");
        }
        assert!(BUILT_IN.iter().all(|name| Material::from_name_or_file(name).is_ok()));
        assert!(Material::is_built_in("Gold") && !Material::is_built_in("gold.csv"));
    }

    #[test]
    fn tables_that_no_material_has_are_refused() {
        let refused = |text: &str| Material::from_text("m", text).unwrap_err().to_string();
        assert!(refused("800,1.5\n980,1.5\n").contains("800 to 980"), "{}", refused("800,1.5\n980,1.5\n"));
        assert!(refused("380,0,1\n780,1,1\n").contains("0 to 100"));
        assert!(refused("380,1,-1\n780,1,1\n").contains("negative"));
        assert!(refused("nm,n,k\n380,1,x\n780,1,1\n").contains("line 2"));
        let lossless = Material::from_text("m", "380,1.5\n780,1.7\n").unwrap();
        assert!((lossless.index(0.58) - Complex64::new(1.6, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn the_ends_of_a_table_hold_over_visible_light_and_are_told() {
        let table = Material::from_text("m.csv", "wl,n\n0.4,1.5\n0.7,1.7\nwl,k\n0.4,0.1\n0.7,0.3\n").unwrap();
        assert_eq!(table.range(), [SHORTEST, LONGEST]);
        for (wavelength, n, k) in [(0.38, 1.5, 0.1), (0.55, 1.6, 0.2), (0.78, 1.7, 0.3)] {
            assert!((table.index(wavelength) - Complex64::new(n, k)).norm() < 1e-12, "{wavelength}");
        }
        let note = table.note().unwrap();
        assert!(
            note.contains("m.csv") && note.contains("from 400 to 700 nm") && note.contains("ends hold"),
            "{note}"
        );
        let laser = Material::from_text("m.csv", "wavelength,n,k\n1064,0.3,7\n").unwrap();
        assert_eq!(
            (laser.index(0.5), laser.index(1.064)),
            (Complex64::new(0.3, 7.0), Complex64::new(0.3, 7.0))
        );
        assert!(laser.check_wavelength(1.064).is_ok() && laser.check_wavelength(2.0).is_err());
        assert!(laser.note().unwrap().contains("at 1064 nm alone"), "{:?}", laser.note());
        assert_eq!(Material::from_text("m", "380,1\n780,1\n").unwrap().note(), None);
        assert!(BUILT_IN.iter().all(|name| Material::from_name_or_file(name).unwrap().note().is_none()));
    }
}
