//! The map of a Waymo scenario: lanes, crossings, signs, and lights with what they show.

use std::collections::{BTreeMap, HashMap};

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::scenario::plausibility::MOST_PARTS;
use nearmiss_scene::scenario::{
    Lanelet, LightPhase, LineMarking, Sign, SignElement, SignalColor, StopLine, TrafficDirection,
    TrafficLight,
};

use super::Recorded;
use super::lanes::{self, Lane, Lines};
use super::messages::{MapFeature, MapPoint, StopSign};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{Ids, Map};
use crate::recordings::lane_shape::{self, directions, without_repeats};
use crate::recordings::{At, Report};

/// m/s in a mile an hour.
const MILE_AN_HOUR: f64 = 0.447_04;

/// The signs of the United States for a speed limit and for a stop.
const SPEED_LIMIT: &str = "R2-1";
const STOP: &str = "R1-1";

/// Half of a stop line, metres, where the lane is not known.
const HALF_STOP_LINE: f64 = 1.75;

/// Reads the map.
pub fn read(report: &Report, recorded: &Recorded, ids: &mut Ids) -> Result<Map, ReadError> {
    let features = &recorded.map_features;
    let (mut lines, mut edges, mut lanes) = (Lines::new(), Lines::new(), Vec::new());
    let mut lane_ids = HashMap::new();
    for (place, feature) in features.iter().enumerate() {
        let at = || report.at(format!("map_features[{place}]"));
        let id = feature.id.unwrap_or_default();
        if let Some(line) = &feature.road_line {
            lines.insert(id, points(&at(), &line.polyline)?.0);
        }
        if let Some(edge) = &feature.road_edge {
            edges.insert(id, points(&at(), &edge.polyline)?.0);
        }
        if let Some(said) = &feature.lane {
            let (centre, heights) = points(&at(), &said.polyline)?;
            let (centre, heights, places) = without_repeats(centre, heights);
            if centre.len() < 2 {
                let count = centre.len();
                at().warn(format!(
                    "lane {id} has {count} points; at least 2 are needed; left out"
                ));
                continue;
            }
            if lane_ids.contains_key(&id) {
                at().warn(format!("lane {id} is there twice; the first is used"));
                continue;
            }
            lane_ids.insert(id, ids.keep(id));
            lanes.push(Lane {
                feature: id,
                said,
                centre,
                heights,
                places,
            });
        }
    }
    let mut map = Map {
        lanelets: lanes::lanelets(report, &lanes, &lines, &edges, &lane_ids),
        ..Map::default()
    };
    forget_missing(report, &mut map.lanelets);
    let places: HashMap<i64, usize> = lanes.iter().map(|l| l.feature).zip(0..).collect();
    speed_limits(&lanes, ids, &mut map);
    stop_signs(report, features, &places, ids, &mut map)?;
    self::lights(report, recorded, &lanes, &places, ids, &mut map)?;
    crossings(report, features, ids, &mut map)?;
    Ok(map)
}

/// The points of a line, with their heights.
fn points(at: &At<'_>, line: &[MapPoint]) -> Result<(Vec<Point>, Vec<f64>), ReadError> {
    if line.len() > MOST_PARTS {
        return Err(at.fail(format!("more than {MOST_PARTS} points in one place")));
    }
    let mut all = (
        Vec::with_capacity(line.len()),
        Vec::with_capacity(line.len()),
    );
    for p in line {
        all.0.push(point(at, p)?);
        all.1.extend(p.z.map(|z| at.number(z)).transpose()?);
    }
    if all.1.len() != all.0.len() {
        all.1.clear();
    }
    Ok(all)
}

fn point(at: &At<'_>, p: &MapPoint) -> Result<Point, ReadError> {
    match (p.x, p.y) {
        (Some(x), Some(y)) => at.point(x, y),
        _ => Err(at.fail("a point without `x` and `y`")),
    }
}

/// Maps are cut out around the ego: lanes beyond the cut are named and not there.
fn forget_missing(report: &Report, lanelets: &mut [Lanelet]) {
    let known: std::collections::HashSet<i64> = lanelets.iter().map(|l| l.id).collect();
    let mut missing = 0;
    for lanelet in lanelets {
        for links in [&mut lanelet.predecessors, &mut lanelet.successors] {
            let before = links.len();
            links.retain(|id| known.contains(id));
            missing += before - links.len();
        }
    }
    report.note_count(missing, |n| {
        format!("links to lanes beyond the cut-out of the map left out: {n}")
    });
}

