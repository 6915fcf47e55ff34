//! Schedule of the lights that the samples of a picture draw.
//!
//! Light from all around varies less between samples than light of a lamp or of the sun, and costs as much to draw. In
//! a picture of many samples, every sample therefore draws the other lights, but only every fourth draws such
//! surroundings, with four times their weight.

use super::frame_set::MOST_LIGHTS;
use super::sampling::{Sample, Sampling};
use std::f64::consts::PI;
use std::ops::Range;

/// Ratio of all samples to those that draw the surroundings in addition to other lights.
///
/// In the default picture the sun makes forty times the noise that the sky makes
/// (docs/decisions/0015-lights-one-after-the-other.md).
const EVERY: u32 = 4;
/// Smallest solid angle of surroundings that count as light from all around \[sr\]: half a hemisphere. An overcast sky
/// has 6; a room with lamps and windows, which make distinct colours, less than 1.
const ALL_AROUND: f64 = PI;
/// Fewest samples that draw the surroundings if not all do: fewer do not represent all directions.
const FEWEST: u32 = 4;

/// Lights that a sample of a picture draws together: consecutive ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPass {
    /// Number of the first light.
    pub light: usize,
    /// Number of lights, 1 … [`MOST_LIGHTS`].
    pub lights: usize,
    /// Sample: its position in the pixel, and its number among the samples that draw these lights.
    pub sample: Sample,
    /// Factor of the brightness: samples of the picture over samples that draw these lights.
    pub weight: f64,
    /// True for the first lights of a sample, which count the covered pixels.
    pub is_first: bool,
}

impl LightPass {
    /// Returns the pass of light number `light` alone in a `sample` of a picture whose samples draw all lights.
    pub const fn of_all(light: usize, sample: Sample) -> Self {
        Self { light, lights: 1, sample, weight: 1.0, is_first: light == 0 }
    }

    /// Returns the place of light number `light` among the lights and depth maps of a pass. It is the same in all passes,
    /// so that a pass leaves the depth maps of other lights as they are.
    pub const fn place_of(light: usize) -> usize {
        light % MOST_LIGHTS
    }

    /// Iterates over the numbers of the lights.
    pub fn numbers(&self) -> Range<usize> {
        self.light..self.light + self.lights
    }

    /// Iterates over passes of one light each.
    pub fn each_light(self) -> impl Iterator<Item = Self> {
        let of =
            move |light| Self { light, lights: 1, is_first: self.is_first && light == self.light, ..self };
        self.numbers().map(of)
    }
}

/// Returns the passes of all `lights` in one `sample`; without lights, one dark pass.
pub fn all_lights(lights: usize, sample: Sample) -> Vec<LightPass> {
    let lights = lights.max(1);
    let first = (0..lights).step_by(MOST_LIGHTS);
    let pass =
        |light| LightPass { lights: MOST_LIGHTS.min(lights - light), ..LightPass::of_all(light, sample) };
    first.map(pass).collect()
}

/// Samples that are drawn together, so that their mean contains all lights.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleGroup {
    /// Passes, drawn one after the other.
    pub passes: Vec<LightPass>,
    /// Number of samples.
    pub samples: u32,
}

/// Schedule of lights of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSchedule {
    sampling: Sampling,
    /// Number of lights that every sample draws.
    lights: usize,
    /// Number of the surroundings, if only some samples draw them.
    seldom: Option<usize>,
}

impl LightSchedule {
    /// Makes the schedule of pictures by `sampling` under `others` lights and, if `extent` is given, surroundings whose
    /// light comes from this solid angle \[sr\].
    pub fn new(others: usize, extent: Option<f64>, sampling: &Sampling) -> Self {
        let even = extent.is_some_and(|extent| extent >= ALL_AROUND);
        let enough = others > 0 && sampling.count >= FEWEST * EVERY;
        let seldom = (even && enough).then_some(others);
        let lights = if seldom.is_some() { others } else { others + usize::from(extent.is_some()) };
        Self { sampling: *sampling, lights, seldom }
    }

    /// Returns the number of samples drawn together; the last group of a picture may have fewer.
    fn group_size(&self) -> u32 {
        if self.seldom.is_some() { EVERY } else { 1 }
    }

    /// Returns the group after the first `before` samples, a number of whole groups.
    pub fn after(&self, before: u32) -> SampleGroup {
        let samples = self.group_size().min(self.sampling.count.max(1).saturating_sub(before));
        let lights = |index| all_lights(self.lights, self.sampling.sample(index));
        let mut passes: Vec<LightPass> = (before..before + samples).flat_map(lights).collect();
        if let Some(light) = self.seldom.filter(|_| samples > 0) {
            passes.push(self.surroundings(light, before / EVERY));
        }
        SampleGroup { passes, samples }
    }

    /// Iterates over all groups of a picture.
    pub fn groups(&self) -> impl Iterator<Item = SampleGroup> {
        let firsts = (0..self.sampling.count.max(1)).step_by(self.group_size() as usize);
        firsts.map(|before| self.after(before))
    }

