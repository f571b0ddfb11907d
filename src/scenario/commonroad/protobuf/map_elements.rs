//! The elements of the map file of 2024, one by one.

use super::messages::{IncomingGroup, MapIntersection, MapLanelet, MapLight, MapSign, MapStopLine};
use super::report::{At, Report};
use super::values::{ids, point};
use super::words::{LINE_MARKINGS, needed_word};
use super::{road, sign_values};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{
    Bound, Incoming, Intersection, Lanelet, LineMarking, Severity, Sign, StopLine, TrafficLight,
};

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

pub(super) fn lanelet(
    r: &mut Report,
    at: &At<'_>,
    message: &MapLanelet,
) -> Result<Pending, ReadError> {
    let empty = || Bound {
        points: Vec::new(),
        heights: Vec::new(),
        marking: LineMarking::Unknown,
    };
    if !message.adjacent_areas.is_empty() {
        let message = "`adjacent_areas` has no place here and was left out";
        r.note(Severity::Note, at, message);
    }
    let left = message.adjacent_left_opposite_dir.unwrap_or(false);
    let right = message.adjacent_right_opposite_dir.unwrap_or(false);
    let lanelet = Lanelet {
        id: r.need(at, "lanelet_id", message.lanelet_id)?.into(),
        left: empty(),
        right: empty(),
        predecessors: ids(&message.predecessors),
        successors: ids(&message.successors),
        adjacent_left: road::adjacent(message.adjacent_left, !left),
        adjacent_right: road::adjacent(message.adjacent_right, !right),
        stop_line: None,
        types: road::types(r, at, &message.lanelet_types),
        users_one_way: road::users(r, at, "user_one_way", &message.user_one_way),
        users_bidirectional: road::users(r, at, "user_bidirectional", &message.user_bidirectional),
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
    };
    let side = |name, boundary, reverse: Option<bool>| {
        Ok(Side {
            boundary: r.need(at, name, boundary)?,
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
    r: &mut Report,
    at: &At<'_>,
    message: &MapStopLine,
) -> Result<(i64, StopLine), ReadError> {
    let id = r.need(at, "stop_line_id", message.stop_line_id)?;
    let from = r.need(at, "start_point", message.start_point.as_ref())?;
    let to = r.need(at, "end_point", message.end_point.as_ref())?;
    let unknown = LineMarking::Unknown;
    let marking = message.line_marking;
    let line = StopLine {
        points: Some((
            point(r, &at.field("start_point"), from)?,
            point(r, &at.field("end_point"), to)?,
        )),
        marking: needed_word(r, at, "line_marking", LINE_MARKINGS, marking, unknown)?,
        signs: Vec::new(),
        lights: Vec::new(),
    };
    Ok((id.into(), line))
}

pub(super) fn sign(
    r: &mut Report,
    at: &At<'_>,
    message: &MapSign,
    country: &str,
) -> Result<Sign, ReadError> {
    let position = r.need(at, "position", message.position.as_ref())?;
    Ok(Sign {
        id: r
            .need(at, "traffic_sign_id", message.traffic_sign_id)?
            .into(),
        elements: sign_values::elements(r, at, &message.traffic_sign_elements, country)?,
        position: Some(point(r, &at.field("position"), position)?),
        is_virtual: message.is_virtual.unwrap_or(false),
    })
}

/// A light without its cycle, which the dynamic file has.
pub(super) fn light(
    r: &mut Report,
    at: &At<'_>,
    message: &MapLight,
) -> Result<TrafficLight, ReadError> {
    let position = r.need(at, "position", message.position.as_ref())?;
    if !message.color.is_empty() {
        r.note(
            Severity::Note,
            at,
            "`color` has no place here and was left out",
        );
    }
    Ok(TrafficLight {
        id: r
            .need(at, "traffic_light_id", message.traffic_light_id)?
            .into(),
        cycle: Vec::new(),
        offset: 0,
        position: Some(point(r, &at.field("position"), position)?),
        direction: road::direction(r, at, message.direction),
        active: true,
    })
}

pub(super) fn intersection(
    r: &mut Report,
    at: &At<'_>,
    message: &MapIntersection,
) -> Result<Intersection, ReadError> {
    let incoming = |(i, group): (usize, &IncomingGroup)| {
        let at = at.nth("incomings", i);
        Ok(Incoming {
            id: r
                .need(&at, "incoming_group_id", group.incoming_group_id)?
                .into(),
            lanelets: ids(&group.incoming_lanelets),
            right: ids(&group.outgoing_right),
            straight: ids(&group.outgoing_straight),
            left: ids(&group.outgoing_left),
            is_left_of: None,
        })
    };
    let incomings = message.incomings.iter().enumerate().map(incoming);
    let incomings = incomings.collect::<Result<Vec<_>, ReadError>>()?;
    if incomings.is_empty() {
        r.note(Severity::Note, at, "an intersection without roads");
    }
    if !message.outgoings.is_empty() {
        r.note(
            Severity::Note,
            at,
            "`outgoings` has no place here and was left out",
        );
    }
    Ok(Intersection {
        id: r
            .need(at, "intersection_id", message.intersection_id)?
            .into(),
        incomings,
        crossings: message
            .crossings
            .iter()
            .flat_map(|c| ids(&c.crossing_lanelets))
            .collect(),
    })
}
