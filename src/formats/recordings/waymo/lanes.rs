//! Lanes of a Waymo map as lanelets.

use std::collections::HashMap;

use super::messages::{BoundarySegment, LaneCenter, LaneNeighbor};
use super::widths::{
    self, HALF_BICYCLE_LANE, HALF_LANE, Lines, MeasuredLines, SideOfLane, measured,
};
use crate::recordings::lane_shape::borders;
use crate::recordings::report::Report;
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{Adjacent, Lanelet, LaneletType, LineMarking, RoadUser};

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
type Told = (Vec<Option<f64>>, Vec<Option<f64>>);

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
    let told: Vec<Told> = lanes
        .iter()
        .map(|lane| self::told(lane, &both, &beside_lanes))
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
            let widths = widths::filled(left, right, ends);
            let (mut left, mut right) = borders(&lane.centre, &lane.heights, &widths);
            left.marking = marking(&lane.said.left_boundaries, edges);
            right.marking = marking(&lane.said.right_boundaries, edges);
            let linked =
                |wanted: &[i64]| wanted.iter().map(|id| *ids.get(id).unwrap_or(id)).collect();
            let adjacent = |left: bool| {
                let id = beside(lane, left)?;
                let other = &lanes[*places.get(&id)?];
                // CommonRoad has one neighbour a side, and the two name each other.
                (beside(other, !left) == Some(lane.feature)).then(|| Adjacent {
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

fn told(lane: &Lane<'_>, lines: &MeasuredLines<'_>, lanes: &MeasuredLines<'_>) -> Told {
    let side = |boundaries, neighbors| {
        let side = SideOfLane {
            boundaries,
            neighbors,
        };
        widths::told(&lane.centre, &lane.places, &side, lines, lanes)
    };
    let said = lane.said;
    (
        side(&said.left_boundaries, &said.left_neighbors),
        side(&said.right_boundaries, &said.right_neighbors),
    )
}

/// The lane beside one for the longest part of it, if that is more than half of it.
fn beside(lane: &Lane<'_>, left: bool) -> Option<i64> {
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
