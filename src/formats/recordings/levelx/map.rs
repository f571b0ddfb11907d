//! The map of an inD, rounD, uniD or exiD recording: a Lanelet2 file that lies beside it, in the data set's folder, or
//! where the user says.

use std::path::{Path, PathBuf};

use super::meta::Recording;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::Map;
use crate::recordings::ids::Ids;
use crate::recordings::lanelet2;
use crate::recordings::report::Report;
use crate::recordings::user_maps::{self, has_extension, users_maps};

/// Folders of the data sets with their maps, from the folder of the recordings.
const FOLDERS: [&str; 4] = [".", "../lanelets", "../maps/lanelets", "../maps"];

/// Reads the map, if there is one.
pub fn beside(
    report: &Report,
    recording_file: &Path,
    recording: &Recording,
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    match find(recording_file, recording.location, users_maps()) {
        Some(file) => {
            report.note(format!("map {}", file.display()));
            lanelet2::read(report, &file, recording.origin, ids)
        }
        None => {
            report.at("").warn(format!(
                "no map: no Lanelet2 file (.osm) of place {} beside it, in ../lanelets{}; the scenario has no lanes",
                recording.location.map_or_else(|| "?".into(), |place| place.to_string()),
                user_maps::in_words()
            ));
            Ok(Map::default())
        }
    }
}

/// The map of a recording: beside it, or else where the user has maps; the only one there, or the one whose name has the
/// number of the place.
fn find(recording: &Path, location: Option<i64>, users: Option<&Path>) -> Option<PathBuf> {
    let folder = recording
        .parent()
        .filter(|f| !f.as_os_str().is_empty())
        .unwrap_or_else(|| Path::new("."));
    let mut folders = FOLDERS
        .iter()
        .map(|below| folder.join(below))
        .chain(users.map(Path::to_path_buf));
    folders.find_map(|folder| {
        if folder.is_file() {
            // The user's map may be one of another data set.
            return (!has_extension(&folder, "gpkg")).then_some(folder);
        }
        let mut maps = Vec::new();
        collect(&folder, 1, &mut maps);
        maps.sort();
        if let [only] = &maps[..] {
            return Some(only.clone());
        }
        let location = location?;
        maps.into_iter().find(|file| {
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            let mut numbers = name
                .split(|c: char| !c.is_ascii_digit())
                .filter(|n| !n.is_empty());
            numbers.next().and_then(|n| n.parse().ok()) == Some(location)
        })
    })
}

/// Files that are looked at in a folder.
const MOST: usize = 1000;

fn collect(folder: &Path, deeper: usize, maps: &mut Vec<PathBuf>) {
    let files = folder.read_dir().into_iter().flatten().flatten().take(MOST);
    for path in files.map(|file| file.path()) {
        if has_extension(&path, "osm") {
            maps.push(path);
        } else if deeper > 0 && path.is_dir() {
            collect(&path, deeper - 1, maps);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn maps_lie_beside_the_recording_or_where_the_user_says() {
        let root = tempfile::tempdir().unwrap();
        let make = |name: &str| {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, "").unwrap();
            path
        };
        let recording = make("data/18_tracks.csv");
        let (one, two) = (
            make("maps-of-mine/location1.osm"),
            make("maps-of-mine/02_b.osm"),
        );
        let folder = one.parent();
        assert_eq!(find(&recording, Some(1), None), None);
        assert_eq!(find(&recording, Some(1), folder), Some(one.clone()));
        assert_eq!(find(&recording, Some(2), folder), Some(two));
        assert_eq!(find(&recording, Some(3), folder), None);
        // A file is the map of all.
        assert_eq!(find(&recording, Some(3), Some(&one)), Some(one.clone()));
        // What lies beside the recording is nearer.
        let beside = make("lanelets/location1.osm");
        let found = find(&recording, Some(1), folder).unwrap();
        assert_eq!(
            found.canonicalize().unwrap(),
            beside.canonicalize().unwrap()
        );
    }
}
