//! The single message of 2020a with its road: lanelets, signs, lights and intersections.

use nearmiss_scene::scenario::{
    Adjacent, Bound, ContentHash, Incoming, Intersection, Lanelet, LaneletType, LightPhase,
    LineMarking, RoadUser, Scenario, Sign, SignElement, SignalColor, StopLine, TrafficDirection,
    TrafficLight,
};

use super::messages::{self, CycleElement, TrafficSignElement};
use super::report::{FieldPath, Report};
use super::shapes::region;
use super::values::{Elements, ids};
use super::words::{
    DIRECTIONS, ENVIRONMENT_2020A, LANELET_TYPES, LINE_MARKINGS, OBSTACLE_TYPES, ROAD_USERS,
    SIGNAL_COLORS,
};
use super::{ONE, header, obstacles, signs};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, ScenarioBuilder, SourceLocation};

pub(super) fn lanelet(
    at: &FieldPath<'_>,
    message: &messages::Lanelet,
) -> Result<Lanelet, ReadError> {
    let border = |name, border: Option<&messages::Bound>| {
        let border = at.need(name, border)?;
        bound(&at.field(name), &border.points, border.line_marking)
    };
    let adjacent = |name, id: Option<u32>, direction: Option<i32>| -> Option<Adjacent> {
        let same = direction.filter(|d| matches!(d, 0 | 1)).map(|d| d == 0);
        Some(builder::adjacent(&at.field(name), id?.into(), same))
    };
    let line = message
        .stop_line
        .as_ref()
        .map(|line| stop_line(&at.field("stop_line"), line));
    let (left, right) = (message.adjacent_left, message.adjacent_right);
    Ok(Lanelet {
        id: at.need("lanelet_id", message.lanelet_id)?.into(),
        left: border("left_bound", message.left_bound.as_ref())?,
        right: border("right_bound", message.right_bound.as_ref())?,
        predecessors: ids(&message.predecessors),
        successors: ids(&message.successors),
        adjacent_left: adjacent("adjacent_left_dir", left, message.adjacent_left_dir),
        adjacent_right: adjacent("adjacent_right_dir", right, message.adjacent_right_dir),
        stop_line: line.transpose()?,
        types: types(at, &message.lanelet_types),
        users_one_way: users(at, "user_one_way", &message.user_one_way),
        users_bidirectional: users(at, "user_bidirectional", &message.user_bidirectional),
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
    })
}

pub(super) fn types(at: &FieldPath<'_>, numbers: &[i32]) -> Vec<LaneletType> {
    at.names(
        "lanelet_types",
        LANELET_TYPES,
        numbers,
        LaneletType::Unknown,
    )
}

pub(super) fn users(at: &FieldPath<'_>, name: &str, numbers: &[i32]) -> Vec<RoadUser> {
    at.names(name, ROAD_USERS, numbers, RoadUser::Vehicle)
}

/// A border of at least two points.
pub(super) fn bound(
    at: &FieldPath<'_>,
    points: &[messages::Point],
    marking: Option<i32>,
) -> Result<Bound, ReadError> {
    let (points, heights) = at.points(points)?;
    let unknown = LineMarking::Unknown;
    let marking = marking.map_or(unknown, |number| {
        at.field("line_marking")
            .word_or(LINE_MARKINGS, number, unknown)
    });
    builder::bound(at, points, heights, marking)
}

/// A line marking.
pub(super) fn marking(at: &FieldPath<'_>, number: Option<i32>) -> Result<LineMarking, ReadError> {
    at.needed_word("line_marking", LINE_MARKINGS, number, LineMarking::Unknown)
}

fn stop_line(at: &FieldPath<'_>, message: &messages::StopLine) -> Result<StopLine, ReadError> {
    let (points, heights) = at.points(&message.points)?;
    if !heights.is_empty() {
        at.no_place_for("points/z");
    }
    Ok(StopLine {
        points: builder::stop_line(at, &points),
        marking: marking(at, message.line_marking)?,
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
    })
}

pub(super) fn sign(at: &FieldPath<'_>, message: &messages::TrafficSign) -> Result<Sign, ReadError> {
    let elements = message
        .traffic_sign_elements
        .iter()
        .enumerate()
        .map(|(i, element)| sign_element(&at.nth("traffic_sign_elements", i), element));
    if !message.first_occurrences.is_empty() {
        at.no_place_for("first_occurrences");
    }
    Ok(Sign {
        id: at.need("traffic_sign_id", message.traffic_sign_id)?.into(),
        elements: elements.collect::<Result<_, _>>()?,
        position: at.optional_point("position", message.position.as_ref())?,
        is_virtual: message.is_virtual.unwrap_or(false),
    })
}

