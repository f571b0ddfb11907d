//! Intersections of a map, and the traffic lights at the ends of the lanes that lead to them.

use std::collections::BTreeMap;

use super::lanes::Cut;
use super::layers::Lane;
use super::lights::Lights;
use super::signs::line_at;
use crate::recordings::ids::Ids;
use crate::recordings::lane_shape::directions;
use crate::recordings::report::Report;
use nearmiss_scene::scenario::{
    Incoming, Intersection, LaneletType, LightPhase, LineMarking, StopLine, TrafficDirection,
    TrafficLight,
};

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
    cut: &mut Cut<'_>,
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

fn direction(cut: &Cut<'_>, connector: &Lane) -> TrafficDirection {
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
fn turn(cut: &Cut<'_>, connector: &Lane) -> Turn {
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
pub fn intersections(cut: &mut Cut<'_>, ids: &mut Ids) -> Vec<Intersection> {
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
