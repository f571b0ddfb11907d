//! Finds the sibling files of a 2024 scenario by the ids in them and by their names.

use std::collections::HashMap;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use super::kind::{FileHeader, MessageKind};
use nearmiss_base::system;

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
