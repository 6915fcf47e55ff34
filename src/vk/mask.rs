//! Hides capabilities of a device, so that tests on a capable device see the behaviour on a limited one.
//!
//! The environment variable `DIFFRACT_DEVICE_MASK` lists the capabilities to hide, separated by semicolons:
//!
//! | entry | effect |
//! | --- | --- |
//! | `memory=256MiB` | the driver provides at most this memory (`KiB`, `MiB`, `GiB`) |
//! | `allocation=7` | the seventh allocation of a resource fails |
//! | `submission=40` | the device is lost at the fortieth submission, and stays lost |
//! | `acquisition=3` | the window's surface is lost when its third image is acquired |
//! | `side=1024` | largest side of images |
//! | `layers=4` | largest number of array layers of images |
//! | `without=synchronization2` | a feature, format or version is missing, given by a part of its name in errors |
//!
//! A mask only removes capabilities. The errors are those of a device without these capabilities.

use crate::error::{Error, Result};

/// Name of the variable.
pub const VARIABLE: &str = "DIFFRACT_DEVICE_MASK";

/// Hidden capabilities.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mask {
    /// Largest memory \[bytes\].
    pub memory: Option<u64>,
    /// Number of the allocation that fails, from 1.
    pub allocation: Option<u64>,
    /// Number of the submission at which the device is lost, from 1.
    pub submission: Option<u64>,
    /// Number of the acquired window image at which the surface is lost, from 1.
    pub acquisition: Option<u64>,
    /// Longest side of an image \[texels\].
    pub side: Option<u32>,
    /// Largest number of array layers of an image.
    pub layers: Option<u32>,
    /// Parts of the names of missing capabilities.
    pub without: Vec<String>,
}

impl Mask {
    /// Returns the mask in the environment variable; an empty mask if it is not set.
    ///
    /// # Errors
    /// Same as [`Mask::parse`].
    pub fn from_environment() -> Result<Self> {
        match std::env::var_os(VARIABLE) {
            None => Ok(Self::default()),
            Some(text) => Self::parse(&text.to_string_lossy()).map_err(|e| e.at(VARIABLE)),
        }
    }

    /// Parses the mask in `text`.
    ///
    /// # Errors
    /// Fails on an entry that is not in the table above.
    pub fn parse(text: &str) -> Result<Self> {
        let mut mask = Self::default();
        for entry in text.split(';').map(str::trim).filter(|entry| !entry.is_empty()) {
            let refuse = || {
                Error::usage(
                    format!("unknown entry `{entry}`"),
                    "write memory=256MiB, allocation=7, submission=40, acquisition=3, side=1024, layers=4 or \
                     without=FEATURE, with ; between",
                )
            };
            let (key, value) = entry.split_once('=').ok_or_else(refuse)?;
            let (key, value) = (key.trim(), value.trim());
            let count = || value.parse::<u32>().ok().filter(|n| *n > 0).ok_or_else(refuse);
            match key {
                "memory" => mask.memory = Some(bytes(value).ok_or_else(refuse)?),
                "allocation" => mask.allocation = Some(count()?.into()),
                "submission" => mask.submission = Some(count()?.into()),
                "acquisition" => mask.acquisition = Some(count()?.into()),
                "side" => mask.side = Some(count()?),
                "layers" => mask.layers = Some(count()?),
                "without" if !value.is_empty() => mask.without.push(value.to_owned()),
                _ => return Err(refuse()),
            }
        }
        Ok(mask)
    }

    /// Returns true if the capability that errors call `name` is hidden.
    pub fn hides(&self, name: &str) -> bool {
        self.without.iter().any(|part| name.contains(part.as_str()))
    }
}

/// Parses a size such as `256MiB` in bytes.
fn bytes(text: &str) -> Option<u64> {
    let units = [("KiB", 1 << 10), ("MiB", 1 << 20), ("GiB", 1_u64 << 30)];
    let (number, unit) = units.iter().find_map(|(name, unit)| Some((text.strip_suffix(name)?, *unit)))?;
    number.trim_end().parse::<u64>().ok()?.checked_mul(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_is_read_entry_by_entry() {
        assert_eq!(Mask::parse(" ").unwrap(), Mask::default());
        let mask =
            Mask::parse("memory=3MiB; allocation=7;side=64 ;layers=2;without=dynamic;without=1.3;").unwrap();
        assert_eq!(
            (mask.memory, mask.allocation, mask.side, mask.layers),
            (Some(3 << 20), Some(7), Some(64), Some(2))
        );
        let losses = Mask::parse("submission=40;acquisition=3").unwrap();
        assert_eq!((losses.submission, losses.acquisition), (Some(40), Some(3)));
        assert!(mask.hides("dynamic rendering") && mask.hides("Vulkan 1.3") && !mask.hides("maintenance4"));
        assert!(!Mask::default().hides("anything"));
    }

    #[test]
    fn what_takes_nothing_away_is_refused() {
        for text in [
            "memory",
            "memory=",
            "memory=3",
            "memory=-3MiB",
            "memory=99999999999GiB",
            "side=0",
            "side=-1",
            "layers=1.5",
            "allocation=0",
            "submission=0",
            "acquisition=-1",
            "without=",
            "x=1",
            "=",
            "memory=1MiB,side=4",
        ] {
            assert_eq!(Mask::parse(text).unwrap_err().kind(), crate::error::ErrorKind::Usage, "{text}");
        }
    }
}
