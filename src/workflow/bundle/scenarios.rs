//! The scenario files of a batch, with the recordings of their egos, for a bundle that holds them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::manifest::{PackedScenario, SCENARIOS};
use nearmiss_formats::{Entry, EntryLocation, find_recording};
use nearmiss_store::Item;

/// The scenarios of a batch, and the files to pack by their names in the bundle. Those that have changed since they were
/// asked about are left out.
pub(super) fn collect(
    items: &[Item],
    paths: &BTreeMap<String, String>,
    with_files: bool,
) -> (Vec<PackedScenario>, BTreeMap<String, PathBuf>) {
    let mut files = BTreeMap::new();
    let mut hashes: BTreeMap<&str, Option<&String>> = BTreeMap::new();
    for item in items {
        let hash = hashes.entry(item.asked.path.as_str()).or_default();
        *hash = hash.or(item.asked.scenario_hash.as_ref());
    }
    let each = hashes.into_iter().map(|(path, hash)| {
        let name = paths.get(path).cloned().unwrap_or_default();
        let entry = Entry::of_argument(Path::new(path));
        let own = match (&entry.place, with_files) {
            // Recordings are not passed on: their licences do not let them be.
            (EntryLocation::File(_), true) if entry.is_recording() => Vec::new(),
            (EntryLocation::File(file), true) if is_same(&entry, hash) => of_entry(&entry, file),
            _ => Vec::new(),
        };
        let folder = Path::new(&name).parent().unwrap_or(Path::new(""));
        let included = !own.is_empty();
        for (at, (below, file)) in own.into_iter().enumerate() {
            // The scenario itself comes first, under the name that its questions have.
            let place = match at {
                0 => name.clone(),
                _ => super::manifest::safe(&folder.join(below).display().to_string()),
            };
            files.insert(format!("{SCENARIOS}{place}"), file);
        }
        PackedScenario {
            path: name,
            sha256: hash.cloned(),
            included,
        }
    });
    let scenarios = each.collect();
    (scenarios, files)
}

fn is_same(entry: &Entry, hash: Option<&String>) -> bool {
    let read = entry.read();
    read.is_ok_and(|scenario| hash == Some(&scenario.hash.to_string()))
}

/// The file of a scenario and those that belong to it, each with its place beside it.
fn of_entry(entry: &Entry, file: &Path) -> Vec<(PathBuf, PathBuf)> {
    let name = |path: &Path| PathBuf::from(path.file_name().unwrap_or_default());
    let mut found = vec![(name(file), file.to_path_buf())];
    let is_protobuf = file.extension().is_some_and(|end| end == "pb");
    let beside = file.parent().filter(|_| is_protobuf).map(std::fs::read_dir);
    if let Some(Ok(beside)) = beside {
        let parts = beside.flatten().map(|one| one.path()).filter(|path| {
            let own = path.extension().is_some_and(|end| end == "pb") && path != file;
            own && name(path).to_string_lossy().starts_with(&entry.name)
        });
        let mut parts: Vec<PathBuf> = parts.collect();
        parts.sort();
        found.extend(parts.into_iter().map(|path| (name(&path), path)));
    }
    if let Some(recording) = find_recording(file) {
        let own = name(&recording);
        let place = if own.to_string_lossy().ends_with("ego_trajectory.csv") {
            PathBuf::from(format!("{}.ego_trajectory.csv", entry.name))
        } else if recording.parent() == file.parent() {
            own
        } else {
            Path::new(&entry.name).join(own)
        };
        found.push((place, recording));
    }
    found
}
