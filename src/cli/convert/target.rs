//! What scenarios are written as: chosen by name or by the ending of the file; and whose motion is the ego's there.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use nearmiss_formats::{EgoSelection, Entry, not_standard_input};
use nearmiss_workflow::SimulatedEgo;
use nearmiss_workflow::convert::{ENDINGS, ROADS, Target, ends_with};
use serde::Serialize;
use strum::EnumMessage;

use crate::Failure;
use crate::plan::as_ego;

/// The format, and whose motion is the ego's.
#[derive(Debug, Clone, clap::Args, Serialize)]
pub(super) struct TargetOptions {
    /// Format to write [default: from the file name, else commonroad].
    #[arg(long, value_parser = formats())]
    format: Option<Target>,
    /// Ego of OpenSCENARIO files and tables [default: the recording beside the scenario]
    ///
    /// `free` places it at its start for a driver under test (OpenSCENARIO only). `planner` is the built-in planner,
    /// `planner:NAME` that of [planner.NAME] in config.toml or a command. ID is an obstacle, FILE a recorded
    /// trajectory.
    #[arg(
        long,
        value_name = "free|planner|ID|FILE",
        allow_negative_numbers = true
    )]
    ego: Option<PathBuf>,
}

impl TargetOptions {
    /// What scenarios are written as.
    ///
    /// # Errors
    /// The ending of the file is of no format, or of another than --format; or an ego is chosen for a format that has none.
    pub fn wanted(&self, output: Option<&Path>) -> Result<Target, Failure> {
        let file = output.filter(|path| !path.is_dir() && path.as_os_str() != "-");
        let by_ending = file.map(of_ending).transpose()?.flatten();
        let target = match (self.format, by_ending, file) {
            (None, None, Some(file)) => return Err(unknown_ending(file)),
            (None, by_ending, _) => by_ending.unwrap_or(Target::CommonRoad),
            (Some(target), Some(other), Some(file))
                if !other.endings().iter().any(|e| target.endings().contains(e)) =>
            {
                return Err(Failure::input(format!(
                    "{}: --format {} writes .{} files; rename the file or leave out --format",
                    file.display(),
                    target.name(),
                    target.endings()[0]
                )));
            }
            (Some(target), ..) => target,
        };
        if self.ego.is_some() && !target.has_ego() {
            return Err(Failure::input(
                "--ego applies to OpenSCENARIO (-o FILE.xosc or --format openscenario) and to tables; CommonRoad files have no ego in them",
            ));
        }
        Ok(target)
    }

    /// The ego of these scenarios; a planner that is a process drives in them first.
    ///
    /// # Errors
    /// It is read from standard input or is none for tables, or the planner drives in none of the scenarios.
    pub fn ego(&self, target: Target, entries: &[Entry]) -> Result<SimulatedEgo, Failure> {
        let Some(wanted) = &self.ego else {
            return Ok(SimulatedEgo::Follows(EgoSelection::Beside));
        };
        // Files of these names are meant by `./free`.
        match wanted.to_str() {
            Some("free") if target == Target::OpenScenario => return Ok(SimulatedEgo::Free),
            Some("free") => {
                return Err(Failure::input(
                    "--ego free applies to OpenSCENARIO; a table has motion only",
                ));
            }
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

/// The formats by name, each with what it is.
fn formats() -> impl TypedValueParser<Value = Target> {
    let named = Target::ALL.map(|target| {
        let what = target.get_documentation().unwrap_or_default();
        PossibleValue::new(target.name()).help(what.trim_end_matches('.'))
    });
    PossibleValuesParser::new(named).try_map(|name| Target::parse(&name).ok_or(name))
}

/// The format that the ending of a file means; `None` where it means none.
fn of_ending(file: &Path) -> Result<Option<Target>, Failure> {
    if ends_with(file, ROADS) {
        return Err(Failure::input(
            "roads are written beside a scenario: -o FILE.xosc writes FILE.xosc and FILE.xodr",
        ));
    }
    Ok(Target::of_ending(file))
}

fn unknown_ending(file: &Path) -> Failure {
    Failure::input(format!(
        "{}: no folder, and no ending of a scenario: {ENDINGS}; create the folder, or choose with --format",
        file.display()
    ))
}
