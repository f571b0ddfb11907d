//! Comparison with the paper "From Words to Collisions" (Gao et al.): its recorded answers and its printed tables.
//!
//! Its convention of measures is [`nearmiss_scene::metrics::paper`], one of the two that `nearmiss metrics` writes.

mod document;
mod recorded;
mod runs;
mod scenes;
mod scored;
mod tables;

pub use crate::evaluation::report::Finding;
pub use recorded::{Recorded, find, is_laid_out};
pub use runs::runs;
pub use scored::scored;
pub use tables::{Comparison, Paper, Part, Published, published};
