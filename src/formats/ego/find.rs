//! Finds egos: the one that is selected, the one beside a scenario, one in a folder of a planner's drives.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use nearmiss_scene::scenario::{ContentHash, Ego, EgoSource, Scenario, Scene, VehicleType};

use super::recording::usual_size;
use super::{EgoError, read_ego_file};
use crate::library::EntryLocation;
use crate::recordings::id_of_track;
use crate::{Entry, commonroad};

pub(crate) const RECORDING: &str = "ego_trajectory.csv";
const LOG: &str = "logs.csv";

/// The file with the ego that belongs to the scenario at `path`, if there is one.
///
/// Looked for as `NAME.ego_trajectory.csv` beside the scenario, in a folder `NAME` beside it, and among results as the
/// repository of "From Words to Collisions" keeps them, see `in_results`. A bare
/// `ego_trajectory.csv` counts where the scenario is the only one in its folder. After that come Frenetix's
/// `logs.csv`, in a folder `NAME` or where the scenario is alone, and a solution beside the scenario that
/// is named after it, `solution_KS2_SM1_NAME_2020a.xml`, if there is exactly one. Where `NAME.xml` lies beside a recording
/// called `NAME`, the ego beside both is that of the XML: `convert` writes them together.
#[must_use]
pub fn find_recording(path: &Path) -> Option<PathBuf> {
    let name = &commonroad::scenario_name(path);
    let folder = path.parent()?;
    let beside = [
        folder.join(format!("{name}.{RECORDING}")),
        folder.join(name).join(RECORDING),
    ];
    let is_commonroad = commonroad::is_xml_name(path) || commonroad::is_protobuf_name(path);
    let is_of_xml = !is_commonroad && path.with_extension("xml").is_file();
    let is_file = |c: &PathBuf| c.is_file();
    let in_lonely_folder = |file| {
        Some(folder.join(file))
            .filter(is_file)
            .filter(|_| alone(folder))
    };
    { beside.into_iter().skip(usize::from(is_of_xml)) }
        .find(is_file)
        .or_else(|| in_results(folder, name))
        .or_else(|| in_lonely_folder(RECORDING))
        .or_else(|| Some(folder.join(name).join(LOG)).filter(is_file))
        .or_else(|| in_lonely_folder(LOG))
        .or_else(|| solution(folder, name))
}

/// What [`find_recording`] looks for, in words.
pub const EGO_FILES: &str = "NAME.ego_trajectory.csv or NAME/ego_trajectory.csv beside it, or below Results or output_validation here or up to two folders up";

/// Folders above that of a scenario in which results may lie, with its own.
const FOLDERS_UP: usize = 3;

/// The folders of results of the paper, for scenarios with contact and for others.
const VALIDATIONS: [&str; 2] = ["output_validation", "output_validation_normal"];

/// The recording among results that were copied together with the scenarios of a folder: in
/// `Results/output_validation*/NAME`, `Results/NAME`, `output_validation*/NAME` and `Metrices/NAME`, beside the
/// scenario and in the folders above. Where a name is in both folders of results, the scenario's folder has to tell which.
fn in_results(folder: &Path, name: &str) -> Option<PathBuf> {
    let is_normal = folder
        .file_name()
        .is_some_and(|kind| kind == "normal_scenarios");
    let is_known = is_normal
        || folder
            .file_name()
            .is_some_and(|kind| kind == "collision_scenarios");
    let recording = |of: &Path| {
        let file = of.join(name).join(RECORDING);
        file.is_file().then_some(file)
    };
    let validated = |of: &Path| {
        let [contact, normal] = VALIDATIONS.map(|results| recording(&of.join(results)));
        match (contact, normal) {
            (_, normal) if is_normal => normal,
            (contact, _) if is_known => contact,
            // Both are of this name, and nothing tells which is meant.
            (Some(_), Some(_)) => None,
            (contact, normal) => contact.or(normal),
        }
    };
    let above = |of: &PathBuf| match of.file_name() {
        Some(_) => of.parent().map(Path::to_path_buf),
        None if of.has_root() => None,
        None => Some(of.join("..")),
    };
    let mut around = std::iter::successors(Some(folder.to_path_buf()), above).take(FOLDERS_UP);
    around.find_map(|of| {
        let results = of.join("Results");
        validated(&results)
            .or_else(|| recording(&results))
            .or_else(|| validated(&of))
            .or_else(|| recording(&of.join("Metrices")))
    })
}

