//! The scenario of 2024: a map, the traffic on it and the planning problems, in a file each.

use std::path::Path;

use super::beside::{Folder, NotFound};
use super::dynamic::{self, Dynamic};
use super::kind::{Head, Kind};
use super::map::{self, RoadMap};
use super::report::{At, Report};
use super::tasks::{self, Tasks};
use super::{check_size, doubts, references};
use crate::scenario::commonroad::ReadError;
use crate::scenario::commonroad::xml::short;
use crate::scenario::{
    ContentHash, LaneletNetwork, Location, Obstacle, Scenario, Severity, Sign, TrafficLight,
};
use crate::system;

/// Bytes of the files of a scenario.
struct Files<'a> {
    map: &'a [u8],
    dynamic: Option<&'a [u8]>,
    tasks: Option<&'a [u8]>,
}

/// Reads the file `bytes` that is `head`, and from beside `path` what it needs.
///
/// A map alone is a road without traffic, a dynamic file with its map a scenario without planning problems.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    head: &Head,
    path: Option<&Path>,
) -> Result<Scenario, ReadError> {
    let mut report = Report::about(file);
    if head.kind == Kind::Map {
        let at = At::root("map");
        let message = format!(
            "a map alone: no obstacles, no planning problems, and {} s a time step",
            map::TIME_STEP_SIZE
        );
        report.note(Severity::Note, &at, message);
        let map = map::read(&mut report, &at, bytes)?;
        let files = Files {
            map: bytes,
            dynamic: None,
            tasks: None,
        };
        return Ok(compose(report, map, None, None, &files));
    }
    // What is wrong with the file itself is said before what is missing beside it.
    let (mut traffic, mut tasks) = (None, None);
    if head.kind == Kind::Scenario {
        tasks = Some(tasks::read(&mut report, &At::root("scenario"), bytes)?);
    } else {
        traffic = Some(dynamic::read(&mut report, &At::root("dynamic"), bytes)?);
        let message =
            "no planning problems: they are in a scenario file, whose name ends in -SC.pb";
        report.note(Severity::Note, &At::root("dynamic"), message);
    }
    let mut parts = beside(&mut report, head, path)?;
    let mut dynamic_bytes = None;
    if let Some((name, bytes)) = parts.dynamic.take() {
        report.file = name;
        traffic = Some(dynamic::read(&mut report, &At::root("dynamic"), &bytes)?);
        dynamic_bytes = Some(bytes);
    }
    let (name, map_bytes) = parts.map;
    report.file = name;
    let map = map::read(&mut report, &At::root("map"), &map_bytes)?;
    report.file = file.to_string();
    let files = Files {
        map: &map_bytes,
        dynamic: dynamic_bytes.as_deref().or(Some(bytes)),
        tasks: tasks.as_ref().map(|_| bytes),
    };
    Ok(compose(report, map, traffic, tasks, &files))
}

/// A file's name and bytes.
type Named = (String, Vec<u8>);

struct Parts {
    map: Named,
    dynamic: Option<Named>,
}

/// Finds and reads the files that a dynamic or scenario file needs.
fn beside(report: &mut Report, head: &Head, path: Option<&Path>) -> Result<Parts, ReadError> {
    let root = At::root("");
    let Some(path) = path else {
        let message = "it is one of the files of a 2024 scenario, and can be read only from a folder with the others";
        return Err(report.fail(&root, message));
    };
    let mut folder = Folder::around(path);
    let dynamic = match (head.kind, &head.dynamic) {
        (Kind::Scenario, Some(id)) => Some(part(report, &mut folder, path, Kind::Dynamic, id)?),
        _ => None,
    };
    let id = report.need(&root, "map_id", head.map.as_deref())?;
    let map = part(report, &mut folder, path, Kind::Map, id)?;
    Ok(Parts { map, dynamic })
}

