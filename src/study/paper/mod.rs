//! Comparison with the paper "From Words to Collisions" (Gao et al.): its recorded answers and its printed tables.
//!
//! Its convention of measures is [`nearmiss_scene::metrics::paper`], one of the two that `nearmiss metrics` writes.

mod document;
mod recorded;
mod scored;
mod tables;

pub use crate::evaluation::report::Finding;
pub use recorded::{Recorded, find, is_laid_out};
pub use scored::{run_of, runs, scored};
pub use tables::{Comparison, Paper, Part, Published, published};
