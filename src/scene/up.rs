//! Axis of mesh files that points up.

use serde::{Deserialize, Serialize};

/// Axis of a mesh file that points up.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, Default, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// Second axis.
    #[default]
    Y,
    /// Third axis.
    Z,
}

impl Up {
    /// Returns the name of the axis.
    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}
