//! Choice of the channel of a file that is the surface.

use super::scan::{Channel, Quantity, Scan};
use crate::error::{Error, Remedy, Result};

/// Words in the names of channels that are the surface, without spaces and in lower case.
const HEIGHTS: [&str; 6] = ["height", "topo", "zsensor", "zpiezo", "zscan", "surface"];

/// Words in the names of channels that are no surface, although files often give them a unit of length.
/// A phase in metres is one of an interferometer, and so a height.
const OTHERS: [&str; 11] = [
    "error",
    "deflection",
    "amplitude",
    "friction",
    "lateral",
    "current",
    "voltage",
    "potential",
    "adhesion",
    "deform",
    "dissipation",
];

/// Returns the index of the channel that is the surface: the one called `name` (or of that number, from 1), or else the first that is a
/// height by its unit and its name.
///
/// # Errors
/// No such channel; no name given and no channel that is a height or a grey image.
pub fn choose(scan: &Scan, name: Option<&str>) -> Result<usize> {
    let channels = &scan.channels;
    if let Some(name) = name {
        let by = |same: &dyn Fn(&Channel) -> bool| channels.iter().position(same);
        let number = name.trim().parse::<usize>().ok().filter(|n| (1..=channels.len()).contains(n));
        return by(&|c| c.name == name)
            .or_else(|| by(&|c| c.name.to_lowercase() == name.trim().to_lowercase()))
            .or(number.map(|n| n - 1))
            .ok_or_else(|| {
                Error::usage(
                    format!("there is no channel `{name}`"),
                    format!("give one of {}", names(channels)),
                )
            });
    }
    if let [_] = channels[..] {
        return Ok(0);
    }
    if scan.asks {
        return Err(Error::usage(
            format!("it has {} surfaces: {}", channels.len(), names(channels)),
            Remedy::Channel,
        ));
    }
    let plain = |c: &Channel| c.name.to_lowercase().replace([' ', '_', '-'], "");
    let has = |c: &Channel, words: &[&str]| words.iter().any(|word| plain(c).contains(word));
    let height = |c: &Channel| c.quantity == Quantity::Height && !has(c, &OTHERS);
    channels
        .iter()
        .position(|c| height(c) && has(c, &HEIGHTS))
        .or_else(|| channels.iter().position(height))
        .or_else(|| channels.iter().position(|c| matches!(c.quantity, Quantity::Code { .. })))
        .ok_or_else(|| {
            let names = names(channels);
            Error::usage(format!("no channel of it is a height: {names}"), Remedy::Channel)
        })
}

fn names(channels: &[Channel]) -> String {
    let name = |(i, c): (usize, &Channel)| format!("{} ({}, {})", i + 1, c.name, unit(&c.unit));
    channels.iter().enumerate().map(name).collect::<Vec<_>>().join(", ")
}

/// Returns a unit for messages.
pub fn unit(unit: &str) -> &str {
    if unit.is_empty() { "no unit" } else { unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(channels: &[(&str, &str)]) -> Scan<'static> {
        let channel = |(name, unit): &(&str, &str)| Channel {
            name: (*name).to_owned(),
            unit: (*unit).to_owned(),
            size: [1, 1],
            spacing: [Some(1.0); 2],
            quantity: if *unit == "m" { Quantity::Height } else { Quantity::Other },
            prepared: Default::default(),
            decode: Box::new(|| Ok(vec![0.0])),
        };
        Scan::new("test", channels.iter().map(channel).collect())
    }

    #[test]
    fn the_first_height_by_unit_and_name_is_the_surface() {
        let chosen = |channels: &[(&str, &str)]| choose(&scan(channels), None).unwrap();
        assert_eq!(
            chosen(&[("Deflection Error", "m"), ("Phase", "deg"), ("Height Sensor", "m"), ("Height", "m")]),
            2
        );
        assert_eq!(chosen(&[("Current", "m"), ("Mine", "m"), ("Z_Sensor", "m")]), 2);
        assert_eq!(chosen(&[("Intensity", ""), ("Phase", "m")]), 1, "of an interferometer");
        assert_eq!(chosen(&[("Amplitude", "m"), ("Mine", "m")]), 1, "no name says it, the unit does");
        assert_eq!(chosen(&[("Height", "V"), ("Mine", "m")]), 1);
        assert_eq!(chosen(&[("Phase", "deg")]), 0, "there is no other");
        assert!(choose(&scan(&[("Phase", "deg"), ("Amplitude", "m")]), None).is_err());
    }

    #[test]
    fn a_name_or_a_number_decides_and_an_unknown_name_is_told_all() {
        let scan = scan(&[("Height", "m"), ("Phase", "deg"), ("height", "m"), ("2", "m")]);
        let chosen = |name| choose(&scan, Some(name)).unwrap();
        assert_eq!([chosen("height"), chosen("PHASE"), chosen("2"), chosen("3")], [2, 1, 3, 2]);
        let e = choose(&scan, Some("Depth")).unwrap_err();
        assert!(
            e.kind() == crate::error::ErrorKind::Usage && e.to_string().contains("2 (Phase, deg)"),
            "{e}"
        );
    }
}