/// Whether a folder holds exactly one scenario, be it in several files or formats.
fn alone(folder: &Path) -> bool {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = files.map(|e| e.path());
    let (protobuf, others): (Vec<_>, Vec<_>) =
        paths.partition(|path| commonroad::is_protobuf_name(path));
    let xml = others
        .into_iter()
        .filter(|p| commonroad::is_xml_name(p) && commonroad::is_scenario(p).is_ok_and(|is| is));
    // A folder of thousands is not looked at further than to its second scenario.
    let mut names = xml
        .chain(commonroad::protobuf_scenarios(protobuf).0)
        .map(|path| commonroad::scenario_name(&path));
    let mut first = None;
    names.all(|name| *first.get_or_insert_with(|| name.clone()) == name) && first.is_some()
}

/// The one solution in a folder that is named after a scenario.
fn solution(folder: &Path, scenario: &str) -> Option<PathBuf> {
    let files = solutions(folder);
    let mut found = files.iter().filter(|name| is_named_after(name, scenario));
    let first = found.next()?;
    found.next().is_none().then(|| folder.join(first))
}

/// A folder that was listed, with the time of its last change.
type Listed = (PathBuf, SystemTime, Arc<Vec<String>>);

/// The folder listed last: of many scenarios in one folder, each asks for the same list.
static LISTED: Mutex<Option<Listed>> = Mutex::new(None);

/// A folder that changed more recently than this is listed again, as file systems count time in steps.
const MIN_AGE: Duration = Duration::from_secs(2);

/// Names of the files in a folder that may be solutions.
fn solutions(folder: &Path) -> Arc<Vec<String>> {
    let changed = folder.metadata().and_then(|m| m.modified()).ok();
    let mut listed = LISTED.lock().unwrap_or_else(PoisonError::into_inner);
    if let (Some((path, time, names)), Some(changed)) = (&*listed, changed)
        && (path.as_path(), *time) == (folder, changed)
    {
        return Arc::clone(names);
    }
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = files
        .filter_map(|file| file.file_name().into_string().ok())
        .filter(|name| name.starts_with(SOLUTION) && name.ends_with(XML));
    let names = Arc::new(names.collect::<Vec<_>>());
    let settled = changed.filter(|time| time.elapsed().is_ok_and(|since| since > MIN_AGE));
    *listed = settled.map(|time| (folder.to_path_buf(), time, Arc::clone(&names)));
    names
}

/// Names of solutions begin and end so.
const SOLUTION: &str = "solution";
const XML: &str = ".xml";

/// Whether `file` is `solution_…_SCENARIO_VERSION.xml`, with or without the version; colons are as good as `_`.
fn is_named_after(file: &str, scenario: &str) -> bool {
    let separators = ['_', ':'];
    let Some(id) = file
        .strip_prefix(SOLUTION)
        .and_then(|rest| rest.strip_suffix(XML))
    else {
        return false;
    };
    let ends = |id: &str| {
        id.strip_suffix(scenario)
            .is_some_and(|before| before.ends_with(separators))
    };
    ends(id) || id.rsplit_once(separators).is_some_and(|(id, _)| ends(id))
}

/// Choice of a scenario's ego.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EgoSelection {
    /// The one whose file lies with the scenario; see [`super::find_recording`].
    #[default]
    Beside,
    /// The one whose file lies with the scenario, which solves several planning problems or holds several vehicles.
    BesideFor {
        /// The planning problem whose vehicle it is.
        planning_problem: i64,
    },
    /// The obstacle with this id.
    Obstacle(i64),
    /// The one in a file.
    File {
        /// A recording, a log or a solution.
        path: PathBuf,
        /// The planning problem whose vehicle it is, where the file solves several.
        planning_problem: Option<i64>,
    },
    /// The one that a planner drove.
    Planner(PlannerDrives),
}

impl EgoSelection {
    /// The drives of a planner, where they are chosen.
    #[must_use]
    pub fn planner(&self) -> Option<&PlannerDrives> {
        match self {
            Self::Planner(drives) => Some(drives),
            _ => None,
        }
    }

    /// The one in a file; of one with several, `FILE#ID`.
    #[must_use]
    pub fn of_file(said: &Path) -> Self {
        let named = || {
            let (file, id) = said.to_str().filter(|_| !said.exists())?.rsplit_once('#')?;
            Some((file, id.parse().ok()?))
        };
        match named() {
            Some((file, id)) => Self::File {
                path: file.into(),
                planning_problem: Some(id),
            },
            None => Self::File {
                path: said.to_path_buf(),
                planning_problem: None,
            },
        }
    }

