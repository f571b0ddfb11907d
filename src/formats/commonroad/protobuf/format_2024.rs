//! A scenario of 2024: map, traffic and planning problems, one file each, and how the files are found.
//!
//! The scenario file of 2024: planning problems, and the map and traffic they refer to.
//!
//! Finds the sibling files of a 2024 scenario by the ids in them and by their names.

use std::collections::HashMap;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use nearmiss_base::system;
use nearmiss_scene::scenario::{ContentHash, Header, Scenario, Severity};

use super::header::{self, Map};
use super::map::{self, Changes};
use super::messages::PlanningProblem;
use super::report::{FieldPath, Report};
use super::values::Elements;
use super::wire::{FileHeader, MessageKind};
use super::{THREE, check_size, obstacles};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{ScenarioBuilder, SourceLocation};
use crate::commonroad::xml::short;

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
        let header = map::read_map(&at, bytes, &mut builder, Changes::default())?;
        let scenario = builder.finish(header, ContentHash::digest(bytes));
        return Ok(super::finish(report, &THREE, scenario));
    }
    // Mistakes in the file itself are reported before missing files.
    let (mut traffic, mut tasks) = (None, None);
    if head.kind == MessageKind::Scenario {
        tasks = Some(read_tasks(&root("scenario"), bytes, &mut builder)?);
    } else {
        let at = root("dynamic");
        traffic = Some(map::read_traffic(&at, bytes, &mut builder)?);
        let message =
            "no planning problems: these are in the scenario file, whose name ends in -SC.pb";
        at.note(Severity::Note, message);
    }
    let mut parts = read_siblings(&report, head, path)?;
    let mut dynamic_bytes = None;
    if let Some((name, bytes)) = parts.dynamic.take() {
        report.file.replace(name);
        traffic = Some(map::read_traffic(&root("dynamic"), &bytes, &mut builder)?);
        dynamic_bytes = Some(bytes);
    }
    let (name, map_bytes) = parts.map;
    report.file.replace(name);
    let (mut header, mut environment, mut changes) = (None, None, Changes::default());
    if let Some(traffic) = traffic {
        (header, environment) = (Some(traffic.header), traffic.environment);
        changes = traffic.changes;
    }
    let map_header = map::read_map(&root("map"), &map_bytes, &mut builder, changes)?;
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
    Ok(super::finish(report, &THREE, builder.finish(header, hash)))
}

/// A file's name and bytes.
type Named = (String, Vec<u8>);

struct Parts {
    map: Named,
    dynamic: Option<Named>,
}

/// Finds and reads the files that a dynamic or scenario file needs.
fn read_siblings(
    report: &Report,
    head: &FileHeader,
    path: Option<&Path>,
) -> Result<Parts, ReadError> {
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

/// Adds the planning problems to a scenario, and the tags of all of them, each once; the header.
pub(super) fn read_tasks(
    root: &FieldPath<'_>,
    bytes: &[u8],
    builder: &mut ScenarioBuilder,
) -> Result<Header, ReadError> {
    let mut information: Option<(Header, Map)> = None;
    let (mut map, mut dynamic, mut cooperative) = (None, None, 0);
    let mut elements = Elements::new(root, builder);
    root.each_field(bytes, |field| {
        match field.number {
            1 => {
                let at = root.field("scenario_meta_information");
                at.part(field, &mut information, header::of_2024)?;
            }
            // These fields were used to find the other files.
            3 => map = Some(()),
            4 => dynamic = Some(()),
            5 => elements.add("planning_problems", field, problem)?,
            6 => cooperative += 1,
            _ => root.skip_unknown(field),
        }
        Ok(())
    })?;
    let (header, _) = root.need("scenario_meta_information", information)?;
    root.need("map_id", map)?;
    root.need("dynamic_id", dynamic)?;
    if cooperative > 0 {
        let message = format!(
            "{cooperative} cooperative planning problems are not supported; their single problems are kept"
        );
        root.note(Severity::Note, message);
    }
    Ok(header)
}

fn problem(
    builder: &mut ScenarioBuilder,
    at: &FieldPath<'_>,
    message: &PlanningProblem,
) -> Result<(), ReadError> {
    let own = at.need("scenario_tags", message.scenario_tags.as_ref())?;
    for tag in obstacles::tags(&at.field("scenario_tags"), own) {
        if !builder.tags.contains(&tag) {
            builder.tags.push(tag);
        }
    }
    builder.problem(at, obstacles::problem(at, message)?);
    Ok(())
}

/// How much of a file is looked at to see what it is, bytes: its information comes first.
const BEGINNING: u64 = 256 << 10;

/// The ending of protobuf files.
pub(super) const ENDING: &str = "pb";

/// The suffix of a scenario file's name after the benchmark id.
const SCENARIO_MARK: &str = "-SC";

/// The protobuf files of one folder; each is looked at once, when it is needed.
pub(super) struct Folder {
    path: PathBuf,
    heads: HashMap<PathBuf, Option<FileHeader>>,
    by_id: Option<HashMap<(MessageKind, String), Vec<PathBuf>>>,
}

/// Why a sibling file was not found.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum NotFound {
    /// No file is it.
    Missing,
    /// Several files have its id.
    Several(Vec<PathBuf>),
}

