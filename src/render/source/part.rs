//! Splitting of sums over wavelengths. Mesa's software devices silently end the loops of an invocation after 65 535
//! iterations in all, and the sum is lost. Its twin is `shaders/part.glsl`.

use bytemuck::{Pod, Zeroable};

/// Largest number of loop iterations per invocation: half the limit of these devices, so that a part of the smallest
/// tile takes about 50 ms at most and a window stays responsive.
const MOST_ITERATIONS: usize = 30_000;

/// Upper bound of the loop iterations of a sum over wavelengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Iterations {
    /// Iterations for one direction of light.
    pub of_pair: usize,
}

impl Iterations {
    /// Counts the iterations of `wavelengths`, each with an inner loop of `each` iterations.
    pub fn new(wavelengths: usize, each: usize) -> Self {
        Self { of_pair: wavelengths * (1 + each) }
    }

    /// Returns the number of parts of the sum of a pair of directions.
    pub fn parts_of_pair(&self) -> u32 {
        parts(self.of_pair)
    }

    /// Returns the number of parts of the sums of a pixel for `lights` directions of light.
    pub fn parts_of_pixel(&self, lights: usize) -> u32 {
        parts(self.of_pixel(lights))
    }

    /// Returns the largest number of iterations of a pixel for `lights` directions of light.
    pub fn of_pixel(&self, lights: usize) -> usize {
        self.of_pair * lights
    }
}

fn parts(iterations: usize) -> u32 {
    iterations.div_ceil(MOST_ITERATIONS).max(1) as u32
}

/// Wavelengths that an invocation sums: every `step`th from `first`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Part {
    /// Number of the first wavelength.
    pub first: u32,
    /// Increment of the number.
    pub step: u32,
}

impl Part {
    /// Iterates over all `parts` of a sum.
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
