//! `nearmiss convert -o FILE.xosc`: scenarios for simulators.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::Converted;
use crate::Failure;
use crate::open::configuration;
use crate::plan::as_ego;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::{EgoSelection, Entry, not_standard_input};
use nearmiss_scene::scenario::in_short;
use nearmiss_workflow::{ExportRequest, SimulatedEgo, export_to_simulator};

/// The ending of scenarios for simulators.
const SCENARIO: &str = "xosc";

/// The ending of CommonRoad files.
const COMMONROAD: &str = "xml";

/// That of their roads.
const ROADS: &str = "xodr";

/// Who the ego is, and what it does.
#[derive(Debug, Clone, clap::Args, Serialize)]
pub struct SimulatorOptions {
    /// Format to write: commonroad (XML) or openscenario (FILE.xosc and FILE.xodr) [default: by the ending of -o, else
    /// commonroad].
    #[arg(long, value_parser = ["commonroad", "openscenario"])]
    format: Option<String>,
    /// OpenSCENARIO: the ego: free (placed at its start, for a driver under test), planner (the built-in planner drives),
    /// `planner:NAME` with a [planner.NAME] of config.toml or a command, id of an obstacle, or file with a trajectory
    /// [default: the recording beside the scenario].
    #[arg(
        long,
        value_name = "free|planner|ID|FILE",
        allow_negative_numbers = true
    )]
    ego: Option<PathBuf>,
}

impl SimulatorOptions {
    /// Whether scenarios are written for simulators.
    ///
    /// # Errors
    /// The ending of the file is of no format, or of another than --format; or an ego is chosen for a format that has none.
    pub fn wanted(&self, output: Option<&Path>) -> Result<bool, Failure> {
        let file = output.filter(|path| !path.is_dir() && path.as_os_str() != "-");
        let by_ending = file.map(of_ending).transpose()?.flatten();
        let for_simulators = match (self.format.as_deref(), by_ending) {
            (None, by_ending) => {
                if let (Some(file), None) = (file, by_ending) {
                    return Err(unknown_ending(file));
                }
                by_ending.unwrap_or(false)
            }
            (Some(format), by_ending) => {
                let wanted = format == "openscenario";
                if let (Some(file), true) = (file, by_ending.is_some_and(|by| by != wanted)) {
                    let ending = if wanted { SCENARIO } else { COMMONROAD };
                    return Err(Failure::input(format!(
                        "{}: --format {format} writes .{ending} files; rename the file or leave out --format",
                        file.display()
                    )));
                }
                wanted
            }
        };
        if self.ego.is_some() && !for_simulators {
            return Err(Failure::input(
                "--ego applies to OpenSCENARIO: -o FILE.xosc or --format openscenario; CommonRoad files have no ego in them",
            ));
        }
        Ok(for_simulators)
    }

    /// The ego of these scenarios; a planner that is a process drives in them first.
    ///
    /// # Errors
    /// It is read from standard input, or the planner drives in none of the scenarios.
    pub fn ego(&self, entries: &[Entry]) -> Result<SimulatedEgo, Failure> {
        let Some(wanted) = &self.ego else {
            return Ok(SimulatedEgo::Follows(EgoSelection::Beside));
        };
        // Files of these names are meant by `./free`.
        match wanted.to_str() {
            Some("free") => return Ok(SimulatedEgo::Free),
            // The second is its earlier name.
            Some("planner" | "planned") => return Ok(SimulatedEgo::Planned),
            _ => {}
        }
        if let Some(planner) = wanted.to_str().and_then(as_ego::named) {
            return as_ego::drive(planner, None, entries).map(SimulatedEgo::Follows);
        }
        if let Some(id) = wanted.to_str().and_then(|text| text.parse().ok()) {
            return Ok(SimulatedEgo::Follows(EgoSelection::Obstacle(id)));
        }
        not_standard_input(wanted).map_err(Failure::input)?;
        Ok(SimulatedEgo::Follows(EgoSelection::File {
            path: wanted.clone(),
            planning_problem: None,
        }))
    }
}

/// Whether the ending of a file is that of scenarios for simulators; `None` where it is of no format.
fn of_ending(file: &Path) -> Result<Option<bool>, Failure> {
    let is = |ending: &str| {
        let own = file.extension();
        own.is_some_and(|own| own.eq_ignore_ascii_case(ending))
    };
    if is(ROADS) {
        return Err(Failure::input(
            "roads are written beside a scenario: -o FILE.xosc writes FILE.xosc and FILE.xodr",
        ));
    }
    let known = [(COMMONROAD, false), (SCENARIO, true)];
    let found = known.into_iter().find(|(ending, _)| is(ending));
    Ok(found.map(|(_, for_simulators)| for_simulators))
}

fn unknown_ending(file: &Path) -> Failure {
    Failure::input(format!(
        "{}: no folder, and no ending of a scenario: .{COMMONROAD} (CommonRoad) or .{SCENARIO} (OpenSCENARIO); create the \
         folder, or choose with --format",
        file.display()
    ))
}

/// The file of an entry in a folder.
pub fn target(folder: &Path, entry: &Entry) -> PathBuf {
    folder.join(format!("{}.{SCENARIO}", entry.name))
}

/// How egos are planned.
fn planning() -> Result<Settings, Failure> {
    let (_, config) = configuration()?;
    Ok((&config.planning()).into())
}

/// One scenario, and what the formats cannot say of it.
pub fn convert(
    entry: &Entry,
    target: Option<PathBuf>,
    ego: &SimulatedEgo,
    cancel: &Cancel,
) -> Result<Converted, Failure> {
    let Some(path) = target else {
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
    let read = in_short(&scenario.diagnostics)
        .into_iter()
        .map(|(_, said)| format!("{}: reading: {said}", entry.name));
    let notes = exported
        .notes
        .iter()
        .map(|note| format!("{}: {note}", entry.name));
    let said = read.chain(notes).collect();
    Ok(Converted {
        // The roads first, so that a scenario is never there without them.
        files: vec![(roads, exported.roads), (path, exported.scenario)],
        printed: None,
        said,
        fits: true,
    })
}
