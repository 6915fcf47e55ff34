//! Kinds of cached results, each with the form of its files.

use super::{EntryFormat, Key, Payload, Store};
use crate::error::Result;
use serde::{Serialize, de::DeserializeOwned};

/// Kind of result in a [`Store`].
pub trait Kept: Sized {
    /// Name and version of the files.
    const FORMAT: EntryFormat;
    /// Everything of a result but its long arrays of numbers.
    type Header: Serialize + DeserializeOwned;

    /// Returns the header of this result.
    fn header(&self) -> Self::Header;

    /// Returns the arrays of this result, in the order in which [`Kept::build`] reads them.
    fn payload(&self) -> Vec<&[u8]>;

    /// Builds the result of `header` and `payload`; `None` if they are not valid. [`Store::load`] says which checks are needed.
    fn build(header: Self::Header, payload: &mut Payload<'_>) -> Option<Self>;
}

impl Store {
    /// Loads the result of `key`; see [`Store::load`].
    pub fn load_kept<T: Kept>(&self, key: &Key, memory_limit: u64) -> Option<T> {
        self.load(&T::FORMAT, key, memory_limit, T::build)
    }

    /// Stores `result` under `key`.
    ///
    /// # Errors
    /// Those of [`Store::save`].
    pub fn save_kept<T: Kept>(&self, key: &Key, result: &T) -> Result<()> {
        self.save(&T::FORMAT, key, &result.header(), &result.payload())
    }
}

/// Returns the product of `counts`; `None` if it overflows.
pub fn count(counts: &[usize]) -> Option<usize> {
    counts.iter().try_fold(1usize, |all, n| all.checked_mul(*n))
}

/// Returns true if all `numbers` are finite and greater than 0.
pub fn positive(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite() && *x > 0.0)
}
