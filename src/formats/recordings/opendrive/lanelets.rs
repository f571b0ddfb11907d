//! Lanes of roads as lanelets, with their neighbours, signs and lights.

use std::collections::{HashMap, HashSet};

use super::links::{Connection, Key, contacts};
use super::road::{End, Lane, Road, Section, Signal};
use super::{KeptSigns, TOLERANCE};
use crate::commonroad::builder::SourceLocation;
use crate::opendrive::signals::marking;
use crate::recordings::Report;
use crate::recordings::assembly::{Ids, Map};
use crate::recordings::lane_shape::without_repeats;
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Adjacent, Bound, Lanelet, LaneletType, LineMarking, RoadUser, Sign, SignElement, TrafficLight,
};

/// Lanes that are nowhere wider are none, metres.
const NARROW: f64 = 0.01;

/// The sign of a speed limit.
const LIMIT: &str = "274";

/// The type of traffic lights.
const LIGHT: &str = "1000001";

/// What roads became.
pub struct Lanes {
    /// The lanelets, signs and lights.
    pub map: Map,
    /// Lights by the ids of their signals.
    pub lights: HashMap<String, i64>,
    /// The signs and lights of an export, where the lanelets are those that it was made of.
    pub kept: Option<KeptSigns>,
}

/// The lanelets of roads.
pub fn lanelets(
    roads: &[Road],
    connections: &[Connection],
    report: &Report,
    ids: &mut Ids,
) -> Lanes {
    let lanes = || {
        roads
            .iter()
            .flat_map(|r| &r.sections)
            .flat_map(|s| &s.lanes)
    };
    // Ids that were lanelets' stay theirs.
    let mut own = HashMap::new();
    for id in lanes().filter_map(|l| l.lanelet) {
        *own.entry(id).or_insert(0) += 1;
    }
    let taken: HashSet<i64> = own
        .into_iter()
        .filter(|(id, count)| *id > 0 && *count == 1)
        .map(|(id, _)| id)
        .filter(|id| ids.take(*id))
        .collect();
    let signal_ids = roads
        .iter()
        .flat_map(|r| &r.signals)
        .filter_map(|s| s.id.parse().ok());
    let mut signal_ids: HashSet<i64> = signal_ids.filter(|id| *id > 0 && ids.take(*id)).collect();
    let mut map = Map::default();
    let mut places: HashMap<Key, usize> = HashMap::new();
    let mut limits = HashMap::new();
    for (r, road) in roads.iter().enumerate() {
        for (x, section) in road.sections.iter().enumerate() {
            let (borders, is_exact) = bounds(road, section);
            if !is_exact {
                let at = report.at(format!("road {}", road.id));
                at.warn(format!(
                    "too curved for borders within {TOLERANCE} m: they have as many points as are read"
                ));
            }
            for (l, lane) in section.lanes.iter().enumerate() {
                let Some((left, right)) = lanelet_bounds(road, section, l, &borders) else {
                    continue;
                };
                let id = lane
                    .lanelet
                    .filter(|id| taken.contains(id))
                    .unwrap_or_else(|| ids.fresh());
                let of_road = road.kind(section.from);
                let (types, mut one_way, mut both) =
                    types_and_users(road, of_road.map(|t| t.kind.as_str()), lane);
                if lane.is_both_ways {
                    both.append(&mut one_way);
                }
                let mut lanelet = Lanelet {
                    id,
                    left,
                    right,
                    types,
                    users_one_way: one_way,
                    users_bidirectional: both,
                    ..Lanelet::default()
                };
                let limit = lane.limit.or(of_road.and_then(|t| t.limit));
                if let Some(limit) = limit.filter(|_| lane.kind == "driving") {
                    let at = lanelet.right.points.first().copied();
                    let sign = limits.entry(limit.to_bits()).or_insert_with(|| {
                        map.signs
                            .push(Sign::speed_limit(ids.fresh(), LIMIT, limit, at));
                        map.signs.last().map_or(0, |s| s.id)
                    });
                    lanelet.signs.push(*sign);
                }
                places.insert((r, x, lane.id), map.lanelets.len());
                map.lanelets.push(lanelet);
            }
        }
    }
    neighbours(roads, &places, &mut map);
    successors(roads, connections, &places, &mut map);
    let lights = signals(roads, &places, &mut map, &mut signal_ids, report, ids);
    let kept = super::restore(roads, &places, &mut map);
    if map.lanelets.is_empty() {
        report.note("the roads have no lanes");
    }
    Lanes { map, lights, kept }
}

/// The points of all borders of a section, from the left to the right, along the road, and whether they are enough.
fn bounds(road: &Road, section: &Section) -> (Vec<Vec<Point>>, bool) {
    let mut all = vec![Vec::new(); section.lanes.len() + 1];
    let (places, is_exact) = road.places(section, TOLERANCE);
    let last = places.len().saturating_sub(1);
    for (i, s) in places.iter().enumerate() {
        // At its end a section is what it was, not what begins there.
        let at = if i == last { s - 1e-7 } else { *s };
        let across = road.borders(section, at);
        for (border, t) in all.iter_mut().zip(across) {
            border.push(road.point(*s, t));
        }
    }
    (all, is_exact)
}

