//! The road of 2020a: lanelets, signs, lights and intersections.

use super::messages::{self, CycleElement, TrafficSignElement};
use super::report::{At, Report};
use super::signs;
use super::values::{ids, point, points, texts};
use super::words::{
    DIRECTIONS, LANELET_TYPES, LINE_MARKINGS, ROAD_USERS, SIGNAL_COLORS, all, needed_word, word_or,
};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{
    Adjacent, Bound, Incoming, Intersection, Lanelet, LaneletType, LightPhase, LineMarking,
    RoadUser, Severity, Sign, SignElement, SignalColor, StopLine, TrafficDirection, TrafficLight,
};

pub(super) fn lanelet(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::Lanelet,
) -> Result<Lanelet, ReadError> {
    let left = report.need(at, "left_bound", message.left_bound.as_ref())?;
    let right = report.need(at, "right_bound", message.right_bound.as_ref())?;
    let line = message.stop_line.as_ref();
    let line = line.map(|line| stop_line(report, &at.field("stop_line"), line));
    let mut beside = |name: &str, id: Option<u32>, direction: Option<i32>| {
        let same = match (id, direction) {
            (Some(_), None | Some(..=-1 | 2..)) => {
                report.warn(&at.field(name), "neither same nor opposite; taken as same");
                true
            }
            (_, direction) => direction != Some(1),
        };
        adjacent(id, same)
    };
    let adjacent_left = beside(
        "adjacent_left_dir",
        message.adjacent_left,
        message.adjacent_left_dir,
    );
    let adjacent_right = beside(
        "adjacent_right_dir",
        message.adjacent_right,
        message.adjacent_right_dir,
    );
    Ok(Lanelet {
        id: report.need(at, "lanelet_id", message.lanelet_id)?.into(),
        left: bound(
            report,
            &at.field("left_bound"),
            &left.points,
            left.line_marking,
        )?,
        right: bound(
            report,
            &at.field("right_bound"),
            &right.points,
            right.line_marking,
        )?,
        predecessors: ids(&message.predecessors),
        successors: ids(&message.successors),
        adjacent_left,
        adjacent_right,
        stop_line: line.transpose()?,
        types: types(report, at, &message.lanelet_types),
        users_one_way: users(report, at, "user_one_way", &message.user_one_way),
        users_bidirectional: users(
            report,
            at,
            "user_bidirectional",
            &message.user_bidirectional,
        ),
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
    })
}

pub(super) fn adjacent(id: Option<u32>, same_direction: bool) -> Option<Adjacent> {
    id.map(|id| Adjacent {
        id: id.into(),
        same_direction,
    })
}

pub(super) fn types(report: &mut Report, at: &At<'_>, numbers: &[i32]) -> Vec<LaneletType> {
    let unknown = LaneletType::Unknown;
    all(report, at, "lanelet_types", LANELET_TYPES, numbers, unknown)
}

pub(super) fn users(
    report: &mut Report,
    at: &At<'_>,
    name: &str,
    numbers: &[i32],
) -> Vec<RoadUser> {
    all(report, at, name, ROAD_USERS, numbers, RoadUser::Vehicle)
}

/// A border of at least two points.
pub(super) fn bound(
    report: &mut Report,
    at: &At<'_>,
    all: &[messages::Point],
    marking: Option<i32>,
) -> Result<Bound, ReadError> {
    if all.len() < 2 {
        let message = format!("{} points, at least 2 are needed", all.len());
        return Err(report.fail(at, message));
    }
    let (points, heights) = points(report, at, all)?;
    let marking = marking.map_or(LineMarking::Unknown, |number| {
        let at = at.field("line_marking");
        word_or(report, &at, LINE_MARKINGS, number, LineMarking::Unknown)
    });
    Ok(Bound {
        points,
        heights,
        marking,
    })
}

fn stop_line(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::StopLine,
) -> Result<StopLine, ReadError> {
    let (points, _) = points(report, at, &message.points)?;
    let unknown = LineMarking::Unknown;
    Ok(StopLine {
        points: match points.as_slice() {
            [from, to, ..] => Some((*from, *to)),
            _ => None,
        },
        marking: needed_word(
            report,
            at,
            "line_marking",
            LINE_MARKINGS,
            message.line_marking,
            unknown,
        )?,
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
    })
}

