//! OpenDRIVE: roads as lanelets.

mod faults;
mod geometry;
mod kept;
mod lane;
mod lanelets;
mod links;
mod road;
mod signal;
pub mod tree;

use std::collections::HashMap;

use super::assembly::Map;
use super::ids::Ids;
use super::report::Report;
use crate::commonroad::ReadError;
use geometry::Offset;
pub use kept::KeptSigns;
use nearmiss_base::geometry::{Point, Pose};
use road::Road;
use tree::Node;

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
    moved: Offset,
}

/// Reads a file; ids of lanelets are those that nearmiss wrote, or new ones.
pub fn read(
    bytes: &[u8],
    file: &str,
    report: &Report,
    ids: &mut Ids,
) -> Result<Network, ReadError> {
    let root = tree::read(bytes, file, "OpenDRIVE")?;
    let header = root.child("header");
    let moved = Offset::read(header)?;
    if let Some(words) = moved.words() {
        report.note(words);
    }
    let mut roads = Vec::new();
    for node in root.all("road") {
        roads.push(road::read(node, &moved)?);
    }
    let connections = links::connections(&root, report)?;
    faults::report(&roads, report);
    let high = roads.iter().filter(|r| r.has_heights).count();
    report.note_count(high, |n| format!("roads with heights: {n}; read as level"));
    let tilted = roads.iter().filter(|r| r.is_tilted).count();
    report.note_count(tilted, |n| {
        format!("roads with superelevation: {n}; read as level, as wide as along the surface")
    });
    let both = roads
        .iter()
        .flat_map(|r| &r.sections)
        .flat_map(|s| &s.lanes)
        .filter(|l| l.is_both_ways)
        .count();
    report.note_count(both, |n| {
        format!("lanes that are driven both ways: {n}; lanelets that run as the others of their side, for users of both")
    });
    let lanelets::Lanes { map, lights, kept } =
        lanelets::lanelets(&roads, &connections, report, ids);
    account(&root, file, report);
    report.note(if kept.is_some() {
        "lanelets as they were exported, from the user data of the lanes".into()
    } else {
        format!(
            "lanes of {} are lanelets whose borders have points within {TOLERANCE} m of them",
            match roads.len() {
                1 => "1 road".into(),
                n => format!("{n} roads"),
            }
        )
    });
    Ok(Network {
        map,
        roads,
        lights,
        kept,
        moved,
    })
}

/// Elements that only hold others.
const GROUPS: [&str; 7] = [
    "elevationProfile",
    "lateralProfile",
    "link",
    "objects",
    "railroad",
    "signals",
    "surface",
];

/// What says of a file what it is, not of its roads.
const LABELS: [&str; 9] = [
    "revMajor", "revMinor", "version", "date", "vendor", "north", "south", "east", "west",
];

/// Notes what of a file was not used.
fn account(root: &Node, file: &str, report: &Report) {
    if let Some(header) = root.child("header") {
        header.skip_attributes(&LABELS);
    }
    for (kind, line) in root.unused(&GROUPS) {
        // The lines of another file than the one that is reported on tell nothing.
        let line = if file == report.file() { line } else { 0 };
        report.unused(kind, line);
    }
}

impl Network {
    /// A pose in the coordinates of its file, in the world: the offset of the header moves both.
    pub fn in_world(&self, pose: Pose) -> Pose {
        self.moved.apply(pose)
    }

    /// How long a road is, metres.
    pub fn length(&self, road: &str) -> Option<f64> {
        let road = self.roads.iter().find(|r| r.id == road)?;
        Some(road.length)
    }

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
        let along = road.is_along(&section.lanes[place]);
        let heading = road.pose(s).heading;
        let turn = if along { 0.0 } else { std::f64::consts::PI };
        let position: Point = road.point(s, t);
        Some(Pose {
            position,
            heading: heading + turn,
        })
    }
}
