//! Signs, lights and stop lines beside a road, and the words of OpenDRIVE for lanelets and borders.

use std::collections::{BTreeSet, HashSet};

use nearmiss_base::geometry::{Point, Polyline};
use nearmiss_scene::scenario::{
    Lanelet, LaneletNetwork, LaneletType, LineMarking, RoadUser, Sign, SignElement, SignMeaning,
};

use super::links::LinkedRoad;

/// A signal of a road.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Unique in the file.
    pub id: String,
    /// In words.
    pub name: String,
    /// Along the road and to its left, metres.
    pub place: (f64, f64),
    /// The country's number of it.
    pub kind: String,
    /// Its subtype.
    pub subtype: String,
    /// A value with its unit.
    pub value: Option<(f64, &'static str)>,
    /// Whether it changes.
    pub is_dynamic: bool,
    /// Lanes for which it holds, counted from the left.
    pub lanes: Vec<usize>,
}

/// The type of traffic lights, as the field writes them.
const LIGHT: &str = "1000001";

/// The type of a stop line.
pub const STOP_LINE: &str = "294";

/// What a file says of a signal, apart from its place.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SignalKey {
    id: String,
    kind: String,
    subtype: String,
}

impl SignalKey {
    /// From the attributes of a signal.
    pub fn new(id: &str, kind: &str, subtype: &str) -> Self {
        Self {
            id: id.into(),
            kind: kind.into(),
            subtype: subtype.into(),
        }
    }
}

/// The signals of a network, without stop lines: signs and lights that hold on a lanelet.
pub fn signal_keys(network: &LaneletNetwork) -> BTreeSet<SignalKey> {
    let holds = |ids: fn(&Lanelet) -> &Vec<i64>| -> HashSet<i64> {
        network.lanelets.iter().flat_map(ids).copied().collect()
    };
    let (on_signs, on_lights) = (holds(|l| &l.signs), holds(|l| &l.lights));
    let signs = network
        .signs
        .iter()
        .filter(|s| on_signs.contains(&s.id))
        .flat_map(|sign| {
            sign.elements.iter().enumerate().map(|(i, element)| {
                let (kind, subtype) = number(element);
                SignalKey::new(&sign_id(sign, i), &kind, &subtype)
            })
        });
    let lights = network
        .lights
        .iter()
        .filter(|l| on_lights.contains(&l.id))
        .map(|l| SignalKey::new(&l.id.to_string(), LIGHT, NO_SUBTYPE));
    let not_a_line = |key: &SignalKey| key.kind != STOP_LINE;
    signs.chain(lights).filter(not_a_line).collect()
}

/// What stands where there is no subtype.
const NO_SUBTYPE: &str = "-1";

/// The id of one of the signs on a post.
fn sign_id(sign: &Sign, place: usize) -> String {
    match place {
        0 => sign.id.to_string(),
        i => format!("{}-{i}", sign.id),
    }
}

/// A place along a road and beside it, metres.
fn place(road: &LinkedRoad, point: &Point) -> (f64, f64) {
    let length = road.road.length();
    let count = (length / 0.5).ceil().clamp(1.0, 4000.0) as usize;
    let at = |i: usize| length * i as f64 / count as f64;
    let all = (0..=count).map(|i| road.road.curve.at(at(i)).position);
    let Some(line) = Polyline::new(all) else {
        return (0.0, 0.0);
    };
    let share = line.project(point).s / line.length().max(1e-9);
    let mut s = (share * length).clamp(0.0, length);
    // The foot of the perpendicular on the curve itself.
    for _ in 0..8 {
        let ahead = road.road.curve.at(s).to_local(point).x;
        s = (s + ahead).clamp(0.0, length);
    }
    (s, road.road.curve.at(s).to_local(point).y)
}

