//! A scenario in each of the formats that are written, and what is said of it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system;
use nearmiss_formats::commonroad::{conform, write, write_2018b};
use nearmiss_formats::{
    EgoSelection, Entry, EntryLocation, TableShape, USUAL_VEHICLE, VariedMotion, find_recording,
    write_recording, write_sized_recording, write_tables,
};
use nearmiss_record::Format;
use nearmiss_scene::scenario::{Ego, EgoSource, Scenario, alike, in_short};

use super::target::{HIGHD_TRACKS, ROADS, Target, ends_with};
use super::{ConvertRequest, Converted};
use crate::{ExportRequest, SimulatedEgo, VariantOrigin, export_to_simulator};

/// A scenario as CommonRoad 2020a XML, made to fit its schema where that is wanted.
pub(super) fn commonroad(
    request: &ConvertRequest<'_>,
    scenario: Arc<Scenario>,
    ego: Option<Ego>,
) -> Result<Converted, String> {
    let (entry, to_schema) = (request.entry, request.to_schema);
    let (scenario, mut done) = begun(request, scenario, ego, to_schema)?;
    let conformed = conform(&scenario);
    let name = &entry.name;
    let written = if to_schema {
        &conformed.scenario
    } else {
        &scenario
    };
    let bytes = write(written).map_err(|error| error.to_string())?;
    done.add(request.file.map(Path::to_path_buf), bytes);
    let said = &mut done.said;
    said.extend(read_in_words(entry, &scenario));
    if !scenario.network.areas.is_empty() {
        said.push(format!("{name}: drivable areas are left out"));
    }
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

/// A scenario of CommonRoad, or the part of it that is written, and what is beside it: its ego.
fn begun(
    request: &ConvertRequest<'_>,
    scenario: Arc<Scenario>,
    ego: Option<Ego>,
    from_zero: bool,
) -> Result<(Arc<Scenario>, Converted), String> {
    let ConvertRequest { entry, part, .. } = *request;
    let name = &entry.name;
    let mut done = Converted::default();
    let is_beside = *request.ego == SimulatedEgo::Follows(EgoSelection::Beside);
    let unchanged = ego.as_ref().filter(|_| is_beside && !part.cuts_time());
    let copied = unchanged.and_then(|ego| as_it_is(entry, &scenario, ego));
    let part = part.of(entry, scenario, ego, from_zero)?;
    done.said.extend(part.said);
    match (request.file, part.ego) {
        (_, None) => {}
        (
            _,
            Some(Ego {
                source: EgoSource::Obstacle(id),
                ..
            }),
        ) => done.said.push(format!(
            "{name}: that the ego is {id} is left out; it stays an obstacle"
        )),
        // Before the scenario, so that it is never there without.
        (Some(path), Some(ego)) => {
            let recording = copied.or_else(|| recording(&ego));
            done.files
                .extend(recording.map(|bytes| (ego_beside(path), bytes)));
        }
        (None, Some(_)) => done.said.push(format!(
            "{name}: the ego is left out; -o FILE.xml writes it beside the scenario"
        )),
    }
    if !matches!(VariantOrigin::read(entry), Ok(None)) {
        done.said.push(format!(
            "{name}: its manifest and the drives of ideal drivers are of the original file, and not copied"
        ));
    }
    Ok((part.scenario, done))
}

/// How notes begin, behind the name.
pub(super) const READING: &str = "reading: ";

/// What was noted while a scenario was read.
fn read_in_words<'a>(
    entry: &'a Entry,
    scenario: &'a Scenario,
) -> impl Iterator<Item = String> + 'a {
    let read = in_short(&scenario.diagnostics).into_iter();
    read.map(|(_, words)| format!("{}: {READING}{words}", entry.name))
}

