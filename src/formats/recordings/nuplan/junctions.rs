//! Intersections of a map, its traffic lights with what they show, and signs on its lanes.

use std::collections::BTreeMap;

use nearmiss_base::geometry::{Point, Polyline, Vector, contains};
use nearmiss_scene::scenario::{
    Incoming, Intersection, LaneletType, LightPhase, LineMarking, Sign, SignElement, SignalColor,
    StopLine, TrafficDirection, TrafficLight,
};

use super::lanes::{LaneSection, Placed};
use super::layers::{Lane, Stop};
use super::log::Clock;
use super::sqlite::Database;
use crate::commonroad::ReadError;
use crate::recordings::Report;
use crate::recordings::assembly::Ids;
use crate::recordings::lane_shape::directions;

/// Turns by less than this go straight on, radians.
const STRAIGHT: f64 = 0.5;

/// A light of a lane: for the ways that turn so.
struct OfLane {
    direction: TrafficDirection,
    cycle: Vec<LightPhase>,
}

/// Lights, at the ends of the lanes that lead to what they are for.
pub fn lights(
    report: &Report,
    cut: &mut LaneSection<'_>,
    lights: &Lights,
    ids: &mut Ids,
) -> Vec<TrafficLight> {
    let mut made = Vec::new();
    let mut away = 0;
    let mut of_lanes: BTreeMap<usize, Vec<(&Lane, &Vec<LightPhase>)>> = BTreeMap::new();
    for (id, cycle) in lights {
        let place = cut.places[1].get(id);
        let lane = place.map(|place| cut.all[*place].lane);
        let from = lane.and_then(|lane| Some((lane, cut.from(lane)?)));
        match from {
            Some((lane, from)) => of_lanes.entry(from).or_default().push((lane, cycle)),
            None => away += 1,
        }
    }
    report.note_count(away, |n| {
        format!("traffic lights of connectors beyond the cut-out of the map left out: {n}")
    });
    for (place, connectors) in of_lanes {
        let own = cut.all[place].lane.id;
        let all = cut
            .layers
            .connectors
            .iter()
            .filter(|lane| lane.connector.as_ref().and_then(|c| c.from) == Some(own));
        let is_whole = all.count() == connectors.len();
        let stops = connectors
            .iter()
            .filter_map(|(lane, _)| lane.connector.as_ref());
        let stops: Vec<i64> = stops.flat_map(|c| c.stops.iter().copied()).collect();
        let stop = cut
            .layers
            .stops
            .iter()
            .find(|stop| stops.contains(&stop.id));
        let ring = stop.map(|stop| cut.ring(&stop.ring));
        let mut told: Vec<OfLane> = Vec::new();
        for (lane, cycle) in &connectors {
            let direction = if is_whole && connectors.iter().all(|(_, other)| other == cycle) {
                TrafficDirection::All
            } else {
                direction(cut, lane)
            };
            if !told
                .iter()
                .any(|t| t.direction == direction && t.cycle == **cycle)
            {
                told.push(OfLane {
                    direction,
                    cycle: cycle.to_vec(),
                });
            }
        }
        let placed = &mut cut.all[place];
        let own: Vec<i64> = told.iter().map(|_| ids.fresh()).collect();
        placed.lanelet.lights.extend(&own);
        let points = ring.and_then(|ring| line_at(placed, &ring));
        let line = placed.lanelet.stop_line.get_or_insert(StopLine {
            points,
            marking: LineMarking::Unknown,
            signs: Vec::new(),
            lights: Vec::new(),
        });
        line.lights.extend(&own);
        let position = placed.lanelet.right.points.last().copied();
        made.extend(told.into_iter().zip(own).map(|(told, id)| TrafficLight {
            id,
            position,
            active: true,
            direction: Some(told.direction),
            offset: 0,
            cycle: told.cycle,
        }));
    }
    report.note_count(made.len(), |n| {
        format!("traffic lights, which the data set derives from the traffic: {n}")
    });
    made
}

fn direction(cut: &LaneSection<'_>, connector: &Lane) -> TrafficDirection {
    match turn(cut, connector) {
        Turn::Left => TrafficDirection::Left,
        Turn::Straight => TrafficDirection::Straight,
        Turn::Right => TrafficDirection::Right,
    }
}

enum Turn {
    Left,
    Straight,
    Right,
}

/// Where a connector leads to: as the map says, or by its course.
fn turn(cut: &LaneSection<'_>, connector: &Lane) -> Turn {
    let said = connector.connector.as_ref().and_then(|c| c.turn);
    let course = || {
        let middle = &cut.all[*cut.places[1].get(&connector.id)?].middle;
        let directions = directions(middle);
        let (first, last) = (directions.first()?, directions.last()?);
        Some(first.perp(last).atan2(first.dot(last)))
    };
    match (said, course()) {
        (Some(0), _) => Turn::Straight,
        (Some(1 | 3), _) => Turn::Left,
        (Some(2), _) => Turn::Right,
        (_, Some(angle)) if angle > STRAIGHT => Turn::Left,
        (_, Some(angle)) if angle < -STRAIGHT => Turn::Right,
        _ => Turn::Straight,
    }
}

