//! Sums over wavelengths in parts. Mesa's software devices end the loops of an invocation after 65 535 iterations in all, without a word, and
//! what they summed is lost. Its twin is `shaders/part.glsl`.

use bytemuck::{Pod, Zeroable};

/// Loop iterations of an invocation, at most: half of what such devices do, so that a part of the smallest tile takes some 50 ms at most and
/// a window answers in between.
const MOST_ITERATIONS: usize = 30_000;

/// Loop iterations of a sum over wavelengths, at most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Iterations {
    /// For one direction of light.
    pub of_pair: usize,
}

impl Iterations {
    /// Returns those of `wavelengths`, each of which takes `each` iterations beside its own.
    pub fn new(wavelengths: usize, each: usize) -> Self {
        Self { of_pair: wavelengths * (1 + each) }
    }

    /// Parts of the sum of a pair of directions.
    pub fn parts_of_pair(&self) -> u32 {
        parts(self.of_pair)
    }

    /// Parts of the sums of a pixel for so many directions of light.
    pub fn parts_of_pixel(&self, lights: usize) -> u32 {
        parts(self.of_pixel(lights))
    }

    /// Iterations of a pixel for so many directions of light, at most.
    pub fn of_pixel(&self, lights: usize) -> usize {
        self.of_pair * lights
    }
}

fn parts(iterations: usize) -> u32 {
    iterations.div_ceil(MOST_ITERATIONS).max(1) as u32
}

/// The wavelengths that an invocation adds: every `step`th from `first`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Part {
    /// Number of the first.
    pub first: u32,
    /// From one to the next.
    pub step: u32,
}

impl Part {
    /// All `parts` of a sum.
    pub fn each(parts: u32) -> impl Iterator<Item = Self> {
        (0..parts).map(move |first| Self { first, step: parts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_part_takes_more_iterations_than_a_device_may_do() {
        for (wavelengths, each, lights) in
            [(0, 0, 1), (81, 5, 8), (4097, 64, 8), (12_000, 4, 9), (30_001, 0, 1)]
        {
            let iterations = Iterations::new(wavelengths, each);
            let parts = iterations.parts_of_pixel(lights);
            let most = Part::each(parts).map(|part| {
                let count = (part.first as usize..wavelengths).step_by(part.step as usize).count();
                count * (1 + each) * lights
            });
            assert!(most.max().unwrap() < 65_535, "{wavelengths} wavelengths, {parts} parts");
            let all: usize = Part::each(parts)
                .map(|part| (part.first as usize..wavelengths).step_by(part.step as usize).count())
                .sum();
            assert_eq!(all, wavelengths);
        }
    }
}
