//! A scenario in each of the formats that `convert` writes, and what is said of it.

use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::commonroad::{conform, write, write_2018b};
use nearmiss_formats::{
    EgoError, Entry, EntryLocation, TableShape, USUAL_VEHICLE, find_recording, write_recording,
    write_sized_recording, write_tables,
};
use nearmiss_record::Format;
use nearmiss_scene::scenario::{Ego, EgoSource, Scenario, alike, in_short};
use nearmiss_workflow::{
    ExportRequest, SimulatedEgo, VariantOrigin, export_to_simulator, scene_to_export,
};

use super::Converted;
use super::target::{HIGHD_TRACKS, ROADS, Target};
use crate::open::configuration;
use crate::{Failure, output};

impl Converted {
    /// A file, or what is printed where there is none.
    fn add(&mut self, file: Option<PathBuf>, bytes: Vec<u8>) {
        match file {
            Some(path) => self.files.push((path, bytes)),
            None => self.printed = Some(output::escaped_xml(&String::from_utf8_lossy(&bytes))),
        }
    }
}

/// A scenario as CommonRoad 2020a XML, made to fit its schema where that is wanted.
pub(super) fn commonroad(
    entry: &Entry,
    file: Option<PathBuf>,
    to_schema: bool,
) -> Result<Converted, Failure> {
    let scenario = entry.read().map_err(Failure::input)?;
    let conformed = conform(&scenario);
    let name = &entry.name;
    let written = if to_schema {
        &conformed.scenario
    } else {
        &scenario
    };
    let bytes = write(written).map_err(Failure::input)?;
    let mut done = beside(entry, &scenario, file.as_deref());
    done.add(file, bytes);
    let said = &mut done.said;
    said.extend(read_in_words(entry, &scenario));
    let (changes, violations) = (&conformed.changes, &conformed.violations);
    if to_schema {
        let changed = alike(changes).into_iter().map(|c| format!("{name}: {c}"));
        said.extend(changed);
        let unfit = alike(violations).into_iter();
        said.extend(unfit.map(|v| format!("{name}: does not conform: {v}")));
    } else if changes.len() + violations.len() > 0 {
        let count = changes.len() + violations.len();
        let things = if count == 1 {
            "element does"
        } else {
            "elements do"
        };
        said.push(format!(
            "{name}: written as read; {count} {things} not conform to the 2020a schema; --schema lists and fixes them"
        ));
    }
    done.fits = violations.is_empty();
    Ok(done)
}

/// What is beside a scenario of CommonRoad: its ego.
fn beside(entry: &Entry, scenario: &Scenario, file: Option<&Path>) -> Converted {
    let name = &entry.name;
    let mut done = Converted::default();
    match (file, ego_recording(entry, scenario)) {
        (_, Ok(None)) => {}
        // Before the scenario, so that it is never there without.
        (Some(path), Ok(Some(recording))) => done.files.push((ego_beside(path), recording)),
        (None, Ok(Some(_))) => done.said.push(format!(
            "{name}: the ego is left out; -o FILE.xml writes it beside the scenario"
        )),
        (_, Err(error)) => done
            .said
            .push(format!("{name}: the ego is left out: {error}")),
    }
    if VariantOrigin::read(entry).is_some() {
        done.said.push(format!(
            "{name}: its manifest and the drives of good drivers are of the original file, and not copied"
        ));
    }
    done
}

/// What was noted while a scenario was read.
fn read_in_words<'a>(
    entry: &'a Entry,
    scenario: &'a Scenario,
) -> impl Iterator<Item = String> + 'a {
    let read = in_short(&scenario.diagnostics).into_iter();
    read.map(|(_, words)| format!("{}: reading: {words}", entry.name))
}

/// A scenario as CommonRoad 2018b XML.
pub(super) fn commonroad_2018b(entry: &Entry, file: Option<PathBuf>) -> Result<Converted, Failure> {
    let scenario = entry.read().map_err(Failure::input)?;
    let (bytes, lost) = write_2018b(&scenario).map_err(Failure::input)?;
    let mut done = beside(entry, &scenario, file.as_deref());
    done.add(file, bytes);
    done.said.extend(read_in_words(entry, &scenario));
    let lost = lost.into_iter();
    done.said
        .extend(lost.map(|said| format!("{}: {said}", entry.name)));
    done.fits = true;
    Ok(done)
}

/// The file beside a scenario, where its ego is looked for first.
pub(super) fn ego_beside(scenario: &Path) -> PathBuf {
    scenario.with_extension("ego_trajectory.csv")
}