    /// This ego of the scenario of an entry; nothing where it was to lie beside it and does not.
    ///
    /// # Errors
    /// The file cannot be read or has no such ego, or the obstacle cannot be one.
    pub fn resolve(
        &self,
        entry: &Entry,
        scenario: &Arc<Scenario>,
    ) -> Result<Option<Ego>, EgoError> {
        match self {
            Self::Beside => entry.recorded_ego(scenario),
            Self::BesideFor { planning_problem } => {
                entry.recorded_ego_for(scenario, Some(*planning_problem))
            }
            Self::Obstacle(id) if own(scenario) == Some(*id) => entry.recorded_ego(scenario),
            Self::Obstacle(id) => match Scene::with_obstacle_as_ego(Arc::clone(scenario), *id) {
                Ok(scene) => Ok(Some(scene.ego)),
                Err(source) => Err(EgoError::Obstacle {
                    file: entry.display(),
                    source,
                }),
            },
            Self::File {
                path,
                planning_problem,
            } => match track_named(entry, path) {
                Some(id) => Self::Obstacle(id).resolve(entry, scenario),
                None => read_ego_file(path, scenario, *planning_problem).map(Some),
            },
            Self::Planner(drives) => drives.resolve(&entry.display(), scenario).map(Some),
        }
    }
}

/// The road user that a table calls so, where there is no such file.
fn track_named(entry: &Entry, name: &Path) -> Option<i64> {
    match &entry.place {
        EntryLocation::File(path) if !name.exists() => id_of_track(path, name.to_str()?),
        _ => None,
    }
}

/// The track that is the ego of a recording.
fn own(scenario: &Scenario) -> Option<i64> {
    scenario.recorded_ego.as_ref().map(|own| own.obstacle.id)
}

/// Drives of one planner under the same settings, and whose they are.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct PlannerDrives {
    /// The planner as it was chosen: `nearmiss`, a name of the configuration, or a command.
    pub planner: String,
    /// Its command, if it is a process.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub command: Vec<String>,
    /// Name and version that its process said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub said: Option<String>,
    /// Settings of the drives, by the names of the configuration.
    pub settings: BTreeMap<String, String>,
    /// SHA-256 of all drives: of the same planner with the same settings it is the same, as long as it drives alike.
    pub sha256: String,
    /// Where they are.
    pub folder: PathBuf,
}

impl PlannerDrives {
    /// The name of the drive in a scenario.
    #[must_use]
    pub fn file_name(hash: ContentHash) -> String {
        format!("{hash}.ego_trajectory.csv")
    }

    /// The planner with its version, as people name it.
    #[must_use]
    pub fn name(&self) -> &str {
        self.said.as_deref().unwrap_or(&self.planner)
    }

    /// Whose drives they are, on one line.
    #[must_use]
    pub fn text(&self) -> String {
        let setting = |name: &str| self.settings.get(name).map_or("?", String::as_str);
        format!(
            "driven by {} (prediction {}, drives {})",
            self.name(),
            setting("prediction"),
            self.sha256.get(..12).unwrap_or(&self.sha256)
        )
    }

    /// The same without the folders and commands of this machine.
    #[must_use]
    pub fn portable(&self) -> Self {
        let planner = if self.command.is_empty() {
            self.planner.clone()
        } else {
            self.name().into()
        };
        let planner = if planner.contains(['/', '\\']) {
            "a command".into()
        } else {
            planner
        };
        Self {
            planner,
            command: Vec::new(),
            folder: self
                .folder
                .file_name()
                .map(PathBuf::from)
                .unwrap_or_default(),
            ..self.clone()
        }
    }

    /// The ego that drove in a scenario, the file of which has this name.
    pub(super) fn resolve(&self, shown: &str, scenario: &Scenario) -> Result<Ego, EgoError> {
        let path = self.folder.join(Self::file_name(scenario.hash));
        if !path.is_file() {
            return Err(EgoError::NoDrive {
                file: shown.into(),
                planner: self.name().into(),
                folder: shown_folder(&self.folder),
            });
        }
        let mut ego = read_ego_file(&path, scenario, None)?;
        let number = self
            .settings
            .get("vehicle")
            .and_then(|number| number.parse::<u32>().ok());
        let mut vehicles = VehicleType::ALL.iter().copied();
        let vehicle = vehicles.find(|vehicle| Some(u32::from(vehicle.number())) == number);
        if let Some(vehicle) = vehicle {
            ego.footprint = vehicle.footprint();
            ego.diagnostics.retain(|doubt| *doubt != usual_size());
        }
        ego.source = EgoSource::Planned {
            planner: (!self.command.is_empty()).then(|| self.name().into()),
            vehicle: vehicle.map_or_else(String::new, |vehicle| vehicle.name().into()),
            forecast: self.settings.get("prediction").cloned().unwrap_or_default(),
            planning_problem: ego.id,
        };
        Ok(ego)
    }
}