    /// Returns the pass of the surroundings, light number `light`, in group number `group`.
    ///
    /// The groups use the pixel positions of the first samples in order, which are spread evenly over the pixel. Every
    /// fourth position would lie in one quarter of it. The other lights have counted the covered pixels already.
    fn surroundings(&self, light: usize, group: u32) -> LightPass {
        let count = self.sampling.count.div_ceil(EVERY);
        let sample = Sample { count, ..self.sampling.sample(group) };
        let weight = f64::from(self.sampling.count) / f64::from(count);
        LightPass { light, lights: 1, sample, weight, is_first: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Environment;

    /// Returns the schedule under `others` lights, with a sky if `surrounded`.
    fn schedule(others: usize, surrounded: bool, sampling: &Sampling) -> LightSchedule {
        LightSchedule::new(others, surrounded.then_some(6.0), sampling)
    }

    #[test]
    fn surroundings_of_small_bright_parts_are_drawn_by_every_sample() {
        for (name, groups) in [("sky", 16), ("studio", 64)] {
            let extent = Environment::open(name).unwrap().extent();
            let schedule = LightSchedule::new(1, Some(extent), &Sampling { count: 64, seed: 0 });
            assert_eq!(schedule.groups().count(), groups, "{name}");
        }
    }

    #[test]
    fn few_samples_draw_all_lights_and_so_do_those_without_surroundings_or_with_nothing_else() {
        for (lights, surrounded, count) in
            [(0, false, 64), (1, false, 64), (5, false, 64), (0, true, 64), (1, true, 15), (2, true, 1)]
        {
            let sampling = Sampling { count, seed: 5 };
            let groups: Vec<SampleGroup> = schedule(lights, surrounded, &sampling).groups().collect();
            assert_eq!(groups.len(), count as usize);
            for (index, group) in groups.into_iter().enumerate() {
                let passes = all_lights(lights + usize::from(surrounded), sampling.sample(index as u32));
                assert_eq!(group, SampleGroup { passes, samples: 1 });
            }
        }
    }

    #[test]
    fn of_many_samples_every_fourth_draws_the_surroundings_as_brightly_as_all_would() {
        for (lights, count) in [(1, 16), (1, 64), (1, 50), (3, 29)] {
            let sampling = Sampling { count, seed: 1 };
            let groups: Vec<SampleGroup> = schedule(lights, true, &sampling).groups().collect();
            assert_eq!(groups.iter().map(|group| group.samples).sum::<u32>(), count);
            let all: Vec<LightPass> =
                groups.iter().flat_map(|group| &group.passes).flat_map(|pass| pass.each_light()).collect();
            assert_eq!(all.iter().filter(|pass| pass.is_first).count(), count as usize);
            for light in 0..=lights {
                let of_light: Vec<&LightPass> = all.iter().filter(|pass| pass.light == light).collect();
                let weights: f64 = of_light.iter().map(|pass| pass.weight).sum();
                assert!((weights - f64::from(count)).abs() < 1e-9, "{count}: {weights}");
                let numbers: Vec<u32> = of_light.iter().map(|pass| pass.sample.index).collect();
                assert_eq!(numbers, (0..of_light.len() as u32).collect::<Vec<_>>());
                assert!(of_light.iter().all(|pass| pass.sample.count == of_light.len() as u32));
                let places =
                    |pass: &&LightPass| sampling.sample(pass.sample.index).jitter == pass.sample.jitter;
                assert!(of_light.iter().all(places));
                let seldom = light == lights;
                assert_eq!(of_light.len() as u32, if seldom { count.div_ceil(EVERY) } else { count });
                let in_group = |group: &SampleGroup| {
                    group.passes.iter().filter(|pass| pass.numbers().contains(&light)).count() as u32
                };
                assert!(groups.iter().all(|group| in_group(group) == if seldom { 1 } else { group.samples }));
            }
        }
    }

    #[test]
    fn many_lights_are_drawn_in_passes_of_at_most_eight() {
        let sample = Sampling::ONE.sample(0);
        for (lights, passes) in
            [(0, vec![1]), (1, vec![1]), (8, vec![8]), (9, vec![8, 1]), (20, vec![8, 8, 4])]
        {
            let all = all_lights(lights, sample);
            assert_eq!(all.iter().map(|pass| pass.lights).collect::<Vec<_>>(), passes);
            let each: Vec<_> = all.into_iter().flat_map(LightPass::each_light).collect();
            let alone: Vec<_> = (0..lights.max(1)).map(|light| LightPass::of_all(light, sample)).collect();
            assert_eq!(each, alone);
        }
    }

    #[test]
    fn a_picture_goes_on_where_it_was() {
        let schedule = schedule(1, true, &Sampling { count: 18, seed: 0 });
        let mut before = 0;
        for group in schedule.groups() {
            assert_eq!(schedule.after(before), group);
            before += group.samples;
        }
        assert_eq!((before, schedule.after(16).samples, schedule.after(18).passes.len()), (18, 2, 0));
    }
}
