//! Kinds of lights, for each of which a stage that reads the G-buffer is compiled.

use crate::error::Result;
use crate::vk::pipeline::{Constant, Pipeline};

/// Light that a stage is compiled for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightKind {
    /// True for the surroundings, if their specular order is reflected separately.
    pub mirrored: bool,
    /// True for a lamp.
    pub lamp: bool,
    /// True if the light casts shadows.
    pub shadows: bool,
}

impl LightKind {
    /// Returns the constants of `light.glsl`.
    pub fn constants(self) -> [Constant; 3] {
        const MIRRORED: u32 = 3;
        const LAMP: u32 = 4;
        const SHADOWS: u32 = 5;
        [
            Constant::new(MIRRORED, self.mirrored),
            Constant::new(LAMP, self.lamp),
            Constant::new(SHADOWS, self.shadows),
        ]
    }
}

/// Pipelines of a stage, one for each kind of light that was drawn.
#[derive(Default)]
pub struct LightPipelines(Vec<(LightKind, Pipeline)>);

impl LightPipelines {
    /// Makes the pipeline for lights of this `kind` by `make`, unless it is there already.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn prepare(&mut self, kind: LightKind, make: impl FnOnce() -> Result<Pipeline>) -> Result<()> {
        if self.of(kind).is_none() {
            self.0.push((kind, make()?));
        }
        Ok(())
    }

    /// Returns the pipeline for lights of this `kind`, once it is prepared.
    pub fn of(&self, kind: LightKind) -> Option<&Pipeline> {
        self.0.iter().find(|(own, _)| *own == kind).map(|(_, pipeline)| pipeline)
    }
}
