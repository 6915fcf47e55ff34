//! The optics against closed forms and against plain sums that are written out here: no code is judged by itself.
//!
//! Every check is a function that returns a deviation, so that a second test can hand it a spoilt input and see it fail.

#![allow(clippy::unwrap_used, reason = "a test whose surface cannot be made has failed")]

mod closed_forms;
mod coherence;
mod colour;
mod efficiency;
mod ends;
mod facets;
mod furnace;
mod invariants;
mod plain;
mod properties;
