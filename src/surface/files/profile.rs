//! Profiles of gratings as text: two columns, the place across the lines and the height there.

use super::scan::{Channel, Quantity, Scan};
use super::table::TextTable;
use super::units;
use crate::error::{Error, Result};
use crate::notes::PreparationRecord;

/// Fewest points of a profile. Two columns of fewer numbers may be anything.
const FEWEST_POINTS: usize = 4;
/// Largest difference of distances between points that counts as none, over their mean: the last digit of most files.
const EQUAL: f64 = 1e-2;
/// Most samples that a profile of unequal distances is interpolated at.
const MOST_SAMPLES: f64 = 4096.0;
/// Largest distance of lines \[m\]: light of 0.38 µm sees nothing finer than twice this.
const LINE_DISTANCE: f64 = 90e-9;
/// Smallest extent along the lines \[m\]: that of a patch for a colour table, with a margin.
const EXTENT: f64 = 1.3e-6;

/// Returns the grating whose profile `table` is; `None` if its first column does not grow or fall all along. A matrix of two columns is such a table by chance alone.
///
/// # Errors
/// Fails for a height that was not measured, which copies of the profile cannot do without, and for a unit that is no length.
pub fn read(table: &TextTable) -> Result<Option<Scan<'static>>> {
    let Some(points) = points(table) else { return Ok(None) };
    if let Some(i) = points.iter().position(|[_, h]| h.is_nan()) {
        return Err(Error::input(
            format!("is a profile whose height number {} was not measured", i + 1),
            "leave that row out: heights between points are interpolated",
        ));
    }
    let [x_unit, h_unit] = units(table)?;
    let (heights, spacing, told) = resampled(&points, x_unit.unwrap_or(1.0));
    let spacing_x = spacing * x_unit.unwrap_or(1.0);
    let spacing_y = spacing_x.min(LINE_DISTANCE);
    let (columns, rows) = (heights.len(), (EXTENT / spacing_y).ceil().clamp(1.0, MOST_SAMPLES) as usize);
    let metres = h_unit.unwrap_or(1.0);
    let decode = Box::new(move || {
        let line: Vec<f64> = heights.iter().map(|h| h * metres).collect();
        Ok(line.repeat(rows))
    });
    let channel = Channel {
        name: "Profile".to_owned(),
        unit: "m".to_owned(),
        size: [columns, rows],
        spacing: [Some(spacing_x), Some(spacing_y)],
        quantity: Quantity::Height,
        prepared: PreparationRecord::default(),
        decode,
    };
    let mut scan = Scan::single("profile", channel);
    scan.notes.push(match [x_unit, h_unit] {
        [None, None] => {
            "the two columns are the place and the height of a grating's profile, in metres".to_owned()
        }
        _ => "the two columns are the place and the height of a grating's profile".to_owned(),
    });
    scan.notes.extend(told);
    Ok(Some(scan))
}

/// Returns the points of a table of two columns, whose places grow; `None` if they neither grow nor fall all along.
fn points(table: &TextTable) -> Option<Vec<[f64; 2]>> {
    let mut points: Vec<[f64; 2]> = table.numbers.chunks_exact(2).map(|row| [row[0], row[1]]).collect();
    if table.columns != 2 || points.len() < FEWEST_POINTS {
        return None;
    }
    if points[1][0] < points[0][0] {
        points.reverse();
    }
    points.windows(2).all(|pair| pair[0][0] < pair[1][0]).then_some(points) // NaN is neither
}

/// Returns the metres of the units that the titles of place and height name; `None` for a title without one. Titles stand in the last line in front of the numbers, which may
/// be a comment.
///
/// # Errors
/// Fails for a unit of another quantity in titles that are no comment.
fn units(table: &TextTable) -> Result<[Option<f64>; 2]> {
    let Some(line) = table.head.last() else { return Ok([None; 2]) };
    let plain = line.trim_start_matches(['#', '%', '/']);
    let separators: &[char] = &[';', '\t', ','];
    let titles: Vec<&str> = if plain.contains(separators) {
        plain.split(separators).map(str::trim).filter(|title| !title.is_empty()).collect()
    } else {
        plain.split_whitespace().collect()
    };
    let [place, height] = titles[..] else { return Ok([None; 2]) };
    let metres = |title: &str| match unit(title) {
        "" => Ok(None),
        name if units::length(name).is_some() || !table.titled => Ok(units::length(name)),
        name => Err(Error::input(
            format!("is a profile in `{name}`, which is no length"),
            "write a column of places and one of heights, with their units in brackets",
        )),
    };
    Ok([metres(place)?, metres(height)?])
}

/// Returns the unit in a title such as `x [um]`, `height (nm)` or `z/nm`; empty if there is none.
fn unit(title: &str) -> &str {
    let bracketed = [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
        let (_, behind) = title.split_once(open)?;
        Some(behind.split(close).next().unwrap_or(behind))
    });
    let behind = |separator: char| title.rsplit_once(separator).map(|(_, last)| last);
    let last = bracketed.or_else(|| behind('/')).or_else(|| {
        // `height_nm` and `height nm` name a unit, `surface height` does not.
        behind('_').or_else(|| behind(' ')).filter(|word| units::length(word).is_some())
    });
    last.unwrap_or_default().trim()
}

