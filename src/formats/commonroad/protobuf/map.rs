//! The map file of 2024, and the dynamic file: the road, and the traffic and changing states on it.
//!
//! Single elements of the map file of 2024.
//!
//! The dynamic file of 2024: the traffic on a map, and the changing states of lights and signs.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};

use nearmiss_scene::scenario::{
    Adjacent, Bound, Environment, Header, Incoming, Intersection, Lanelet, LightPhase, Location,
    Severity, Sign, SignElement, StopLine, TrafficLight,
};

use super::header::{self, Map};
use super::messages::{
    Boundary, IncomingGroup, MapInformation, MapIntersection, MapLanelet, MapLight, MapSign,
    MapStopLine, SignValue, TrafficLightCycle,
};
use super::report::{FieldPath, Report};
use super::shapes::body;
use super::values::{ENVIRONMENT_2024, Elements, MAP_OBSTACLE_TYPES, ids};
use super::wire::Field;
use super::{obstacles, road};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{ScenarioBuilder, SourceLocation};

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
pub(super) fn read_map(
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
                    header::location(at, m, &ENVIRONMENT_2024)
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

/// A lanelet whose borders and stop line are still to be found.
pub(super) struct Pending {
    pub lanelet: Lanelet,
    pub left: Side,
    pub right: Side,
    pub stop_line: Option<u32>,
}

pub(super) struct Side {
    pub boundary: i32,
    pub reverse: bool,
}

pub(super) fn lanelet(at: &FieldPath<'_>, message: &MapLanelet) -> Result<Pending, ReadError> {
    if !message.adjacent_areas.is_empty() {
        at.no_place_for("adjacent_areas");
    }
    let adjacent = |id: Option<u32>, opposite: Option<bool>| {
        id.map(|id| Adjacent {
            id: id.into(),
            same_direction: !opposite.unwrap_or(false),
        })
    };
    let (left, right) = (message.adjacent_left, message.adjacent_right);
    let lanelet = Lanelet {
        id: at.need("lanelet_id", message.lanelet_id)?.into(),
        predecessors: ids(&message.predecessors),
        successors: ids(&message.successors),
        adjacent_left: adjacent(left, message.adjacent_left_opposite_dir),
        adjacent_right: adjacent(right, message.adjacent_right_opposite_dir),
        types: road::types(at, &message.lanelet_types),
        users_one_way: road::users(at, "user_one_way", &message.user_one_way),
        users_bidirectional: road::users(at, "user_bidirectional", &message.user_bidirectional),
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
        ..Lanelet::default()
    };
    let side = |name, boundary, reverse: Option<bool>| {
        Ok(Side {
            boundary: at.need(name, boundary)?,
            reverse: reverse.unwrap_or(false),
        })
    };
    Ok(Pending {
        lanelet,
        left: side("left_bound", message.left_bound, message.left_bound_reverse)?,
        right: side(
            "right_bound",
            message.right_bound,
            message.right_bound_reverse,
        )?,
        stop_line: message.stop_line,
    })
}

pub(super) fn stop_line(
    at: &FieldPath<'_>,
    message: &MapStopLine,
) -> Result<(i64, StopLine), ReadError> {
    let id = at.need("stop_line_id", message.stop_line_id)?;
    let from = at.needed_point("start_point", message.start_point.as_ref())?;
    let to = at.needed_point("end_point", message.end_point.as_ref())?;
    let line = StopLine {
        points: Some((from, to)),
        marking: road::marking(at, message.line_marking)?,
        signs: Vec::new(),
        lights: Vec::new(),
    };
    Ok((id.into(), line))
}

pub(super) fn sign(
    at: &FieldPath<'_>,
    message: &MapSign,
    country: &str,
) -> Result<Sign, ReadError> {
    Ok(Sign {
        id: at.need("traffic_sign_id", message.traffic_sign_id)?.into(),
        elements: road::sign_elements(at, &message.traffic_sign_elements, country)?,
        position: Some(at.needed_point("position", message.position.as_ref())?),
        is_virtual: message.is_virtual.unwrap_or(false),
    })
}

/// A light without its cycle, which the dynamic file has.
pub(super) fn light(at: &FieldPath<'_>, message: &MapLight) -> Result<TrafficLight, ReadError> {
    if !message.color.is_empty() {
        at.no_place_for("color");
    }
    Ok(TrafficLight {
        id: at
            .need("traffic_light_id", message.traffic_light_id)?
            .into(),
        cycle: Vec::new(),
        offset: 0,
        position: Some(at.needed_point("position", message.position.as_ref())?),
        direction: road::direction(at, message.direction),
        active: true,
    })
}

pub(super) fn intersection(
    at: &FieldPath<'_>,
    message: &MapIntersection,
) -> Result<Intersection, ReadError> {
    let incoming = |(i, group): (usize, &IncomingGroup)| {
        let id = group.incoming_group_id;
        Ok(Incoming {
            id: at.nth("incomings", i).need("incoming_group_id", id)?.into(),
            lanelets: ids(&group.incoming_lanelets),
            right: ids(&group.outgoing_right),
            straight: ids(&group.outgoing_straight),
            left: ids(&group.outgoing_left),
            is_left_of: None,
        })
    };
    let incomings = message.incomings.iter().enumerate().map(incoming);
    if !message.outgoings.is_empty() {
        at.no_place_for("outgoings");
    }
    let crossings = message.crossings.iter();
    Ok(Intersection {
        incomings: incomings.collect::<Result<_, ReadError>>()?,
        id: at.need("intersection_id", message.intersection_id)?.into(),
        crossings: crossings.flat_map(|c| ids(&c.crossing_lanelets)).collect(),
    })
}

/// Contents of a dynamic file, except obstacles.
pub(super) struct Dynamic {
    pub header: Header,
    pub environment: Option<Environment>,
    pub changes: Changes,
}

/// Changes to the map's lights and signs, by id, each with its place in the file.
#[derive(Default)]
pub(super) struct Changes {
    cycles: BTreeMap<i64, (usize, Cycle)>,
    signs: BTreeMap<i64, (usize, Vec<SignElement>)>,
}

/// The cycle of a traffic light.
struct Cycle {
    phases: Vec<LightPhase>,
    offset: i64,
    active: bool,
}

/// Adds the traffic to a scenario.
pub(super) fn read_traffic(
    root: &FieldPath<'_>,
    bytes: &[u8],
    builder: &mut ScenarioBuilder,
) -> Result<Dynamic, ReadError> {
    let mut information: Option<(Header, Map)> = None;
    let (mut environment, mut signs, mut cycles) = (None, Vec::new(), 0);
    let mut changes = Changes::default();
    let mut elements = Elements::new(root, builder);
    root.each_field(bytes, |field| match field.number {
        1 => {
            let at = root.field("dynamic_meta_information");
            at.part(field, &mut information, header::of_2024)
        }
        2 => {
            let at = root.field("environment");
            at.part(field, &mut environment, |at, m| {
                Ok(header::environment(at, m, &ENVIRONMENT_2024))
            })
        }
        3 => elements.add("traffic_light_cycle", field, |_, at, m| {
            let (light, cycle) = cycle(at, m)?;
            changes.cycles.insert(light, (cycles, cycle));
            cycles += 1;
            Ok(())
        }),
        4 => elements.add("traffic_sign_value", field, |_, _, m: &SignValue| {
            signs.push(m.clone());
            Ok(())
        }),
        5 => elements.add("static_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::fixed(at, m, body)?);
            Ok(())
        }),
        6 => elements.add("dynamic_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::moving(at, m, body)?);
            Ok(())
        }),
        7 => elements.add("phantom_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::phantom(at, m)?);
            Ok(())
        }),
        _ => {
            root.skip_unknown(field);
            Ok(())
        }
    })?;
    let (header, map) = root.need("dynamic_meta_information", information)?;
    for (i, message) in signs.iter().enumerate() {
        let at = root.nth("traffic_sign_value", i);
        let id = at.need("traffic_sign_id", message.traffic_sign_id)?;
        let elements = road::sign_elements(&at, &message.traffic_sign_elements, &map.country)?;
        changes.signs.insert(id.into(), (i, elements));
    }
    Ok(Dynamic {
        header,
        environment: root.need("environment", environment)?,
        changes,
    })
}

