//! The map file of 2024: the road, and what stands beside it for good.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::header::{self, Map};
use super::map_elements::{Pending, Side, intersection, lanelet, light, sign, stop_line};
use super::messages::{Boundary, MapInformation, MapSign, MapStopLine};
use super::report::{At, Report};
use super::wire::{Field, Fields};
use super::words::{ENVIRONMENT_2024, MAP_OBSTACLE_TYPES};
use super::{obstacles, place, road};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{
    Bound, Header, Intersection, Lanelet, Location, ObstacleParts, Severity, Sign, StopLine,
    TrafficLight,
};

/// A map has no time steps; these are the usual ones, seconds.
pub(super) const TIME_STEP_SIZE: f64 = 0.1;

/// A border has two sides; roads that cross share a few. More users would let a small file fill the memory.
const MOST_USERS: usize = 64;

/// What a map file says.
pub(super) struct RoadMap {
    pub header: Header,
    pub location: Location,
    pub lanelets: Vec<Lanelet>,
    pub signs: Vec<Sign>,
    pub lights: Vec<TrafficLight>,
    pub intersections: Vec<Intersection>,
    pub obstacles: Vec<ObstacleParts>,
}

/// What was read so far.
#[derive(Default)]
struct Found {
    information: Option<(Map, Header)>,
    location: Option<Location>,
    lanelets: Vec<Pending>,
    stop_lines: HashMap<i64, StopLine>,
    boundaries: HashMap<i64, (Bound, usize)>,
    areas: usize,
    signs: Vec<MapSign>,
    lights: Vec<TrafficLight>,
    intersections: Vec<Intersection>,
    obstacles: Vec<ObstacleParts>,
}

pub(super) fn read(r: &mut Report, root: &At<'_>, bytes: &[u8]) -> Result<RoadMap, ReadError> {
    let mut found = Found::default();
    for field in Fields::of(bytes) {
        let field = r.whole(root, field)?;
        found.add(r, root, &field)?;
    }
    let (map, header) = r.need(root, "map_meta_information", found.information.take())?;
    let location = r.need(root, "location", found.location.take())?;
    if found.areas > 0 {
        let message = format!("{} areas have no place here and were left out", found.areas);
        r.note(Severity::Note, root, message);
    }
    let mut lanelets = Vec::with_capacity(found.lanelets.len());
    for (i, pending) in std::mem::take(&mut found.lanelets).into_iter().enumerate() {
        lanelets.push(found.complete(r, &root.nth("lanelets", i), pending)?);
    }
    let mut signs = Vec::with_capacity(found.signs.len());
    for (i, message) in found.signs.iter().enumerate() {
        signs.push(sign(
            r,
            &root.nth("traffic_signs", i),
            message,
            &map.country,
        )?);
    }
    Ok(RoadMap {
        header,
        location,
        lanelets,
        signs,
        lights: found.lights,
        intersections: found.intersections,
        obstacles: found.obstacles,
    })
}