fn part(
    report: &mut Report,
    folder: &mut Folder,
    path: &Path,
    kind: Kind,
    id: &str,
) -> Result<Named, ReadError> {
    let root = At::root("");
    let what = if kind == Kind::Map {
        "map"
    } else {
        "dynamic file"
    };
    let shown = short(id);
    let file = folder.part_of(path, kind, id).map_err(|why| {
        report.fail(
            &root,
            match why {
                NotFound::Missing => format!(
                    "it needs the {what} `{shown}`, which is not beside it: there is no {shown}.pb, and no other .pb file has that id; put it into the same folder"
                ),
                NotFound::Several(files) => {
                    let names = files.iter().filter_map(|f| f.file_name());
                    let names: Vec<_> = names.map(|n| n.to_string_lossy()).collect();
                    format!(
                        "it needs the {what} `{shown}`, and several files beside it say that they are: {}; name the right one {shown}.pb",
                        short(&names.join(", "))
                    )
                }
            },
        )
    })?;
    let name = file.display().to_string();
    if let Some(other) = folder.head(&file).filter(|h| h.id != id) {
        let message = format!(
            "it needs the {what} `{shown}`; {name}, taken for its name, is `{}`",
            short(&other.id)
        );
        report.warn(&root, message);
    }
    check_size(&name, file.metadata().map_or(0, |m| m.len()))?;
    let bytes = system::read_file(&file, system::LARGEST).map_err(|e| ReadError::io(&name, &e))?;
    Ok((name, bytes))
}

fn compose(
    mut report: Report,
    map: RoadMap,
    traffic: Option<Dynamic>,
    tasks: Option<Tasks>,
    files: &Files<'_>,
) -> Scenario {
    let r = &mut report;
    let (mut signs, mut lights) = (map.signs, map.lights);
    let (mut header, mut environment, mut parts) = (map.header, None, Vec::new());
    if let Some(traffic) = traffic {
        apply(r, &traffic, &mut signs, &mut lights);
        header = traffic.header;
        environment = traffic.environment;
        parts = traffic.obstacles;
    }
    for (i, _) in signs
        .iter()
        .enumerate()
        .filter(|(_, s)| s.elements.is_empty())
    {
        let at = At::root("map");
        let at = at.nth("traffic_signs", i);
        r.note(Severity::Note, &at, "a traffic sign that says nothing");
    }
    parts.extend(map.obstacles);
    let (mut tags, mut problems) = (Vec::new(), Vec::new());
    if let Some(tasks) = tasks {
        let (own, other) = (tasks.header.time_step_size, header.time_step_size);
        if own != other {
            let message =
                format!("{own} s a time step here, {other} s in the dynamic file; {own} s taken");
            r.warn(&At::root("scenario"), message);
        }
        header = tasks.header;
        tags = tasks.tags;
        problems = tasks.problems;
    }
    let network = LaneletNetwork::new(map.lanelets, signs, lights, map.intersections);
    let (road, planning) = (At::root("map"), At::root("scenario"));
    references::check(r, &network, &road, &problems, &planning);
    let dt = header.time_step_size;
    let obstacles = parts.into_iter().map(|parts| Obstacle::new(parts, dt));
    let all = [Some(files.map), files.dynamic, files.tasks];
    let mut scenario = Scenario {
        header,
        location: Some(Location {
            environment,
            ..map.location
        }),
        tags,
        network,
        obstacles: obstacles.collect(),
        planning_problems: problems,
        diagnostics: Vec::new(),
        hash: ContentHash::of_parts(all.into_iter().flatten()),
    };
    doubts::note(&mut report, &doubts::THREE, &scenario);
    scenario.diagnostics = report.into_diagnostics();
    scenario
}

/// Gives lights their cycles, and signs what they say in this scenario.
fn apply(r: &mut Report, traffic: &Dynamic, signs: &mut [Sign], lights: &mut [TrafficLight]) {
    let root = At::root("dynamic");
    let places = lights.iter().enumerate().map(|(i, l)| (l.id, i));
    let places: std::collections::HashMap<i64, usize> = places.collect();
    for (i, cycle) in traffic.cycles.iter().enumerate() {
        let Some(place) = places.get(&cycle.light) else {
            let message = format!("it refers to light {}, which is not there", cycle.light);
            r.warn(&root.nth("traffic_light_cycle", i), message);
            continue;
        };
        let light = &mut lights[*place];
        light.cycle.clone_from(&cycle.phases);
        (light.offset, light.active) = (cycle.offset, cycle.active);
    }
    let places = signs.iter().enumerate().map(|(i, s)| (s.id, i));
    let places: std::collections::HashMap<i64, usize> = places.collect();
    for (i, (id, elements)) in traffic.signs.iter().enumerate() {
        match places.get(id) {
            Some(place) => signs[*place].elements.clone_from(elements),
            None => {
                let message = format!("it refers to sign {id}, which is not there");
                r.warn(&root.nth("traffic_sign_value", i), message);
            }
        }
    }
}
