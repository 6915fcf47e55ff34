//! The observer and the illuminants, as tabulated by the CIE, and the integrals over them.

use crate::error::{Error, Result};
use glam::DVec3;
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Shortest wavelength of the colour integral \[µm\].
pub const SHORTEST: f64 = 0.380;
/// Longest wavelength of the colour integral \[µm\].
pub const LONGEST: f64 = 0.780;
/// Range of single wavelengths that are answered \[µm\]: from hard ultraviolet to far infrared.
pub const ANSWERED: (f64, f64) = (0.01, 100.0);
/// A wavelength in the middle of the visible range \[µm\], near the peak of the eye's sensitivity at 555 nm.
pub const MIDDLE: f64 = 0.55;
/// Distance of wavelengths to which a user's illuminant is resolved \[nm\]: colour integrals sample it 0.02 to 0.2 nm apart. A narrower line is spread over two
/// neighbours.
const RESOLUTION: f64 = 0.5;
/// Nanometres of a micrometre.
pub const NM_PER_UM: f64 = 1e3;
/// Peak of the blue colour function z̄ of the CIE 1931 observer \[µm\], rounded: coherence blurs directions least there.
pub const BLUE: f64 = 0.45;

/// Function of wavelength, tabulated at increasing wavelengths \[nm\], linear between them and 0 outside.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralTable<const N: usize> {
    wavelengths: Vec<f64>,
    values: Vec<[f64; N]>,
}

impl<const N: usize> Serialize for SpectralTable<N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let Self { wavelengths, values } = self;
        let values: Vec<&[f64]> = values.iter().map(|row| row.as_slice()).collect();
        (wavelengths, values).serialize(serializer)
    }
}

impl<const N: usize> SpectralTable<N> {
    /// Reads CSV with rows `wavelength,value…` \[nm\], below a line of names or without one.
    ///
    /// # Errors
    /// A row that is not N + 1 finite numbers, wavelengths that do not increase, fewer than two rows; the message
    /// names the line.
    pub fn parse(text: &str) -> Result<Self> {
        let table = Self::parse_rows(text)?;
        if table.wavelengths.len() < 2 {
            return Err(Error::input(
                "the spectrum has fewer than two rows",
                "give at least two wavelengths",
            ));
        }
        Ok(table)
    }

