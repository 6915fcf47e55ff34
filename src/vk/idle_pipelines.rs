//! Pipelines that nothing uses any more, kept for the next renderer that makes the same ones.
//!
//! A pipeline cache spares a driver the compiler at most, and not every driver has one: a second picture of the same kind
//! would wait for its pipelines again.

use ash::vk;
use std::sync::{Mutex, PoisonError};

/// Largest number of pipelines that are kept: a picture has 11 to 14, so those of two kinds of picture and some more.
const MOST: usize = 32;

/// Handles of a pipeline and its layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PipelineHandles {
    pub(super) raw: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
}

/// Idle pipelines by the hash of what they follow from, the longest idle first.
#[derive(Default)]
pub(super) struct IdlePipelines(Mutex<Vec<(blake3::Hash, PipelineHandles)>>);

impl IdlePipelines {
    /// Takes a pipeline that follows from what `key` is the hash of.
    pub(super) fn take(&self, key: &blake3::Hash) -> Option<PipelineHandles> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner); // whole at any time
        let place = kept.iter().rposition(|(of, _)| of == key)?;
        Some(kept.remove(place).1)
    }

    /// Keeps a pipeline. Returns the one that has to be destroyed in exchange, if there are too many.
    pub(super) fn keep(&self, key: blake3::Hash, handles: PipelineHandles) -> Option<PipelineHandles> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner); // whole at any time
        kept.push((key, handles));
        (kept.len() > MOST).then(|| kept.remove(0).1)
    }

    /// Takes all pipelines.
    pub(super) fn take_all(&self) -> Vec<PipelineHandles> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner); // whole at any time
        kept.drain(..).map(|(_, handles)| handles).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ash::vk::Handle;

    fn handles(number: u64) -> PipelineHandles {
        PipelineHandles { raw: vk::Pipeline::from_raw(number), layout: vk::PipelineLayout::from_raw(number) }
    }

    #[test]
    fn a_pipeline_is_taken_once_by_what_it_follows_from() {
        let (idle, [a, b]) = (IdlePipelines::default(), [b"a", b"b"].map(|text| blake3::hash(text)));
        assert!(idle.keep(a, handles(1)).is_none() && idle.keep(b, handles(2)).is_none());
        assert_eq!([&a, &a, &b].map(|key| idle.take(key)), [Some(handles(1)), None, Some(handles(2))]);
    }

    #[test]
    fn the_longest_idle_pipeline_makes_room() {
        let idle = IdlePipelines::default();
        let key = |number: u64| blake3::hash(&number.to_le_bytes());
        let most = MOST as u64;
        assert!((0..most).all(|number| idle.keep(key(number), handles(number)).is_none()));
        assert_eq!(idle.keep(key(most), handles(most)), Some(handles(0)));
        assert_eq!(idle.take_all(), (1..=most).map(handles).collect::<Vec<_>>());
    }
}
