//! Tables of refractive indices in the forms that people have: CSV of wavelength, n and k, or a block of n and below it a block of k, as refractiveindex.info
//! exports them. Wavelengths are in nm or µm.

use super::spectrum::{NM_PER_UM, SpectralTable};
use crate::error::{Error, Result};

/// Wavelength below which a table's last one counts as µm \[unit of the table\]: light that short, 100 nm, is in no table of visible light.
const LONGEST_MICROMETRES: f64 = 100.0;
/// Longest wavelength that is kept \[nm\]: beyond it metals have indices of several hundred, and no command asks for them.
const LONGEST_KEPT: f64 = 10.0 * NM_PER_UM;
/// First words of columns of wavelengths in µm: `wl` is that of refractiveindex.info.
const MICROMETRE_COLUMNS: [&str; 6] = ["wl", "um", "µm", "μm", "micron", "microns"];

/// Returns n and k over the wavelength \[nm\] of the table in `text`, which may have a single row.
///
/// # Errors
/// Fails for columns in another order, for a row that is none, and for blocks of n and k that have no wavelength in common.
pub fn read(text: &str) -> Result<SpectralTable<2>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let second = second_header(text);
    let (first, rest) = text.split_at(second.unwrap_or(text.len()));
    check_columns(&columns(first))?;
    let table = match second {
        None => one_block(first)?,
        Some(_) => {
            check_second(&columns(rest)).map_err(|e| e.at(format!("line {}", lines(first) + 1)))?;
            // Empty lines in place of the first block keep the numbers of lines in errors.
            let below = "\n".repeat(lines(first)) + rest;
            joined(&SpectralTable::<1>::parse_rows(first)?, &SpectralTable::<1>::parse_rows(&below)?)?
        }
    };
    let [_, last] = table.ends();
    let is_micrometres = names_micrometres(first).unwrap_or(last < LONGEST_MICROMETRES);
    let table = if is_micrometres { table.scaled(NM_PER_UM) } else { table };
    Ok(table.up_to(LONGEST_KEPT))
}

/// Reads rows of wavelength, n and k, or of wavelength and n.
fn one_block(text: &str) -> Result<SpectralTable<2>> {
    let of_three = SpectralTable::<2>::parse_rows(text);
    of_three.or_else(|e| {
        let of_two = SpectralTable::<1>::parse_rows(text).map_err(|_| e)?; // neither three columns nor two
        Ok::<_, Error>(of_two.map(|[n]| [n, 0.0]))
    })
}

/// Returns n and k of two tables at the wavelengths of both, where both are given.
fn joined(n: &SpectralTable<1>, k: &SpectralTable<1>) -> Result<SpectralTable<2>> {
    let ([first_n, last_n], [first_k, last_k]) = (n.ends(), k.ends());
    let (first, last) = (first_n.max(first_k), last_n.min(last_k));
    if first > last {
        return Err(Error::input(
            format!(
                "n is given from {first_n} to {last_n} and k from {first_k} to {last_k}, at other wavelengths"
            ),
            "give n and k at the same wavelengths",
        ));
    }
    let mut wavelengths = [n.wavelengths(), k.wavelengths()].concat();
    wavelengths.retain(|x| (first..=last).contains(x));
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    Ok(SpectralTable::sampled(wavelengths, |x| [n.at(x)[0], k.at(x)[0]]))
}

/// Returns the place of a second line of names below rows of numbers.
fn second_header(text: &str) -> Option<usize> {
    let mut has_rows = false;
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let is_names = cells(line).iter().all(|cell| !cell.is_empty() && cell.parse::<f64>().is_err());
        if is_names && has_rows {
            return Some(start);
        }
        has_rows |= !is_names && !line.trim().is_empty();
        start += line.len();
    }
    None
}

fn lines(text: &str) -> usize {
    text.matches('\n').count()
}

fn cells(line: &str) -> Vec<&str> {
    line.split(',').map(|cell| cell.trim().trim_matches('"').trim()).collect()
}

/// Returns the names of the columns in the first line of `text`, in lower case. A unit may follow a name, as in `wavelength [nm]`.
fn columns(text: &str) -> Vec<String> {
    let first = text.lines().next().unwrap_or("");
    let name = |cell: &&str| cell.split_whitespace().next().unwrap_or("").to_ascii_lowercase();
    cells(first).iter().map(name).collect()
}

