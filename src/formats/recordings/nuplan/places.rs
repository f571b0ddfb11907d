//! Where the map of a log is: in the data set's folders, beside the log, or where the user says.

use std::path::{Path, PathBuf};

use super::log::Log;
use crate::recordings::user_maps::{self, has_extension, users_maps};

/// The name of maps.
const FILE: &str = "map.gpkg";

/// Folders of the data set in each other, from a log to the folder of its maps.
const UP: usize = 6;

/// Versions of a map that are looked at.
const MOST: usize = 100;

/// The map of a log, if there is one.
pub fn find(path: &Path, log: &Log) -> Option<PathBuf> {
    let mut names = [log.map.as_str(), log.location.as_str()]
        .into_iter()
        .filter(|name| is_plain(name));
    names.find_map(|name| of_name(path, name, users_maps()))
}

/// Where it was searched, and what helps, for a log without a map.
pub fn nowhere(log: &Log) -> String {
    let name = if is_plain(&log.map) { &log.map } else { "?" };
    format!(
        "no map: no {name}/VERSION/{FILE} beside the log, in `maps` of a folder above it{}; the scenario has no lanes and no lights; unpack nuPlan's maps there, or set `maps` in config.toml",
        user_maps::in_words()
    )
}

/// Whether a name from a log is one of a folder, and leads nowhere else.
fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    !name.is_empty() && name.chars().all(plain) && !name.starts_with('.')
}

fn of_name(path: &Path, name: &str, users: Option<&Path>) -> Option<PathBuf> {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut above = whole.ancestors().skip(1);
    let beside = above.next()?;
    let in_maps = std::iter::once(beside)
        .chain(above.take(UP))
        .map(|folder| folder.join("maps"));
    let mut found = in_folder(beside, name).or_else(|| in_folder_itself(beside));
    found = found.or_else(|| { in_maps }.find_map(|maps| in_folder(&maps, name)));
    found.or_else(|| match users? {
        file if file.is_file() => has_extension(file, "gpkg").then(|| file.to_path_buf()),
        folder => in_folder(folder, name).or_else(|| of_versions(folder, name)),
    })
}

/// The map of a name in a folder of maps: its newest version.
fn in_folder(maps: &Path, name: &str) -> Option<PathBuf> {
    let alone = maps.join(format!("{name}.gpkg"));
    let folder = maps.join(name);
    { alone.is_file().then_some(alone) }
        .or_else(|| in_folder_itself(&folder))
        .or_else(|| newest(&folder))
}

fn in_folder_itself(folder: &Path) -> Option<PathBuf> {
    let map = folder.join(FILE);
    map.is_file().then_some(map)
}

/// A folder of one map is named, not that of all maps.
fn of_versions(folder: &Path, name: &str) -> Option<PathBuf> {
    let is_its = folder.file_name().is_some_and(|folder| folder == name);
    in_folder_itself(folder).or_else(|| is_its.then(|| newest(folder))?)
}

fn newest(folder: &Path) -> Option<PathBuf> {
    let versions = folder.read_dir().into_iter().flatten().flatten().take(MOST);
    let maps = versions.map(|version| version.path().join(FILE));
    let mut maps: Vec<PathBuf> = maps.filter(|map| map.is_file()).collect();
    maps.sort_by_key(|map| version(map));
    maps.pop()
}

/// The numbers of a version, such as `9.17.1964`.
fn version(map: &Path) -> (Vec<u64>, PathBuf) {
    let folder = map
        .parent()
        .and_then(Path::file_name)
        .unwrap_or_default()
        .to_string_lossy();
    let numbers = folder
        .split('.')
        .filter_map(|part| part.parse().ok())
        .collect();
    (numbers, map.to_path_buf())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn maps_lie_in_the_data_set_beside_the_log_or_where_the_user_says() {
        let root = tempfile::tempdir().unwrap().path().canonicalize().unwrap();
        let make = |name: &str| {
            let path = root.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, "").unwrap();
            path
        };
        let log = make("dataset/nuplan-v1.1/splits/mini/a.db");
        let find = |users: Option<&Path>| of_name(&log, "us-ma-boston", users);
        assert_eq!(find(None), None);
        let mine = make("mine/us-ma-boston/9.9.1817/map.gpkg");
        let newer = make("mine/us-ma-boston/9.12.1817/map.gpkg");
        make("mine/sg-one-north/9.17.1964/map.gpkg");
        assert_eq!(find(mine.ancestors().nth(3)), Some(newer.clone()));
        assert_eq!(find(mine.ancestors().nth(2)), Some(newer));
        assert_eq!(find(Some(&mine)), Some(mine.clone()));
        let osm = make("mine/a.osm");
        assert_eq!(find(Some(&osm)), None);
        let of_dataset = make("dataset/maps/us-ma-boston/9.12.1817/map.gpkg");
        assert_eq!(find(Some(&mine)), Some(of_dataset));
        let beside = make("dataset/nuplan-v1.1/splits/mini/map.gpkg");
        assert_eq!(find(None), Some(beside));
        for name in ["", "..", "a/b", "/", ".hidden"] {
            assert!(!is_plain(name), "{name}");
        }
    }
}
