//! OpenDRIVE: roads as lanelets.

mod geometry;
mod lanelets;
mod links;
mod road;
pub mod tree;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::mem::{replace, take};

use nearmiss_base::geometry::{Point, Polyline, Pose};
use nearmiss_scene::scenario::{Bound, Lanelet};

use super::Report;
use super::assembly::{Ids, Map};
use crate::commonroad::ReadError;
use crate::opendrive::signals::{STOP_LINE, SignalKey};
use crate::opendrive::user_data::KeptLanelet;
use geometry::Offset;
use links::Key;
use road::{Lane, Road};
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
    if let Some(words) = moved.text() {
        report.note(words);
    }
    let mut roads = Vec::new();
    for node in root.all("road") {
        roads.push(road::read(node, &moved)?);
    }
    let connections = links::connections(&root, report)?;
    links::report(&roads, report);
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
    pub fn pose_beside(&self, road: &str, s: f64, t: f64) -> Option<Pose> {
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

/// Lanes may be so much farther from their lanelets than was written, metres: what reading and rounding add.
const ROUNDING: f64 = 0.02;

/// What is cut off the beginning of a lane for a junction is not longer, metres.
const CUT: f64 = 3.0;

/// What the file of an export says of signs and lights, beside what it keeps of them.
pub struct KeptSigns {
    /// By the ids of lanelets.
    pub lanelets: HashMap<i64, LaneletSigns>,
    /// The signals beside its roads, without stop lines.
    pub signals: BTreeSet<SignalKey>,
}

/// The signs and lights of an exported lanelet, by id.
pub struct LaneletSigns {
    /// Signs and lights of the lanelet.
    pub own: [Vec<i64>; 2],
    /// Signs and lights of its stop line.
    pub stop_line: [Vec<i64>; 2],
    /// The speed limit of its lane, m/s.
    pub limit: Option<f64>,
}

/// Puts the lanelets that were exported in the place of those that lanes became, and tells their signs and lights as they
/// were. They themselves have those of the roads, for what they refer to is not in this file.
///
/// All of them or none: where a road was added or changed since, its lanes hold.
fn restore(roads: &[Road], places: &HashMap<Key, usize>, map: &mut Map) -> Option<KeptSigns> {
    let mut lanes: Vec<Option<&Lane>> = vec![None; map.lanelets.len()];
    for ((road, section, id), place) in places {
        let section = &roads[*road].sections[*section];
        lanes[*place] = section.lanes.iter().find(|l| l.id == *id);
    }
    let parts: HashSet<i64> = lanes.iter().flatten().filter_map(|l| l.part_of).collect();
    let kept = |lane: &Lane| lane.kept.as_ref().map(|k| k.lanelet.id);
    let known: HashSet<i64> = lanes.iter().flatten().filter_map(|l| kept(l)).collect();
    let holds = |(lanelet, lane): (&Lanelet, &Option<&Lane>)| match lane {
        Some(Lane {
            kept: Some(kept), ..
        }) => kept.lanelet.id == lanelet.id && is_near(kept, lanelet, parts.contains(&lanelet.id)),
        Some(Lane { part_of, .. }) => part_of.is_some_and(|of| known.contains(&of)),
        None => false,
    };
    if known.is_empty() || !map.lanelets.iter().zip(&lanes).all(holds) {
        return None;
    }
    let mut lanelets = HashMap::new();
    let mut restored = Vec::new();
    for (read, lane) in take(&mut map.lanelets).into_iter().zip(lanes) {
        let Some(kept) = lane.and_then(|l| l.kept.as_ref()) else {
            continue;
        };
        let mut lanelet = kept.lanelet.clone();
        let line = lanelet.stop_line.as_mut();
        let signs = LaneletSigns {
            own: [
                replace(&mut lanelet.signs, read.signs),
                replace(&mut lanelet.lights, read.lights),
            ],
            stop_line: line.map_or_else(Default::default, |line| {
                [take(&mut line.signs), take(&mut line.lights)]
            }),
            limit: lane.and_then(|l| l.limit),
        };
        lanelets.insert(lanelet.id, signs);
        lanelet.predecessors.retain(|id| known.contains(id));
        lanelet.successors.retain(|id| known.contains(id));
        for beside in [&mut lanelet.adjacent_left, &mut lanelet.adjacent_right] {
            *beside = beside.filter(|a| known.contains(&a.id));
        }
        restored.push((kept.place, lanelet));
    }
    restored.sort_by_key(|(place, _)| *place);
    map.lanelets = restored.into_iter().map(|(_, lanelet)| lanelet).collect();
    let signals = roads
        .iter()
        .flat_map(|r| &r.signals)
        .filter(|s| s.kind != STOP_LINE);
    Some(KeptSigns {
        lanelets,
        signals: signals
            .map(|s| SignalKey::new(&s.id, &s.kind, &s.subtype))
            .collect(),
    })
}

/// Whether the borders of a lane are still those of its lanelet.
fn is_near(kept: &KeptLanelet, read: &Lanelet, is_cut: bool) -> bool {
    let most = kept.deviation + TOLERANCE + ROUNDING;
    let near = |own: &Bound, read: &Bound| {
        let Some(line) = Polyline::new(own.points.iter().copied()) else {
            return false;
        };
        let ends = |b: &Bound| Some((*b.points.first()?, *b.points.last()?));
        let (Some((own_first, own_last)), Some((first, last))) = (ends(own), ends(read)) else {
            return false;
        };
        let begins = if is_cut { CUT } else { most };
        (own_first - first).norm() <= begins
            && (own_last - last).norm() <= most
            && read.points.iter().all(|p| line.project(p).d.abs() <= most)
    };
    near(&kept.lanelet.left, &read.left) && near(&kept.lanelet.right, &read.right)
}
