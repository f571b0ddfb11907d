//! Figures of bundled scenes: geometry, formats, sizes, and that the same is always the same.
#![allow(clippy::unwrap_used)]
