//! The map of a levelXdata recording: a Lanelet2 file beside it, or the straight road of highD.

use std::path::{Path, PathBuf};

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Adjacent, Bound, Lanelet, LaneletType, LineMarking, RoadUser, Sign,
};

use super::tables::Recording;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{Ids, Map};
use crate::recordings::lanelet2::Placement;
use crate::recordings::{Report, has_extension, lanelet2, users_maps};

/// Folders of the data sets with their maps, from the folder of the recordings.
const FOLDERS: [&str; 4] = [".", "../lanelets", "../maps/lanelets", "../maps"];

/// Reads the map, if there is one.
pub fn read_map(
    report: &Report,
    recording_file: &Path,
    recording: &Recording,
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    match find(recording_file, recording.location, users_maps()) {
        Some(file) => {
            report.note(format!("map {}", file.display()));
            if recording.origin == (0.0, 0.0) && !lanelet2::is_in_metres(&file)? {
                report.at("").warn(
                    "the map is in degrees, and the recording has no origin (`xUtmOrigin`, `yUtmOrigin`): its lanes are not where the tracks are",
                );
            }
            lanelet2::read(report, &file, Placement::FromUtm(recording.origin), ids)
        }
        None => {
            report.at("").warn(format!(
                "no map: no Lanelet2 file (.osm) of place {} beside it, in ../lanelets{}; the scenario has no lanes",
                recording.location.map_or_else(|| "?".into(), |place| place.to_string()),
                super::super::in_words()
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
const MAX_FILES: usize = 1000;

fn collect(folder: &Path, deeper: usize, maps: &mut Vec<PathBuf>) {
    let files = folder
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .take(MAX_FILES);
    for path in files.map(|file| file.path()) {
        if has_extension(&path, "osm") {
            maps.push(path);
        } else if deeper > 0 && path.is_dir() {
            collect(&path, deeper - 1, maps);
        }
    }
}

/// The sign of a speed limit in Germany.
const SPEED_LIMIT: &str = "274";

/// The road reaches so far beyond the first and last middle of a vehicle, metres.
const ROAD_MARGIN: f64 = 20.0;

/// From a point of a border to the next, metres, at most.
const PIECE: f64 = 50.0;

/// The lanes of both directions; `extent` is from where to where there is traffic, metres.
///
/// The picture's y points down. Lanes at its top are driven to the left, those at its bottom to the right.
pub fn map(
    report: &Report,
    recording: &Recording,
    extent: Option<(f64, f64)>,
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    let (low, high) = extent.unwrap_or((0.0, 0.0));
    let (low, high) = (low - ROAD_MARGIN, high + ROAD_MARGIN);
    let pieces = ((high - low) / PIECE).ceil().clamp(1.0, 1000.0) as usize;
    let mut map = Map::default();
    for (place, lines) in recording.markings.iter().enumerate() {
        let to_the_left = place == 0;
        if lines.len() == 1 {
            let name = ["upperLaneMarkings", "lowerLaneMarkings"][place];
            report.at(name).warn("one line makes no lane; left out");
        }
        let lanes: Vec<i64> = lines.windows(2).map(|_| ids.fresh()).collect();
        let last = lanes.len().saturating_sub(1);
        for (i, pair) in lines.windows(2).enumerate() {
            let bound = |y: f64, outer: bool| {
                let at = |i: usize| low + (high - low) * i as f64 / pieces as f64;
                let mut points: Vec<Point> = (0..=pieces).map(|i| Point::new(at(i), -y)).collect();
                if to_the_left {
                    points.reverse();
                }
                Bound {
                    points,
                    heights: Vec::new(),
                    marking: if outer {
                        LineMarking::Solid
                    } else {
                        LineMarking::Dashed
                    },
                }
            };
            let (upper, lower) = (bound(pair[0], i == 0), bound(pair[1], i == last));
            let (left, right) = if to_the_left {
                (lower, upper)
            } else {
                (upper, lower)
            };
            let beside = |i: Option<usize>| {
                let id = *lanes.get(i?)?;
                Some(Adjacent {
                    id,
                    same_direction: true,
                })
            };
            let (above, below) = (beside(i.checked_sub(1)), beside(i.checked_add(1)));
            let (adjacent_left, adjacent_right) = if to_the_left {
                (below, above)
            } else {
                (above, below)
            };
            map.lanelets.push(Lanelet {
                id: lanes[i],
                left,
                right,
                adjacent_left,
                adjacent_right,
                types: vec![LaneletType::Highway],
                users_one_way: vec![RoadUser::Vehicle],
                ..Lanelet::default()
            });
        }
    }
    if let Some(limit) = recording.speed_limit {
        let id = ids.fresh();
        map.lanelets.iter_mut().for_each(|l| l.signs.push(id));
        let first = map.lanelets.first();
        let position = first.and_then(|l| l.right.points.first().copied());
        let limit = (limit * 1e4).round() / 1e4;
        map.signs
            .push(Sign::speed_limit(id, SPEED_LIMIT, limit, position));
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

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
