//! Lanes of a Waymo map as lanelets, and how wide they are: from their boundaries, their neighbours, or assumed.

use std::cell::Cell;
use std::collections::HashMap;

use nearmiss_base::geometry::{Point, Vector, distance_to_segment};
use nearmiss_scene::scenario::{Adjacent, Lanelet, LaneletType, LineMarking, RoadUser};

use super::messages::{BoundarySegment, LaneCenter, LaneNeighbor};
use crate::recordings::Report;
use crate::recordings::lane_shape::{Widths, borders};

/// A lane with its middle.
pub struct Lane<'m> {
    /// As the data set counts.
    pub feature: i64,
    pub said: &'m LaneCenter,
    pub centre: Vec<Point>,
    pub heights: Vec<f64>,
    /// The number of each point in the data set, which repeats some.
    pub places: Vec<usize>,
}

/// A lane with the distances of its borders that are told, left and right.
type BorderDistances = (Vec<Option<f64>>, Vec<Option<f64>>);

/// A lane for bicycles.
const BIKE_LANE: i32 = 3;

/// The lanelets of the lanes, in their order; `ids` has the id of each lane that is there.
pub fn lanelets(
    report: &Report,
    lanes: &[Lane<'_>],
    lines: &Lines,
    edges: &Lines,
    ids: &HashMap<i64, i64>,
) -> Vec<Lanelet> {
    let middles: Lines = lanes
        .iter()
        .map(|l| (l.feature, l.centre.clone()))
        .collect();
    let both = measured(lines.iter().chain(edges));
    let beside_lanes = measured(&middles);
    let told: Vec<BorderDistances> = lanes
        .iter()
        .map(|lane| self::lane_border_distances(lane, &both, &beside_lanes))
        .collect();
    let places: HashMap<i64, usize> = lanes.iter().map(|l| l.feature).zip(0..).collect();
    let mut assumed = 0;
    let made = lanes
        .iter()
        .zip(&told)
        .map(|(lane, (left, right))| {
            let unknown = |side: &Vec<Option<f64>>| side.iter().all(Option::is_none);
            assumed += usize::from(unknown(left) || unknown(right));
            let half = match lane.said.r#type {
                Some(BIKE_LANE) => HALF_BICYCLE_LANE,
                _ => HALF_LANE,
            };
            let near = |ids: &[i64], last: bool| {
                let known = |side: &Vec<Option<f64>>| {
                    let end = if last { side.last() } else { side.first() };
                    end.copied().flatten()
                };
                let mut beside = ids.iter().filter_map(|id| told.get(*places.get(id)?));
                let (left, right) = beside
                    .next()
                    .map_or((None, None), |(l, r)| (known(l), known(r)));
                (left.unwrap_or(half), right.unwrap_or(half))
            };
            let ends = (
                near(&lane.said.entry_lanes, true),
                near(&lane.said.exit_lanes, false),
            );
            let widths = filled(left, right, ends);
            let (mut left, mut right) = borders(&lane.centre, &lane.heights, &widths);
            left.marking = marking(&lane.said.left_boundaries, edges);
            right.marking = marking(&lane.said.right_boundaries, edges);
            let linked =
                |wanted: &[i64]| wanted.iter().map(|id| *ids.get(id).unwrap_or(id)).collect();
            let adjacent = |left: bool| {
                let id = main_neighbour(lane, left)?;
                let other = &lanes[*places.get(&id)?];
                // CommonRoad has one neighbour a side, and the two name each other.
                (main_neighbour(other, !left) == Some(lane.feature)).then(|| Adjacent {
                    id: ids[&id],
                    same_direction: true,
                })
            };
            let (types, users) = match lane.said.r#type {
                Some(BIKE_LANE) => (vec![LaneletType::BicycleLane], vec![RoadUser::Bicycle]),
                Some(1) => (vec![LaneletType::Highway], vec![RoadUser::Vehicle]),
                _ => (vec![LaneletType::Urban], vec![RoadUser::Vehicle]),
            };
            Lanelet {
                id: ids[&lane.feature],
                left,
                right,
                predecessors: linked(&lane.said.entry_lanes),
                successors: linked(&lane.said.exit_lanes),
                adjacent_left: adjacent(true),
                adjacent_right: adjacent(false),
                types,
                users_one_way: users,
                ..Lanelet::default()
            }
        })
        .collect();
    report.note_count(assumed, |n| {
        format!(
            "lanes without a boundary or neighbour on a side: {n}; that side is as wide as in the lanes before and after, or {HALF_LANE} m from the middle ({HALF_BICYCLE_LANE} m of lanes for bicycles)"
        )
    });
    made
}

fn lane_border_distances(
    lane: &Lane<'_>,
    lines: &MeasuredLines<'_>,
    lanes: &MeasuredLines<'_>,
) -> BorderDistances {
    let side = |boundaries, neighbors| {
        let side = SideOfLane {
            boundaries,
            neighbors,
        };
        border_distances(&lane.centre, &lane.places, &side, lines, lanes)
    };
    let said = lane.said;
    (
        side(&said.left_boundaries, &said.left_neighbors),
        side(&said.right_boundaries, &said.right_neighbors),
    )
}

