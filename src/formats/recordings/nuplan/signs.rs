//! Signs on the lanes of a map: speed limits, and where to stop or give way.

use std::collections::BTreeMap;

use super::lanes::{Cut, Placed};
use super::layers::Stop;
use crate::recordings::ids::Ids;
use crate::recordings::report::Report;
use nearmiss_base::geometry::{Point, Polyline, Vector, contains};
use nearmiss_scene::scenario::{LineMarking, Sign, SignElement, StopLine};

/// Signs of a country for a speed limit in m/s, for a stop and to give way.
pub struct Signs {
    limit: &'static str,
    stop: &'static str,
    give_way: &'static str,
}

impl Signs {
    /// Those of the country of a map, by its name.
    pub fn of(map: &str) -> Self {
        if map.starts_with("us-") {
            return Self {
                limit: "R2-1",
                stop: "R1-1",
                give_way: "R1-2",
            };
        }
        Self {
            limit: "274",
            stop: "206",
            give_way: "205",
        }
    }
}

/// Kinds of stop polygons.
const STOP_SIGN: i64 = 1;
const YIELD: i64 = 4;

/// So much of the end of a lane is looked at for stop polygons, metres.
const END: f64 = 15.0;

/// A sign for each speed limit, which all its lanes refer to.
pub fn speed_limits(cut: &mut Cut<'_>, signs: &Signs, ids: &mut Ids) -> Vec<Sign> {
    let mut limits: BTreeMap<u64, Sign> = BTreeMap::new();
    for placed in &mut cut.all {
        let Some(limit) = placed.lane.limit.filter(|limit| *limit > 0.0) else {
            continue;
        };
        let sign = limits.entry(limit.to_bits()).or_insert_with(|| Sign {
            id: ids.fresh(),
            position: placed.lanelet.right.points.first().copied(),
            is_virtual: true,
            elements: vec![SignElement {
                id: signs.limit.into(),
                values: vec![((limit * 1e6).round() / 1e6).to_string()],
            }],
        });
        placed.lanelet.signs.push(sign.id);
    }
    limits.into_values().collect()
}

/// Signs at stop polygons, and the lines there.
pub fn stop_signs(report: &Report, cut: &mut Cut<'_>, signs: &Signs, ids: &mut Ids) -> Vec<Sign> {
    let mut made = Vec::new();
    let layers = cut.layers;
    for stop in &layers.stops {
        let name = match stop.kind {
            STOP_SIGN => signs.stop,
            YIELD => signs.give_way,
            _ => continue,
        };
        let ring = cut.ring(&stop.ring);
        let lanes = lanes_of(cut, stop, &ring);
        // Readers of CommonRoad refuse a sign to which no lane refers.
        if lanes.is_empty() {
            continue;
        }
        let id = ids.fresh();
        for place in &lanes {
            let placed = &mut cut.all[*place];
            placed.lanelet.signs.push(id);
            let points = line_at(placed, &ring);
            let line = placed.lanelet.stop_line.get_or_insert(StopLine {
                points,
                marking: LineMarking::Unknown,
                signs: Vec::new(),
                lights: Vec::new(),
            });
            line.signs.push(id);
        }
        made.push(Sign {
            id,
            position: cut.all[lanes[0]].lanelet.right.points.last().copied(),
            is_virtual: false,
            elements: vec![SignElement {
                id: name.into(),
                values: Vec::new(),
            }],
        });
    }
    report.note_count(made.len(), |n| {
        format!("stop and yield signs, of which the map tells only the lines: {n}")
    });
    made
}

/// The lanes for which a stop polygon is: those that it names, or those that end in it.
fn lanes_of(cut: &Cut<'_>, stop: &Stop, ring: &[Point]) -> Vec<usize> {
    let lanes = stop.lanes.iter().filter_map(|id| cut.places[0].get(id));
    let connectors = stop
        .connectors
        .iter()
        .filter_map(|id| cut.from(cut.all[*cut.places[1].get(id)?].lane));
    let mut found: Vec<usize> = lanes.copied().chain(connectors).collect();
    if stop.lanes.is_empty() && stop.connectors.is_empty() {
        let all = cut.all.iter().zip(0..);
        let lanes = all.filter(|(placed, _)| placed.lane.connector.is_none());
        let inside = lanes.filter(|(placed, _)| ends_in(&placed.middle, ring));
        found.extend(inside.map(|(_, place)| place));
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Whether a line is in a ring near its end.
fn ends_in(line: &[Point], ring: &[Point]) -> bool {
    let Some(line) = Polyline::new(line.iter().copied()) else {
        return false;
    };
    let steps = 0..=(END * 2.0) as u32;
    let mut back = steps.map(|n| line.length() - f64::from(n) / 2.0);
    back.any(|s| s >= 0.0 && contains(ring, &line.pose_at(s).position))
}

/// A line across a lane where a stop polygon is; nothing is the end of the lane.
pub fn line_at(placed: &Placed<'_>, ring: &[Point]) -> Option<(Point, Point)> {
    let middle = Polyline::new(placed.middle.iter().copied())?;
    let sum: Vector = ring.iter().map(|p| p.coords).sum();
    let center = Point::from(sum / ring.len().max(1) as f64);
    let at = middle.pose_at(middle.project(&center).s);
    let across = Vector::new(-at.heading.sin(), at.heading.cos());
    let off = |border: &[Point]| {
        let line = Polyline::new(border.iter().copied())?;
        Some(line.project(&at.position).d.abs())
    };
    let left = off(&placed.lanelet.left.points)?;
    let right = off(&placed.lanelet.right.points)?;
    Some((at.position + across * left, at.position - across * right))
}
