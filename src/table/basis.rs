//! Basis of a colour table over |w|: a texel holds coordinates in a subspace of few dimensions that is near all colours of this surface in
//! this light.

use super::LARGEST_W;
use super::sums::NODES;
use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Basis of colours over |w|.
///
/// The range 0 … 2 of |w| is cut into equal pieces. In a piece X, Y and Z of a place are cubics, which are twelve numbers. Those of all
/// places lie near a subspace of fewer dimensions, because a colour and its change with |w| come from the same orders. The texel of a place
/// holds the coordinates in that subspace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorBasis {
    /// Number of equal pieces of 0 … 2.
    pub pieces: usize,
    /// Numbers of a texel for each piece, a multiple of four.
    pub components: usize,
    /// Cubics `[piece][component]`; t goes from −1 to 1 over the piece.
    pub cubics: Vec<Cubics>,
}

/// Cubics in t of X, Y and Z: the coefficients of 1, t, t² and t³.
pub type Cubics = [[f32; NODES]; 3];

/// Numbers of a texel of the texture, which are read at once.
pub const PER_TEXEL: usize = 4;
/// Largest number of pieces of the range of |w|.
pub const MOST_PIECES: usize = 16;
/// Number of components that hold any three cubics.
pub const MOST_COMPONENTS: usize = 3 * NODES;

impl ColorBasis {
    /// Returns the basis of a table without light.
    pub fn dark() -> Self {
        Self { pieces: 1, components: PER_TEXEL, cubics: vec![Cubics::default(); PER_TEXEL] }
    }

    /// Returns the number of texels that a direction reads at each place.
    pub fn texels(&self) -> usize {
        self.components / PER_TEXEL
    }

    /// Returns the number of texels of all pieces.
    pub fn layers(&self) -> usize {
        self.pieces * self.texels()
    }

    /// Returns the piece of |w| = `w`, and t there.
    pub fn piece(&self, w: f64) -> (usize, f64) {
        let place = w / LARGEST_W * self.pieces as f64;
        let piece = (place as usize).min(self.pieces - 1);
        (piece, 2.0 * (place - piece as f64) - 1.0)
    }

    /// Returns the cubics of the components of `piece`.
    pub fn of_piece(&self, piece: usize) -> &[Cubics] {
        &self.cubics[piece * self.components..][..self.components]
    }

    /// Returns XYZ at `t` of a piece whose components have these `cubics` and a texel these `numbers`.
    pub fn colour(cubics: &[Cubics], numbers: &[f32], t: f64) -> Vec3 {
        let powers = Vec4::new(1.0, t as f32, (t * t) as f32, (t * t * t) as f32);
        let colour = |c: &Cubics| Vec3::from(c.map(|c| powers.dot(c.into())));
        cubics.iter().zip(numbers).map(|(cubics, number)| *number * colour(cubics)).sum()
    }
}
