//! Markings of lanes as lines to be painted: where beside the border, how broad, dashed or not.

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::scenario::LineMarking;

/// Dash and gap of a dashed line, metres.
pub const DASH: f64 = 3.0;

/// What a line along a border shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paint {
    /// A solid line.
    Solid,
    /// Dashes and gaps of [`DASH`].
    Dashed,
    /// A kerb.
    Curb,
    /// A kerb that vehicles can cross.
    LoweredCurb,
    /// Nothing is painted there.
    None,
    /// The file does not say.
    Unknown,
}

/// One line of a marking. Lengths are in widths of a painted line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkingLine {
    /// What it shows.
    pub paint: Paint,
    /// How far to the right of the border it lies; to the left where negative.
    pub offset: f64,
    /// How broad it is.
    pub width: f64,
}

const fn line(paint: Paint, offset: f64, width: f64) -> MarkingLine {
    MarkingLine {
        paint,
        offset,
        width,
    }
}

/// The lines of a marking, from left to right.
#[must_use]
pub fn lines_of(marking: LineMarking) -> &'static [MarkingLine] {
    use LineMarking as M;
    use Paint::{Dashed, Solid};
    const BROAD: f64 = 2.0;
    match marking {
        M::Solid => const { &[line(Solid, 0.0, 1.0)] },
        M::BroadSolid => const { &[line(Solid, 0.0, BROAD)] },
        M::Dashed => const { &[line(Dashed, 0.0, 1.0)] },
        M::BroadDashed => const { &[line(Dashed, 0.0, BROAD)] },
        M::SolidSolid => const { &[line(Solid, -1.0, 1.0), line(Solid, 1.0, 1.0)] },
        M::DashedDashed => const { &[line(Dashed, -1.0, 1.0), line(Dashed, 1.0, 1.0)] },
        M::SolidDashed => const { &[line(Solid, -1.0, 1.0), line(Dashed, 1.0, 1.0)] },
        M::DashedSolid => const { &[line(Dashed, -1.0, 1.0), line(Solid, 1.0, 1.0)] },
        M::Curb => const { &[line(Paint::Curb, 0.0, 1.3)] },
        M::LoweredCurb => const { &[line(Paint::LoweredCurb, 0.0, 1.3)] },
        M::NoMarking => const { &[line(Paint::None, 0.0, 1.0)] },
        M::Unknown => const { &[line(Paint::Unknown, 0.0, 1.0)] },
    }
}

/// The same line so many metres to its right; to its left where that is negative.
#[must_use]
pub fn offset(points: &[Point], metres: f64) -> Vec<Point> {
    let shifted = |i: usize| {
        let last = points.len() - 1;
        let along = points[(i + 1).min(last)] - points[i.saturating_sub(1)];
        let norm = along.norm();
        let scale = if norm > 0.0 { metres / norm } else { 0.0 };
        points[i] + Vector::new(along.y, -along.x) * scale
    };
    (0..points.len()).map(shifted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_lines_lie_on_both_sides() {
        let line = [0.0, 10.0, 20.0].map(|x| Point::new(x, 0.0));
        // y is up: driving to the right, the right side is below.
        assert_eq!(offset(&line, 2.0)[1], Point::new(10.0, -2.0));
        assert_eq!(offset(&line, -2.0)[2], Point::new(20.0, 2.0));
        for marking in LineMarking::ALL {
            let lines = lines_of(*marking);
            assert!(lines.is_sorted_by_key(|line| line.offset), "{marking}");
            let middle: f64 = lines.iter().map(|line| line.offset).sum();
            assert!(middle == 0.0 && lines.len() <= 2, "{marking}");
        }
    }

    #[test]
    fn a_line_beside_a_bend_follows_it() {
        let line = [(0.0, 0.0), (10.0, 0.0), (10.0, -5.0)].map(|(x, y)| Point::new(x, y));
        let moved = offset(&line, 0.5);
        assert_eq!(moved[0], Point::new(0.0, -0.5));
        assert_eq!(moved[2], Point::new(9.5, -5.0));
    }
}