/// A scenario as CommonRoad 2018b XML.
pub(super) fn commonroad_2018b(
    request: &ConvertRequest<'_>,
    scenario: Arc<Scenario>,
    ego: Option<Ego>,
) -> Result<Converted, String> {
    let entry = request.entry;
    let (scenario, mut done) = begun(request, scenario, ego, false)?;
    let (bytes, lost) = write_2018b(&scenario).map_err(|error| error.to_string())?;
    done.add(request.file.map(Path::to_path_buf), bytes);
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

/// An ego as CSV, with its size where that is not the usual one.
fn recording(ego: &Ego) -> Option<Vec<u8>> {
    let size = ego.footprint.shape().size();
    let written = if size == usual_size() {
        write_recording(ego.id, &ego.track)
    } else {
        write_sized_recording(ego.id, &ego.track, size)
    };
    // Writing goes to memory.
    written.ok()
}

fn usual_size() -> (f64, f64) {
    USUAL_VEHICLE.footprint().shape().size()
}

/// The bytes of a recording in a file of its own that tells all.
fn as_it_is(entry: &Entry, scenario: &Scenario, ego: &Ego) -> Option<Vec<u8>> {
    let is_csv = matches!(ego.source, EgoSource::Recording(_)) && scenario.recorded_ego.is_none();
    match &entry.place {
        EntryLocation::File(path) if is_csv && ego.footprint.shape().size() == usual_size() => {
            system::read_file(&find_recording(path)?, system::LARGEST).ok()
        }
        _ => None,
    }
}

/// One scenario, and what the formats cannot say of it.
pub(super) fn openscenario(
    request: &ConvertRequest<'_>,
    scenario: Arc<Scenario>,
    ego: Option<Ego>,
    varied: Option<&VariedMotion>,
) -> Result<Converted, String> {
    let entry = request.entry;
    let roads = request.file.map(|path| path.with_extension(ROADS));
    let road_file = roads.as_deref().and_then(Path::file_name);
    let part = request.part.of(entry, scenario, ego, true)?;
    let exported = export_to_simulator(&ExportRequest {
        entry,
        scenario: &part.scenario,
        ego: part.ego.as_ref(),
        is_free: *request.ego == SimulatedEgo::Free,
        road_file: &road_file.unwrap_or_default().to_string_lossy(),
        varied,
    })?;
    let told = exported.notes.iter();
    let notes = told.map(|note| format!("{}: {note}", entry.name));
    let read = read_in_words(entry, &part.scenario).chain(notes);
    let mut done = Converted {
        said: part.said.iter().cloned().chain(read).collect(),
        fits: true,
        ..Converted::default()
    };
    // The roads first, so that a scenario is never there without them.
    done.add(roads, exported.roads);
    done.add(request.file.map(Path::to_path_buf), exported.scenario);
    Ok(done)
}

/// A scenario as tables of tracks.
pub(super) fn tables(
    request: &ConvertRequest<'_>,
    scenario: Arc<Scenario>,
    ego: Option<Ego>,
) -> Result<Converted, String> {
    let ConvertRequest { entry, file, .. } = *request;
    let ends = |ending| file.is_some_and(|file| ends_with(file, ending));
    let shape = match request.target {
        Target::HighD => TableShape::HighD,
        Target::Interaction => TableShape::Interaction,
        _ if ends("parquet") => TableShape::Tracks(Format::Parquet),
        _ if ends("arrow") => TableShape::Tracks(Format::Arrow),
        _ => TableShape::Tracks(Format::Csv),
    };
    let part = request.part.of(entry, scenario, ego, false)?;
    let written = write_tables(shape, &part.scenario, part.ego.as_ref())
        .map_err(|error| format!("{}: {error}", entry.display()))?;
    let read = read_in_words(entry, &part.scenario);
    let mut done = Converted {
        said: part.said.iter().cloned().chain(read).collect(),
        fits: true,
        ..Converted::default()
    };
    for (end, bytes) in written.files {
        done.add(file.map(|file| with_end(file, end)), bytes);
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