/// The lane beside one for the longest part of it, if that is more than half of it.
fn main_neighbour(lane: &Lane<'_>, left: bool) -> Option<i64> {
    let neighbors = if left {
        &lane.said.left_neighbors
    } else {
        &lane.said.right_neighbors
    };
    let length = |n: &LaneNeighbor| {
        let end = |i: Option<i32>| i64::from(i.unwrap_or(0));
        end(n.self_end_index) - end(n.self_start_index)
    };
    let longest = neighbors.iter().max_by_key(|n| length(n))?;
    let half = lane.said.polyline.len() as i64 / 2;
    longest.feature_id.filter(|_| length(longest) >= half)
}

/// The marking along most of a border.
fn marking(boundaries: &[BoundarySegment], edges: &Lines) -> LineMarking {
    let length = |b: &&BoundarySegment| {
        let end = |i: Option<i32>| i64::from(i.unwrap_or(0));
        end(b.lane_end_index) - end(b.lane_start_index)
    };
    let Some(longest) = boundaries.iter().max_by_key(length) else {
        return LineMarking::NoMarking;
    };
    match longest.boundary_type {
        Some(1 | 4) => LineMarking::Dashed,
        Some(2 | 6) => LineMarking::Solid,
        Some(3 | 7) => LineMarking::SolidSolid,
        Some(5) => LineMarking::DashedDashed,
        // Two lines that may be crossed from one side.
        Some(8) => LineMarking::SolidDashed,
        _ if longest
            .boundary_feature_id
            .is_some_and(|id| edges.contains_key(&id)) =>
        {
            LineMarking::Curb
        }
        _ => LineMarking::Unknown,
    }
}

/// Half the width of a lane that is not told by anything, metres: lanes in the United States are 3.0 to 3.7 m wide.
pub const HALF_LANE: f64 = 1.75;

/// The same of a lane for bicycles, metres.
pub const HALF_BICYCLE_LANE: f64 = 0.75;

/// What lies nearer to or farther from the middle of a lane than this is not its border, metres.
const BORDER: (f64, f64) = (0.3, 5.0);

/// Distances along a line are exact to less than this, metres.
const ROUNDED: f64 = 1e-6;

/// Lines and lanes of the map, by the ids of the data set.
pub type Lines = HashMap<i64, Vec<Point>>;

/// The same, measured once for all lanes beside them.
pub type MeasuredLines<'l> = HashMap<i64, Measured<'l>>;

/// Measures lines; those of less than two points are left out.
pub fn measured<'l>(
    lines: impl IntoIterator<Item = (&'l i64, &'l Vec<Point>)>,
) -> MeasuredLines<'l> {
    let each = lines.into_iter();
    each.filter_map(|(id, line)| Some((*id, Measured::new(line)?)))
        .collect()
}

/// One side of a lane.
pub struct SideOfLane<'a> {
    pub boundaries: &'a [BoundarySegment],
    pub neighbors: &'a [LaneNeighbor],
}

/// Distances of a border from the points of a lane's middle, where they are told; `places` are the points' own numbers.
pub fn border_distances(
    centre: &[Point],
    places: &[usize],
    side: &SideOfLane<'_>,
    lines: &MeasuredLines<'_>,
    lanes: &MeasuredLines<'_>,
) -> Vec<Option<f64>> {
    let within = |place: usize, from: Option<i32>, to: Option<i32>| {
        let index = |i: Option<i32>| usize::try_from(i.unwrap_or(0)).unwrap_or(0);
        (index(from)..=index(to)).contains(&place)
    };
    let usable = |d: &f64| (BORDER.0..=BORDER.1).contains(d);
    let boundaries = side.boundaries.iter().filter_map(|b| {
        let line = lines.get(&b.boundary_feature_id?)?;
        let span = (b.lane_start_index, b.lane_end_index);
        Some((span, line, Cell::new(0)))
    });
    let neighbors = side.neighbors.iter().filter_map(|n| {
        let line = lanes.get(&n.feature_id?)?;
        let span = (n.self_start_index, n.self_end_index);
        Some((span, line, Cell::new(0)))
    });
    let (boundaries, neighbors): (Vec<_>, Vec<_>) = (boundaries.collect(), neighbors.collect());
    let each = centre.iter().zip(places).map(|(p, place)| {
        let here = |((from, to), ..): &&LateralNeighbour<'_, '_>| within(*place, *from, *to);
        let boundary = boundaries
            .iter()
            .filter(here)
            .filter_map(|(_, line, near)| line.distance(p, BORDER.1, near));
        let nearest = boundary.filter(usable).reduce(f64::min);
        nearest.or_else(|| {
            let beside = neighbors.iter().filter(here);
            let most = 2.0 * BORDER.1;
            let beside = beside.filter_map(|(_, line, near)| line.distance(p, most, near));
            beside.map(|d| d / 2.0).filter(usable).reduce(f64::min)
        })
    });
    each.collect()
}

