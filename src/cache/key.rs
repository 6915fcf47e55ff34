//! Keys of cached results: a hash of everything that they depend on.

use crate::error::{Error, Result};
use crate::surface::HeightField;
use serde::Serialize;

/// Kind of cached result, with the version of its files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryFormat {
    /// Name in the plural, which is the extension of the files: lower-case letters and `-`.
    pub name: &'static str,
    /// Version, which changes whenever the result of the same settings would change.
    pub version: u32,
}

/// Key of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key(blake3::Hash);

impl Key {
    /// Returns the key of the result of `format` for `settings` and `field`.
    ///
    /// `settings` are hashed as JSON: every field that they serialise counts, by its name and its exact value. A new field of a struct that
    /// derives `Serialize` changes the key without any change here. Numbers that are not finite count as absent, so that a setting may use
    /// only one of them.
    ///
    /// # Errors
    /// Settings that JSON cannot hold, such as maps whose keys are no text.
    pub fn new(format: &EntryFormat, settings: &impl Serialize, field: &HeightField) -> Result<Self> {
        let mut hasher = hasher_of(format, settings)?;
        hasher.update(bytemuck::cast_slice(&[field.columns() as u64, field.rows() as u64]));
        hasher.update(bytemuck::cast_slice(&field.pixel_size()));
        hasher.update_rayon(bytemuck::cast_slice(field.heights()));
        Ok(Self(hasher.finalize()))
    }

    /// Returns the key of a result of `format` that depends on `settings` alone, hashed as by [`Self::new`].
    ///
    /// # Errors
    /// Same as [`Self::new`].
    pub fn of_settings(format: &EntryFormat, settings: &impl Serialize) -> Result<Self> {
        Ok(Self(hasher_of(format, settings)?.finalize()))
    }

    /// Returns a key of `name` alone, for tests of readers without settings.
    pub fn named(name: &str) -> Self {
        Self(blake3::hash(name.as_bytes()))
    }

    /// Returns 64 hexadecimal digits.
    pub fn to_hex(&self) -> impl std::fmt::Display + use<> {
        self.0.to_hex()
    }

    pub(super) fn as_bytes(&self) -> &[u8; blake3::OUT_LEN] {
        self.0.as_bytes()
    }
}

/// Returns a hasher of `format` and `settings`.
fn hasher_of(format: &EntryFormat, settings: &impl Serialize) -> Result<blake3::Hasher> {
    let mut hasher = blake3::Hasher::new();
    let EntryFormat { name, version } = format;
    let json = serde_json::to_vec(&(name, version, settings))
        .map_err(|e| Error::bug(format!("the settings are no key ({e})")).caused_by(e))?;
    hasher.update(&(json.len() as u64).to_le_bytes());
    hasher.update(&json);
    Ok(hasher)
}
