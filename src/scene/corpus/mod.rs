//! What a corpus of recordings holds: windows of pairs of road users, their manoeuvre, road and severity.
//!
//! [`for_each_window`] measures the windows of one scenario, [`Coverage`] counts them, and [`Sampler`] draws windows so
//! that they cover what is there. [`worst_moments`] finds what is worth looking at in a long recording. [`Part`] reads a part of an index, and [`CorpusIndex`] all of them.

mod coverage;
mod index;
mod manoeuvre;
mod parts;
mod road_type;
mod row_cell;
mod sampler;

mod windows;
mod worst_moments;

pub use coverage::{Cell, Coverage, SEVERITIES};
pub use index::INTEGERS as WINDOW_INTEGERS;
pub use index::{
    CellCounts, CellWindows, CorpusIndex, InIndex, IndexedScenario, WindowKey, WindowPlace,
};
pub use manoeuvre::Manoeuvre;
pub use parts::{Columns, IndexError, Part, PartRow, part_files};
pub use road_type::RoadType;
pub use row_cell::RowCell;
pub use sampler::{Axis, Candidate, Drawn, Sampler};
pub use windows::{IndexOptions, IndexedWindow, WindowEgo, for_each_window};
pub use worst_moments::{WorstMoment, worst_moments};
