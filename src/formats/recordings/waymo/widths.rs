//! How wide the lanes of a Waymo map are: from their boundaries, their neighbours, or assumed.

use std::collections::HashMap;

use super::messages::{BoundarySegment, LaneNeighbor};
use crate::formats::recordings::lane_shape::Widths;
use crate::geometry::{Point, distance_to_segment};

/// Half the width of a lane that is not told by anything, metres: lanes in the United States are 3.0 to 3.7 m wide.
pub const HALF_LANE: f64 = 1.75;

/// The same of a lane for bicycles, metres.
pub const HALF_BICYCLE_LANE: f64 = 0.75;

/// What lies nearer to or farther from the middle of a lane than this is not its border, metres.
const BORDER: (f64, f64) = (0.3, 5.0);

/// Lines and lanes of the map, by the ids of the data set.
pub type Lines = HashMap<i64, Vec<Point>>;

/// One side of a lane.
pub struct SideOfLane<'a> {
    pub boundaries: &'a [BoundarySegment],
    pub neighbors: &'a [LaneNeighbor],
}

/// Distances of a border from the points of a lane's middle, where they are told; `places` are the points' own numbers.
pub fn told(
    centre: &[Point],
    places: &[usize],
    side: &SideOfLane<'_>,
    lines: &Lines,
    lanes: &Lines,
) -> Vec<Option<f64>> {
    let within = |place: usize, from: Option<i32>, to: Option<i32>| {
        let index = |i: Option<i32>| usize::try_from(i.unwrap_or(0)).unwrap_or(0);
        (index(from)..=index(to)).contains(&place)
    };
    let usable = |d: &f64| (BORDER.0..=BORDER.1).contains(d);
    let each = centre.iter().zip(places).map(|(p, place)| {
        let boundary = side.boundaries.iter().filter_map(|b| {
            let here = within(*place, b.lane_start_index, b.lane_end_index);
            let line = lines.get(&b.boundary_feature_id?).filter(|_| here)?;
            distance(p, line)
        });
        let nearest = boundary.filter(usable).reduce(f64::min);
        nearest.or_else(|| {
            let beside = side.neighbors.iter().filter_map(|n| {
                let here = within(*place, n.self_start_index, n.self_end_index);
                let lane = lanes.get(&n.feature_id?).filter(|_| here)?;
                distance(p, lane).map(|d| d / 2.0)
            });
            beside.filter(usable).reduce(f64::min)
        })
    });
    each.collect()
}

fn distance(p: &Point, line: &[Point]) -> Option<f64> {
    let pieces = line
        .windows(2)
        .map(|w| distance_to_segment(p, &w[0], &w[1]));
    pieces.reduce(f64::min)
}

/// Both sides along a lane: a point without a width has that of the nearest one with it, and a side without any the
/// widths that its ends are given.
pub fn filled(
    left: &[Option<f64>],
    right: &[Option<f64>],
    (start, end): ((f64, f64), (f64, f64)),
) -> Widths {
    let count = left.len();
    let part = |i: usize| i as f64 / (count.max(2) - 1) as f64;
    let side = |told: &[Option<f64>], from: f64, to: f64| -> Vec<f64> {
        let known: Vec<usize> = (0..count).filter(|i| told[*i].is_some()).collect();
        let each = (0..count).map(|i| {
            let after = known.partition_point(|k| *k < i);
            let near = [
                after.checked_sub(1).map(|k| known[k]),
                known.get(after).copied(),
            ];
            let near = near.into_iter().flatten().min_by_key(|k| k.abs_diff(i));
            near.and_then(|k| told[k])
                .unwrap_or_else(|| from + (to - from) * part(i))
        });
        each.collect()
    };
    let left = side(left, start.0, end.0);
    let right = side(right, start.1, end.1);
    left.into_iter().zip(right).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_has_the_nearest_width_and_a_side_without_any_that_of_its_ends() {
        let left = [None, Some(2.0), None, None, Some(1.0)];
        let widths = filled(&left, &[None; 5], ((9.0, 1.0), (9.0, 3.0)));
        let (left, right): (Vec<f64>, Vec<f64>) = widths.into_iter().unzip();
        assert_eq!(left, [2.0, 2.0, 2.0, 1.0, 1.0]);
        assert_eq!(right, [1.0, 1.5, 2.0, 2.5, 3.0]);
    }
}