impl Folder {
    /// The folder that a file is in.
    pub fn around(file: &Path) -> Self {
        Self {
            path: file.parent().unwrap_or(Path::new("")).to_path_buf(),
            heads: HashMap::new(),
            by_id: None,
        }
    }

    /// The kind of a file; `None` if it is not a CommonRoad message.
    pub fn head(&mut self, file: &Path) -> Option<&FileHeader> {
        let head = self.heads.entry(file.to_path_buf());
        head.or_insert_with(|| look(file)).as_ref()
    }

    /// The files that `file` needs: the map, and for a scenario file the dynamic file.
    pub fn parts_of(&mut self, file: &Path) -> Vec<Result<PathBuf, NotFound>> {
        let Some(head) = self.head(file).cloned() else {
            return Vec::new();
        };
        let map = head.map.map(|id| self.part_of(file, MessageKind::Map, &id));
        let dynamic = head
            .dynamic
            .map(|id| self.part_of(file, MessageKind::Dynamic, &id));
        map.into_iter().chain(dynamic).collect()
    }

    /// The file of a kind and with an id that `file` needs.
    pub fn part_of(
        &mut self,
        file: &Path,
        kind: MessageKind,
        id: &str,
    ) -> Result<PathBuf, NotFound> {
        let named = match kind {
            MessageKind::Map => map_name(file),
            _ => dynamic_name(file),
        };
        self.find(kind, id, named.as_deref())
    }

    /// The file of a kind with an id: the one that has its name, the only one that has it inside, or the one that
    /// has the name that goes with the file that asks for it.
    fn find(
        &mut self,
        kind: MessageKind,
        id: &str,
        named: Option<&str>,
    ) -> Result<PathBuf, NotFound> {
        let by_name = self.named(kind, id);
        if let Some(file) = &by_name
            && self.head(file).is_some_and(|h| h.id == id)
        {
            return Ok(file.clone());
        }
        match self.with_id(kind, id) {
            [one] => return Ok(one.clone()),
            [] => {}
            several => return Err(NotFound::Several(several.to_vec())),
        }
        let by_custom = named.and_then(|name| self.named(kind, name));
        by_name.or(by_custom).ok_or(NotFound::Missing)
    }

    /// The file of a kind with a name.
    fn named(&mut self, kind: MessageKind, name: &str) -> Option<PathBuf> {
        let name = format!("{name}.{ENDING}");
        // An id is what some file says: it must not lead out of the folder.
        let mut components = Path::new(&name).components();
        let (Some(Component::Normal(_)), None) = (components.next(), components.next()) else {
            return None;
        };
        let file = self.path.join(&name);
        let right = self.head(&file).is_some_and(|head| head.kind == kind);
        right.then_some(file)
    }

    fn with_id(&mut self, kind: MessageKind, id: &str) -> &[PathBuf] {
        if self.by_id.is_none() {
            self.by_id = Some(self.index());
        }
        let found = self
            .by_id
            .as_ref()
            .and_then(|all| all.get(&(kind, id.to_string())));
        found.map_or(&[], Vec::as_slice)
    }

    fn index(&mut self) -> HashMap<(MessageKind, String), Vec<PathBuf>> {
        let folder = if self.path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &self.path
        };
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut files: Vec<PathBuf> = entries
            .map(|entry| self.path.join(entry.file_name()))
            .filter(|file| is_protobuf_name(file))
            .collect();
        files.sort();
        let mut index: HashMap<_, Vec<PathBuf>> = HashMap::new();
        for file in files {
            if let Some(head) = self.head(&file) {
                let key = (head.kind, head.id.clone());
                index.entry(key).or_default().push(file);
            }
        }
        index
    }
}

/// Whether a file's name ends as those of protobuf files do.
pub(in crate::commonroad) fn is_protobuf_name(file: &Path) -> bool {
    file.extension()
        .is_some_and(|x| x.eq_ignore_ascii_case(ENDING))
}

/// The name of a scenario file's dynamic file: its own name without the suffix.
fn dynamic_name(file: &Path) -> Option<String> {
    let stem = file.file_stem()?.to_str()?;
    stem.strip_suffix(SCENARIO_MARK).map(str::to_string)
}

/// The name of the map of a dynamic or scenario file: `DEU_Bremen-1` of `DEU_Bremen-1_10_T-1-SC`.
fn map_name(file: &Path) -> Option<String> {
    let name = file.file_stem()?.to_str()?;
    let stem = name.strip_prefix("C-").unwrap_or(name);
    let mut parts = stem.split('_');
    Some(format!("{}_{}", parts.next()?, parts.next()?))
}

/// The name of the scenario in a file: a scenario file's is without its mark.
pub(in crate::commonroad) fn scenario_name(file: &Path) -> Option<String> {
    is_protobuf_name(file).then(|| dynamic_name(file)).flatten()
}

fn look(file: &Path) -> Option<FileHeader> {
    let mut beginning = Vec::new();
    let opened = system::open_file(file).ok()?;
    opened.take(BEGINNING).read_to_end(&mut beginning).ok()?;
    FileHeader::detect(&beginning)
}
