//! The ego of a scenario as a file beside the CommonRoad file that is written.

use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_formats::{EgoError, Entry, EntryLocation, USUAL_VEHICLE, find_recording};
use nearmiss_formats::{write_recording, write_sized_recording};
use nearmiss_scene::scenario::{Ego, EgoSource, Scenario};

/// The file beside a scenario, where its ego is looked for first.
pub fn beside(scenario: &Path) -> PathBuf {
    scenario.with_extension("ego_trajectory.csv")
}

/// The ego that lies with a scenario, or is in its file, as CSV; nothing where there is none.
///
/// A CSV file that tells all is copied byte for byte.
///
/// # Errors
/// The file with the ego cannot be read.
pub fn recording(entry: &Entry, scenario: &Scenario) -> Result<Option<Vec<u8>>, EgoError> {
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
