//! Answers as JSON: what was asked, under which settings, and the rows of the table that the command writes.

use super::write::Csv;
use crate::notes::Notes;
use crate::optics::coherence::{Coherence, Windows};
use crate::settings::Optics;
use crate::surface::HeightField;
use serde::Serialize;
use serde_json::{Map, Number, Value};
use std::borrow::Cow;

/// The height field that a command was asked about. Lengths are metres.
#[derive(Clone, Debug, Serialize)]
pub struct AskedSurface {
    surface: String,
    samples: [usize; 2],
    spacing_m: [f64; 2],
    height_range_m: [f64; 2],
}

/// Metres of a micrometre.
const METRES: f64 = 1e-6;

impl AskedSurface {
    /// Describes `field`, which the user calls `name`.
    pub fn new(name: impl Into<String>, field: &HeightField) -> Self {
        let (low, high) = field.range();
        Self {
            surface: name.into(),
            samples: [field.columns(), field.rows()],
            spacing_m: field.pixel_size().map(|x| METRES * x),
            height_range_m: [METRES * low, METRES * high],
        }
    }
}

/// Settings of the optics. Lengths are micrometres, as on the command line.
#[derive(Clone, Debug, Serialize)]
pub struct AskedOptics {
    method: &'static str,
    coherence: Coherence,
    /// `all`, or the numbers of windows along x and y.
    windows: Value,
    beyond: &'static str,
    reflectance: String,
    illuminant: String,
    tolerance: f64,
}

impl AskedOptics {
    /// Describes `optics`.
    pub fn new(optics: &Optics) -> Self {
        Self {
            method: optics.method.name(),
            coherence: optics.coherence,
            windows: match optics.windows {
                Windows::All => "all".into(),
                Windows::Grid(grid) => grid.to_vec().into(),
            },
            beyond: optics.beyond.name(),
            reflectance: optics.reflectance.to_string(),
            illuminant: Cow::into_owned(optics.illuminant.name()),
            tolerance: optics.tolerance,
        }
    }
}

/// Answer of a command that writes a table.
#[derive(Serialize)]
pub struct TableAnswer<'a, S> {
    input: AskedSurface,
    settings: S,
    rows: Vec<Map<String, Value>>,
    origin: &'a Notes,
}

impl<'a, S: Serialize> TableAnswer<'a, S> {
    /// Returns the answer that `table` holds, about `input` under `settings`.
    pub fn new(input: AskedSurface, settings: S, table: &Csv, origin: &'a Notes) -> Self {
        Self { input, settings, rows: objects(table), origin }
    }
}

/// Returns an object for each row of `table`, with its columns as keys: numbers as numbers, empty cells as null.
pub fn objects(table: &Csv) -> Vec<Map<String, Value>> {
    let Some((header, rows)) = table.rows().split_first() else { return Vec::new() };
    let object = |row: &Vec<String>| header.iter().cloned().zip(row.iter().map(|cell| value(cell))).collect();
    rows.iter().map(object).collect()
}

fn value(cell: &str) -> Value {
    if cell.is_empty() {
        return Value::Null;
    }
    let whole = cell.parse::<i64>().ok().map(Number::from);
    let number = whole.or_else(|| Number::from_f64(cell.parse().ok()?));
    number.map_or_else(|| cell.into(), Value::Number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_numbers_texts_or_nothing() {
        let mut table = Csv::new();
        table.row(["m", "efficiency", "period", "name"]);
        table.row(["-2", "3.5e-1", "", "a, b"]);
        let objects = Value::from(objects(&table).into_iter().map(Value::from).collect::<Vec<_>>());
        let expected = serde_json::json!([{"m": -2, "efficiency": 0.35, "period": null, "name": "a, b"}]);
        assert_eq!(objects, expected);
        assert_eq!(value("nan"), Value::from("nan"));
    }
}
