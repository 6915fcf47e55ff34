//! precompute.