    /// Reads CSV like [`Self::parse`], also of a single row.
    ///
    /// # Errors
    /// Those of [`Self::parse`], and no row at all.
    pub fn parse_rows(text: &str) -> Result<Self> {
        let mut table = Self { wavelengths: Vec::new(), values: Vec::new() };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text); // spreadsheets write a byte order mark
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        for (index, record) in reader.records().enumerate() {
            let refuse = |line: u64, what: &str| {
                Error::input(
                    format!("line {line}: {what}"),
                    format!("write wavelength in nm and {N} value(s) a line, increasing"),
                )
            };
            let record = record.map_err(|e| {
                refuse(e.position().map_or(1, csv::Position::line), &e.to_string()).caused_by(e)
            })?;
            let cells: Vec<&str> = record.iter().collect();
            // A line of names has no number; a line with some numbers is a damaged row.
            if index == 0 && cells.iter().all(|cell| cell.parse::<f64>().is_err())
                || cells.iter().all(|cell| cell.is_empty())
            {
                continue;
            }
            let line = record.position().map_or(0, csv::Position::line);
            let bad = |what: &str| refuse(line, &format!("{what}: `{}`", cells.join(",")));
            let numbers = cells
                .iter()
                .map(|cell| cell.parse::<f64>().ok().filter(|x| x.is_finite()))
                .collect::<Option<Vec<f64>>>()
                .ok_or_else(|| bad("not a number"))?;
            let Some((&wavelength, rest)) = numbers.split_first() else { continue };
            let values = <[f64; N]>::try_from(rest).map_err(|_| bad("wrong number of values"))?;
            if table.wavelengths.last().is_some_and(|&last| wavelength <= last) {
                return Err(bad("wavelengths must increase"));
            }
            table.wavelengths.push(wavelength);
            table.values.push(values);
        }
        if table.wavelengths.is_empty() {
            return Err(Error::input("the table has no row", "give at least one wavelength"));
        }
        Ok(table)
    }

    /// Returns the table of the values of `of` at increasing `wavelengths` \[nm\].
    pub fn sampled(wavelengths: Vec<f64>, of: impl Fn(f64) -> [f64; N]) -> Self {
        Self { values: wavelengths.iter().map(|&x| of(x)).collect(), wavelengths }
    }

    /// Returns the wavelengths \[nm\].
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }

    /// Returns the table with all wavelengths multiplied by `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.wavelengths.iter_mut().for_each(|x| *x *= factor);
        self
    }

    /// Returns the rows up to a wavelength of `last` \[nm\], the first row in any case.
    #[must_use]
    pub fn up_to(mut self, last: f64) -> Self {
        let count = self.wavelengths.partition_point(|x| *x <= last).max(1);
        self.wavelengths.truncate(count);
        self.values.truncate(count);
        self
    }

    /// Returns the first and last wavelength \[nm\].
    pub fn ends(&self) -> [f64; 2] {
        [self.wavelengths[0], self.wavelengths[self.wavelengths.len() - 1]]
    }

    /// Returns true if `sane` is true for all values.
    pub fn all(&self, sane: impl FnMut([f64; N]) -> bool) -> bool {
        self.values.iter().copied().all(sane)
    }

    /// Returns the table with `of` applied to every value.
    pub fn map<const M: usize>(self, of: impl FnMut([f64; N]) -> [f64; M]) -> SpectralTable<M> {
        SpectralTable { wavelengths: self.wavelengths, values: self.values.into_iter().map(of).collect() }
    }

    /// Returns the values at `wavelength` \[nm\].
    pub fn at(&self, wavelength: f64) -> [f64; N] {
        let above = self.wavelengths.partition_point(|&x| x < wavelength);
        if above == self.wavelengths.len() || (above == 0 && self.wavelengths[0] > wavelength) {
            return [0.0; N];
        }
        if self.wavelengths[above] == wavelength {
            return self.values[above];
        }
        let (x0, x1) = (self.wavelengths[above - 1], self.wavelengths[above]);
        let t = (wavelength - x0) / (x1 - x0);
        std::array::from_fn(|i| (1.0 - t) * self.values[above - 1][i] + t * self.values[above][i])
    }
}

impl SpectralTable<1> {
    /// Returns the table averaged onto whole multiples of `step` \[nm\] by hat functions, if some of its wavelengths are closer; otherwise itself.
    ///
    /// Hat functions add up to 1 and reproduce straight lines, so that the energy and the mean wavelength of each line are kept.
    fn resolved_to(self, step: f64) -> Self {
        let segments = || self.wavelengths.windows(2).zip(self.values.windows(2));
        if segments().all(|(x, _)| x[1] - x[0] >= step) {
            return self;
        }
        let [first, last] = [SHORTEST, LONGEST].map(|x| x * NM_PER_UM);
        let count = ((last - first) / step).round() as usize + 1;
        let mut powers = vec![0.0; count];
        for (x, y) in segments() {
            let power = |at: f64| y[0][0] + (y[1][0] - y[0][0]) * (at - x[0]) / (x[1] - x[0]);
            let (begin, end) = (x[0].max(first), x[1].min(last));
            let mut left = begin;
            while left < end {
                let cell = (((left - first) / step).floor()).min(count as f64 - 2.0);
                let right = end.min(first + (cell + 1.0) * step);
                // Simpson's rule is exact for the product of two straight lines.
                for (at, weight) in [(left, 1.0), (0.5 * (left + right), 4.0), (right, 1.0)] {
                    let energy = weight / 6.0 * (right - left) * power(at) / step;
                    let share = (at - first) / step - cell;
                    powers[cell as usize] += energy * (1.0 - share);
                    powers[cell as usize + 1] += energy * share;
                }
                left = right;
            }
        }
        // A hat at an end of the range has half the area.
        powers[0] *= 2.0;
        powers[count - 1] *= 2.0;
        // One place beyond the given ones on either side: hats reach there.
        let place = |x: f64| ((x - first) / step).clamp(0.0, count as f64 - 1.0);
        let [given, end] = self.ends().map(place);
        let begin = (given.floor() as usize).saturating_sub(1).min(count - 2);
        let kept = begin..(end.ceil() as usize + 2).min(count);
        let wavelengths = kept.clone().map(|i| first + i as f64 * step).collect();
        Self { wavelengths, values: powers[kept].iter().map(|power| [*power]).collect() }
    }
}