fn shown_folder(folder: &Path) -> String {
    folder.display().to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::{EgoSelection, bundled};

    #[test]
    fn names_of_solutions() {
        let scenario = "DEU_A-1_1_T-1";
        for file in [
            "solution_KS2_SM1_DEU_A-1_1_T-1_2020a.xml",
            "solution_KS2:SM1:DEU_A-1_1_T-1:2020a.xml",
            "solution_KS2_SM1_DEU_A-1_1_T-1.xml",
            "solution_DEU_A-1_1_T-1.xml",
        ] {
            assert!(is_named_after(file, scenario), "{file}");
        }
        for file in [
            "solution_KS2_SM1_DEU_A-1_1_T-10_2020a.xml",
            "solution_KS2_SM1_C-DEU_A-1_1_T-1_2020a.xml",
            "solution_KS2_SM1_DEU_A-1_1_T-1_2020a.txt",
            "DEU_A-1_1_T-1.xml",
            "solution_KS2_SM1_2020a.xml",
            "solution_.xml",
        ] {
            assert!(!is_named_after(file, scenario), "{file}");
        }
        assert!(!is_named_after(
            "solution_KS2_SM1_DEU_A-1_1_T-1_2020a.xml",
            "DEU_A-1_1"
        ));
    }

    #[test]
    fn the_ego_beside_a_table_and_xml_of_one_name_is_that_of_the_xml() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("part.ego_trajectory.csv"), "").unwrap();
        let beside = Some(at("part.ego_trajectory.csv"));
        assert_eq!(find_recording(&at("part.csv")), beside);
        std::fs::write(at("part.xml"), "").unwrap();
        assert_eq!(find_recording(&at("part.csv")), None);
        assert_eq!(find_recording(&at("part.xml")), beside);
    }

    fn drives(folder: &Path) -> PlannerDrives {
        PlannerDrives {
            planner: "python3 /home/ada/minimal.py".into(),
            command: vec!["python3".into(), "/home/ada/minimal.py".into()],
            said: Some("minimal 1".into()),
            settings: [("prediction", "lane"), ("vehicle", "4")]
                .map(|(name, value)| (name.to_string(), value.to_string()))
                .into(),
            sha256: "0123456789abcdef".into(),
            folder: folder.into(),
        }
    }

    #[test]
    fn a_batch_keeps_whose_drives_it_asks_about() {
        let ego = EgoSelection::Planner(drives(Path::new("/home/ada/drives/01")));
        let json = serde_json::to_string(&ego).unwrap();
        assert_eq!(serde_json::from_str::<EgoSelection>(&json).unwrap(), ego);
        let words = "driven by minimal 1 (prediction lane, drives 0123456789ab)";
        assert_eq!(ego.planner().unwrap().text(), words);
        // What older versions wrote stays what it was.
        assert_eq!(
            serde_json::from_str::<EgoSelection>("\"beside\"").unwrap(),
            EgoSelection::Beside
        );
    }

    #[test]
    fn what_leaves_the_machine_names_no_folder_of_it() {
        let portable = drives(Path::new("/home/ada/drives/01")).portable();
        assert!(!serde_json::to_string(&portable).unwrap().contains("ada"));
        assert_eq!(portable.portable(), portable);
        let unnamed = PlannerDrives {
            said: None,
            ..drives(Path::new("/home/ada/drives/01"))
        };
        assert!(
            !serde_json::to_string(&unnamed.portable())
                .unwrap()
                .contains("ada")
        );
    }

    #[test]
    fn a_drive_is_found_by_the_scenario_and_has_the_vehicle_of_the_drives() {
        let folder = tempfile::tempdir().unwrap();
        let entry = bundled().remove(0);
        let scenario = entry.read().unwrap();
        let ego = EgoSelection::Planner(drives(folder.path()));
        let missing = ego.resolve(&entry, &scenario).unwrap_err().to_string();
        assert!(missing.contains("not driven by minimal 1"), "{missing}");
        let file = folder.path().join(PlannerDrives::file_name(scenario.hash));
        std::fs::write(file, "timestep,x_position,y_position\n0,1,2\n1,2,2\n").unwrap();
        let ego = ego.resolve(&entry, &scenario).unwrap().unwrap();
        assert_eq!(ego.footprint, VehicleType::Truck.footprint());
        let source = ego.source.to_string();
        assert!(
            source.starts_with("planned by minimal 1 for problem"),
            "{source}"
        );
    }
}
