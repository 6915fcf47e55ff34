//! Runs of lights of one kind, for each of which a stage that reads the G-buffer is compiled.

use crate::error::Result;
use crate::vk::pipeline::{Constant, Pipeline};

/// Consecutive lights of one kind, which a stage is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightRun {
    /// Place of the first light in the `Frame` block.
    pub first: u32,
    /// Number of lights.
    pub lights: u32,
    /// True for the surroundings, if their specular order is reflected separately.
    pub mirrored: bool,
    /// True for lamps.
    pub lamp: bool,
    /// True if the lights cast shadows.
    pub shadows: bool,
    /// True if each pixel chooses one of the directions of the light.
    pub chosen: bool,
}

impl LightRun {
    /// Returns true if `next`, a single light, continues the run.
    pub fn is_continued_by(self, next: Self) -> bool {
        self.first + self.lights == next.first
            && Self { first: next.first, lights: next.lights, ..self } == next
    }

    /// Returns the constants of `light.glsl` and `shade.frag`.
    pub fn constants(self) -> [Constant; 6] {
        const MIRRORED: u32 = 3;
        const LAMP: u32 = 4;
        const SHADOWS: u32 = 5;
        const FIRST_LIGHT: u32 = 6;
        const LIGHTS: u32 = 7;
        const CHOSEN: u32 = 8;
        [
            Constant::new(MIRRORED, self.mirrored),
            Constant::new(LAMP, self.lamp),
            Constant::new(SHADOWS, self.shadows),
            Constant::new(FIRST_LIGHT, self.first),
            Constant::new(LIGHTS, self.lights),
            Constant::new(CHOSEN, self.chosen),
        ]
    }
}

/// Pipelines of a stage, one for each run of lights that was drawn.
#[derive(Default)]
pub struct LightPipelines(Vec<(LightRun, Pipeline)>);

impl LightPipelines {
    /// Makes the pipeline for `run` by `make`, unless it is there already.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn prepare(&mut self, run: LightRun, make: impl FnOnce() -> Result<Pipeline>) -> Result<()> {
        if self.of(run).is_none() {
            self.0.push((run, make()?));
        }
        Ok(())
    }

    /// Returns the pipeline for `run`, once it is prepared.
    pub fn of(&self, run: LightRun) -> Option<&Pipeline> {
        self.0.iter().find(|(compiled, _)| *compiled == run).map(|(_, pipeline)| pipeline)
    }
}