/// Parses a built-in table.
#[expect(
    clippy::expect_used,
    reason = "the text is a part of the program, and a test of this module parses all of them"
)]
fn built_in<const N: usize>(text: &str) -> SpectralTable<N> {
    SpectralTable::parse(text).expect("a built-in table is sound")
}

/// Returns x̄, ȳ, z̄ of the CIE 1931 2° standard observer at `wavelength` \[nm\].
pub fn observer(wavelength: f64) -> DVec3 {
    static TABLE: OnceLock<SpectralTable<3>> = OnceLock::new();
    let table = TABLE.get_or_init(|| built_in(include_str!("../../assets/spectra/cie-1931-2deg.csv")));
    DVec3::from_array(table.at(wavelength))
}

/// Returns the middles of all half nanometres of the visible range \[nm\]. Sums over them are exact to 1e-6 on tables that are linear between whole
/// nanometres.
pub fn midpoints() -> impl Iterator<Item = f64> {
    (0..800).map(|i| 380.25 + 0.5 * f64::from(i))
}

/// Names of the built-in illuminants.
pub const BUILT_IN: [&str; 5] = ["d65", "d50", "a", "e", "led"];

/// Spectral power of the light, up to a factor.
#[derive(Clone, Debug, PartialEq, Default, Serialize)]
pub enum Illuminant {
    /// CIE D65, daylight, tabulated.
    #[default]
    D65,
    /// CIE D50, warm daylight of graphic arts: tabulated (CIE 15:2004).
    D50,
    /// CIE A, a tungsten lamp: Planck's law at 2848 K with c₂ = 1.435e7 nm K (CIE 15).
    A,
    /// Equal energy.
    E,
    /// CIE LED-B3, a blue LED with a phosphor, neutral white: tabulated (CIE 15:2018).
    Led,
    /// A user's table.
    Table(UserSpectrum),
}

/// Spectrum of a user, and the file that it was read from. Spectra of the same values are equal, whatever their files.
#[derive(Clone)]
pub struct UserSpectrum {
    table: SpectralTable<1>,
    // Empty for a spectrum that is from no file.
    file: PathBuf,
}

impl From<SpectralTable<1>> for UserSpectrum {
    fn from(table: SpectralTable<1>) -> Self {
        Self { table, file: PathBuf::new() }
    }
}

impl PartialEq for UserSpectrum {
    fn eq(&self, other: &Self) -> bool {
        self.table == other.table
    }
}

impl fmt::Debug for UserSpectrum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.table.fmt(f)
    }
}

impl Serialize for UserSpectrum {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.table.serialize(serializer)
    }
}

impl Illuminant {
    /// Returns the illuminant `d65`, `d50`, `a`, `e`, `led`, or that of a CSV file of wavelength \[nm\] and power.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, or that holds no light in 380–780 nm.
    pub fn from_name_or_file(name: impl AsRef<OsStr>) -> Result<Self> {
        let name = name.as_ref();
        Self::built_in(name).map_or_else(|| Self::from_file(Path::new(name)), Ok)
    }

