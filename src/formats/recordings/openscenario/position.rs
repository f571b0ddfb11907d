//! Positions in a storyboard: in the world, on roads and lanes, and relative to entities.

use std::collections::HashMap;

use super::motion::Motions;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::opendrive::Network;
use crate::recordings::opendrive::tree::Node;
use crate::recordings::report::Report;
use nearmiss_base::geometry::{Point, Pose};

/// Positions that are read.
const POSITIONS: [&str; 5] = [
    "WorldPosition",
    "RelativeWorldPosition",
    "RelativeObjectPosition",
    "LanePosition",
    "RoadPosition",
];

/// A place further than this beyond an end of its road is told, metres.
const BEYOND: f64 = 0.1;

/// The kind of a position that only a player works out: of a kind that is not read, or told from an entity that begins
/// at such a one.
pub fn unread_position(position: &Node, all: &HashMap<String, Motions>) -> Option<String> {
    let of = position.children().next()?;
    let base = of.text("entityRef").and_then(|name| all.get(name));
    let unread = !POSITIONS.contains(&of.name.as_str());
    let from_unread = base.is_some_and(|m| m.start.is_none() && m.other.is_some());
    (unread || from_unread).then(|| of.name.clone())
}

/// Whether a position tells a heading.
pub fn has_heading(position: &Node) -> bool {
    let Some(of) = position.children().next() else {
        return false;
    };
    of.text("h").is_some()
        || of
            .child("Orientation")
            .is_some_and(|o| o.text("h").is_some())
}

/// The pose of a position; `known` tells where entities are.
pub fn position_of(
    node: &Node,
    known: &dyn Fn(&str) -> Option<Pose>,
    network: Option<&Network>,
    report: &Report,
) -> Result<Pose, ReadError> {
    let Some(of) = node.children().next() else {
        return Err(node.fail("no position in it"));
    };
    let other = || -> Result<Pose, ReadError> {
        let name = of.needed("entityRef")?;
        known(name).ok_or_else(|| of.fail(format!("entityRef=\"{name}\" has no known position")))
    };
    let turn = |base: f64, along: f64| -> Result<f64, ReadError> {
        let Some(orientation) = of.child("Orientation") else {
            return Ok(along);
        };
        let h = orientation.or_zero("h")?;
        Ok(match orientation.text("type") {
            Some("relative") => base + h,
            _ => h,
        })
    };
    let road = || {
        network.ok_or_else(|| {
            of.fail("a position on a road, but the scenario names no road file that is there")
        })
    };
    // Players go no further than the end of a road.
    let along = |id: &str, s: f64| {
        let length = network.and_then(|network| network.length(id));
        if let Some(length) = length.filter(|length| !(-BEYOND..=length + BEYOND).contains(&s)) {
            let at = report.row(of.line, of.name.as_str());
            at.warn(format!(
                "s={s} is not on road `{id}`, which is {length:.2} m long; taken as its {}",
                if s < 0.0 { "beginning" } else { "end" }
            ));
        }
        s
    };
    let missing = |id: &str| of.fail(format!("road `{id}` or its lane is not in the road file"));
    match of.name.as_str() {
        "WorldPosition" => {
            let (x, y) = (of.needed_number("x")?, of.needed_number("y")?);
            let pose = Pose::new(x, y, of.or_zero("h")?);
            Ok(network.map_or(pose, |network| network.in_world(pose)))
        }
        "RelativeWorldPosition" => {
            let base = other()?;
            let heading = turn(base.heading, base.heading)?;
            Ok(Pose::new(
                base.position.x + of.or_zero("dx")?,
                base.position.y + of.or_zero("dy")?,
                heading,
            ))
        }
        "RelativeObjectPosition" => {
            let base = other()?;
            let at = base.to_world(&Point::new(of.or_zero("dx")?, of.or_zero("dy")?));
            let heading = turn(base.heading, base.heading)?;
            Ok(Pose { position: at, heading })
        }
        "LanePosition" => {
            let (id, lane) = (of.needed("roadId")?, of.needed_number("laneId")? as i64);
            let (s, offset) = (of.needed_number("s")?, of.or_zero("offset")?);
            let pose = road()?.on_lane(id, lane, along(id, s), offset).ok_or_else(|| missing(id))?;
            let heading = turn(pose.heading, pose.heading)?;
            Ok(Pose { heading, ..pose })
        }
        "RoadPosition" => {
            let (id, s) = (of.needed("roadId")?, of.needed_number("s")?);
            let pose = road()?.beside(id, along(id, s), of.or_zero("t")?).ok_or_else(|| missing(id))?;
            let heading = turn(pose.heading, pose.heading)?;
            Ok(Pose { heading, ..pose })
        }
        name => Err(of.fail(format!(
            "<{name}> is not read; positions are read in the world, on roads and lanes, and relative to entities"
        ))),
    }
}
