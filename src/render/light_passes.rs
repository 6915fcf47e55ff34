//! Schedule of the lights that the samples of a picture draw.
//!
//! Light from all around varies less between samples than light of a lamp or of the sun, and costs as much to draw. In
//! a picture of many samples, every sample therefore draws the other lights, but only every fourth draws such
//! surroundings, with four times their weight.
//!
//! A sample draws the surroundings from many directions at once: each pixel takes one of them, and another in each pass.
//! The light and the shadow of a single direction would be a pattern over the whole picture; so they are fine noise, which
//! the samples and the pixel filter average.

use super::frame_set::{LIGHT_SLOTS, MOST_LIGHTS};
use super::sampling::{Sample, Sampling, hash};
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

/// Number of directions of the surroundings that a pixel takes in a sample, a power of two. With one, sixteen samples of the
/// default picture have a visible texture.
const TAKEN: u32 = 4;

/// Directions of the surroundings among which each pixel of a pass takes some: a block of [`LIGHT_SLOTS`] out of several.
/// The directions of a block are spread over all of the surroundings, and successive passes with the same block show each of
/// them to each pixel equally often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choices {
    /// Number of the block.
    pub block: u32,
    /// Number of blocks.
    pub blocks: u32,
    /// Place of the part of the block from which all pixels take their first direction \[2⁻³²\].
    pub turn: u32,
    /// Binary logarithm of the number of parts of the block, one for each direction that a pixel takes in the picture, within
    /// which pixels differ.
    pub parts: u32,
    /// Number of directions that a pixel takes, a power of two.
    pub taken: u32,
}

impl Choices {
    /// Returns the choices of pass number `pass` of `passes` by the sequence `seed`.
    fn new(pass: u32, passes: u32, seed: u64) -> Self {
        let slots = LIGHT_SLOTS as u32;
        // A whole number of slots.
        let turned = (hash(&[seed, 2]) as u32 % slots) << (u32::BITS - slots.trailing_zeros());
        let turn = (pass * TAKEN % slots).reverse_bits() ^ turned;
        // A pixel takes a direction of each part.
        let parts = (passes * TAKEN).min(slots).ilog2();
        Self { block: pass / slots, blocks: passes.div_ceil(slots), turn, parts, taken: TAKEN }
    }

    /// Iterates over choices of one direction each.
    fn each(self) -> impl Iterator<Item = Self> {
        (0..self.taken).map(move |number| Self { turn: self.turn_of(number), taken: 1, ..self })
    }

    /// Returns the turn of direction number `number` of a pixel.
    fn turn_of(&self, number: u32) -> u32 {
        self.turn ^ number.reverse_bits()
    }

    /// Returns the number of the direction in `slot` of the block, and the number of directions in all blocks.
    pub fn number(&self, slot: u32) -> (u32, u32) {
        (slot * self.blocks + self.block, LIGHT_SLOTS as u32 * self.blocks)
    }

    /// Returns the slot of the first direction of the `pixel`. Neighbouring pixels are far apart in a part of the block: they
    /// have the ranks of an 8 × 8 ordered dither (Bayer 1973), whose first bit is a checkerboard. Of all patterns of two
    /// equal halves, the pixel filter leaves least of that one: (2/π)⁶ = 0.07. Parts that lie side by side have the
    /// ranks in other orders, so that what pixels differ by has either sign. Twin of `slot_of` in `light.glsl`.
    pub fn slot(&self, [x, y]: [u32; 2]) -> u32 {
        let rank = |bit: u32| (((x ^ y) >> bit & 1) << 1 | (y >> bit & 1)) << (u32::BITS - 2 - 2 * bit);
        let rank = rank(0) | rank(1) | rank(2);
        // Bits of the number of the part turn the ranks, so that those of neighbouring parts, and of their neighbours, differ.
        let part = self.turn.checked_shr(u32::BITS - self.parts).unwrap_or(0).reverse_bits();
        let rank = rank ^ part ^ part << 2;
        ((rank >> self.parts) ^ self.turn) >> (u32::BITS - LIGHT_SLOTS.trailing_zeros())
    }
}