/// Intersections, with the roads that lead in.
pub fn intersections(cut: &mut LaneSection<'_>, ids: &mut Ids) -> Vec<Intersection> {
    // By the intersection, then by the road.
    let mut found: BTreeMap<i64, BTreeMap<(bool, i64), Incoming>> = BTreeMap::new();
    let mut inside = Vec::new();
    for (place, placed) in cut.all.iter().enumerate() {
        let Some(connector) = &placed.lane.connector else {
            continue;
        };
        let Some(intersection) = connector.intersection else {
            continue;
        };
        if cut.layers.without_traffic.contains(&intersection) {
            continue;
        }
        inside.push(place);
        let Some(from) = cut.from(placed.lane) else {
            continue;
        };
        let lane = cut.all[from].lane;
        let road = lane
            .group
            .map_or((false, lane.id), |(group, _)| (true, group));
        let roads = found.entry(intersection).or_default();
        let incoming = roads.entry(road).or_default();
        if !incoming.lanelets.contains(&cut.id(from)) {
            incoming.lanelets.push(cut.id(from));
        }
        let ways = match turn(cut, placed.lane) {
            Turn::Left => &mut incoming.left,
            Turn::Straight => &mut incoming.straight,
            Turn::Right => &mut incoming.right,
        };
        ways.push(cut.id(place));
    }
    for place in inside {
        cut.all[place].lanelet.types.push(LaneletType::Intersection);
    }
    let made = found.into_iter().map(|(id, roads)| Intersection {
        id: ids.keep(id),
        incomings: roads
            .into_values()
            .map(|incoming| Incoming {
                id: ids.fresh(),
                ..incoming
            })
            .collect(),
        crossings: Vec::new(),
    });
    made.collect()
}

/// What connectors are shown, by their ids in the map.
pub type Lights = BTreeMap<i64, Vec<LightPhase>>;

const COLUMNS: [&str; 3] = ["token", "lane_connector_id", "status"];

fn color(status: &str) -> SignalColor {
    match status {
        "green" => SignalColor::Green,
        "yellow" => SignalColor::Yellow,
        "red" => SignalColor::Red,
        _ => SignalColor::Inactive,
    }
}

/// The lights of some sweeps.
///
/// # Errors
/// A row is damaged.
pub fn read(database: &Database, clock: &Clock<'_>) -> Result<Lights, ReadError> {
    let table = "traffic_light_status";
    let mut said: BTreeMap<i64, BTreeMap<i64, SignalColor>> = BTreeMap::new();
    if !database.has(table) {
        return Ok(Lights::new());
    }
    let lights = &clock.log.lights;
    lights.each(database, table, &COLUMNS, clock, &mut |row, step| {
        let colors = said.entry(row.integer(1)?).or_default();
        colors.insert(step, color(&row.text(2)));
        Ok(())
    })?;
    let lights = said.into_iter().map(|(connector, colors)| {
        let mut cycle: Vec<LightPhase> = Vec::new();
        for (n, (_, step)) in clock.sweeps.iter().enumerate() {
            // Up to the next sweep; where nothing is said, it is not known.
            let next = clock.sweeps.get(n + 1).map_or(step + 1, |(_, next)| *next);
            let color = colors.get(step).copied().unwrap_or(SignalColor::Inactive);
            let duration = next - step;
            match cycle.last_mut() {
                Some(phase) if phase.color == color => phase.duration += duration,
                _ => cycle.push(LightPhase { duration, color }),
            }
        }
        (connector, cycle)
    });
    Ok(lights.collect())
}

/// Signs of a country for a speed limit in m/s, for a stop and to give way.
pub struct Signs {
    limit: &'static str,
    stop: &'static str,
    give_way: &'static str,
}

impl Signs {
    /// Those of the country of a map, by its name.
    pub fn for_map(map: &str) -> Self {
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
pub fn speed_limits(cut: &mut LaneSection<'_>, signs: &Signs, ids: &mut Ids) -> Vec<Sign> {
    let mut limits: BTreeMap<u64, Sign> = BTreeMap::new();
    for placed in &mut cut.all {
        let Some(limit) = placed.lane.limit.filter(|limit| *limit > 0.0) else {
            continue;
        };
        let sign = limits.entry(limit.to_bits()).or_insert_with(|| {
            let position = placed.lanelet.right.points.first().copied();
            let limit = (limit * 1e6).round() / 1e6;
            Sign::speed_limit(ids.fresh(), signs.limit, limit, position)
        });
        placed.lanelet.signs.push(sign.id);
    }
    limits.into_values().collect()
}

/// Signs at stop polygons, and the lines there.
pub fn stop_signs(
    report: &Report,
    cut: &mut LaneSection<'_>,
    signs: &Signs,
    ids: &mut Ids,
) -> Vec<Sign> {
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
fn lanes_of(cut: &LaneSection<'_>, stop: &Stop, ring: &[Point]) -> Vec<usize> {
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
