//! Mould of a surface: hills become valleys. A stamper is the mould of a disc.
//!
//! The height changes its sign and nothing moves sideways: to look at a mould from its moulded side, mirror it as well.

use crate::error::Result;
use crate::surface::HeightField;

/// Returns `field` with every height `h` replaced by `−h`.
pub(super) fn apply(field: &HeightField) -> Result<HeightField> {
    let heights = field.heights().iter().map(|h| -h).collect();
    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;

    #[test]
    fn the_mould_of_a_mould_is_the_surface() {
        let surface = field(5, 4, |x, y| x + 2.0 * y);
        let mould = apply(&surface).unwrap();
        assert_eq!(mould.row(1)[2], -surface.row(1)[2]);
        assert_eq!(apply(&mould).unwrap(), surface);
    }
}
