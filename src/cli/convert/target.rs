//! What scenarios are written as: chosen by name or by the ending of the file; and whose motion is the ego's there.

use std::path::{Path, PathBuf};

use nearmiss_formats::{EgoSelection, Entry, not_standard_input};
use nearmiss_workflow::SimulatedEgo;
use serde::Serialize;

use crate::Failure;
use crate::plan::as_ego;

/// The ending of roads beside OpenSCENARIO.
pub(super) const ROADS: &str = "xodr";

/// How the tracks of a recording in the shape of highD are called.
pub(super) const HIGHD_TRACKS: &str = "_tracks.csv";

/// What scenarios are written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Target {
    /// CommonRoad 2020a XML, and the ego beside it.
    #[value(name = "commonroad")]
    CommonRoad,
    /// CommonRoad 2018b XML, and the ego beside it.
    #[value(name = "commonroad-2018b")]
    #[serde(rename = "commonroad-2018b")]
    CommonRoad2018b,
    /// FILE.xosc and FILE.xodr.
    #[value(name = "openscenario")]
    OpenScenario,
    /// A table of tracks, .csv or .parquet (`nearmiss help tracks`).
    Tracks,
    /// A table in the shape of the INTERACTION Dataset.
    Interaction,
    /// The three tables of a recording in the shape of highD.
    #[value(name = "highd")]
    HighD,
}

impl Target {
    /// Endings of its files, the usual one first.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::CommonRoad | Self::CommonRoad2018b => &["xml"],
            Self::OpenScenario => &["xosc"],
            Self::Tracks => &["csv", "parquet"],
            Self::Interaction | Self::HighD => &["csv"],
        }
    }

    /// The file of a scenario in a folder.
    pub fn file_name(self, scenario: &str) -> String {
        match self {
            Self::HighD => format!("{scenario}{HIGHD_TRACKS}"),
            _ => format!("{scenario}.{}", self.endings()[0]),
        }
    }

    /// Whether the ego is in its files.
    pub fn has_ego(self) -> bool {
        !matches!(self, Self::CommonRoad | Self::CommonRoad2018b)
    }

    fn name(self) -> String {
        let value = clap::ValueEnum::to_possible_value(&self);
        value.map_or_else(String::new, |value| value.get_name().to_string())
    }
}

/// The format, and whose motion is the ego's.
#[derive(Debug, Clone, clap::Args, Serialize)]
pub(super) struct TargetOptions {
    /// Format to write [default: by the ending of -o, else commonroad].
    #[arg(long)]
    format: Option<Target>,
    /// OpenSCENARIO and tables: the ego: free (placed at its start, for a driver under test; OpenSCENARIO only), planner
    /// (the built-in planner drives), `planner:NAME` with a [planner.NAME] of config.toml or a command, id of an obstacle,
    /// or file with a trajectory [default: the recording beside the scenario].
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

/// The format that the ending of a file means; `None` where it means none.
fn of_ending(file: &Path) -> Result<Option<Target>, Failure> {
    let is = |ending: &&str| {
        let own = file.extension();
        own.is_some_and(|own| own.eq_ignore_ascii_case(ending))
    };
    if is(&ROADS) {
        return Err(Failure::input(
            "roads are written beside a scenario: -o FILE.xosc writes FILE.xosc and FILE.xodr",
        ));
    }
    let mut usual = [Target::CommonRoad, Target::OpenScenario, Target::Tracks].into_iter();
    Ok(usual.find(|target| target.endings().iter().any(is)))
}

fn unknown_ending(file: &Path) -> Failure {
    Failure::input(format!(
        "{}: no folder, and no ending of a scenario: .xml (CommonRoad), .xosc (OpenSCENARIO), .csv or .parquet (tracks); \
         create the folder, or choose with --format",
        file.display()
    ))
}
