//! The part of the world on a map of character cells, and how large cells and dots are in it.

use std::ops::Deref;

use super::MapStyle;
use crate::scene::Viewport;
use nearmiss_base::geometry::{Bounds, Point, Pose, Vector, part_within};

/// What is seen, in character cells; lengths are metres.
#[derive(Debug, Clone, Copy)]
pub struct CellView {
    /// What is seen.
    pub seen: Viewport,
    /// A column and a row.
    pub cell: (f64, f64),
    /// From one Braille dot to the next, where they are farther apart.
    pub dot: f64,
}

impl Deref for CellView {
    type Target = Viewport;

    fn deref(&self) -> &Viewport {
        &self.seen
    }
}

impl CellView {
    /// The view around a frame; `half` is half its width and height, `cell` a column and a row.
    #[must_use]
    pub fn new(frame: Pose, half: (f64, f64), cell: (f64, f64)) -> Self {
        Self {
            seen: Viewport::new(frame, half),
            cell,
            dot: (cell.0 / 2.0).max(cell.1 / 4.0),
        }
    }

    /// Metres of a part of a block character, the longer way.
    #[must_use]
    pub fn block(&self, style: MapStyle) -> f64 {
        let (across, down) = style.blocks().per_cell();
        (self.cell.0 / across as f64).max(self.cell.1 / down as f64)
    }

    /// The part of a line on the canvas that may be seen, from 0 (its beginning) to 1; with some dots around the map.
    #[must_use]
    pub fn part_seen(&self, from: (f64, f64), to: (f64, f64)) -> Option<(f64, f64)> {
        let half = Vector::new(self.half.0 + 2.0 * self.dot, self.half.1 + 2.0 * self.dot);
        let bounds = Bounds {
            min: Point::from(-half),
            max: Point::from(half),
        };
        part_within(
            &Point::new(from.0, from.1),
            &Point::new(to.0, to.1),
            &bounds,
        )
    }
}
