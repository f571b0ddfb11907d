//! Recordings of other data sets, as scenarios: Waymo Open Motion, Argoverse 2, nuPlan, levelXdata,
//! SUMO and OpenSCENARIO.
//!
//! Each reader translates a file into a [`assembly::Map`] and [`assembly::RecordedTrack`]s; [`assembly::assemble`]
//! makes the scenario of them, with the recording's own ego, a planning problem and the checks that every format gets.

mod argoverse;
mod assembly;
mod lane_shape;
mod lanelet2;
mod levelx;
mod nuplan;
mod opendrive;
mod openscenario;
mod report;
mod rows;
mod sumo;
mod utm;
mod waymo;
mod windows;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::commonroad::ReadError;
use super::dispatch::Address;

pub(super) use argoverse::{Argoverse, columns as parquet_columns};
pub(super) use levelx::{LevelX, missing_columns};
pub(super) use nuplan::NuPlan;
pub(super) use openscenario::OpenScenario;
pub(super) use rows::columns_of;
pub(super) use sumo::Sumo;
pub(super) use waymo::Waymo;
pub use windows::LongRecording;

/// The file of a format in which each file is one scenario.
///
/// # Errors
/// A part of it is named.
pub(super) fn whole_file(address: &Address) -> Result<&Path, ReadError> {
    let (file, Some(part)) = (&address.file, &address.part) else {
        return Ok(&address.file);
    };
    let file = file.display();
    let message = format!("{file} is one scenario; name it without `#{part}`");
    Err(report::Report::about(format!("{file}#{part}")).fail(message))
}

static MAPS: OnceLock<PathBuf> = OnceLock::new();

/// Says where maps are that do not lie with their recordings: a map, or a folder of them. Said once, before the first
/// recording is read, so that all readings of a recording have the same map.
pub fn look_for_maps_in(place: PathBuf) {
    // What is said again is what is said already: there is one configuration.
    let _ = MAPS.set(place);
}

/// The map or folder, where the user has one.
fn users_maps() -> Option<&'static Path> {
    MAPS.get().map(PathBuf::as_path)
}

/// The same as the end of a list of places that were searched.
fn in_words() -> String {
    users_maps().map_or_else(String::new, |maps| {
        format!(" or in {} (`maps` in config.toml)", maps.display())
    })
}

/// Whether a file has this extension, in any case.
fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

/// Where a file or folder is that `by` names: the first place at which there is one, else as it is named.
fn named_file(by: &Path, name: &str) -> PathBuf {
    let folder = by.parent().unwrap_or_else(|| Path::new(""));
    let plain = name.replace('\\', "/");
    let mut places = vec![folder.join(name), folder.join(&plain)];
    // The folders of another machine are not here.
    let is_elsewhere = plain.starts_with('/') || plain.get(1..3) == Some(":/");
    if let Some(last) = Path::new(&plain).file_name().filter(|_| is_elsewhere) {
        places.push(folder.join(last));
    }
    let found = places.iter().position(|place| place.exists());
    places.swap_remove(found.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn files_are_found_as_windows_and_other_machines_name_them() {
        let folder = tempfile::tempdir().unwrap();
        let (roads, scenarios) = (folder.path().join("roads"), folder.path().join("scenarios"));
        std::fs::create_dir_all(&roads).unwrap();
        std::fs::create_dir_all(&scenarios).unwrap();
        std::fs::write(roads.join("a.xodr"), "").unwrap();
        std::fs::write(scenarios.join("b.xodr"), "").unwrap();
        let by = scenarios.join("x.xosc");
        for name in ["../roads/a.xodr", r"..\roads\a.xodr", r".\..\roads/a.xodr"] {
            assert!(named_file(&by, name).is_file(), "{name}");
        }
        for name in [
            "b.xodr",
            r"C:\maps\b.xodr",
            "/home/somebody/maps/b.xodr",
            "C:/b.xodr",
        ] {
            assert_eq!(named_file(&by, name), scenarios.join("b.xodr"), "{name}");
        }
        // What is nowhere is called as it was named; a file of the same name elsewhere is another one.
        assert_eq!(named_file(&by, r"..\c.xodr"), scenarios.join(r"..\c.xodr"));
        assert!(!named_file(&by, "maps/b.xodr").exists());
    }
}
