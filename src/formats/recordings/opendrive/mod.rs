//! OpenDRIVE: roads as lanelets.

mod geometry;
mod kept;
mod lanelets;
mod links;
mod road;
pub mod tree;

use std::collections::HashMap;

use super::assembly::Map;
use super::ids::Ids;
use super::report::Report;
use crate::formats::commonroad::ReadError;
use crate::geometry::{Point, Pose};
pub use kept::KeptSigns;
use road::Road;

/// How far borders of lanelets are from those of the roads at most, metres.
pub const TOLERANCE: f64 = 0.01;

/// A road network that was read.
pub struct Network {
    /// The lanelets.
    pub map: Map,
    roads: Vec<Road>,
    /// Lights by the ids of their signals.
    pub lights: HashMap<String, i64>,
    /// The signs and lights of an export, where the lanelets are those that it was made of.
    pub kept: Option<KeptSigns>,
}

/// Reads a file; ids of lanelets are those that nearmiss wrote, or new ones.
pub fn read(
    bytes: &[u8],
    file: &str,
    report: &Report,
    ids: &mut Ids,
) -> Result<Network, ReadError> {
    let root = tree::read(bytes, file, "OpenDRIVE")?;
    let mut roads = Vec::new();
    for node in root.all("road") {
        roads.push(road::read(node)?);
    }
    let high = roads.iter().filter(|r| r.has_heights).count();
    report.note_count(high, |n| format!("roads with heights: {n}; read as level"));
    let lanelets::Lanes { map, lights, kept } = lanelets::lanelets(&roads, report, ids);
    report.note(match kept.is_some() {
        true => "lanelets as they were exported, from the user data of the lanes".into(),
        false => format!(
            "lanes of {} roads are lanelets whose borders have points within {TOLERANCE} m of them",
            roads.len()
        ),
    });
    Ok(Network {
        map,
        roads,
        lights,
        kept,
    })
}

impl Network {
    /// A place beside a road, with its direction there.
    pub fn beside(&self, road: &str, s: f64, t: f64) -> Option<Pose> {
        let road = self.roads.iter().find(|r| r.id == road)?;
        let s = s.clamp(0.0, road.length);
        Some(Pose {
            position: road.point(s, t),
            heading: road.pose(s).heading,
        })
    }

    /// A place on a lane, to the left of its middle, with the direction in which it is driven.
    pub fn on_lane(&self, road: &str, lane: i64, s: f64, offset: f64) -> Option<Pose> {
        let road = self.roads.iter().find(|r| r.id == road)?;
        let s = s.clamp(0.0, road.length);
        let section = road.sections.iter().rfind(|x| x.from <= s + 1e-9)?;
        let place = section.lanes.iter().position(|l| l.id == lane)?;
        let borders = road.borders(section, s);
        // The reference line is between the lanes of both sides.
        let t = f64::midpoint(*borders.get(place)?, *borders.get(place + 1)?) + offset;
        let along = (lane < 0) != road.left_hand;
        let heading = road.pose(s).heading;
        let turn = if along { 0.0 } else { std::f64::consts::PI };
        let position: Point = road.point(s, t);
        Some(Pose {
            position,
            heading: heading + turn,
        })
    }
}