/// A sign for each speed limit, which all its lanes refer to.
fn speed_limits(lanes: &[Lane<'_>], ids: &mut Ids, map: &mut Map) {
    let mut limits: BTreeMap<u64, (i64, Sign)> = BTreeMap::new();
    for (lane, lanelet) in lanes.iter().zip(&mut map.lanelets) {
        let limit = lane.said.speed_limit_mph.unwrap_or(0.0);
        if !(limit > 0.0 && limit.is_finite()) {
            continue;
        }
        let (id, _) = limits.entry(limit.to_bits()).or_insert_with(|| {
            let id = ids.fresh();
            let metres = (limit * MILE_AN_HOUR * 1e6).round() / 1e6;
            let position = lanelet.right.points.first().copied();
            (id, Sign::speed_limit(id, SPEED_LIMIT, metres, position))
        });
        lanelet.signs.push(*id);
    }
    map.signs.extend(limits.into_values().map(|(_, sign)| sign));
}

fn stop_signs(
    report: &Report,
    features: &[MapFeature],
    lanes: &HashMap<i64, usize>,
    ids: &mut Ids,
    map: &mut Map,
) -> Result<(), ReadError> {
    let mut alone = 0;
    for (place, feature) in features.iter().enumerate() {
        let Some(StopSign { lane, position }) = &feature.stop_sign else {
            continue;
        };
        let at = report.at(format!("map_features[{place}]/stop_sign"));
        let known: Vec<usize> = { lane.iter() }
            .filter_map(|l| lanes.get(l).copied())
            .collect();
        // Readers of CommonRoad refuse a sign to which no lane refers.
        if known.is_empty() {
            alone += 1;
            continue;
        }
        let id = ids.keep(feature.id.unwrap_or_default());
        for lane in known {
            map.lanelets[lane].signs.push(id);
        }
        map.signs.push(Sign {
            id,
            position: position.as_ref().map(|p| point(&at, p)).transpose()?,
            is_virtual: false,
            elements: vec![SignElement {
                id: STOP.into(),
                values: Vec::new(),
            }],
        });
    }
    report.note_count(alone, |n| {
        format!("stop signs of no lane in the map left out: {n}")
    });
    Ok(())
}

fn lights(
    report: &Report,
    recorded: &Recorded,
    lanes: &[Lane<'_>],
    places: &HashMap<i64, usize>,
    ids: &mut Ids,
    map: &mut Map,
) -> Result<(), ReadError> {
    for said in read_lights(report, recorded)? {
        let Some(place) = places.get(&said.lane).copied() else {
            let at = report.at("dynamic_map_states");
            at.warn(format!("a light for missing lane {}; left out", said.lane));
            continue;
        };
        let id = ids.fresh();
        let lanelet = &mut map.lanelets[place];
        lanelet.lights.push(id);
        lanelet.stop_line = said.stop_point.map(|p| StopLine {
            points: Some(across(&p, &lanes[place].centre, lanelet)),
            marking: LineMarking::Unknown,
            signs: Vec::new(),
            lights: vec![id],
        });
        map.lights.push(said.light(id));
    }
    Ok(())
}

/// A line across a lane at a point of its middle.
fn across(at: &Point, centre: &[Point], lanelet: &Lanelet) -> (Point, Point) {
    let nearest = (0..centre.len()).min_by(|a, b| {
        let off = |i: &usize| (centre[*i] - at).norm_squared();
        off(a).total_cmp(&off(b))
    });
    let Some(i) = nearest else {
        return (*at, *at);
    };
    let along = directions(centre)[i];
    let left = Vector::new(-along.y, along.x);
    let off = |border: &[Point]| {
        border
            .get(i)
            .map_or(HALF_STOP_LINE, |p| (p - centre[i]).norm())
    };
    (
        at + left * off(&lanelet.left.points),
        at - left * off(&lanelet.right.points),
    )
}

fn crossings(
    report: &Report,
    features: &[MapFeature],
    ids: &mut Ids,
    map: &mut Map,
) -> Result<(), ReadError> {
    for (place, feature) in features.iter().enumerate() {
        let Some(said) = &feature.crosswalk else {
            continue;
        };
        let at = report.at(format!("map_features[{place}]/crosswalk"));
        let (ring, _) = points(&at, &said.polygon)?;
        let id = ids.keep(feature.id.unwrap_or_default());
        match lane_shape::of_ring(id, &ring) {
            Some(lanelet) => map.lanelets.push(lanelet),
            None => at.warn("a crosswalk without an area; left out"),
        }
    }
    Ok(())
}

/// A light by the lane that it is for, as the data set counts lanes.
pub struct LaneLight {
    pub lane: i64,
    pub stop_point: Option<Point>,
    pub cycle: Vec<LightPhase>,
}

/// The colour of a state of a signal.
fn color(state: i32) -> SignalColor {
    match state {
        // Arrows say the same to those they are for; a flashing light is told by its colour.
        1 | 4 | 7 => SignalColor::Red,
        2 | 5 | 8 => SignalColor::Yellow,
        3 | 6 => SignalColor::Green,
        _ => SignalColor::Inactive,
    }
}

/// The lights, by lane.
pub fn read_lights(report: &Report, recorded: &Recorded) -> Result<Vec<LaneLight>, ReadError> {
    let steps = recorded.timestamps_seconds.len();
    let mut lanes: BTreeMap<i64, (Option<Point>, Vec<SignalColor>)> = BTreeMap::new();
    for (step, states) in recorded.dynamic_map_states.iter().take(steps).enumerate() {
        for state in &states.lane_states {
            let Some(lane) = state.lane else { continue };
            let (point, colors) = lanes.entry(lane).or_default();
            if let (None, Some(stop)) = (&point, &state.stop_point) {
                let at = report.at(format!("dynamic_map_states[{step}]"));
                *point = Some(at.point(stop.x.unwrap_or(0.0), stop.y.unwrap_or(0.0))?);
            }
            // Where it is not said, it is not known.
            colors.resize(step, SignalColor::Inactive);
            colors.push(color(state.state.unwrap_or(0)));
        }
    }
    let lights = lanes.into_iter().map(|(lane, (stop_point, mut colors))| {
        colors.resize(steps, SignalColor::Inactive);
        let mut cycle: Vec<LightPhase> = Vec::new();
        for color in colors {
            match cycle.last_mut() {
                Some(phase) if phase.color == color => phase.duration += 1,
                _ => cycle.push(LightPhase { duration: 1, color }),
            }
        }
        LaneLight {
            lane,
            stop_point,
            cycle,
        }
    });
    Ok(lights.collect())
}

impl LaneLight {
    /// The light, under an id of the scenario.
    pub fn light(&self, id: i64) -> TrafficLight {
        TrafficLight {
            id,
            position: self.stop_point,
            active: true,
            direction: Some(TrafficDirection::All),
            offset: 0,
            cycle: self.cycle.clone(),
        }
    }
}
