//! The lanes of a SUMO net as lanelets, with their links, limits, and the programs of its lights.

use std::collections::HashMap;

use nearmiss_scene::scenario::{
    Adjacent, ContentHash, Lanelet, LaneletType, LightPhase, LineMarking, RoadUser, Sign,
    SignElement, SignalColor, TrafficDirection, TrafficLight,
};

use super::net::{Connection, Net, NetLane};
use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml};
use crate::recordings::assembly::{Ids, Map};
use crate::recordings::lane_shape::{borders, without_repeats};
use crate::recordings::report::{Leftovers, Report};

/// The lanes of a net, with the lights as they are from `start` on in steps of `dt` seconds.
pub fn map(
    report: &Report,
    net: &Net,
    ids: &mut Ids,
    (start, dt): (f64, f64),
) -> (Map, ContentHash) {
    let Net {
        lanes,
        connections,
        programs,
        hash,
        leftovers,
        ..
    } = net;
    leftovers.report_to(report);
    let mut map = lanelets(lanes, connections, ids);
    let actuated = programs.values().filter(|p| !p.is_static).count();
    report.note_count(actuated, |n| {
        format!("traffic lights that are not static: {n}; the phases of their program are taken as they stand")
    });
    let places = names(&map.names);
    for connection in connections {
        let Some((light, link)) = &connection.light else {
            continue;
        };
        let on = connection
            .via
            .clone()
            .unwrap_or_else(|| lane_name(&connection.from));
        let (Some(place), Some(program)) = (places.get(&on), programs.get(light)) else {
            continue;
        };
        let lanelet = &mut map.lanelets[*place];
        if let Some(light) = program.light(*link, start, dt) {
            let id = ids.fresh();
            let position = lanelet.right.points.first().copied();
            lanelet.lights.push(id);
            map.lights.push(nearmiss_scene::scenario::TrafficLight {
                id,
                position,
                ..light
            });
        }
    }
    let map = Map {
        lanelets: map.lanelets,
        signs: map.signs,
        lights: map.lights,
        ..Map::default()
    };
    (map, *hash)
}

fn names(names: &[String]) -> HashMap<String, usize> {
    names.iter().cloned().zip(0..).collect()
}

fn lane_name((edge, index): &(String, i64)) -> String {
    format!("{edge}_{index}")
}

/// Lanelets with the names of their lanes.
struct NamedMap {
    names: Vec<String>,
    lanelets: Vec<Lanelet>,
    signs: Vec<Sign>,
    lights: Vec<nearmiss_scene::scenario::TrafficLight>,
}

fn lanelets(lanes: &[NetLane], connections: &[Connection], ids: &mut Ids) -> NamedMap {
    let mut map = NamedMap {
        names: Vec::new(),
        lanelets: Vec::new(),
        signs: Vec::new(),
        lights: Vec::new(),
    };
    let mut limits: HashMap<u64, i64> = HashMap::new();
    let mut kept = Vec::new();
    for lane in lanes {
        let (centre, ..) = without_repeats(lane.shape.clone(), Vec::new());
        if centre.len() < 2 {
            continue;
        }
        let half = lane.width / 2.0;
        let (mut left, mut right) = borders(&centre, &[], &vec![(half, half); centre.len()]);
        if !lane.internal && !lane.crossing {
            (left.marking, right.marking) = (LineMarking::Unknown, LineMarking::Unknown);
        } else {
            (left.marking, right.marking) = (LineMarking::NoMarking, LineMarking::NoMarking);
        }
        let kind = match lane.users[..] {
            _ if lane.crossing => LaneletType::Crosswalk,
            [RoadUser::Pedestrian] => LaneletType::Sidewalk,
            [RoadUser::Bicycle] => LaneletType::BicycleLane,
            [RoadUser::Bus] => LaneletType::BusLane,
            [RoadUser::Train] => LaneletType::Tram,
            _ => LaneletType::Urban,
        };
        let mut lanelet = Lanelet {
            id: ids.fresh(),
            left,
            right,
            types: vec![kind],
            ..Lanelet::default()
        };
        if lane.internal {
            lanelet.types.push(LaneletType::Intersection);
        }
        if lane.crossing || lane.users == [RoadUser::Pedestrian] {
            lanelet.users_bidirectional = vec![RoadUser::Pedestrian]
        } else {
            lanelet.users_one_way = lane.users.clone()
        }
        let limit = lane
            .speed
            .filter(|v| *v > 0.0 && kind == LaneletType::Urban && !lane.internal);
        if let Some(limit) = limit {
            let id = *limits.entry(limit.to_bits()).or_insert_with(|| {
                let id = ids.fresh();
                map.signs.push(Sign {
                    id,
                    position: lanelet.right.points.first().copied(),
                    is_virtual: true,
                    elements: vec![SignElement {
                        id: "274".into(),
                        values: vec![limit.to_string()],
                    }],
                });
                id
            });
            lanelet.signs.push(id);
        }
        map.names.push(lane_name(&(lane.edge.clone(), lane.index)));
        map.lanelets.push(lanelet);
        kept.push(lane);
    }
    link(&mut map, &kept, connections);
    map
}