impl Found {
    fn add(&mut self, r: &mut Report, root: &At<'_>, field: &Field<'_>) -> Result<(), ReadError> {
        let at = |name| root.field(name);
        match field.number {
            1 => {
                let at = at("map_meta_information");
                r.part(&at, field, &mut self.information, information)
            }
            2 => r.part(&at("location"), field, &mut self.location, |r, at, m| {
                place::location(r, at, m, &ENVIRONMENT_2024)
            }),
            3 => {
                let (at, into) = (at("lanelets"), &mut self.lanelets);
                r.element(&at, field, into, lanelet, |l: &Pending| l.lanelet.id)
            }
            4 => {
                let at = root.nth("stop_lines", self.stop_lines.len());
                let message: MapStopLine = r.decode(&at, field)?;
                let (id, line) = stop_line(r, &at, &message)?;
                keep_first(r, &at, &mut self.stop_lines, id, line);
                Ok(())
            }
            5 => {
                let at = root.nth("boundaries", self.boundaries.len());
                let message: Boundary = r.decode(&at, field)?;
                let id = r.need(&at, "boundary_id", message.boundary_id)?;
                let bound = road::bound(r, &at, &message.points, message.line_marking)?;
                keep_first(r, &at, &mut self.boundaries, id.into(), (bound, 0));
                Ok(())
            }
            6 => {
                self.areas += 1;
                Ok(())
            }
            7 => {
                let (at, into) = (at("traffic_signs"), &mut self.signs);
                let read = |r: &mut Report, at: &At<'_>, m: &MapSign| {
                    r.need(at, "traffic_sign_id", m.traffic_sign_id)?;
                    Ok(m.clone())
                };
                let id = |s: &MapSign| s.traffic_sign_id.unwrap_or_default().into();
                r.element(&at, field, into, read, id)
            }
            8 => r.element(&at("traffic_lights"), field, &mut self.lights, light, |l| {
                l.id
            }),
            9 => {
                let (at, into) = (at("intersections"), &mut self.intersections);
                r.element(&at, field, into, intersection, |i| i.id)
            }
            10 => {
                let (at, into) = (at("environment_obstacles"), &mut self.obstacles);
                let read = |r: &mut Report, at: &At<'_>, m: &_| {
                    obstacles::environment(r, at, m, MAP_OBSTACLE_TYPES)
                };
                r.element(&at, field, into, read, |o| o.id)
            }
            _ => {
                r.unknown(root, field);
                Ok(())
            }
        }
    }

    /// Gives a lanelet its borders and its stop line.
    fn complete(
        &mut self,
        r: &mut Report,
        at: &At<'_>,
        pending: Pending,
    ) -> Result<Lanelet, ReadError> {
        let mut lanelet = pending.lanelet;
        lanelet.left = self.border(r, &at.field("left_bound"), &pending.left)?;
        lanelet.right = self.border(r, &at.field("right_bound"), &pending.right)?;
        if let Some(id) = pending.stop_line {
            lanelet.stop_line = self.stop_lines.get(&i64::from(id)).cloned();
            if lanelet.stop_line.is_none() {
                r.warn(
                    at,
                    format!("it refers to stop line {id}, which is not there"),
                );
            }
        }
        Ok(lanelet)
    }

    fn border(&mut self, r: &Report, at: &At<'_>, side: &Side) -> Result<Bound, ReadError> {
        let id = side.boundary;
        let Some((bound, users)) = self.boundaries.get_mut(&i64::from(id)) else {
            return Err(r.fail(at, format!("boundary {id} is not in the file")));
        };
        *users += 1;
        if *users > MOST_USERS {
            let message = format!("boundary {id} borders more than {MOST_USERS} lanelets");
            return Err(r.fail(at, message));
        }
        let mut bound = bound.clone();
        if side.reverse {
            bound.points.reverse();
            bound.heights.reverse();
        }
        Ok(bound)
    }
}

fn keep_first<T>(r: &mut Report, at: &At<'_>, into: &mut HashMap<i64, T>, id: i64, value: T) {
    match into.entry(id) {
        Entry::Vacant(place) => {
            place.insert(value);
        }
        Entry::Occupied(_) => {
            r.warn(at, format!("id {id} is used twice; the first one is meant"));
        }
    }
}

fn information(
    r: &mut Report,
    at: &At<'_>,
    message: &MapInformation,
) -> Result<(Map, Header), ReadError> {
    let id = r.need(at, "map_id", message.map_id.as_ref())?;
    let map = header::map(r, &at.field("map_id"), id)?;
    let file = r.need(at, "file_information", message.file_information.as_ref())?;
    let header = Header {
        benchmark_id: map.id.clone(),
        version: "2024".to_string(),
        time_step_size: TIME_STEP_SIZE,
        attributes: header::of_file(r, &at.field("file_information"), file)?,
    };
    Ok((map, header))
}
