//! Single elements of the map file of 2024.

use super::messages::{IncomingGroup, MapIntersection, MapLanelet, MapLight, MapSign, MapStopLine};
use super::report::FieldPath;
use super::values::ids;
use super::{road, sign_values};
use crate::commonroad::ReadError;
use nearmiss_scene::scenario::{
    Adjacent, Incoming, Intersection, Lanelet, Sign, StopLine, TrafficLight,
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
        elements: sign_values::elements(at, &message.traffic_sign_elements, country)?,
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