fn sign_element(
    at: &FieldPath<'_>,
    message: &TrafficSignElement,
) -> Result<SignElement, ReadError> {
    let number = message
        .number
        .ok_or_else(|| at.fail("does not say which sign it is"))?;
    let id = signs::of_2020a(number);
    if id.is_none() {
        at.warn("an unknown sign; its number was left empty");
    }
    Ok(SignElement {
        id: id.unwrap_or_default().to_string(),
        values: at.texts("additional_values", &message.additional_values),
    })
}

pub(super) fn light(
    at: &FieldPath<'_>,
    message: &messages::TrafficLight,
) -> Result<TrafficLight, ReadError> {
    Ok(TrafficLight {
        id: at
            .need("traffic_light_id", message.traffic_light_id)?
            .into(),
        cycle: cycle(at, &message.cycle_elements)?,
        offset: message.time_offset.unwrap_or(0).into(),
        position: at.optional_point("position", message.position.as_ref())?,
        direction: direction(at, message.direction),
        active: message.active.unwrap_or(true),
    })
}

pub(super) fn direction(at: &FieldPath<'_>, number: Option<i32>) -> Option<TrafficDirection> {
    let at = at.field("direction");
    number.map(|n| at.word_or(DIRECTIONS, n, TrafficDirection::All))
}

pub(super) fn cycle(
    at: &FieldPath<'_>,
    elements: &[CycleElement],
) -> Result<Vec<LightPhase>, ReadError> {
    let phase = |(i, element): (usize, &CycleElement)| {
        let (at, inactive) = (at.nth("cycle_elements", i), SignalColor::Inactive);
        Ok(LightPhase {
            duration: at.need("duration", element.duration)?.into(),
            color: at.needed_word("color", SIGNAL_COLORS, element.color, inactive)?,
        })
    };
    elements.iter().enumerate().map(phase).collect()
}

pub(super) fn intersection(
    at: &FieldPath<'_>,
    message: &messages::Intersection,
) -> Result<Intersection, ReadError> {
    let incoming = |(i, road): (usize, &messages::Incoming)| {
        let id = at
            .nth("incomings", i)
            .need("incoming_id", road.incoming_id)?;
        Ok(Incoming {
            id: id.into(),
            lanelets: ids(&road.incoming_lanelets),
            right: ids(&road.successors_right),
            straight: ids(&road.successors_straight),
            left: ids(&road.successors_left),
            is_left_of: road.is_left_of.map(i64::from),
        })
    };
    let incomings = message.incomings.iter().enumerate().map(incoming);
    Ok(Intersection {
        incomings: incomings.collect::<Result<_, ReadError>>()?,
        id: at.need("intersection_id", message.intersection_id)?.into(),
        crossings: ids(&message.crossing_lanelets),
    })
}

/// Reads the message.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<Scenario, ReadError> {
    let report = Report::about(file);
    let root = FieldPath::root(&report, "");
    let mut builder = ScenarioBuilder::default();
    let (mut header, mut tags, mut location) = (None, None, None);
    let mut elements = Elements::new(&root, &mut builder);
    root.each_field(bytes, |field| match field.number {
        1 => {
            let at = root.field("information");
            at.part(field, &mut header, header::of_2020a)
        }
        2 => {
            let at = root.field("scenario_tags");
            at.part(field, &mut tags, |at, m| Ok(obstacles::tags(at, m)))
        }
        3 => {
            let at = root.field("location");
            at.part(field, &mut location, |at, m| {
                header::location(at, m, &ENVIRONMENT_2020A)
            })
        }
        4 => elements.add("lanelets", field, |builder, at, m| {
            builder.lanelet(at, lanelet(at, m)?);
            Ok(())
        }),
        5 => elements.add("traffic_signs", field, |builder, at, m| {
            builder.sign(at, sign(at, m)?);
            Ok(())
        }),
        6 => elements.add("traffic_lights", field, |builder, at, m| {
            builder.light(at, light(at, m)?);
            Ok(())
        }),
        7 => elements.add("intersections", field, |builder, at, m| {
            builder.intersection(at, intersection(at, m)?);
            Ok(())
        }),
        8 => elements.add("static_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::fixed(at, m, region)?);
            Ok(())
        }),
        9 => elements.add("dynamic_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::moving(at, m, region)?);
            Ok(())
        }),
        10 => elements.add("environment_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::environment(at, m, OBSTACLE_TYPES)?);
            Ok(())
        }),
        11 => elements.add("phantom_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::phantom(at, m)?);
            Ok(())
        }),
        12 => elements.add("planning_problems", field, |builder, at, m| {
            builder.problem(at, obstacles::problem(at, m)?);
            Ok(())
        }),
        _ => {
            root.skip_unknown(field);
            Ok(())
        }
    })?;
    let header = root.need("information", header)?;
    builder.tags = root.need("scenario_tags", tags)?;
    builder.location = Some(root.need("location", location)?);
    let scenario = builder.finish(header, ContentHash::digest(bytes));
    Ok(super::finish(report, &ONE, scenario))
}