/// Returns true if the first column is named as one in µm, false if as one in nm; `None` if it names no unit.
fn names_micrometres(text: &str) -> Option<bool> {
    let first = text.lines().next().and_then(|line| line.split(',').next()).unwrap_or("");
    let first = first.to_lowercase();
    let mut words = first.split(|c: char| !c.is_alphabetic()).filter(|word| !word.is_empty());
    words.find_map(|word| match word {
        "nm" => Some(false),
        word => MICROMETRE_COLUMNS.contains(&word).then_some(true),
    })
}

/// Fails if the names are those of columns in another order than wavelength, n, k.
fn check_columns(names: &[String]) -> Result<()> {
    let is_at =
        |place: usize, known: &str| names.iter().position(|name| name == known).is_none_or(|p| p == place);
    if is_at(1, "n") && is_at(2, "k") && is_at(0, "wavelength") && is_at(0, "wl") {
        return Ok(());
    }
    Err(Error::input(
        format!("line 1: the columns are {}", names.join(", ")),
        "write the columns wavelength (nm or µm), n and k, in this order",
    ))
}

/// Fails unless the second block has a column k alone.
fn check_second(names: &[String]) -> Result<()> {
    if names.len() == 2 && names[1] == "k" {
        return Ok(());
    }
    Err(Error::input(
        format!("a second block has the columns {}", names.join(", ")),
        "write wavelength and k below wavelength and n, as refractiveindex.info does, or all in one block",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_blocks_of_refractiveindex_info_are_one_table() {
        let table = read("wl,n\n0.4,1.5\n0.5,1.6\n0.7,1.7\nwl,k\n0.4,0\n0.6,2\n0.7,3\n").unwrap();
        assert_eq!(table.wavelengths(), [400.0, 500.0, 600.0, 700.0]);
        assert_eq!(table.at(500.0), [1.6, 1.0]);
        assert!((table.at(600.0)[0] - 1.65).abs() < 1e-12 && table.at(600.0)[1] == 2.0);
        // n alone, k alone beyond n, and Windows' ends of lines.
        assert_eq!(read("wl,n\r\n0.4,1.5\r\n0.7,1.7\r\n").unwrap().at(700.0), [1.7, 0.0]);
        assert_eq!(
            read("wl,n\r\n0.4,2\r\n0.7,2\r\n\r\nwl,k\r\n0.3,1\r\n0.9,1\r\n").unwrap().ends(),
            [400.0, 700.0]
        );
    }

    #[test]
    fn units_are_named_or_told_from_the_numbers() {
        for (text, ends) in [
            ("400,1\n700,1\n", [400.0, 700.0]),
            ("0.4,1\n0.7,1\n", [400.0, 700.0]),
            ("wavelength (um),n\n0.4,1\n0.7,1\n", [400.0, 700.0]),
            ("wavelength [µm],n,k\n0.4,1,1\n0.7,1,1\n", [400.0, 700.0]),
            ("wavelength [nm],n\n40,1\n70,1\n", [40.0, 70.0]),
            ("wl,n\n0.4,1\n0.7,1\n125,300\n", [400.0, 700.0]),
            ("0.6328,1.5,0.1\n", [632.8, 632.8]),
        ] {
            let found = read(text).unwrap().ends();
            assert!(found.iter().zip(ends).all(|(a, b)| (a - b).abs() < 1e-9), "{text:?}: {found:?}");
        }
    }

    #[test]
    fn blocks_that_do_not_belong_together_are_refused_by_line() {
        for (text, said) in [
            ("wl,k\n0.4,1\n", "columns are wl, k"),
            ("wl,n\n0.4,1\n0.5,1\nwl,n\n0.4,1\n", "line 4: a second block"),
            ("wl,n\n0.4,1\n0.5,1\nwl,k\n0.6,1\n0.7,1\n", "other wavelengths"),
            ("wl,n\n0.4,1\n0.5,1\nwl,k\n0.4,1\n0.5,x\n", "line 6"),
            ("n,wl\n1,0.4\n", "columns are n, wl"),
            ("wl,n\nwl,k\n", "line 2"),
            ("", "no row"),
        ] {
            let e = read(text).unwrap_err().to_string();
            assert!(e.contains(said) && e.contains("; "), "{text:?}: {e}");
        }
    }
}