fn lanelet_bounds(
    road: &Road,
    section: &Section,
    place: usize,
    borders: &[Vec<Point>],
) -> Option<(Bound, Bound)> {
    let lane = &section.lanes[place];
    if lane.kind == "none" {
        return None;
    }
    // The line in the middle is between the lanes of both sides: borders and lanes are counted alike.
    let (left, right) = (borders.get(place)?, borders.get(place + 1)?);
    let wide = left.iter().zip(right).any(|(a, b)| (a - b).norm() > NARROW);
    if !wide {
        return None;
    }
    let marks = |i: usize| -> LineMarking {
        // The border to the left of a lane on the right is that of its inner neighbour.
        let inner = section.lanes.get(i);
        let outer = i.checked_sub(1).and_then(|i| section.lanes.get(i));
        let mark = match (outer, inner) {
            (_, Some(inner)) if inner.id > 0 => inner.mark.as_ref(),
            (Some(outer), _) if outer.id < 0 => outer.mark.as_ref(),
            _ => section.middle_mark.as_ref(),
        };
        mark.map_or(LineMarking::Unknown, |(kind, weight)| marking(kind, weight))
    };
    let bound = |points: &Vec<Point>, marking: LineMarking, along: bool| {
        let (mut points, ..) = without_repeats(points.clone(), Vec::new());
        if !along {
            points.reverse();
        }
        (points.len() > 1).then_some(Bound {
            points,
            heights: Vec::new(),
            marking,
        })
    };
    let along = road.is_along(lane);
    let (a, b) = (
        bound(left, marks(place), along)?,
        bound(right, marks(place + 1), along)?,
    );
    Some(if along { (a, b) } else { (b, a) })
}

type Users = Vec<RoadUser>;

/// The types of a lane, and the road users that may use it one way and both ways.
fn types_and_users(
    road: &Road,
    of_road: Option<&str>,
    lane: &Lane,
) -> (Vec<LaneletType>, Users, Users) {
    let of_road = match of_road.unwrap_or_default() {
        "motorway" | "townExpressway" => Some(LaneletType::Highway),
        "rural" | "townArterial" => Some(LaneletType::Country),
        "town" | "townLocal" | "townCollector" | "lowSpeed" => Some(LaneletType::Urban),
        _ => None,
    };
    let vehicle = vec![RoadUser::Vehicle];
    let (kind, one_way, both) = match lane.kind.as_str() {
        "shoulder" => (Some(LaneletType::Shoulder), vehicle, vec![]),
        "border" | "curb" | "median" => (Some(LaneletType::Border), vec![], vec![]),
        "sidewalk" | "walking" => (
            Some(LaneletType::Sidewalk),
            vec![],
            vec![RoadUser::Pedestrian],
        ),
        "biking" => (
            Some(LaneletType::BicycleLane),
            vec![RoadUser::Bicycle],
            vec![],
        ),
        "bus" => (Some(LaneletType::BusLane), vec![RoadUser::Bus], vec![]),
        "stop" => (Some(LaneletType::BusStop), vehicle, vec![]),
        "tram" | "rail" => (Some(LaneletType::Tram), vec![RoadUser::Train], vec![]),
        "parking" => (Some(LaneletType::Parking), vehicle, vec![]),
        "restricted" => (Some(LaneletType::Restricted), vec![], vec![]),
        "onRamp" | "entry" => (Some(LaneletType::AccessRamp), vehicle, vec![]),
        "offRamp" | "exit" => (Some(LaneletType::ExitRamp), vehicle, vec![]),
        "bidirectional" => (None, vec![], vehicle),
        _ => (None, vehicle, vec![]),
    };
    let mut types: Vec<LaneletType> = kind.or(of_road).into_iter().collect();
    if types.is_empty() {
        types.push(LaneletType::Unknown);
    }
    if road.is_connecting && !types.contains(&LaneletType::Intersection) {
        types.push(LaneletType::Intersection);
    }
    (types, one_way, both)
}

fn neighbours(roads: &[Road], places: &HashMap<Key, usize>, map: &mut Map) {
    for (r, road) in roads.iter().enumerate() {
        for (x, section) in road.sections.iter().enumerate() {
            for pair in section.lanes.windows(2) {
                let (Some(a), Some(b)) = (
                    places.get(&(r, x, pair[0].id)).copied(),
                    places.get(&(r, x, pair[1].id)).copied(),
                ) else {
                    continue;
                };
                let same = road.is_along(&pair[0]) == road.is_along(&pair[1]);
                let (left, right) = (map.lanelets[a].id, map.lanelets[b].id);
                let beside = |id| {
                    Some(Adjacent {
                        id,
                        same_direction: same,
                    })
                };
                // Seen along the road; the other way round for those that drive against it.
                if road.is_along(&pair[0]) {
                    map.lanelets[a].adjacent_right = beside(right)
                } else {
                    map.lanelets[a].adjacent_left = beside(right)
                }
                if road.is_along(&pair[1]) {
                    map.lanelets[b].adjacent_left = beside(left)
                } else {
                    map.lanelets[b].adjacent_right = beside(left)
                }
            }
        }
    }
}

