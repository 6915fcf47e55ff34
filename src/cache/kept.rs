//! Kinds of results, each with the form of its files.

use super::{EntryFormat, Key, Payload, Store};
use crate::error::Result;
use serde::{Serialize, de::DeserializeOwned};

/// A kind of result that a [`Store`] keeps.
pub trait Kept: Sized {
    /// Name and version of its files.
    const FORMAT: EntryFormat;
    /// Everything of a result but its long arrays of numbers.
    type Header: Serialize + DeserializeOwned;

    /// The header of this result.
    fn header(&self) -> Self::Header;

    /// The arrays of this result, in the order in which [`Kept::build`] takes them.
    fn payload(&self) -> Vec<&[u8]>;

    /// The result of `header` and `payload`; `None` where no such result is made by this program. What has to be checked:
    /// see [`Store::load`].
    fn build(header: Self::Header, payload: &mut Payload<'_>) -> Option<Self>;
}

impl Store {
    /// The result of `key`; as [`Store::load`].
    pub fn load_kept<T: Kept>(&self, key: &Key, memory_limit: u64) -> Option<T> {
        self.load(&T::FORMAT, key, memory_limit, T::build)
    }

    /// Keeps `result` as that of `key`.
    ///
    /// # Errors
    /// As [`Store::save`].
    pub fn save_kept<T: Kept>(&self, key: &Key, result: &T) -> Result<()> {
        self.save(&T::FORMAT, key, &result.header(), &result.payload())
    }
}

/// The product of `counts`; `None` where it does not fit.
pub fn count(counts: &[usize]) -> Option<usize> {
    counts.iter().try_fold(1usize, |all, n| all.checked_mul(*n))
}

/// Whether all `numbers` are finite and greater than 0.
pub fn positive(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite() && *x > 0.0)
}
