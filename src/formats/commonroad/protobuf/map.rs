//! The map file of 2024: the road and its permanent surroundings.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::dynamic::Changes;
use super::elements::Elements;
use super::header::{self, Map};
use super::map_elements::{Pending, Side, intersection, lanelet, light, sign, stop_line};
use super::messages::{Boundary, MapInformation, MapSign};
use super::report::FieldPath;
use super::wire::Field;
use super::words::{ENVIRONMENT_2024, MAP_OBSTACLE_TYPES};
use super::{obstacles, place, road};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{ScenarioBuilder, SourceLocation};
use nearmiss_scene::scenario::{Bound, Header, Lanelet, Location, Severity, StopLine};

/// A map has no time steps; these are the usual ones, seconds.
pub(super) const TIME_STEP_SIZE: f64 = 0.1;

/// A border has two sides; roads that cross share a few. More users would let a small file fill the memory.
const MOST_USERS: usize = 64;

/// Elements read so far, beside those in the builder.
#[derive(Default)]
struct Parts {
    information: Option<(Map, Header)>,
    location: Option<Location>,
    lanelets: Vec<Pending>,
    stop_lines: HashMap<i64, StopLine>,
    boundaries: HashMap<i64, (Bound, usize)>,
    areas: usize,
    signs: Vec<MapSign>,
}

/// Adds a map to a scenario, with what a dynamic file changes of it; its header.
pub(super) fn read(
    root: &FieldPath<'_>,
    bytes: &[u8],
    builder: &mut ScenarioBuilder,
    mut changes: Changes,
) -> Result<Header, ReadError> {
    let mut parts = Parts::default();
    let mut elements = Elements::new(root, builder);
    root.each_field(bytes, |field| parts.add(&mut elements, &mut changes, field))?;
    let (map, header) = root.need("map_meta_information", parts.information.take())?;
    builder.location = Some(root.need("location", parts.location.take())?);
    if parts.areas > 0 {
        let message = format!("{} areas are not supported and were left out", parts.areas);
        root.note(Severity::Note, message);
    }
    for (i, pending) in std::mem::take(&mut parts.lanelets).into_iter().enumerate() {
        let at = root.nth("lanelets", i);
        builder.lanelet(&at, parts.complete(&at, pending)?);
    }
    for (i, message) in parts.signs.iter().enumerate() {
        let at = root.nth("traffic_signs", i);
        let mut sign = sign(&at, message, &map.country)?;
        changes.apply_to_sign(&mut sign);
        builder.sign(&at, sign);
    }
    changes.warn_of_rest(root.report);
    Ok(header)
}

impl Parts {
    fn add(
        &mut self,
        elements: &mut Elements<'_>,
        changes: &mut Changes,
        field: &Field<'_>,
    ) -> Result<(), ReadError> {
        let root = elements.root;
        match field.number {
            1 => {
                let at = root.field("map_meta_information");
                at.part(field, &mut self.information, information)
            }
            2 => {
                let at = root.field("location");
                at.part(field, &mut self.location, |at, m| {
                    place::location(at, m, &ENVIRONMENT_2024)
                })
            }
            3 => elements.add("lanelets", field, |_, at, m| {
                self.lanelets.push(lanelet(at, m)?);
                Ok(())
            }),
            4 => elements.add("stop_lines", field, |_, at, m| {
                let (id, line) = stop_line(at, m)?;
                keep_first(at, &mut self.stop_lines, id, line);
                Ok(())
            }),
            5 => elements.add("boundaries", field, |_, at, m: &Boundary| {
                let id = at.need("boundary_id", m.boundary_id)?;
                let bound = road::bound(at, &m.points, m.line_marking)?;
                keep_first(at, &mut self.boundaries, id.into(), (bound, 0));
                Ok(())
            }),
            6 => {
                self.areas += 1;
                Ok(())
            }
            7 => elements.add("traffic_signs", field, |_, at, m: &MapSign| {
                at.need("traffic_sign_id", m.traffic_sign_id)?;
                self.signs.push(m.clone());
                Ok(())
            }),
            8 => elements.add("traffic_lights", field, |builder, at, m| {
                let mut light = light(at, m)?;
                changes.apply_to_light(&mut light);
                builder.light(at, light);
                Ok(())
            }),
            9 => elements.add("intersections", field, |builder, at, m| {
                builder.intersection(at, intersection(at, m)?);
                Ok(())
            }),
            10 => elements.add("environment_obstacles", field, |builder, at, m| {
                builder.obstacle(at, obstacles::environment(at, m, MAP_OBSTACLE_TYPES)?);
                Ok(())
            }),
            _ => {
                root.skip_unknown(field);
                Ok(())
            }
        }
    }

    /// Gives a lanelet its borders and its stop line.
    fn complete(&mut self, at: &FieldPath<'_>, pending: Pending) -> Result<Lanelet, ReadError> {
        let mut lanelet = pending.lanelet;
        lanelet.left = self.border(&at.field("left_bound"), &pending.left)?;
        lanelet.right = self.border(&at.field("right_bound"), &pending.right)?;
        if let Some(id) = pending.stop_line {
            lanelet.stop_line = self.stop_lines.get(&i64::from(id)).cloned();
            if lanelet.stop_line.is_none() {
                at.warn(format!("refers to missing stop line {id}"));
            }
        }
        Ok(lanelet)
    }

    fn border(&mut self, at: &FieldPath<'_>, side: &Side) -> Result<Bound, ReadError> {
        let id = side.boundary;
        let Some((bound, users)) = self.boundaries.get_mut(&i64::from(id)) else {
            return Err(at.fail(format!("boundary {id} is missing")));
        };
        *users += 1;
        if *users > MOST_USERS {
            let message = format!("boundary {id} borders more than {MOST_USERS} lanelets");
            return Err(at.fail(message));
        }
        let mut bound = bound.clone();
        if side.reverse {
            bound.points.reverse();
            bound.heights.reverse();
        }
        Ok(bound)
    }
}

fn keep_first<T>(at: &FieldPath<'_>, into: &mut HashMap<i64, T>, id: i64, value: T) {
    match into.entry(id) {
        Entry::Vacant(place) => {
            place.insert(value);
        }
        Entry::Occupied(_) => at.warn(format!("id {id} is used twice; the first is used")),
    }
}

fn information(at: &FieldPath<'_>, message: &MapInformation) -> Result<(Map, Header), ReadError> {
    let id = at.need("map_id", message.map_id.as_ref())?;
    let map = header::map(&at.field("map_id"), id)?;
    let file = at.need("file_information", message.file_information.as_ref())?;
    let header = Header {
        other_format: None,
        benchmark_id: map.id.clone(),
        version: "2024".to_string(),
        time_step_size: TIME_STEP_SIZE,
        attributes: header::of_file(&at.field("file_information"), file)?,
    };
    Ok((map, header))
}
