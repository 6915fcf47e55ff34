//! expansion.