/// The signals of a road. Each sign and light stands at the road of the first lanelet that it holds on.
pub fn of_road(
    network: &LaneletNetwork,
    road: &LinkedRoad,
    country: &str,
    written: &mut HashSet<i64>,
) -> Vec<Signal> {
    if road.is_cut {
        return Vec::new();
    }
    let lanelets: Vec<&Lanelet> = road
        .road
        .lanelets
        .iter()
        .map(|place| &network.lanelets[*place])
        .collect();
    let lanes = |holds: &dyn Fn(&Lanelet) -> bool| -> Vec<usize> {
        let all = lanelets.iter().enumerate();
        all.filter(|(_, l)| holds(l)).map(|(i, _)| i).collect()
    };
    let end = |lane: usize| lanelets[lane].right.points.last().copied();
    let mut all = Vec::new();
    for sign in &network.signs {
        let holds = lanes(&|l| l.signs.contains(&sign.id));
        let Some(first) = holds.first().copied() else {
            continue;
        };
        if !written.insert(sign.id) {
            continue;
        }
        let begin = lanelets[first].right.points.first().copied();
        let Some(at) = sign.position.or(begin) else {
            continue;
        };
        for (i, element) in sign.elements.iter().enumerate() {
            let (kind, subtype) = number(element);
            all.push(Signal {
                id: sign_id(sign, i),
                name: sign_text(element),
                place: place(road, &at),
                kind,
                subtype,
                value: value(element, country),
                is_dynamic: false,
                lanes: holds.clone(),
            });
        }
    }
    for light in &network.lights {
        let holds = lanes(&|l| l.lights.contains(&light.id));
        let Some(first) = holds.first().copied() else {
            continue;
        };
        if !written.insert(light.id) {
            continue;
        }
        let Some(at) = light.position.or_else(|| end(first)) else {
            continue;
        };
        all.push(Signal {
            id: light.id.to_string(),
            name: format!("light {}", light.id),
            place: place(road, &at),
            kind: LIGHT.into(),
            subtype: NO_SUBTYPE.into(),
            value: None,
            is_dynamic: true,
            lanes: holds,
        });
    }
    for (lane, lanelet) in lanelets.iter().enumerate() {
        let Some((a, b)) = lanelet.stop_line_ends() else {
            continue;
        };
        all.push(Signal {
            id: format!("stop-{}", lanelet.id),
            name: "stop line".into(),
            place: place(road, &nalgebra::center(&a, &b)),
            kind: STOP_LINE.into(),
            subtype: NO_SUBTYPE.into(),
            value: None,
            is_dynamic: false,
            lanes: vec![lane],
        });
    }
    all
}

/// `283-10` is subtype 10 of sign 283.
fn number(element: &SignElement) -> (String, String) {
    let split = element.id.split_once('-');
    let whole = split.filter(|(a, _)| a.bytes().all(|b| b.is_ascii_digit()));
    match whole {
        Some((a, b)) => (a.to_string(), b.to_string()),
        None => (element.id.clone(), NO_SUBTYPE.into()),
    }
}

fn sign_text(element: &SignElement) -> String {
    match element.meaning() {
        Some(SignMeaning::SpeedLimit(_)) => "speed limit".into(),
        Some(SignMeaning::LeastSpeed(_)) => "minimum speed".into(),
        Some(SignMeaning::Words(words)) => words.into(),
        None => format!("sign {}", element.id),
    }
}

fn value(element: &SignElement, country: &str) -> Option<(f64, &'static str)> {
    match element.meaning()? {
        SignMeaning::SpeedLimit(v) | SignMeaning::LeastSpeed(v) => Some(match country {
            "US" | "GB" => (v * 2.236_936, "mph"),
            _ => (v * 3.6, "km/h"),
        }),
        SignMeaning::Words(_) => None,
    }
}

/// The speed limit that signs give a lanelet, m/s.
pub fn speed_limit(network: &LaneletNetwork, lanelet: &Lanelet) -> Option<f64> {
    let signs = network
        .signs
        .iter()
        .filter(|s| lanelet.signs.contains(&s.id));
    let limits = signs
        .flat_map(|s| &s.elements)
        .filter_map(|e| match e.meaning() {
            Some(SignMeaning::SpeedLimit(v)) => Some(v),
            _ => None,
        });
    limits.min_by(f64::total_cmp)
}

