//! The straight road of a highD recording, from the lines in its picture.

use super::meta::Recording;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::Map;
use crate::recordings::ids::Ids;
use crate::recordings::report::Report;
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Adjacent, Bound, Lanelet, LaneletType, LineMarking, RoadUser, Sign, SignElement,
};

/// The sign of a speed limit in Germany.
const SPEED_LIMIT: &str = "274";

/// The road reaches so far beyond the first and last middle of a vehicle, metres.
const BEYOND: f64 = 20.0;

/// From a point of a border to the next, metres, at most.
const PIECE: f64 = 50.0;

/// The lanes of both directions; `extent` is from where to where there is traffic, metres.
///
/// The picture's y points down. Lanes at its top are driven to the left, those at its bottom to the right.
pub fn map(
    report: &Report,
    recording: &Recording,
    extent: Option<(f64, f64)>,
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    let (low, high) = extent.unwrap_or((0.0, 0.0));
    let (low, high) = (low - BEYOND, high + BEYOND);
    let pieces = ((high - low) / PIECE).ceil().clamp(1.0, 1000.0) as usize;
    let mut map = Map::default();
    for (place, lines) in recording.markings.iter().enumerate() {
        let to_the_left = place == 0;
        if lines.len() == 1 {
            let name = ["upperLaneMarkings", "lowerLaneMarkings"][place];
            report.at(name).warn("one line makes no lane; left out");
        }
        let lanes: Vec<i64> = lines.windows(2).map(|_| ids.fresh()).collect();
        let last = lanes.len().saturating_sub(1);
        for (i, pair) in lines.windows(2).enumerate() {
            let bound = |y: f64, outer: bool| {
                let at = |i: usize| low + (high - low) * i as f64 / pieces as f64;
                let mut points: Vec<Point> = (0..=pieces).map(|i| Point::new(at(i), -y)).collect();
                if to_the_left {
                    points.reverse();
                }
                Bound {
                    points,
                    heights: Vec::new(),
                    marking: if outer {
                        LineMarking::Solid
                    } else {
                        LineMarking::Dashed
                    },
                }
            };
            let (upper, lower) = (bound(pair[0], i == 0), bound(pair[1], i == last));
            let (left, right) = if to_the_left {
                (lower, upper)
            } else {
                (upper, lower)
            };
            let beside = |i: Option<usize>| {
                let id = *lanes.get(i?)?;
                Some(Adjacent {
                    id,
                    same_direction: true,
                })
            };
            let (above, below) = (beside(i.checked_sub(1)), beside(i.checked_add(1)));
            let (adjacent_left, adjacent_right) = if to_the_left {
                (below, above)
            } else {
                (above, below)
            };
            map.lanelets.push(Lanelet {
                id: lanes[i],
                left,
                right,
                adjacent_left,
                adjacent_right,
                types: vec![LaneletType::Highway],
                users_one_way: vec![RoadUser::Vehicle],
                ..Lanelet::default()
            });
        }
    }
    if let Some(limit) = recording.speed_limit {
        let id = ids.fresh();
        map.lanelets.iter_mut().for_each(|l| l.signs.push(id));
        map.signs.push(Sign {
            id,
            position: map
                .lanelets
                .first()
                .and_then(|l| l.right.points.first().copied()),
            is_virtual: true,
            elements: vec![SignElement {
                id: SPEED_LIMIT.into(),
                values: vec![((limit * 1e4).round() / 1e4).to_string()],
            }],
        });
    }
    Ok(map)
}
