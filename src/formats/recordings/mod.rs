//! Recordings of other data sets, as scenarios: Waymo Open Motion, Argoverse 2, nuPlan, nuScenes, levelXdata, SUMO,
//! OpenSCENARIO, ASAM OSI, py123d and tables of tracks.
//!
//! Each reader translates a file into a [`assembly::Map`] and [`assembly::RecordedTrack`]s; [`assembly::assemble`]
//! makes the scenario of them, with the recording's own ego, a planning problem and the checks that every format gets.

mod argoverse;
mod assembly;
mod esmini;
mod lane_shape;
mod lanelet2;
mod levelx;
mod maps;
mod nuplan;
mod nuscenes;
mod opendrive;
mod openscenario;
mod osi;
mod py123d;
mod rows;
mod sumo;
mod tracks;
mod utm;
mod waymo;
mod windows;

pub(super) use argoverse::{Argoverse, columns as parquet_columns};
pub(super) use esmini::is_log as is_esmini_log;
pub(super) use levelx::{LevelX, missing_columns};
pub(super) use maps::MapAlone;
pub(super) use nuplan::NuPlan;
pub(super) use nuscenes::NuScenes;
pub(super) use openscenario::OpenScenario;
pub use openscenario::{LONGEST_PLAY, Player, play_with};
pub(super) use osi::Osi;
pub(super) use py123d::{Py123d, is_in_log as is_in_log_of_py123d};
pub(super) use rows::columns_of;
pub(super) use sumo::Sumo;
pub use tracks::{
    Columns, ColumnsError, Forecast, NamedTable, TableOptions, check_table, check_table_options,
    read_forecasts, read_tables_with, reading_tables_with, usual_table_options,
};
pub(super) use tracks::{
    Lacking, Tables, id_of as id_of_track, json_columns, lacking as lacking_columns, without_header,
};
pub(super) use waymo::Waymo;
pub(super) use windows::WindowList;
pub use windows::{LongRecording, RankedMoment};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use nearmiss_base::geometry::{Point, ShapeError};
use nearmiss_scene::scenario::{Diagnostic, Severity};

use super::commonroad::ReadError;
use super::commonroad::builder::{self, Diagnostics, SourceLocation};
use super::commonroad::xml::{Element, Xml};
use super::dispatch::Address;

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
    Err(Report::about(format!("{file}#{part}")).fail(message))
}

fn report_of(address: &Address) -> Report {
    let shown = address.part.as_ref();
    let shown = shown.map_or_else(String::new, |part| format!("#{part}"));
    Report::about(format!("{}{shown}", address.file.display()))
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

/// The file that is read, and what was noted about it.
struct Report {
    file: String,
    diagnostics: Diagnostics,
}

/// A place in a recording: its row, where it has rows, and the track, lane or field.
struct At<'a> {
    report: &'a Report,
    line: usize,
    element: String,
}

impl Report {
    fn about(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            diagnostics: Diagnostics::default(),
        }
    }

    /// A named part of the file; an empty name means the whole.
    fn at(&self, element: impl Into<String>) -> At<'_> {
        self.row(0, element)
    }

    /// The same in a row, from 1.
    fn row(&self, line: usize, element: impl Into<String>) -> At<'_> {
        At {
            report: self,
            line,
            element: element.into(),
        }
    }

    /// An error about the whole file.
    fn fail(&self, message: impl Into<String>) -> ReadError {
        self.at("").fail(message)
    }

    /// Notes something about the whole file.
    fn note(&self, message: impl Into<String>) {
        self.at("").note(Severity::Note, message);
    }

    /// Notes what was assumed of so many things; nothing where there are none.
    fn note_count(&self, count: usize, message: impl FnOnce(usize) -> String) {
        if count > 0 {
            self.note(message(count));
        }
    }

    /// Counts what stands in the file and is not used, by its kind, such as `column dhw` or `edge@type`; `line` is 0
    /// where the file has none.
    fn unused(&self, kind: impl Into<String>, line: usize) {
        self.unused_times(kind, 1, line);
    }

    /// The same of so many.
    fn unused_times(&self, kind: impl Into<String>, count: usize, line: usize) {
        self.diagnostics.unused_times(kind, count, || line);
    }

    fn file(&self) -> &str {
        &self.file
    }

    fn push(&self, severity: Severity, element: String, message: String) {
        self.diagnostics.push(severity, || (0, element), message);
    }

    fn into_diagnostics(self) -> Vec<Diagnostic> {
        self.diagnostics.into_list()
    }
}

