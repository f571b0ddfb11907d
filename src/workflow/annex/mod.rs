//! A requirement on planners, written down in a file: the scenarios, who drives them, and the driver that planners are held
//! to. [`held`] drives one scenario, [`Annex`] is what all come to, as a document and for programs.

mod document;
mod results;

use std::path::{Path, PathBuf};

use nearmiss_drive::driver::driver;
use nearmiss_drive::simulation::{Clock, Policy};
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_settings::{Config, Planning};
use serde_json::{Map, Value as Json};

use super::Selector;
use super::drive::{BUILT_IN, PlannerChoice, RECORDED};
use super::experiment::is_bundled;
pub use results::{
    Annex, AnnexDrive, AnnexRecord, AnnexScenario, ContactsByDriver, Finding, HeldScenario,
    PlannerFindings, Role, held,
};

nearmiss_record::fields! {
    /// A requirement that planners are checked against, and in which scenarios.
    pub struct SafetyRequirement {
        "requirement" {
            /// Number of the requirement, in its source or your own list.
            id [required]: String;
            /// Title.
            title [required]: String;
            /// Wording.
            text [required]: String;
            /// Source: a regulation, a standard, a contract.
            source: Option<String>;
            /// Operational design domain, in words; use `select` to choose scenarios within it.
            odd: Option<String>;
            /// Reference driver model: a planner must avoid what this driver avoids in its place [default: cc].
            driver: String = "cc".into(), Takes::Checked(known_driver);
        }
        "scenarios" {
            /// Scenario files and folders, relative to the folder of this file, and names of bundled scenarios.
            scenarios [required]: Vec<PathBuf>;
            /// Filter of the workbench's list that scenarios must match, such as `tag:highway risk<3`.
            select: Option<String>;
            /// Index folder (`nearmiss corpus index`) for the rates of such manoeuvres.
            index: Option<PathBuf>;
        }
        "planners" {
            /// Planners, as in `plan --planner` [default: the built-in one].
            planners: Vec<String>;
            /// Settings of planning and traffic, with the keys of [planner] in config.toml: `{ traffic = "reactive" }`.
            /// That section of config.toml itself is ignored.
            planning: Planning;
        }
    }
}

fn known_driver(id: &str) -> Result<(), String> {
    driver(id).map(drop)
}

impl SafetyRequirement {
    /// Reads one; its paths are made relative to the working folder.
    ///
    /// # Errors
    /// Every mistake in the text, each with `file` and line.
    pub fn read(text: &str, file: &Path) -> Result<Self, String> {
        let mut layers = Layers::<Self>::default();
        layers.file(&file.display().to_string(), text);
        layers.require();
        let mut read = layers.fields_so_far();
        if let Some(Err(why)) = read.select.as_deref().map(Selector::read) {
            layers.mistake("select", &why);
        }
        layers.checked()?;
        let folder = file.parent().unwrap_or(Path::new(""));
        for path in &mut read.scenarios {
            if !is_bundled(path) {
                *path = folder.join(&path);
            }
        }
        read.index = read.index.map(|index| folder.join(index));
        Ok(read)
    }

    /// Its JSON schema, for editors.
    #[must_use]
    pub fn schema() -> Json {
        let mut schema = Map::new();
        let about = [
            ("$schema", "https://json-schema.org/draft/2020-12/schema"),
            ("title", "nearmiss requirement"),
            (
                "description",
                "`nearmiss annex FILE.toml` checks planners against it.",
            ),
        ];
        schema.extend(about.map(|(key, words)| (key.to_string(), words.into())));
        if let Json::Object(fields) = Self::json_schema() {
            schema.extend(fields);
        }
        schema.into()
    }

    /// All that drive: the planners, then the drivers that have a rule and the baselines, those that are named as
    /// planners left out.
    ///
    /// # Errors
    /// A planner is neither known nor a program.
    pub fn who_drives(&self, config: &Config) -> Result<Vec<(PlannerChoice, Role)>, String> {
        let named = |said: &String| match said.as_str() {
            RECORDED => Ok(PlannerChoice {
                name: said.clone(),
                is_recorded: true,
                ..PlannerChoice::default()
            }),
            said => PlannerChoice::named(
                said,
                "planners: ",
                config,
                self.planning.timeout,
                Clock::Simulated,
            ),
        };
        let built_in = [BUILT_IN.to_string()];
        let planners = match self.planners.as_slice() {
            [] => &built_in[..],
            planners => planners,
        };
        let mut all = Vec::new();
        for said in planners {
            all.push((named(said)?, Role::Planner));
        }
        let is_named = |policy: &Policy| {
            let mut named = all.iter().filter_map(|(planner, _)| planner.policy);
            named.any(|one| one == *policy)
        };
        let beside: Vec<Policy> = Policy::all().filter(|policy| !is_named(policy)).collect();
        let (baselines, drivers): (Vec<Policy>, Vec<Policy>) =
            { beside.into_iter() }.partition(|policy| Policy::BASELINES.contains(policy));
        all.extend({ drivers.into_iter() }.map(|policy| (policy.into(), Role::Driver)));
        all.extend({ baselines.into_iter() }.map(|policy| (policy.into(), Role::Baseline)));
        Ok(all)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_file_with_its_mistakes() {
        let text = "id = '1'\ntitle = 'A'\ndriver = 'c'\nscenarios = ['a', 'ZAM_CutIn-1_1_T-1']\nselect = 'ttc<'\n";
        let why = SafetyRequirement::read(text, Path::new("lab/r.toml")).unwrap_err();
        for part in [
            "lab/r.toml:1: text is missing",
            "lab/r.toml:3: driver",
            "lab/r.toml:5: select",
        ] {
            assert!(why.contains(part), "{part}: {why}");
        }
        let text = "id = '1'\ntitle = 'A'\ntext = 'B'\nscenarios = ['a', 'ZAM_CutIn-1_1_T-1']\nplanners = ['idm']\n";
        let read = SafetyRequirement::read(text, Path::new("lab/r.toml")).unwrap();
        assert_eq!(
            read.scenarios,
            ["lab/a", "ZAM_CutIn-1_1_T-1"].map(PathBuf::from)
        );
        assert_eq!(read.driver, "cc");
        let who = read.who_drives(&Config::default()).unwrap();
        let names = |role: Role| -> Vec<String> {
            let of_role = who.iter().filter(|(_, one)| *one == role);
            of_role.map(|(planner, _)| planner.name.clone()).collect()
        };
        assert_eq!(names(Role::Planner), ["idm"]);
        assert_eq!(names(Role::Driver), ["cc", "r157", "rss", "fsm", "nieon"]);
        assert_eq!(
            names(Role::Baseline),
            ["constant-velocity", "lane-following"]
        );
    }
}