fn successors(
    roads: &[Road],
    connections: &[Connection],
    places: &HashMap<Key, usize>,
    map: &mut Map,
) {
    let leaves = |key: &Key, at: End| {
        let road = &roads[key.0];
        let lane = road.sections[key.1].lanes.iter().find(|l| l.id == key.2);
        lane.is_some_and(|lane| road.is_along(lane) == (at == End::End))
    };
    for ((a, end_a), (b, end_b)) in contacts(roads, connections) {
        let (Some(x), Some(y)) = (places.get(&a).copied(), places.get(&b).copied()) else {
            continue;
        };
        let (from, to) = match (leaves(&a, end_a), leaves(&b, end_b)) {
            (true, false) => (x, y),
            (false, true) => (y, x),
            _ => continue,
        };
        let (from_id, to_id) = (map.lanelets[from].id, map.lanelets[to].id);
        if !map.lanelets[from].successors.contains(&to_id) {
            map.lanelets[from].successors.push(to_id);
            map.lanelets[to].predecessors.push(from_id);
        }
    }
}

fn signals(
    roads: &[Road],
    places: &HashMap<Key, usize>,
    map: &mut Map,
    own_ids: &mut HashSet<i64>,
    report: &Report,
    ids: &mut Ids,
) -> HashMap<String, i64> {
    let mut lights = HashMap::new();
    let (mut idle, mut others) = (0, 0);
    for (r, road) in roads.iter().enumerate() {
        for signal in &road.signals {
            let s = signal.s.clamp(0.0, road.length);
            let section = road
                .sections
                .iter()
                .rposition(|x| x.from <= s + 1e-9)
                .unwrap_or(0);
            let lanes = road.sections[section]
                .lanes
                .iter()
                .filter(|lane| holds(signal, road, lane));
            let on: Vec<usize> = lanes
                .filter_map(|l| places.get(&(r, section, l.id)).copied())
                .collect();
            if on.is_empty() {
                idle += 1;
                continue;
            }
            let written = signal.id.parse().ok();
            let own = written.filter(|id| own_ids.remove(id));
            let id = own.unwrap_or_else(|| ids.fresh());
            let position = Some(road.point(s, signal.t));
            if signal.is_dynamic || signal.kind == LIGHT {
                lights.insert(signal.id.clone(), id);
                map.lights.push(TrafficLight {
                    id,
                    position,
                    active: false,
                    direction: None,
                    offset: 0,
                    cycle: Vec::new(),
                });
                on.iter().for_each(|l| map.lanelets[*l].lights.push(id));
                continue;
            }
            // Stop lines are no signs.
            if signal.kind == "294" || signal.kind.is_empty() {
                continue;
            }
            if signal.kind == LIMIT {
                // Where its lanes tell a limit, that holds.
                let told = map.signs.iter().filter(|sign| {
                    sign.is_virtual && on.iter().any(|l| map.lanelets[*l].signs.contains(&sign.id))
                });
                let told: Vec<f64> = told.filter_map(Sign::limit).collect();
                let is_other = |value: f64| told.iter().any(|told| (told - value).abs() > 0.1);
                others += usize::from(signal.value.is_some_and(is_other));
                if !told.is_empty() || signal.value.is_none() {
                    continue;
                }
            }
            let number = match signal.subtype.as_str() {
                "" | "-1" | "none" => signal.kind.clone(),
                subtype => format!("{}-{subtype}", signal.kind),
            };
            map.signs.push(Sign {
                id,
                position,
                is_virtual: false,
                elements: vec![SignElement {
                    id: number,
                    values: signal.value.iter().map(f64::to_string).collect(),
                }],
            });
            on.iter().for_each(|l| map.lanelets[*l].signs.push(id));
        }
    }
    report.note_count(others, |n| {
        format!(
            "speed limit signs with another value than <speed> of their lanes: {n}; <speed> holds"
        )
    });
    report.note_count(idle, |n| {
        format!("signals for which there is no lane in the direction that they face: {n}; left out")
    });
    lights
}

/// Whether a signal is for those on a lane.
fn holds(signal: &Signal, road: &Road, lane: &Lane) -> bool {
    let within = |(a, b): &(i64, i64)| (*a.min(b)..=*a.max(b)).contains(&lane.id);
    match (&signal.lanes[..], road.is_along(lane)) {
        ([], true) => signal.along || lane.is_both_ways,
        ([], false) => signal.against || lane.is_both_ways,
        (lanes, _) => lanes.iter().any(within),
    }
}