    /// Returns one of [`BUILT_IN`], by its name.
    pub fn built_in(name: impl AsRef<OsStr>) -> Option<Self> {
        let name = name.as_ref();
        let known = [Self::D65, Self::D50, Self::A, Self::E, Self::Led];
        BUILT_IN
            .into_iter()
            .zip(known)
            .find(|(known_name, _)| name.eq_ignore_ascii_case(known_name))
            .map(|(_, known_name)| known_name)
    }

    /// Returns the name of a built-in illuminant, or the file of a user's.
    pub fn name(&self) -> Cow<'_, str> {
        match self {
            Self::D65 => "d65".into(),
            Self::D50 => "d50".into(),
            Self::A => "a".into(),
            Self::E => "e".into(),
            Self::Led => "led".into(),
            Self::Table(user) => user.file.to_string_lossy(),
        }
    }

    /// Returns the file of a user's spectrum; `None` for a built-in illuminant.
    pub fn file(&self) -> Option<&Path> {
        let Self::Table(user) = self else { return None };
        Some(&user.file)
    }

    /// Returns true if `name` is that of a built-in illuminant.
    pub fn is_built_in(name: impl AsRef<OsStr>) -> bool {
        Self::built_in(name).is_some()
    }

    /// Returns the first and last wavelength \[nm\] of a user's table that leaves out a part of the visible range.
    pub fn missing_light(&self) -> Option<[f64; 2]> {
        let Self::Table(UserSpectrum { table, .. }) = self else { return None };
        let ends = [*table.wavelengths.first()?, *table.wavelengths.last()?];
        (ends[0] > 1e3 * SHORTEST || ends[1] < 1e3 * LONGEST).then_some(ends)
    }

    fn from_file(path: &Path) -> Result<Self> {
        let text = crate::input::read_text(
            path,
            &format!("{} or a CSV file of wavelength in nm and power", BUILT_IN.join(", ")),
        )?;
        let mut light = Self::from_text(&text).map_err(|e| e.at(path.display()))?;
        if let Self::Table(user) = &mut light {
            path.clone_into(&mut user.file);
        }
        Ok(light)
    }

    /// Reads the illuminant in the text of a CSV file of wavelength \[nm\] and power.
    ///
    /// # Errors
    /// Those of [`SpectralTable::parse`]; a negative power; no light in 380–780 nm, or more than a number holds.
    pub fn from_text(text: &str) -> Result<Self> {
        let table = SpectralTable::<1>::parse(text)?;
        if table.values.iter().any(|v| v[0] < 0.0) {
            return Err(Error::input("an illuminant's power is negative", "give powers of at least 0"));
        }
        let light = Self::Table(table.resolved_to(RESOLUTION).into());
        let luminance = light.luminance();
        if luminance == f64::INFINITY {
            return Err(Error::input(
                "the illuminant's powers are too large for a number",
                "scale them down, only their ratios count",
            ));
        }
        if luminance > 0.0 {
            Ok(light)
        } else {
            Err(Error::input("the illuminant has no light in 380–780 nm", "give powers in that range"))
        }
    }

    /// Returns the spectral power at `wavelength` \[nm\].
    pub fn power(&self, wavelength: f64) -> f64 {
        match self {
            Self::D65 => {
                static TABLE: OnceLock<SpectralTable<1>> = OnceLock::new();
                TABLE.get_or_init(|| built_in(include_str!("../../assets/spectra/d65.csv"))).at(wavelength)[0]
            }
            Self::D50 => {
                static TABLE: OnceLock<SpectralTable<1>> = OnceLock::new();
                TABLE.get_or_init(|| built_in(include_str!("../../assets/spectra/d50.csv"))).at(wavelength)[0]
            }
            Self::A => {
                let planck = |x: f64| x.powi(-5) / ((1.435e7 / (2848.0 * x)).exp() - 1.0);
                100.0 * planck(wavelength) / planck(560.0)
            }
            Self::E => 100.0,
            Self::Led => {
                static TABLE: OnceLock<SpectralTable<1>> = OnceLock::new();
                let table = TABLE.get_or_init(|| built_in(include_str!("../../assets/spectra/led-b3.csv")));
                table.at(wavelength)[0]
            }
            Self::Table(user) => user.table.at(wavelength)[0],
        }
    }

    /// Returns ∫ S ȳ dλ \[nm\], the normalisation of every colour.
    pub fn luminance(&self) -> f64 {
        midpoints().map(|x| 0.5 * self.power(x) * observer(x).y).sum()
    }

    /// Returns S (x̄, ȳ, z̄) / ∫ S ȳ dλ at `wavelength` \[nm\], in nm⁻¹, given the normalisation from [`Self::luminance`].
    pub fn weight(&self, wavelength: f64, luminance: f64) -> DVec3 {
        observer(wavelength) * (self.power(wavelength) / luminance)
    }

    /// Returns XYZ of a white diffuse surface in this light, whose Y is 1.
    pub fn white(&self) -> DVec3 {
        let luminance = self.luminance();
        midpoints().map(|x| 0.5 * self.weight(x, luminance)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_tables_are_whole() {
        let observer: SpectralTable<3> =
            SpectralTable::parse(include_str!("../../assets/spectra/cie-1931-2deg.csv")).unwrap();
        assert_eq!(observer.wavelengths.len(), 401);
        let d65: SpectralTable<1> =
            SpectralTable::parse(include_str!("../../assets/spectra/d65.csv")).unwrap();
        assert_eq!((d65.wavelengths[0], d65.wavelengths[80]), (380.0, 780.0));
        for text in
            [include_str!("../../assets/spectra/d50.csv"), include_str!("../../assets/spectra/led-b3.csv")]
        {
            let table = SpectralTable::<1>::parse(text).unwrap();
            assert!(table.all(|[power]| power >= 0.0) && table.values.iter().any(|[power]| *power > 0.0));
        }
    }

    #[test]
    fn the_observer_has_its_published_values() {
        // CIE 15:2004 table: 555 nm, 450 nm, 600 nm.
        assert!((observer(555.0) - DVec3::new(0.512_050_1, 1.0, 0.005_749_999)).length() < 1e-6);
        assert!((observer(450.0) - DVec3::new(0.3362, 0.038, 1.77211)).length() < 1e-5);
        assert!((observer(600.0) - DVec3::new(1.0622, 0.631, 0.0008)).length() < 1e-5);
        assert_eq!(observer(379.0), DVec3::ZERO);
    }

    #[test]
    fn the_illuminants_have_their_published_white_points() {
        // CIE 15:2018, 2° observer.
        for (light, x, y) in [
            (Illuminant::D65, 0.3127, 0.3290),
            (Illuminant::D50, 0.3457, 0.3585),
            (Illuminant::A, 0.4476, 0.4074),
            (Illuminant::E, 1.0 / 3.0, 1.0 / 3.0),
            (Illuminant::Led, 0.3756, 0.3723),
        ] {
            let white = light.white();
            let sum = white.element_sum();
            assert!((white.x / sum - x).abs() < 2e-4, "{light:?}: x {}", white.x / sum);
            assert!((white.y / sum - y).abs() < 2e-4, "{light:?}: y {}", white.y / sum);
            assert!((white.y - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_table_with_a_bad_line_is_refused_by_its_line_number() {
        let error = SpectralTable::<1>::parse("wavelength,power\n380,1\n390,x\n").unwrap_err().to_string();
        assert!(error.contains("line 3"), "{error}");
        assert!(SpectralTable::<1>::parse("wavelength,power\n390,1\n380,1\n").is_err());
        assert!(SpectralTable::<1>::parse("").is_err());
    }

    #[test]
    fn a_first_row_of_numbers_is_data_and_one_of_names_is_not() {
        let expected = [[380.0, 1.0], [600.0, 2.0], [780.0, 1.0]];
        for text in [
            "380,1\n600,2\n780,1\n",
            "wavelength,power\n380,1\n600,2\n780,1\n",
            "\u{feff}380,1\n600,2\n780,1",
            "nm,W\r\n\r\n380, 1\r\n600 ,2\r\n780,\"1\"\r\n",
        ] {
            let table = SpectralTable::<1>::parse(text).unwrap();
            let rows: Vec<[f64; 2]> =
                table.wavelengths.iter().zip(&table.values).map(|(w, v)| [*w, v[0]]).collect();
            assert_eq!(rows, expected, "{text:?}");
        }
        // Neither names nor a row: something is lost.
        for text in ["380,power\n600,1\n780,1\n", "power,1\n600,1\n780,1\n", "380\n600,1\n780,1\n"] {
            assert!(SpectralTable::<1>::parse(text).unwrap_err().to_string().contains("line 1"), "{text:?}");
        }
    }

    #[test]
    fn a_spectrum_without_a_header_is_as_bright_as_the_one_with_it() {
        let rows = "380,1\n600,1\n780,1\n";
        let bare = Illuminant::from_text(rows).unwrap();
        let named = Illuminant::from_text(&format!("wavelength,power\n{rows}")).unwrap();
        assert_eq!(bare, named);
        let equal = Illuminant::E.luminance() / 100.0;
        assert!((bare.luminance() / equal - 1.0).abs() < 1e-12, "all of the visible range has power 1");
    }

    #[test]
    fn narrow_lines_keep_their_energy_and_their_wavelength() {
        let line = |middle: f64, half: f64| {
            let rows = [(middle - half, 0), (middle, 1), (middle + half, 0)];
            let text: Vec<_> = rows.iter().map(|(x, power)| format!("{x},{power}")).collect();
            SpectralTable::<1>::parse(&text.join("\n")).unwrap().resolved_to(RESOLUTION)
        };
        for (middle, half) in [(632.8, 0.01), (550.0, 0.3), (589.3, 0.05), (450.25, 0.4)] {
            let table = line(middle, half);
            let fine = (0..40_000).map(|i| 380.0 + 0.01 * (f64::from(i) + 0.5));
            let (mut energy, mut moment) = (0.0, 0.0);
            for x in fine {
                energy += 0.01 * table.at(x)[0];
                moment += 0.01 * table.at(x)[0] * x;
            }
            assert!((energy / half - 1.0).abs() < 1e-9, "{middle}: {energy}");
            assert!((moment / energy - middle).abs() < 1e-6, "{middle}: {}", moment / energy);
            let colour = Illuminant::Table(table.into()).white();
            let exact = observer(middle) / observer(middle).y;
            assert!((colour - exact).length() < 0.01 * exact.length(), "{middle}: {colour} {exact}");
        }
        // A spectrum that is cut off, sampled finely, and one that is coarse already.
        let fine: String = (0..=2000).map(|i| format!("{},2\n", 400.0 + 0.1 * f64::from(i))).collect();
        let table = SpectralTable::<1>::parse(&fine).unwrap().resolved_to(RESOLUTION);
        assert!((table.at(500.0)[0] - 2.0).abs() < 1e-12 && (table.at(400.0)[0] - 1.0).abs() < 1e-9);
        let coarse = SpectralTable::<1>::parse("380,1\n600,2\n").unwrap();
        assert_eq!(coarse.clone().resolved_to(RESOLUTION), coarse);
    }

    #[test]
    fn a_spectrum_that_leaves_out_visible_light_says_so() {
        let missing = |text: &str| Illuminant::from_text(text).unwrap().missing_light();
        assert_eq!(missing("380,1\n780,1\n"), None);
        assert_eq!(missing("300,1\n900,1\n"), None);
        assert_eq!(missing("400,1\n780,1\n"), Some([400.0, 780.0]));
        assert_eq!(missing("380,1\n700,1\n"), Some([380.0, 700.0]));
        assert_eq!(Illuminant::D65.missing_light(), None);
    }
}
