//! Finds a scenario's ego when none is named.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use crate::commonroad;

const RECORDING: &str = "ego_trajectory.csv";
const LOG: &str = "logs.csv";

/// The file with the ego that belongs to the scenario at `path`, if there is one.
///
/// Looked for as `NAME.ego_trajectory.csv` beside the scenario, in a folder `NAME` beside it, and where
/// the repository of "From Words to Collisions" keeps them: `Results/output_validation*/NAME` for
/// `Scenarios/*_scenarios`, and `Generation/Metrices/NAME` for `Generation/NAME`. A bare
/// `ego_trajectory.csv` counts where the scenario is the only one in its folder. After that come Frenetix's
/// `logs.csv`, in a folder `NAME` or where the scenario is alone, and a solution beside the scenario that
/// is named after it, `solution_KS2_SM1_NAME_2020a.xml`, if there is exactly one.
#[must_use]
pub fn find_recording(path: &Path) -> Option<PathBuf> {
    let name = &commonroad::scenario_name(path);
    let folder = path.parent()?;
    let mut candidates = vec![
        folder.join(format!("{name}.{RECORDING}")),
        folder.join(name).join(RECORDING),
    ];
    let parent = folder.parent();
    if let (Some(parent), Some(kind)) = (parent, folder.file_name().and_then(|f| f.to_str())) {
        let results = match kind {
            "normal_scenarios" => "output_validation_normal",
            _ => "output_validation",
        };
        if let Some(root) = parent.parent() {
            candidates.push(
                root.join("Results")
                    .join(results)
                    .join(name)
                    .join(RECORDING),
            );
        }
        candidates.push(parent.join("Metrices").join(name).join(RECORDING));
    }
    let is_file = |c: &PathBuf| c.is_file();
    let in_lonely_folder = |file| {
        Some(folder.join(file))
            .filter(is_file)
            .filter(|_| alone(folder))
    };
    candidates
        .into_iter()
        .find(is_file)
        .or_else(|| in_lonely_folder(RECORDING))
        .or_else(|| Some(folder.join(name).join(LOG)).filter(is_file))
        .or_else(|| in_lonely_folder(LOG))
        .or_else(|| solution(folder, name))
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
const SETTLED: Duration = Duration::from_secs(2);

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
    let settled = changed.filter(|time| time.elapsed().is_ok_and(|since| since > SETTLED));
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