/// The ego that lies with a scenario, or is in its file, as CSV; nothing where there is none.
///
/// A CSV file that tells all is copied byte for byte.
///
/// # Errors
/// The file with the ego cannot be read.
fn ego_recording(entry: &Entry, scenario: &Scenario) -> Result<Option<Vec<u8>>, EgoError> {
    let Some(ego) = entry.recorded_ego(scenario)? else {
        return Ok(None);
    };
    let size = ego.footprint.shape().size();
    let is_usual = size == USUAL_VEHICLE.footprint().shape().size();
    if is_usual && let Some(bytes) = as_it_is(entry, scenario, &ego) {
        return Ok(Some(bytes));
    }
    let written = if is_usual {
        write_recording(ego.id, &ego.track)
    } else {
        write_sized_recording(ego.id, &ego.track, size)
    };
    // Writing goes to memory.
    Ok(written.ok())
}

/// The bytes of a recording in a file of its own.
fn as_it_is(entry: &Entry, scenario: &Scenario, ego: &Ego) -> Option<Vec<u8>> {
    let is_csv = matches!(ego.source, EgoSource::Recording(_)) && scenario.recorded_ego.is_none();
    match &entry.place {
        EntryLocation::File(path) if is_csv => {
            system::read_file(&find_recording(path)?, system::LARGEST).ok()
        }
        _ => None,
    }
}

/// How egos are planned.
fn planning() -> Result<Settings, Failure> {
    let (_, config) = configuration()?;
    Ok((&config.planning()).into())
}

/// One scenario, and what the formats cannot say of it.
pub(super) fn openscenario(
    entry: &Entry,
    file: Option<PathBuf>,
    ego: &SimulatedEgo,
    cancel: &Cancel,
) -> Result<Converted, Failure> {
    let Some(path) = file else {
        return Err(Failure::input(
            "OpenSCENARIO is two files; name the first one or a folder: -o FILE.xosc",
        ));
    };
    let roads = path.with_extension(ROADS);
    let road_file = roads.file_name().unwrap_or_default().to_string_lossy();
    let request = ExportRequest {
        entry,
        ego,
        road_file: &road_file,
        settings: &planning()?,
    };
    let exported = export_to_simulator(&request, cancel).map_err(Failure::input)?;
    let Some((scenario, exported)) = exported else {
        return Ok(Converted::default());
    };
    let told = exported.notes.iter();
    let notes = told.map(|note| format!("{}: {note}", entry.name));
    let said = read_in_words(entry, &scenario).chain(notes).collect();
    Ok(Converted {
        // The roads first, so that a scenario is never there without them.
        files: vec![(roads, exported.roads), (path, exported.scenario)],
        printed: None,
        said,
        fits: true,
    })
}

/// A scenario as tables of tracks.
pub(super) fn tables(
    entry: &Entry,
    file: Option<PathBuf>,
    target: Target,
    ego: &SimulatedEgo,
    cancel: &Cancel,
) -> Result<Converted, Failure> {
    let is_parquet = |path: &PathBuf| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("parquet"))
    };
    let shape = match target {
        Target::HighD if file.is_none() => {
            return Err(Failure::input(
                "highD is three files; name the one of the tracks or a folder: -o 01_tracks.csv",
            ));
        }
        Target::HighD => TableShape::HighD,
        Target::Interaction => TableShape::Interaction,
        _ if file.as_ref().is_some_and(is_parquet) => TableShape::Tracks(Format::Parquet),
        _ => TableShape::Tracks(Format::Csv),
    };
    let exported = scene_to_export(entry, ego, &planning()?, cancel).map_err(Failure::input)?;
    let Some((scenario, ego)) = exported else {
        return Ok(Converted::default());
    };
    let written = write_tables(shape, &scenario, ego.as_ref())
        .map_err(|error| Failure::input(format!("{}: {error}", entry.display())))?;
    let mut done = Converted {
        said: read_in_words(entry, &scenario).collect(),
        fits: true,
        ..Converted::default()
    };
    for (end, bytes) in written.files {
        done.add(file.as_ref().map(|file| with_end(file, end)), bytes);
    }
    let notes = written.notes.iter();
    done.said
        .extend(notes.map(|note| format!("{}: {note}", entry.name)));
    Ok(done)
}

/// A file of the same recording whose name ends so: `01_tracks.csv` and `_tracksMeta.csv` make `01_tracksMeta.csv`.
fn with_end(file: &Path, end: &str) -> PathBuf {
    if end.is_empty() {
        return file.to_path_buf();
    }
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let ends = [HIGHD_TRACKS, ".csv"];
    let recording = ends
        .iter()
        .find_map(|end| name.strip_suffix(end))
        .unwrap_or(&name);
    file.with_file_name(format!("{recording}{end}"))
}
