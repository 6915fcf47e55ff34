//! Options of the display of a picture.

use super::exposure;
use crate::error::Result;

/// The exposure of a display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Number of stops.
    Stops(f64),
    /// Measured from the picture.
    Auto,
}

impl Exposure {
    /// Parses a number of stops, or `auto`.
    ///
    /// # Errors
    /// Neither of them.
    pub fn parse(text: &str) -> Result<Self> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        exposure(text).map(Self::Stops).map_err(|e| e.or("auto"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exposure_is_a_number_of_stops_or_auto() {
        assert_eq!(Exposure::parse("auto").unwrap(), Exposure::Auto);
        assert_eq!(Exposure::parse("-2.5").unwrap(), Exposure::Stops(-2.5));
        for bad in ["", "Auto", "automatic", "41", "-41", "nan", "1EV"] {
            let e = Exposure::parse(bad).unwrap_err();
            assert!(
                e.kind() == crate::error::ErrorKind::Usage && e.to_string().contains("auto"),
                "{bad}: {e}"
            );
        }
    }
}
