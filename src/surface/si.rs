//! Serialises micrometres as metres, the unit of machine-readable output.

use serde::{Serialize, Serializer};

/// Metres in a micrometre.
const METRES: f64 = 1e-6;

pub(super) fn metres<S: Serializer>(um: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    (um * METRES).serialize(serializer)
}

pub(super) fn metres_of_option<S: Serializer>(um: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    um.map(|um| um * METRES).serialize(serializer)
}

pub(super) fn metres_of_both<S: Serializer>(um: &[f64; 2], serializer: S) -> Result<S::Ok, S::Error> {
    um.map(|um| um * METRES).serialize(serializer)
}

pub(super) fn per_metre_of_both<S: Serializer>(per_um: &[f64; 2], serializer: S) -> Result<S::Ok, S::Error> {
    per_um.map(|per_um| per_um / METRES).serialize(serializer)
}

pub(super) fn metres_of_some<S: Serializer>(um: &[Option<f64>; 2], serializer: S) -> Result<S::Ok, S::Error> {
    um.map(|um| um.map(|um| um * METRES)).serialize(serializer)
}