impl At<'_> {
    /// A number that a scenario can have.
    fn number(&self, value: f64) -> Result<f64, ReadError> {
        builder::finite(self, value, || value.to_string())
    }

    /// A place on a map, metres.
    fn point(&self, x: f64, y: f64) -> Result<Point, ReadError> {
        let coordinate = |value| builder::coordinate(self, self.number(value)?);
        Ok(Point::new(coordinate(x)?, coordinate(y)?))
    }

    /// A length or width, metres.
    fn size(&self, value: f64) -> Result<f64, ReadError> {
        builder::size(self, self.number(value)?)
    }
}

impl SourceLocation for At<'_> {
    fn fail(&self, message: impl Into<String>) -> ReadError {
        ReadError {
            file: self.report.file.clone(),
            line: self.line,
            column: 0,
            element: self.element.clone(),
            message: message.into(),
        }
    }

    fn note(&self, severity: Severity, message: impl Into<String>) {
        let place = || (self.line, self.element.clone());
        self.report.diagnostics.push(severity, place, message);
    }

    fn warn_tiny(&self, _: f64) {
        // Velocities at standstill are such numbers, written by filters.
    }

    fn leave_out(&self, error: &ShapeError) -> Result<(), ReadError> {
        self.warn(format!("{error}; it was left out"));
        Ok(())
    }
}

/// Kinds that are told apart.
const MOST_KINDS: usize = 200;

/// Counts by kind, with the line of the first one; 0 where the file has no lines.
#[derive(Debug, Default)]
struct Leftovers {
    counts: BTreeMap<String, (usize, usize)>,
    /// The name that is looked up: there are millions of attributes of few kinds.
    name: String,
}

/// Attributes that say nothing of what is described: of XML itself, and who wrote an element when.
const ABOUT: [&str; 8] = [
    "version",
    "visible",
    "changeset",
    "timestamp",
    "user",
    "uid",
    "action",
    "xmlns",
];

impl Leftovers {
    /// Counts one of a kind.
    fn add(&mut self, kind: &str, line: impl FnOnce() -> usize) {
        self.add_times(kind, 1, line);
    }

    /// Counts so many of a kind.
    fn add_times(&mut self, kind: &str, count: usize, line: impl FnOnce() -> usize) {
        if let Some((_, known)) = self.counts.get_mut(kind) {
            *known += count;
        } else if count > 0 && self.counts.len() < MOST_KINDS {
            self.counts.insert(kind.to_string(), (line(), count));
        }
    }

    /// Counts an attribute of an element.
    fn attribute(&mut self, element: &str, attribute: &str, line: impl FnOnce() -> usize) {
        self.part(element, '@', attribute, line);
    }

    /// Counts a field of a message.
    fn field(&mut self, message: &str, field: &str) {
        self.part(message, '/', field, || 0);
    }

    fn part(&mut self, whole: &str, between: char, part: &str, line: impl FnOnce() -> usize) {
        self.name.clear();
        if !whole.is_empty() {
            self.name.push_str(whole);
            self.name.push(between);
        }
        self.name.push_str(part);
        match self.counts.get_mut(&self.name) {
            Some((_, known)) => *known += 1,
            None => {
                let name = self.name.clone();
                self.add(&name, line);
            }
        }
    }

    /// Counts the attributes of an element but those that are used.
    fn attributes<'a>(&mut self, xml: &Xml<'a>, element: Element<'a>, used: &[&str]) {
        for (name, _) in xml.attributes(element) {
            let is_about = ABOUT.contains(&name) || name.contains(':');
            if !is_about && !used.contains(&name) {
                self.attribute(element.name, name, || xml.line(element));
            }
        }
    }

    /// Counts an element within another one, and passes over it.
    fn element<'a>(
        &mut self,
        xml: &mut Xml<'a>,
        within: &str,
        element: Element<'a>,
    ) -> Result<(), ReadError> {
        let name: String = element.name.chars().take(40).collect();
        self.add(&format!("{within}/{name}"), || xml.line(element));
        xml.skip()
    }

    /// Counts all elements within the innermost open one, and passes over its rest.
    fn rest<'a>(&mut self, xml: &mut Xml<'a>, within: &str) -> Result<(), ReadError> {
        while let Some(element) = xml.next()? {
            self.element(xml, within, element)?;
        }
        Ok(())
    }

    /// Tells them all in a scenario's report.
    fn report_to(&self, report: &Report) {
        for (kind, (line, count)) in &self.counts {
            report.unused_times(kind.as_str(), *count, *line);
        }
    }
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