/// Lights that a sample of a picture draws together: consecutive ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPass {
    /// Number of the first light.
    pub light: usize,
    /// Number of lights, 1 … [`MOST_LIGHTS`].
    pub lights: usize,
    /// Sample: its position in the pixel, and its number among the samples that draw these lights.
    pub sample: Sample,
    /// Factor of the brightness: samples of the picture over samples that draw these lights, and over the directions that a
    /// pixel takes in each.
    pub weight: f64,
    /// True for the first lights of a sample, which count the covered pixels.
    pub is_first: bool,
    /// Directions of the surroundings, if the pixels choose among several; the pass then has no other light.
    pub choices: Option<Choices>,
}

impl LightPass {
    /// Returns the pass of light number `light` alone in a `sample` of a picture whose samples draw all lights.
    pub const fn of_all(light: usize, sample: Sample) -> Self {
        Self { light, lights: 1, sample, weight: 1.0, is_first: light == 0, choices: None }
    }

    /// Returns the place of light number `light` among the lights and depth maps of the pass. It is the same in all passes,
    /// so that a pass leaves the depth maps of other lights as they are. Directions that pixels choose take all places.
    pub fn place_of(&self, light: usize) -> usize {
        if self.choices.is_some() { 0 } else { light % MOST_LIGHTS }
    }

    /// Iterates over the numbers of the lights.
    pub fn numbers(&self) -> Range<usize> {
        self.light..self.light + self.lights
    }

    /// Iterates over passes of one light each, or of one direction of it.
    pub fn each_light(self) -> impl Iterator<Item = Self> {
        let choices: Vec<Option<Choices>> = match self.choices {
            Some(choices) => choices.each().map(Some).collect(),
            None => vec![None],
        };
        let of = move |(number, (light, choices))| Self {
            light,
            lights: 1,
            is_first: self.is_first && number == 0,
            choices,
            ..self
        };
        let each = self.numbers().flat_map(move |light| choices.clone().into_iter().map(move |c| (light, c)));
        each.enumerate().map(of)
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
    /// Number of lights that every sample draws together.
    lights: usize,
    /// Surroundings whose directions pixels choose.
    surroundings: Option<ChosenSurroundings>,
}

/// Schedule of surroundings whose directions pixels choose.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ChosenSurroundings {
    /// Number of the light.
    light: usize,
    /// Ratio of all samples to those that draw them.
    every: u32,
}

impl LightSchedule {
    /// Makes the schedule of pictures by `sampling` under `others` lights and, if `extent` is given, surroundings whose
    /// light comes from this solid angle \[sr\].
    pub fn new(others: usize, extent: Option<f64>, sampling: &Sampling) -> Self {
        // A single sample shows the mean direction: noise in a moving picture is worse than a pattern.
        let chosen = extent.filter(|_| sampling.count > 1);
        let surroundings = chosen.map(|extent| {
            let is_seldom = extent >= ALL_AROUND && others > 0 && sampling.count >= FEWEST * EVERY;
            ChosenSurroundings { light: others, every: if is_seldom { EVERY } else { 1 } }
        });
        let together = extent.is_some() && surroundings.is_none();
        Self { sampling: *sampling, lights: others + usize::from(together), surroundings }
    }

    /// Returns the number of samples drawn together; the last group of a picture may have fewer.
    fn group_size(&self) -> u32 {
        self.surroundings.map_or(1, |chosen| chosen.every)
    }

    /// Returns the group after the first `before` samples, a number of whole groups.
    pub fn after(&self, before: u32) -> SampleGroup {
        let samples = self.group_size().min(self.sampling.count.max(1).saturating_sub(before));
        let lights = |index| all_lights(self.lights, self.sampling.sample(index));
        // Without other lights the surroundings alone count the covered pixels.
        let is_alone = self.lights == 0 && self.surroundings.is_some();
        let with_others = if is_alone { before..before } else { before..before + samples };
        let mut passes: Vec<LightPass> = with_others.flat_map(lights).collect();
        if let Some(chosen) = self.surroundings.filter(|_| samples > 0) {
            passes.push(self.surroundings(chosen, before / chosen.every, is_alone));
        }
        SampleGroup { passes, samples }
    }

    /// Iterates over all groups of a picture.
    pub fn groups(&self) -> impl Iterator<Item = SampleGroup> {
        let firsts = (0..self.sampling.count.max(1)).step_by(self.group_size() as usize);
        firsts.map(|before| self.after(before))
    }

