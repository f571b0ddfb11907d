//! A scenario of 2024: map, traffic and planning problems, one file each.

use std::path::Path;

use super::checks::{self, THREE};
use super::dynamic::{self, Changes};
use super::kind::{FileHeader, MessageKind};
use super::report::{FieldPath, Report};
use super::sibling_files::{Folder, NotFound};
use super::{check_size, map, tasks};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{ScenarioBuilder, SourceLocation};
use crate::commonroad::xml::short;
use nearmiss_base::system;
use nearmiss_scene::scenario::{ContentHash, Scenario, Severity};

/// Reads the file `bytes` that is `head`, and from beside `path` what it needs.
///
/// A map alone is a road without traffic, a dynamic file with its map a scenario without planning problems.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    head: &FileHeader,
    path: Option<&Path>,
) -> Result<Scenario, ReadError> {
    let report = Report::about(file);
    let mut builder = ScenarioBuilder::default();
    let root = |name| FieldPath::root(&report, name);
    if head.kind == MessageKind::Map {
        let at = root("map");
        let message = format!(
            "a map alone: no obstacles, no planning problems, time steps of {} s",
            map::TIME_STEP_SIZE
        );
        at.note(Severity::Note, message);
        let header = map::read(&at, bytes, &mut builder, Changes::default())?;
        let scenario = builder.finish(header, ContentHash::digest(bytes));
        return Ok(checks::finish(report, &THREE, scenario));
    }
    // Mistakes in the file itself are reported before missing files.
    let (mut traffic, mut tasks) = (None, None);
    if head.kind == MessageKind::Scenario {
        tasks = Some(tasks::read(&root("scenario"), bytes, &mut builder)?);
    } else {
        let at = root("dynamic");
        traffic = Some(dynamic::read(&at, bytes, &mut builder)?);
        let message =
            "no planning problems: these are in the scenario file, whose name ends in -SC.pb";
        at.note(Severity::Note, message);
    }
    let mut parts = beside(&report, head, path)?;
    let mut dynamic_bytes = None;
    if let Some((name, bytes)) = parts.dynamic.take() {
        report.file.replace(name);
        traffic = Some(dynamic::read(&root("dynamic"), &bytes, &mut builder)?);
        dynamic_bytes = Some(bytes);
    }
    let (name, map_bytes) = parts.map;
    report.file.replace(name);
    let (mut header, mut environment, mut changes) = (None, None, Changes::default());
    if let Some(traffic) = traffic {
        (header, environment) = (Some(traffic.header), traffic.environment);
        changes = traffic.changes;
    }
    let map_header = map::read(&root("map"), &map_bytes, &mut builder, changes)?;
    report.file.replace(file.to_string());
    let mut header = header.unwrap_or(map_header);
    let tasks_bytes = tasks.as_ref().map(|_| bytes);
    if let Some(tasks) = tasks {
        let (own, other) = (tasks.time_step_size, header.time_step_size);
        if own != other {
            let message =
                format!("time steps of {own} s here, {other} s in the dynamic file; using {own} s");
            root("scenario").warn(message);
        }
        header = tasks;
    }
    if let Some(location) = &mut builder.location {
        location.environment = environment;
    }
    let traffic_bytes = dynamic_bytes.as_deref().or(Some(bytes));
    let all = [Some(&map_bytes[..]), traffic_bytes, tasks_bytes];
    let hash = ContentHash::of_parts(all.into_iter().flatten());
    Ok(checks::finish(report, &THREE, builder.finish(header, hash)))
}

/// A file's name and bytes.
type Named = (String, Vec<u8>);

struct Parts {
    map: Named,
    dynamic: Option<Named>,
}

/// Finds and reads the files that a dynamic or scenario file needs.
fn beside(report: &Report, head: &FileHeader, path: Option<&Path>) -> Result<Parts, ReadError> {
    let root = FieldPath::root(report, "");
    let Some(path) = path else {
        let message =
            "one of the files of a 2024 scenario; it can only be read in a folder with the others";
        return Err(root.fail(message));
    };
    let mut folder = Folder::around(path);
    let dynamic = match (head.kind, &head.dynamic) {
        (MessageKind::Scenario, Some(id)) => {
            Some(part(&root, &mut folder, path, MessageKind::Dynamic, id)?)
        }
        _ => None,
    };
    let id = root.need("map_id", head.map.as_deref())?;
    let map = part(&root, &mut folder, path, MessageKind::Map, id)?;
    Ok(Parts { map, dynamic })
}

fn part(
    root: &FieldPath<'_>,
    folder: &mut Folder,
    path: &Path,
    kind: MessageKind,
    id: &str,
) -> Result<Named, ReadError> {
    let what = if kind == MessageKind::Map {
        "map"
    } else {
        "dynamic file"
    };
    let shown = short(id);
    let file = folder.part_of(path, kind, id).map_err(|why| {
        root.fail(
            match why {
                NotFound::Missing => format!(
                    "needs the {what} `{shown}`, but the folder has no {shown}.pb and no other .pb file with that id; put it into the same folder"
                ),
                NotFound::Several(files) => {
                    let names = files.iter().filter_map(|f| f.file_name());
                    let names: Vec<_> = names.map(|n| n.to_string_lossy()).collect();
                    format!(
                        "needs the {what} `{shown}`, but several files beside it have that id: {}; rename the right one to {shown}.pb",
                        short(&names.join(", "))
                    )
                }
            },
        )
    })?;
    let name = file.display().to_string();
    if let Some(other) = folder.head(&file).filter(|h| h.id != id) {
        let message = format!(
            "needs the {what} `{shown}`; {name}, chosen by its name, is `{}`",
            short(&other.id)
        );
        root.warn(message);
    }
    check_size(&name, file.metadata().map_or(0, |m| m.len()))?;
    let bytes = system::read_file(&file, system::LARGEST).map_err(|e| ReadError::io(&name, &e))?;
    Ok((name, bytes))
}
