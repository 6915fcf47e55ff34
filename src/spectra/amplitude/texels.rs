//! Texels of the layers, in 32 or 16 bits.

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use rayon::prelude::*;

/// RGBA texels (Re, Im of a term, Re, Im of the next), one after the other.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 32-bit floats.
    Single(Vec<f32>),
    /// The bits of 16-bit floats in units of [`HALF_UNIT`]: half the memory to read, and a rounding of up to 4.9e-4.
    Half(Vec<u16>),
}

/// Value of a stored 1 of 16-bit floats: 16 times the specular peak is below their end, 65504, and 1e-8 of the peak is above the limit of
/// full precision, 6.1e-5.
pub const HALF_UNIT: f32 = 1.0 / 4096.0;

/// Numbers that a thread converts at once: enough work for a thread, and small enough for its cache.
const TOGETHER: usize = 1 << 16;

impl Texels {
    /// Rounds `value` to 16 bits.
    pub fn halved(value: f32) -> f32 {
        f16::from_f32(value / HALF_UNIT).to_f32() * HALF_UNIT
    }

    /// Stores `values`, in 16 bits if `half`; they have to fit then.
    pub fn of(half: bool, values: Vec<f32>) -> Self {
        if !half {
            return Self::Single(values);
        }
        let mut halves = vec![0u16; values.len()];
        let scaled = |values: &[f32]| -> Vec<f32> { values.iter().map(|v| v / HALF_UNIT).collect() };
        halves.par_chunks_mut(TOGETHER).zip(values.par_chunks(TOGETHER)).for_each(|(halves, values)| {
            halves.reinterpret_cast_mut::<f16>().convert_from_f32_slice(&scaled(values));
        });
        Self::Half(halves)
    }

    /// Returns true if 16 bits hold `values`.
    pub fn fit_halves(values: &[f32]) -> bool {
        let most = f16::MAX.to_f32() * HALF_UNIT;
        values.iter().all(|v| v.abs() <= most)
    }

    /// Returns the number of floats, four to a texel.
    pub fn len(&self) -> usize {
        match self {
            Self::Single(stored) => stored.len(),
            Self::Half(stored) => stored.len(),
        }
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns true for 16-bit floats.
    pub fn is_half(&self) -> bool {
        matches!(self, Self::Half(_))
    }

    /// Returns number `index`.
    pub fn at(&self, index: usize) -> f32 {
        match self {
            Self::Single(stored) => stored[index],
            Self::Half(stored) => f16::from_bits(stored[index]).to_f32() * HALF_UNIT,
        }
    }

    /// Returns the value of a stored 1.
    pub fn unit(&self) -> f32 {
        if self.is_half() { HALF_UNIT } else { 1.0 }
    }

    /// Returns the stored bytes.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Single(stored) => bytemuck::cast_slice(stored),
            Self::Half(stored) => bytemuck::cast_slice(stored),
        }
    }

    /// Returns a buffer of `count` zeros, of 16 bits if `half`, into which bytes are read.
    pub fn zeroed(half: bool, count: usize) -> Self {
        if half { Self::Half(vec![0; count]) } else { Self::Single(vec![0.0; count]) }
    }

    /// Returns true if all numbers are finite.
    pub fn are_finite(&self) -> bool {
        // Mask of the exponent, all ones for infinities and NaN. There is no early exit, so that the loop is vectorised.
        const SINGLE: u32 = 0x7f80_0000;
        const HALF: u16 = 0x7c00;
        match self {
            Self::Single(stored) => stored
                .par_chunks(TOGETHER)
                .all(|part| part.iter().fold(true, |all, x| all & (x.to_bits() & SINGLE != SINGLE))),
            Self::Half(stored) => stored
                .par_chunks(TOGETHER)
                .all(|part| part.iter().fold(true, |all, x| all & (x & HALF != HALF))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_width_rounds_by_less_than_a_thousandth_from_the_peak_to_what_is_too_faint_to_judge() {
        let values: Vec<f32> = (0..200).map(|i| 10f32.powf(-7.0 * i as f32 / 200.0)).collect();
        let texels = Texels::of(true, values.clone());
        assert!(texels.bytes().len() == 400 && texels.are_finite());
        for (i, v) in values.iter().enumerate() {
            assert!((texels.at(i) / v - 1.0).abs() < 5e-4, "{v}");
            assert_eq!(texels.at(i), Texels::halved(*v));
        }
    }

    #[test]
    fn what_sixteen_bits_cannot_hold_is_known_beforehand() {
        assert!(Texels::fit_halves(&[0.5, -15.9]) && !Texels::fit_halves(&[17.0]));
        assert!(!Texels::of(true, vec![17.0]).are_finite());
    }
}