fn cycle(at: &FieldPath<'_>, message: &TrafficLightCycle) -> Result<(i64, Cycle), ReadError> {
    let light = at.need("traffic_light_id", message.traffic_light_id)?;
    let cycle = Cycle {
        phases: road::cycle(at, &message.cycle_elements)?,
        offset: message.time_offset.unwrap_or(0).into(),
        active: message.active.unwrap_or(true),
    };
    Ok((light.into(), cycle))
}

impl Changes {
    /// Gives a light of the map its cycle.
    pub fn apply_to_light(&mut self, light: &mut TrafficLight) {
        if let Some((_, cycle)) = self.cycles.remove(&light.id) {
            light.cycle = cycle.phases;
            (light.offset, light.active) = (cycle.offset, cycle.active);
        }
    }

    /// Gives a sign of the map what it says in this scenario.
    pub fn apply_to_sign(&mut self, sign: &mut Sign) {
        if let Some((_, elements)) = self.signs.remove(&sign.id) {
            sign.elements = elements;
        }
    }

    /// Warns of what no light or sign of the map took.
    pub fn warn_of_rest(&self, report: &Report) {
        let root = FieldPath::root(report, "dynamic");
        for (id, (i, _)) in &self.cycles {
            let at = root.nth("traffic_light_cycle", *i);
            at.warn(format!("refers to missing light {id}"));
        }
        for (id, (i, _)) in &self.signs {
            let at = root.nth("traffic_sign_value", *i);
            at.warn(format!("refers to missing sign {id}"));
        }
    }
}