/// A line beside a lane: from and to which of its points, and the piece of it that was nearest last.
type LateralNeighbour<'a, 'l> = ((Option<i32>, Option<i32>), &'a Measured<'l>, Cell<usize>);

/// A line with the distance along it from its first point to each, and the direction of each piece.
pub struct Measured<'l> {
    points: &'l [Point],
    along: Vec<f64>,
    /// Unit vectors; zero where two points are at the same place.
    directions: Vec<Vector>,
    /// The length of the longest piece, metres.
    longest: f64,
}

impl<'l> Measured<'l> {
    fn new(points: &'l [Point]) -> Option<Self> {
        if points.len() < 2 {
            return None;
        }
        let mut along = vec![0.0];
        let mut directions = Vec::with_capacity(points.len() - 1);
        let mut longest = f64::MIN_POSITIVE;
        for (pair, i) in points.windows(2).zip(0..) {
            let piece = pair[1] - pair[0];
            let length = piece.norm();
            along.push(along[i] + length);
            longest = length.max(longest);
            directions.push(if length > 0.0 { piece / length } else { piece });
        }
        Some(Self {
            points,
            along,
            directions,
            longest,
        })
    }

    /// The square of the distance of a point from a piece.
    fn squared(&self, p: &Point, piece: usize) -> f64 {
        let from = p - self.points[piece];
        let direction = self.directions[piece];
        let length = self.along[piece + 1] - self.along[piece];
        (from - direction * from.dot(&direction).clamp(0.0, length)).norm_squared()
    }

    /// How far a point is from the line; nothing if it is farther than `most`.
    ///
    /// It looks from the piece that was nearest last, which `near` keeps for the next point, to both ends. Where a point
    /// of the line is far away, so are those not far along from it: they are passed over.
    fn distance(&self, p: &Point, most: f64, near: &Cell<usize>) -> Option<f64> {
        let pieces = self.directions.len();
        let begin = near.get().min(pieces - 1);
        let mut nearest = self.squared(p, begin);
        let mut reach = nearest.sqrt().min(most) + ROUNDED;
        let mut look = |piece: usize, reach: &mut f64| {
            let here = self.squared(p, piece);
            if here < nearest {
                nearest = here;
                near.set(piece);
                *reach = here.sqrt().min(most) + ROUNDED;
            }
        };
        // So many whole pieces are within a distance along the line; none within less than nothing.
        let clear = |along: f64| (along / self.longest) as usize;
        let mut i = begin + 1;
        while i < pieces {
            match clear((self.points[i] - p).norm() - reach) {
                0 => {
                    look(i, &mut reach);
                    i += 1;
                }
                far => i += far,
            }
        }
        let mut end = begin;
        while end > 0 {
            match clear((self.points[end] - p).norm() - reach) {
                0 => {
                    look(end - 1, &mut reach);
                    end -= 1;
                }
                far => end = end.saturating_sub(far),
            }
        }
        let (a, b) = (&self.points[near.get()], &self.points[near.get() + 1]);
        let nearest = distance_to_segment(p, a, b);
        (nearest <= most).then_some(nearest)
    }
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
            ]
            .into_iter()
            .flatten()
            .min_by_key(|k| k.abs_diff(i));
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
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn what_is_passed_over_is_farther() {
        let bend = |i: i32| {
            let angle = f64::from(i) * 0.05;
            Point::new(
                30.0 * angle.sin() + 0.3 * f64::from(i % 3),
                -30.0 * angle.cos(),
            )
        };
        let line: Vec<Point> = (0..100).map(bend).collect();
        let measured = Measured::new(&line).unwrap();
        let near = Cell::new(0);
        for (x, y) in (-40..40).flat_map(|x| (-40..40).map(move |y| (x, y))) {
            let p = Point::new(f64::from(x), f64::from(y));
            let pieces = line
                .windows(2)
                .map(|w| distance_to_segment(&p, &w[0], &w[1]));
            let nearest = pieces.fold(f64::MAX, f64::min);
            let expected = (nearest <= 5.0).then_some(nearest);
            let found = measured.distance(&p, 5.0, &near);
            // Of pieces that meet in the nearest point, either may be taken.
            let apart = found.zip(expected).map_or(0.0, |(a, b)| (a - b).abs());
            assert!(
                apart < 1e-12 && found.is_some() == expected.is_some(),
                "{p}"
            );
        }
        assert!(Measured::new(&line[..1]).is_none());
    }

    #[test]
    fn a_gap_has_the_nearest_width_and_a_side_without_any_that_of_its_ends() {
        let left = [None, Some(2.0), None, None, Some(1.0)];
        let widths = filled(&left, &[None; 5], ((9.0, 1.0), (9.0, 3.0)));
        let (left, right): (Vec<f64>, Vec<f64>) = widths.into_iter().unzip();
        assert_eq!(left, [2.0, 2.0, 2.0, 1.0, 1.0]);
        assert_eq!(right, [1.0, 1.5, 2.0, 2.5, 3.0]);
    }
}
