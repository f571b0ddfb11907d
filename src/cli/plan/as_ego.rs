//! `--ego planner`: drives scenarios and keeps the drives in the data folder, as egos for other commands.

use std::collections::BTreeMap;
use std::path::Path;

use crate::ending::interrupted;
use crate::many_files::{Job, NEXT};
use crate::open::configuration;
use crate::{Failure, output};
use nearmiss_base::system::{self, save_private};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Clock, Outcome, Settings, TrafficMode};
use nearmiss_formats::{EgoSelection, Entry, PlannerDrives, write_recording};
use nearmiss_scene::scenario::ContentHash;
use nearmiss_settings::{Config, Planning};
use nearmiss_workflow::PlannerFailure;
use nearmiss_workflow::drive::{
    BUILT_IN, DriveOptions, DriveRecord, DrivenScenario, PlannerChoice, drive_entry,
};

/// How a planner is named as the ego: `planner` for the built-in one, else a name or command after it.
const WORD: &str = "planner";

/// The drives of a planner, one JSON line each, as `plan --format json` prints them.
const LINES: &str = "drives.jsonl";

/// The planner that a value of `--ego` names; nothing where it names something else.
pub fn named(said: &str) -> Option<&str> {
    match said.split_once(':') {
        None if said == WORD => Some(BUILT_IN),
        Some((WORD, planner)) => Some(planner),
        _ => None,
    }
}

/// Lets a planner drive the ego of every scenario through recorded traffic, and keeps the drives.
///
/// # Errors
/// There is no such planner, no scenario could be driven, the drives cannot be kept, or the user asked for an end.
pub fn drive(said: &str, problem: Option<i64>, entries: &[Entry]) -> Result<EgoSelection, Failure> {
    let (folders, config) = configuration()?;
    let planner = PlannerChoice::named(said, "--ego planner:", &config, None, Clock::default())
        .map_err(Failure::input)?;
    let settings = settings(&config);
    let mut kept = CachedDrives::default();
    kept.drive(&planner, problem, entries, &settings)?;
    if kept.files.is_empty() {
        return Err(Failure::input(match entries {
            [only] => format!("{}: not driven by {said}", only.display()),
            _ => format!(
                "--ego: none of the {} scenarios was driven by {said}",
                entries.len()
            ),
        }));
    }
    let sha256 = kept.hash();
    let folder = folders.drives().join(&sha256[..24]);
    kept.save(&folder)?;
    Ok(EgoSelection::Planner(PlannerDrives {
        planner: said.into(),
        command: match &planner.external {
            Some(external) => external.options().command.clone(),
            None => Vec::new(),
        },
        said: kept.said,
        settings: setting_values(&settings, &planner),
        sha256,
        folder,
    }))
}

/// How egos are driven.
pub fn settings(config: &Config) -> Settings {
    Settings {
        // They are shown and asked about in the recorded traffic.
        traffic: TrafficMode::Recorded,
        ..Settings::from(&config.planning())
    }
}

/// The settings of drives by the names of the configuration; of a process those that it is run with, too.
fn setting_values(settings: &Settings, planner: &PlannerChoice) -> BTreeMap<String, String> {
    let word = |value| match value {
        toml::Value::String(word) => word,
        other => other.to_string(),
    };
    let values = Planning::values(settings).into_iter();
    let mut words: BTreeMap<String, String> =
        values.map(|(key, value)| (key, word(value))).collect();
    if let Some(external) = &planner.external {
        let options = external.options();
        for (name, value) in [
            ("start_timeout", options.start.as_secs_f64().to_string()),
            ("timeout", options.cycle.as_secs_f64().to_string()),
            ("predictions", options.predictions.to_string()),
            ("history", options.history.to_string()),
        ] {
            words.insert(name.into(), value);
        }
    }
    words
}

/// Drives to keep.
#[derive(Default)]
struct CachedDrives {
    /// By file name.
    files: BTreeMap<String, Vec<u8>>,
    lines: String,
    said: Option<String>,
}

impl CachedDrives {
    fn drive(
        &mut self,
        planner: &PlannerChoice,
        problem: Option<i64>,
        entries: &[Entry],
        settings: &Settings,
    ) -> Result<(), Failure> {
        let stop = interrupted(true);
        let cancel = Cancel::from_flag(&stop);
        let work = |entry: &Entry| {
            drive_entry(
                entry,
                problem,
                settings,
                DriveOptions {
                    planner: Some(planner),
                    monitor: None,
                    counts: false,
                },
                &cancel,
            )
        };
        let done = Job::new("drives", &stop).run(entries, work, |_, driven| {
            match driven {
                Ok(driven) => self.take(&driven)?,
                Err(error) => output::say(&format!("nearmiss: {error}")),
            }
            NEXT
        });
        done.end("none was kept")
    }

    /// A planner that failed has driven nothing that could be asked about.
    fn take(&mut self, driven: &DrivenScenario) -> Result<(), Failure> {
        let report = driven.drive.external.as_ref();
        if self.said.is_none() {
            self.said = report.filter(|r| !r.name.is_empty()).map(|r| r.named());
        }
        if let (Outcome::PlannerError(_), Some(report)) = (driven.outcome(), report) {
            let failure = PlannerFailure::from_report(driven.file.clone(), report);
            let why = failure.map(|failure| output::visible(&format!("nearmiss: {failure}")));
            why.iter().for_each(|why| output::say(why));
            return Ok(());
        }
        let recording = write_recording(driven.problem, &driven.drive.track())
            .map_err(|error| Failure::input(format!("{}: {error}", driven.file)))?;
        let name = PlannerDrives::file_name(driven.scenario.hash);
        self.files.insert(name, recording);
        self.lines += &output::json_line(&DriveRecord::new(driven))?;
        Ok(())
    }

    /// The hash of all drives.
    fn hash(&self) -> String {
        let mut all = Vec::new();
        for (name, bytes) in &self.files {
            all.extend(format!("{name} {}\n", ContentHash::digest(bytes)).into_bytes());
        }
        ContentHash::digest(&all).to_string()
    }

    /// Writes what is not there yet.
    fn save(&self, folder: &Path) -> Result<(), Failure> {
        let failed = |error: &dyn std::fmt::Display| {
            Failure::input(format!("{}: {error}", folder.display()))
        };
        system::make_folder(folder).map_err(|error| failed(&system::error_text(&error)))?;
        let lines = (LINES.to_string(), self.lines.as_bytes());
        let files = self
            .files
            .iter()
            .map(|(name, bytes)| (name.clone(), bytes.as_slice()));
        for (name, bytes) in files.chain([lines]) {
            let path = folder.join(name);
            if path.is_file() {
                continue;
            }
            save_private(&path, bytes).map_err(|error| failed(&error))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planners_are_told_from_files_and_ids() {
        assert_eq!(named("planner"), Some("nearmiss"));
        assert_eq!(named("planner:lab"), Some("lab"));
        assert_eq!(named("planner:python3 a:b.py"), Some("python3 a:b.py"));
        for other in ["./planner", "7", "ego.csv", "planners", "C:planner"] {
            assert_eq!(named(other), None, "{other}");
        }
    }
}