/// The type of a lane.
pub fn lane_type(lanelet: &Lanelet) -> &'static str {
    let is = |wanted: LaneletType| lanelet.types.contains(&wanted);
    let by_type = [
        (LaneletType::Shoulder, "shoulder"),
        (LaneletType::Sidewalk, "sidewalk"),
        (LaneletType::Crosswalk, "sidewalk"),
        (LaneletType::BicycleLane, "biking"),
        (LaneletType::BusLane, "bus"),
        (LaneletType::BusStop, "stop"),
        (LaneletType::Tram, "tram"),
        (LaneletType::Parking, "parking"),
        (LaneletType::Border, "border"),
        (LaneletType::Restricted, "restricted"),
        (LaneletType::RestrictedArea, "restricted"),
        (LaneletType::AccessRamp, "onRamp"),
        (LaneletType::ExitRamp, "offRamp"),
    ];
    if let Some((_, word)) = by_type.iter().find(|(t, _)| is(*t)) {
        return word;
    }
    let users = || {
        lanelet
            .users_one_way
            .iter()
            .chain(&lanelet.users_bidirectional)
    };
    let only =
        |wanted: &[RoadUser]| users().next().is_some() && users().all(|u| wanted.contains(u));
    if only(&[RoadUser::Pedestrian]) {
        "sidewalk"
    } else if only(&[RoadUser::Bicycle, RoadUser::Pedestrian]) {
        "biking"
    } else if lanelet.users_bidirectional.contains(&RoadUser::Vehicle)
        || lanelet.users_bidirectional.contains(&RoadUser::Car)
    {
        "bidirectional"
    } else {
        "driving"
    }
}

/// The type of a road.
pub fn road_type(lanelets: &[&Lanelet]) -> &'static str {
    let any = |wanted: LaneletType| lanelets.iter().any(|l| l.types.contains(&wanted));
    if any(LaneletType::Interstate) || any(LaneletType::Highway) {
        "motorway"
    } else if any(LaneletType::Country) {
        "rural"
    } else if lanelets.iter().all(|l| matches!(lane_type(l), "sidewalk")) {
        "pedestrian"
    } else if lanelets.iter().all(|l| lane_type(l) == "biking") {
        "bicycle"
    } else if any(LaneletType::Urban) || any(LaneletType::Intersection) {
        "town"
    } else {
        "unknown"
    }
}

/// A marking of a border: its type and weight.
pub fn road_mark(marking: LineMarking) -> (&'static str, &'static str) {
    match marking {
        LineMarking::Dashed => ("broken", "standard"),
        LineMarking::Solid => ("solid", "standard"),
        LineMarking::SolidSolid => ("solid solid", "standard"),
        LineMarking::DashedDashed => ("broken broken", "standard"),
        LineMarking::SolidDashed => ("solid broken", "standard"),
        LineMarking::DashedSolid => ("broken solid", "standard"),
        LineMarking::Curb | LineMarking::LoweredCurb => ("curb", "standard"),
        LineMarking::BroadDashed => ("broken", "bold"),
        LineMarking::BroadSolid => ("solid", "bold"),
        LineMarking::NoMarking | LineMarking::Unknown => ("none", "standard"),
    }
}

/// The marking that a type and weight tell.
pub fn marking(kind: &str, weight: &str) -> LineMarking {
    match (kind, weight) {
        ("broken", "bold") => LineMarking::BroadDashed,
        ("solid", "bold") => LineMarking::BroadSolid,
        ("broken", _) => LineMarking::Dashed,
        ("solid", _) => LineMarking::Solid,
        ("solid solid", _) => LineMarking::SolidSolid,
        ("broken broken", _) => LineMarking::DashedDashed,
        ("solid broken", _) => LineMarking::SolidDashed,
        ("broken solid", _) => LineMarking::DashedSolid,
        ("curb", _) => LineMarking::Curb,
        ("none", _) => LineMarking::NoMarking,
        _ => LineMarking::Unknown,
    }
}
