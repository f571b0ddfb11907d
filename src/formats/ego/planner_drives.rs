//! Egos that a planner drove, kept in a folder: one recording a scenario, found by the scenario's hash.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::recording::usual_size;
use super::{EgoError, read_ego_file};
use nearmiss_scene::scenario::{ContentHash, Ego, EgoSource, Scenario, VehicleType};

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
    pub fn words(&self) -> String {
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
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{EgoSelection, bundled};

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
        assert_eq!(ego.planner().unwrap().words(), words);
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