fn link(map: &mut NamedMap, lanes: &[&NetLane], connections: &[Connection]) {
    let places = names(&map.names);
    for connection in connections {
        let to = connection
            .via
            .clone()
            .unwrap_or_else(|| lane_name(&connection.to));
        let from = places.get(&lane_name(&connection.from));
        let (Some(from), Some(to)) = (from, places.get(&to)) else {
            continue;
        };
        let (from_id, to_id) = (map.lanelets[*from].id, map.lanelets[*to].id);
        let successors = &mut map.lanelets[*from].successors;
        if !successors.contains(&to_id) {
            successors.push(to_id);
            map.lanelets[*to].predecessors.push(from_id);
        }
    }
    for (place, lane) in lanes.iter().enumerate() {
        // On junctions, lanes of one edge may part.
        if lane.internal || lane.crossing {
            continue;
        }
        // Lanes are counted from the right.
        let Some(left) = places.get(&lane_name(&(lane.edge.clone(), lane.index + 1))) else {
            continue;
        };
        let adjacent = |id| {
            Some(Adjacent {
                id,
                same_direction: true,
            })
        };
        let (own, other) = (map.lanelets[place].id, map.lanelets[*left].id);
        map.lanelets[place].adjacent_left = adjacent(other);
        map.lanelets[*left].adjacent_right = adjacent(own);
    }
}

/// A program: its phases one after the other.
pub struct Program {
    pub is_static: bool,
    /// Seconds by which it is delayed.
    offset: f64,
    /// Seconds, and the signal of each connection.
    phases: Vec<(f64, String)>,
}

/// Phases longer than this are none, seconds.
const LONGEST: f64 = 1e6;

/// Reads a program, with the id of its light.
pub fn program<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    leftovers: &mut Leftovers,
) -> Result<(String, Program), ReadError> {
    leftovers.attributes(xml, element, &["id", "type", "offset", "programID"]);
    let id = xml
        .attribute(element, "id")
        .unwrap_or_default()
        .into_owned();
    let kind = xml.attribute(element, "type");
    let is_static = kind.is_none_or(|kind| kind == "static");
    let offset = xml
        .attribute(element, "offset")
        .and_then(|o| o.parse::<f64>().ok());
    let mut phases = Vec::new();
    while let Some(child) = xml.next()? {
        if child.name != "phase" {
            leftovers.element(xml, "tlLogic", child)?;
            continue;
        }
        leftovers.attributes(xml, child, &["duration", "state"]);
        let text = xml.attribute(child, "duration").unwrap_or_default();
        let seconds = text
            .parse::<f64>()
            .ok()
            .filter(|s| (0.0..=LONGEST).contains(s))
            .ok_or_else(|| {
                let shown: String = text.chars().take(40).collect();
                xml.fail(
                    child.at,
                    format!("duration=\"{shown}\" is not a number of seconds"),
                )
            })?;
        let state = xml
            .attribute(child, "state")
            .unwrap_or_default()
            .into_owned();
        phases.push((seconds, state));
        xml.check_count(element, phases.len(), "phases")?;
        xml.skip()?;
    }
    let offset = offset.filter(|o| o.is_finite() && o.abs() < LONGEST);
    let program = Program {
        is_static,
        offset: offset.unwrap_or(0.0),
        phases,
    };
    Ok((id, program))
}

impl Program {
    /// The light of a connection as it is from `start` on, in steps of `dt` seconds; its id is still to be given.
    pub fn light(&self, link: usize, start: f64, dt: f64) -> Option<TrafficLight> {
        let steps = |seconds: f64| (seconds / dt).round() as i64;
        let mut cycle: Vec<LightPhase> = Vec::new();
        for (seconds, state) in &self.phases {
            let color = match state.as_bytes().get(link)? {
                b'r' => SignalColor::Red,
                b'y' | b'Y' => SignalColor::Yellow,
                b'g' | b'G' | b's' => SignalColor::Green,
                b'u' => SignalColor::RedYellow,
                _ => SignalColor::Inactive,
            };
            let duration = steps(*seconds);
            match cycle.last_mut() {
                Some(phase) if phase.color == color => phase.duration += duration,
                _ => cycle.push(LightPhase { duration, color }),
            }
        }
        let whole: i64 = cycle.iter().map(|p| p.duration).sum();
        if whole <= 0 {
            return None;
        }
        Some(TrafficLight {
            id: 0,
            position: None,
            active: true,
            direction: Some(TrafficDirection::All),
            offset: steps(self.offset - start).rem_euclid(whole),
            cycle,
        })
    }
}
