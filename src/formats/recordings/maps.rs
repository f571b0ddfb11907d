//! A map of any format: that of `--map` beside a table of tracks, and one that is opened alone.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use nearmiss_base::geometry::Point;
use nearmiss_base::system;
use nearmiss_scene::scenario::{ContentHash, Scenario};

use super::assembly::{About, Ids, Map, assemble};
use super::lanelet2::Placement;
use super::utm::TransverseMercator;
use super::{Report, lanelet2, opendrive, sumo, whole_file};
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::{self, ReadError, root_name_of};
use crate::dispatch::{Address, Format, HEAD};

/// The format of files that are maps and nothing else: Lanelet2 and nets of SUMO.
pub struct MapAlone;

impl Format for MapAlone {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        matches!(root_name_of(head).as_deref(), Some("osm" | "net"))
    }

    /// They lie beside recordings.
    fn is_found(&self, _: &Path, _: &[u8]) -> bool {
        false
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let path = whole_file(address)?;
        let report = Report::about(path.display().to_string());
        let (map, hash) = read(&report, path, &Around::default(), &mut Ids::default())?;
        report.note("a map without traffic");
        let about = About {
            source: "map",
            benchmark_id: "ZAM_Map-1".into(),
            time_step_size: 0.1,
            tags: Vec::new(),
            ego: None,
            hash,
        };
        assemble(report, about, map, Vec::new())
    }
}

/// What a map is to lie around.
#[derive(Debug, Default)]
pub struct Around {
    /// Where places in degrees became metres.
    pub plane: Option<TransverseMercator>,
    /// Some places of tracks, metres.
    pub places: Vec<Point>,
    /// When the first step is and how long one is, seconds; lights of SUMO's nets have phases from then on.
    pub clock: (f64, f64),
}

/// Reads a map, whose hash comes with it.
///
/// # Errors
/// It is no map that is known, or damaged.
pub fn read(
    report: &Report,
    path: &Path,
    around: &Around,
    ids: &mut Ids,
) -> Result<(Map, ContentHash), ReadError> {
    let file = path.display().to_string();
    let about = Report::about(&file);
    let io = |error| ReadError::io(&file, &error);
    let bytes = system::read_file(path, system::LARGEST).map_err(io)?;
    let root = root_name_of(&bytes[..bytes.len().min(HEAD)]);
    let hash = ContentHash::digest(&bytes);
    let map = match root.as_deref() {
        Some("osm") => {
            let placement = match around.plane {
                Some(plane) => Placement::On(plane),
                None => Placement::FromUtm(lanelet2::origin(path, &around.places)?),
            };
            lanelet2::read(report, path, placement, ids)?
        }
        Some("OpenDRIVE") => opendrive::read(&bytes, &file, report, ids)?.map,
        Some("net") => sumo::map(report, path, ids, around.clock)?,
        Some("commonRoad") => {
            let network = commonroad::read_file(path)?.network;
            let map = Map {
                lanelets: network.lanelets,
                signs: network.signs,
                lights: network.lights,
                intersections: network.intersections,
                areas: network.areas,
            };
            renumbered(map, ids)
        }
        _ => {
            return Err(about.fail(
                "no map; Lanelet2 (.osm), OpenDRIVE (.xodr), nets of SUMO (.net.xml) and CommonRoad are read",
            ));
        }
    };
    if around.plane.is_some() && root.as_deref() != Some("osm") {
        report.at("").warn(
            "the tracks are in degrees and the map is in metres: its lanes may not be where they are",
        );
    } else if !around.places.is_empty() && is_elsewhere(&map, &around.places) {
        report
            .at("")
            .warn("no track is on the map: are both in the same coordinates?");
    }
    Ok((map, hash))
}

/// Whether no place is within the extent of a map.
fn is_elsewhere(map: &Map, places: &[Point]) -> bool {
    let points = map
        .lanelets
        .iter()
        .flat_map(|l| l.left.points.iter().chain(&l.right.points));
    let mut extent: Option<(Point, Point)> = None;
    for point in points {
        let (low, high) = extent.get_or_insert((*point, *point));
        *low = low.inf(point);
        *high = high.sup(point);
    }
    extent.is_none_or(|(low, high)| {
        let inside = |p: &Point| (low.x..=high.x).contains(&p.x) && (low.y..=high.y).contains(&p.y);
        !places.iter().any(inside)
    })
}

/// A map whose ids are free.
fn renumbered(mut map: Map, ids: &mut Ids) -> Map {
    let lanelets = map.lanelets.iter_mut().map(|l| &mut l.id);
    let signs = map.signs.iter_mut().map(|s| &mut s.id);
    let lights = map.lights.iter_mut().map(|l| &mut l.id);
    let crossings = map.intersections.iter_mut();
    let crossings = crossings.flat_map(|c| {
        let incomings = c.incomings.iter_mut().map(|i| &mut i.id);
        incomings.chain([&mut c.id])
    });
    let mut new = HashMap::new();
    let mut seen = HashSet::new();
    for id in lanelets.chain(signs).chain(lights).chain(crossings) {
        let free = if seen.insert(*id) {
            ids.keep(*id)
        } else {
            ids.fresh()
        };
        if free != *id {
            new.insert(*id, free);
            *id = free;
        }
    }
    if new.is_empty() {
        return map;
    }
    let change = |id: &mut i64| *id = new.get(id).copied().unwrap_or(*id);
    for lanelet in &mut map.lanelets {
        let beside = [&mut lanelet.adjacent_left, &mut lanelet.adjacent_right];
        beside.into_iter().flatten().for_each(|a| change(&mut a.id));
        let lists = [
            &mut lanelet.predecessors,
            &mut lanelet.successors,
            &mut lanelet.signs,
            &mut lanelet.lights,
        ];
        lists.into_iter().flatten().for_each(change);
        if let Some(line) = &mut lanelet.stop_line {
            line.signs
                .iter_mut()
                .chain(&mut line.lights)
                .for_each(change);
        }
    }
    for crossing in &mut map.intersections {
        crossing.crossings.iter_mut().for_each(change);
        for incoming in &mut crossing.incomings {
            let lists = [
                &mut incoming.lanelets,
                &mut incoming.right,
                &mut incoming.straight,
                &mut incoming.left,
            ];
            lists.into_iter().flatten().for_each(change);
            incoming.is_left_of.iter_mut().for_each(change);
        }
    }
    map
}