pub(super) fn sign(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::TrafficSign,
) -> Result<Sign, ReadError> {
    let position = message.position.as_ref();
    let position = position.map(|p| point(report, &at.field("position"), p));
    let mut elements = Vec::with_capacity(message.traffic_sign_elements.len());
    for (i, element) in message.traffic_sign_elements.iter().enumerate() {
        elements.push(sign_element(
            report,
            &at.nth("traffic_sign_elements", i),
            element,
        )?);
    }
    if elements.is_empty() {
        report.note(Severity::Note, at, "a traffic sign that says nothing");
    }
    if !message.first_occurrences.is_empty() {
        let message = "`first_occurrences` has no place here and was left out";
        report.note(Severity::Note, at, message);
    }
    Ok(Sign {
        id: report
            .need(at, "traffic_sign_id", message.traffic_sign_id)?
            .into(),
        elements,
        position: position.transpose()?,
        is_virtual: message.is_virtual.unwrap_or(false),
    })
}

fn sign_element(
    report: &mut Report,
    at: &At<'_>,
    message: &TrafficSignElement,
) -> Result<SignElement, ReadError> {
    let number = message.number;
    let number = number.ok_or_else(|| report.fail(at, "it does not say which sign it is"))?;
    let id = signs::of_2020a(number);
    if id.is_none() {
        report.warn(at, "an unknown sign; its number was left empty");
    }
    Ok(SignElement {
        id: id.unwrap_or_default().to_string(),
        values: texts(report, at, "additional_values", &message.additional_values),
    })
}

pub(super) fn light(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::TrafficLight,
) -> Result<TrafficLight, ReadError> {
    let position = message.position.as_ref();
    let position = position.map(|p| point(report, &at.field("position"), p));
    Ok(TrafficLight {
        id: report
            .need(at, "traffic_light_id", message.traffic_light_id)?
            .into(),
        cycle: cycle(report, at, &message.cycle_elements)?,
        offset: message.time_offset.unwrap_or(0).into(),
        position: position.transpose()?,
        direction: direction(report, at, message.direction),
        active: message.active.unwrap_or(true),
    })
}

pub(super) fn direction(
    report: &mut Report,
    at: &At<'_>,
    number: Option<i32>,
) -> Option<TrafficDirection> {
    let at = at.field("direction");
    number.map(|n| word_or(report, &at, DIRECTIONS, n, TrafficDirection::All))
}

pub(super) fn cycle(
    report: &mut Report,
    at: &At<'_>,
    elements: &[CycleElement],
) -> Result<Vec<LightPhase>, ReadError> {
    let mut phases = Vec::with_capacity(elements.len());
    for (i, element) in elements.iter().enumerate() {
        let at = at.nth("cycle_elements", i);
        let inactive = SignalColor::Inactive;
        phases.push(LightPhase {
            duration: report.need(&at, "duration", element.duration)?.into(),
            color: needed_word(report, &at, "color", SIGNAL_COLORS, element.color, inactive)?,
        });
    }
    Ok(phases)
}

pub(super) fn intersection(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::Intersection,
) -> Result<Intersection, ReadError> {
    let mut incomings = Vec::with_capacity(message.incomings.len());
    for (i, road) in message.incomings.iter().enumerate() {
        let at = at.nth("incomings", i);
        incomings.push(Incoming {
            id: report.need(&at, "incoming_id", road.incoming_id)?.into(),
            lanelets: ids(&road.incoming_lanelets),
            right: ids(&road.successors_right),
            straight: ids(&road.successors_straight),
            left: ids(&road.successors_left),
            is_left_of: road.is_left_of.map(i64::from),
        });
    }
    if incomings.is_empty() {
        report.note(Severity::Note, at, "an intersection without roads");
    }
    Ok(Intersection {
        id: report
            .need(at, "intersection_id", message.intersection_id)?
            .into(),
        incomings,
        crossings: ids(&message.crossing_lanelets),
    })
}