    /// Returns the pass of the surroundings in group number `group`.
    ///
    /// The groups use the pixel positions of the first samples in order, which are spread evenly over the pixel. Every
    /// fourth position would lie in one quarter of it. Other lights, if any, have counted the covered pixels already.
    fn surroundings(&self, chosen: ChosenSurroundings, group: u32, is_first: bool) -> LightPass {
        let count = self.sampling.count.div_ceil(chosen.every);
        let sample = Sample { count, ..self.sampling.sample(group) };
        let weight = f64::from(self.sampling.count) / f64::from(count * TAKEN);
        let choices = Some(Choices::new(group, count, self.sampling.seed));
        LightPass { light: chosen.light, lights: 1, sample, weight, is_first, choices }
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
                let each = group.passes.iter().flat_map(|pass| pass.each_light());
                let mut drawn: Vec<_> = each.map(|pass| (pass.light, pass.sample)).collect();
                drawn.dedup();
                let sample = sampling.sample(index as u32);
                let all = lights + usize::from(surrounded);
                let expected: Vec<_> = (0..all.max(1)).map(|light| (light, sample)).collect();
                assert_eq!((drawn, group.samples), (expected, 1));
                let first: Vec<_> = group.passes.iter().map(|pass| pass.is_first).collect();
                assert_eq!(first, (0..first.len()).map(|i| i == 0).collect::<Vec<_>>());
                // A single sample has one direction for all pixels.
                let chosen = group.passes.iter().filter(|pass| pass.choices.is_some()).count();
                assert_eq!(chosen, usize::from(surrounded && count > 1));
            }
        }
    }

    #[test]
    fn each_pixel_sees_each_direction_once_and_neighbours_see_others_at_a_time() {
        let slots = LIGHT_SLOTS as u32;
        let all = |passes: u32, seed| -> Vec<Choices> {
            (0..passes).flat_map(|pass| Choices::new(pass, passes, seed).each()).collect()
        };
        for (passes, seed) in [(slots / TAKEN, 3), (slots, 0), (4 * slots, 7)] {
            let choices = all(passes, seed);
            for pixel in [[0, 0], [639, 479], [16_383, 5]] {
                let mut seen: Vec<u32> = choices.iter().map(|c| c.number(c.slot(pixel)).0).collect();
                seen.sort_unstable();
                let directions = choices[0].number(0).1;
                let times = passes * TAKEN / directions;
                assert_eq!(seen, (0..passes * TAKEN).map(|i| i / times).collect::<Vec<_>>());
            }
        }
        // Four passes show a pixel one direction of each part.
        let choices = all(4, 3);
        let mut parts: Vec<u32> = choices.iter().map(|c| c.slot([5, 9]) / (slots / (4 * TAKEN))).collect();
        parts.sort_unstable();
        assert_eq!(parts, (0..4 * TAKEN).collect::<Vec<_>>());
        // Two neighbours see all directions.
        for pixel in [[101, 70], [100, 71]] {
            let mut near: Vec<u32> =
                [[100, 70], pixel].iter().flat_map(|p| choices.iter().map(|c| c.slot(*p))).collect();
            near.sort_unstable();
            assert_eq!(near, (0..slots).collect::<Vec<_>>());
        }
        // Eight pixels in a block of 4 × 2 see all directions in one pass.
        let one = all(1, 3);
        let pixels = (0..8).map(|i| [40 + i % 4, 30 + i / 4]);
        let mut near: Vec<u32> = pixels.flat_map(|pixel| one.iter().map(move |c| c.slot(pixel))).collect();
        near.sort_unstable();
        assert_eq!(near, (0..slots).collect::<Vec<_>>());
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
                let seldom = light == lights;
                let taken = if seldom { TAKEN } else { 1 };
                let numbers: Vec<u32> = of_light.iter().map(|pass| pass.sample.index).collect();
                let drawn = of_light.len() as u32 / taken;
                assert_eq!(numbers, (0..of_light.len() as u32).map(|i| i / taken).collect::<Vec<_>>());
                assert!(of_light.iter().all(|pass| pass.sample.count == drawn));
                let places =
                    |pass: &&LightPass| sampling.sample(pass.sample.index).jitter == pass.sample.jitter;
                assert!(of_light.iter().all(places));
                assert_eq!(drawn, if seldom { count.div_ceil(EVERY) } else { count });
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
