//! The map of an inD, rounD, uniD or exiD recording: a Lanelet2 file that lies beside it or in the data set's folder.

use std::path::{Path, PathBuf};

use super::meta::Recording;
use crate::formats::commonroad::ReadError;
use crate::formats::commonroad::builder::SourceLocation;
use crate::formats::recordings::assembly::Map;
use crate::formats::recordings::ids::Ids;
use crate::formats::recordings::lanelet2;
use crate::formats::recordings::report::Report;

/// Folders of the data sets with their maps, from the folder of the recordings.
const FOLDERS: [&str; 4] = [".", "../lanelets", "../maps/lanelets", "../maps"];

/// Reads the map, if there is one.
pub fn beside(
    report: &Report,
    recording_file: &Path,
    recording: &Recording,
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    match find(recording_file, recording.location) {
        Some(file) => {
            report.note(format!("map {}", file.display()));
            lanelet2::read(report, &file, recording.origin, ids)
        }
        None => {
            let message = "no map: no Lanelet2 file (.osm) beside it or in ../lanelets; the scenario has no lanes";
            report.at("").warn(message);
            Ok(Map::default())
        }
    }
}

/// The map beside a recording: the only one there, or the one whose name has the number of the place.
fn find(recording: &Path, location: Option<i64>) -> Option<PathBuf> {
    let folder = recording.parent().filter(|f| !f.as_os_str().is_empty());
    let folder = folder.unwrap_or_else(|| Path::new("."));
    FOLDERS.iter().find_map(|below| {
        let mut maps = Vec::new();
        collect(&folder.join(below), 1, &mut maps);
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
        if path
            .extension()
            .is_some_and(|x| x.eq_ignore_ascii_case("osm"))
        {
            maps.push(path);
        } else if deeper > 0 && path.is_dir() && !folder.ends_with(".") {
            collect(&path, deeper - 1, maps);
        }
    }
}