/// Returns heights at equal distances along all of `points`, the distance, and a note if they had to be interpolated. A place is of this `unit` \[m\].
fn resampled(points: &[[f64; 2]], unit: f64) -> (Vec<f64>, f64, Option<String>) {
    let [first, last] = [points[0][0], points[points.len() - 1][0]];
    let steps = || points.windows(2).map(|pair| pair[1][0] - pair[0][0]);
    let (least, most) = steps().fold((f64::INFINITY, 0.0_f64), |(a, b), step| (a.min(step), b.max(step)));
    let mean = (last - first) / (points.len() - 1) as f64;
    if most - least <= EQUAL * mean {
        return (points.iter().map(|[_, h]| *h).collect(), mean, None);
    }
    let count = ((last - first) / least).ceil().clamp((points.len() - 1) as f64, MOST_SAMPLES);
    let spacing = (last - first) / count;
    let mut place = 0;
    let height = |i: usize| {
        let x = first + spacing * i as f64;
        while place + 2 < points.len() && points[place + 1][0] < x {
            place += 1;
        }
        let [[x0, h0], [x1, h1]] = [points[place], points[place + 1]];
        h0 + (h1 - h0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
    };
    let heights: Vec<f64> = (0..=count as usize).map(height).collect();
    let [least, most, distance] = [least, most, spacing].map(|length| 1e9 * unit * length);
    let note = format!(
        "the points of the profile are {least:.4} to {most:.4} nm apart: heights are interpolated at {} places, {distance:.4} nm apart",
        heights.len()
    );
    (heights, spacing, Some(note))
}

#[cfg(test)]
mod tests {
    use super::super::table::parse;
    use super::*;

    fn profile(text: &str) -> Option<Scan<'static>> {
        read(&parse(text).unwrap()).unwrap()
    }

    fn samples(scan: Scan<'static>) -> ([usize; 2], [f64; 2], Vec<f64>) {
        let channel = scan.channels.into_iter().next().unwrap();
        let (size, spacing) = (channel.size, channel.spacing.map(Option::unwrap));
        (size, spacing, channel.samples().unwrap())
    }

    #[test]
    fn two_columns_with_units_of_any_kind_are_the_profile_of_lines() {
        for text in [
            "x [um],h [nm]\n0,0\n0.1,50\n0.2,100\n0.3,50\n",
            "x (nm)\theight (um)\n0\t0\n100\t0.05\n200\t0.1\n300\t0.05\n",
            "x/nm;z/nm\n300;50\n200;100\n100;50\n0;0\n",
            "position_um, height_nm\n0, 0\n0.1, 50\n0.2, 100\n0.3, 50\n",
            "x_um h_nm\n0 0\n0.1 50\n0.2 100\n0.3 50\n",
            "# x[um] h[nm]\n0 0\n0.1 50\n0.2 100\n0.3 50\n",
            "# profile of a ruling\n# x (um), z (nm)\n0,0\n0.1,50\n0.2,100\n0.3,50\n",
            "0 0\n1e-7 5e-8\n2e-7 1e-7\n3e-7 5e-8\n",
        ] {
            let scan = profile(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(scan.notes.len(), 1, "{:?}", scan.notes);
            let ([columns, rows], spacing, heights) = samples(scan);
            assert!((spacing[0] - 1e-7).abs() < 1e-15 && spacing[1] * rows as f64 >= EXTENT, "{text}");
            assert_eq!(columns, 4);
            for line in heights.chunks_exact(columns) {
                let expected = [0.0, 5e-8, 1e-7, 5e-8];
                assert!(line.iter().zip(expected).all(|(h, e)| (h - e).abs() < 1e-18), "{text}: {line:?}");
            }
        }
    }

    #[test]
    fn unequal_distances_are_interpolated_and_told() {
        let scan = profile("x [um],h [um]\n0,0\n1,0\n1.25,0.2\n2,0.2\n").unwrap();
        assert!(scan.notes[1].contains("250.0000 to 1000.0000 nm apart"), "{:?}", scan.notes);
        let ([columns, _], spacing, heights) = samples(scan);
        assert!(columns == 9 && (spacing[0] - 0.25e-6).abs() < 1e-15);
        assert_eq!(
            heights[..columns].iter().map(|h| (h * 1e7).round()).collect::<Vec<_>>(),
            [0., 0., 0., 0., 0., 2., 2., 2., 2.]
        );
    }

    #[test]
    fn matrices_and_damaged_profiles_are_none() {
        assert!(profile("1 2\n3 4\n2 5\n6 7\n").is_none(), "it does not grow");
        assert!(profile("1 2\n3 4\n5 6\n").is_none(), "too few");
        assert!(profile("1 2 3\n4 5 6\n7 8 9\n10 11 12\n").is_none(), "three columns");
        assert!(profile("1 2\nnan 4\n5 6\n7 8\n").is_none(), "a place that is none");
        let error = |text: &str| read(&parse(text).unwrap()).err().unwrap().to_string();
        assert!(error("x,h\n0,1\n1,nan\n2,1\n3,1\n").contains("number 2"));
        assert!(error("x [um],h [V]\n0,1\n1,1\n2,1\n3,1\n").contains("`V`"));
    }
}
