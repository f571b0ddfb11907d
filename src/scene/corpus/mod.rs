//! What a corpus of recordings holds: windows of pairs of road users, their manoeuvre, road and severity.
//!
//! [`for_each_window`] measures the windows of one scenario, [`Coverage`] counts them, and [`Sampler`] draws windows so
//! that they cover what is there. [`for_each_window`] finds what is worth looking at in a long recording. [`Part`] reads a part of
//! an index, and [`CorpusIndex`] all of them.

mod index;
mod parts;
mod sampler;

mod windows;

pub use index::INTEGERS as WINDOW_INTEGERS;
pub use index::{
    CellCounts, CellWindows, CorpusIndex, InIndex, IndexedScenario, WindowKey, WindowPlace,
};
pub use parts::{Columns, IndexError, Part, PartRow, part_files};
pub use sampler::{Axis, Candidate, Cell, Coverage, RowCell, SEVERITIES, SampledWindow, Sampler};
pub use windows::{
    IndexOptions, IndexedWindow, Manoeuvre, RoadType, WindowEgo, WorstMoment, for_each_window,
    worst_moments,
};
