//! Header of Radiance pictures (.hdr): exposures by which the pixels were multiplied (G. Ward, *Real Pixels*, Graphics Gems II, 1991; "Radiance File Formats",
//! `EXPOSURE` and `COLORCORR`). The decoder leaves them to its users.

use crate::error::{Error, Result};
use glam::DVec3;

/// Beginnings of a Radiance picture.
const SIGNATURES: [&[u8]; 2] = [b"#?RADIANCE", b"#?RGBE"];
/// Largest product of exposures, and 1 over the smallest: that of 100 stops is no camera's.
const LARGEST: f64 = 1e30;

/// Returns the divisor of each channel that turns pixels into radiance: the product of all exposures in the header of the picture `bytes`; 1 for pictures of
/// other formats.
///
/// # Errors
/// Fails for exposures that are no positive numbers.
pub fn exposure(bytes: &[u8]) -> Result<DVec3> {
    let mut product = DVec3::ONE;
    if !SIGNATURES.iter().any(|signature| bytes.starts_with(signature)) {
        return Ok(product);
    }
    // An empty line ends the header.
    for line in bytes.split(|byte| *byte == b'\n').take_while(|line| !line.trim_ascii().is_empty()) {
        let line = String::from_utf8_lossy(line);
        let Some((name, value)) = line.split_once('=') else { continue };
        let numbers: Option<Vec<f64>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
        let factor = match (name.trim(), numbers.as_deref()) {
            ("EXPOSURE", Some([exposure])) => DVec3::splat(*exposure),
            ("COLORCORR", Some([r, g, b])) => DVec3::new(*r, *g, *b),
            ("EXPOSURE" | "COLORCORR", _) => return Err(refused(&line)),
            _ => continue,
        };
        product *= factor;
        let is_sound = product.to_array().iter().all(|x| (1.0 / LARGEST..=LARGEST).contains(x));
        if factor.min_element() <= 0.0 || !is_sound {
            return Err(refused(&line));
        }
    }
    Ok(product)
}

fn refused(line: &str) -> Error {
    Error::input(format!("`{}` in the header is no exposure", line.trim()), "save the picture again")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(lines: &str) -> Result<DVec3> {
        exposure(format!("#?RADIANCE\n{lines}\n\n-Y 1 +X 1\nEXPOSURE=9").as_bytes())
    }

    #[test]
    fn exposures_of_the_header_multiply() {
        assert_eq!(of("FORMAT=32-bit_rle_rgbe").unwrap(), DVec3::ONE);
        assert_eq!(of("EXPOSURE=4").unwrap(), DVec3::splat(4.0));
        let both = of("# made by\nEXPOSURE= 2\nCOLORCORR= 1 2 4\nEXPOSURE=0.5\nCOLORCORR=3 1 1").unwrap();
        assert_eq!(both, DVec3::new(3.0, 2.0, 4.0));
        assert_eq!(exposure(b"v/1\x01EXPOSURE=4\n").unwrap(), DVec3::ONE, "another format");
    }

    #[test]
    fn what_is_no_exposure_is_refused() {
        for line in [
            "EXPOSURE=",
            "EXPOSURE=x",
            "EXPOSURE=0",
            "EXPOSURE=-1",
            "EXPOSURE=nan",
            "EXPOSURE=1e99",
            "COLORCORR=1",
        ] {
            let error = of(line).unwrap_err().to_string();
            assert!(error.contains(line) && error.contains("; "), "{error}");
        }
    }
}
