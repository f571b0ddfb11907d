//! Files that lie beside a scenario and belong to it: a shell's `DIR/*` names them, too, but they are no scenarios.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::output;

/// What follows the name of the scenario in the names of such files. Drives of good drivers have a time, too.
const ENDINGS: [&str; 3] = [".ego_trajectory.csv", ".solution.xml", ".json"];

/// The paths without side files of scenarios that are named with them, which are said. A file that is named without its
/// scenario stays.
pub fn without_side_files(paths: &[PathBuf]) -> Vec<PathBuf> {
    let (aside, kept) = partition(paths);
    if let Some(first) = aside.first() {
        let more = match aside.len() {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        let first = output::visible(&first.display().to_string());
        output::say(&format!(
            "nearmiss: skipped what lies beside scenarios: {first}{more}"
        ));
    }
    kept.into_iter().cloned().collect()
}

/// Side files of scenarios that are named with them, and the other paths.
pub fn partition(paths: &[PathBuf]) -> (Vec<&PathBuf>, Vec<&PathBuf>) {
    let named: HashSet<&Path> = paths.iter().map(PathBuf::as_path).collect();
    paths.iter().partition(|path| is_aside(path, &named))
}

fn is_aside(path: &Path, named: &HashSet<&Path>) -> bool {
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return false;
    };
    if name == "ego_trajectory.csv" {
        return named
            .iter()
            .any(|other| other.extension().is_some_and(|x| x == "xml"));
    }
    let avoiding = name
        .rsplit_once(".avoid-")
        .filter(|(_, rest)| rest.ends_with(".csv"));
    let stem = match avoiding {
        Some((stem, _)) => Some(stem),
        None => { ENDINGS.iter() }.find_map(|ending| name.strip_suffix(ending)),
    };
    stem.is_some_and(|stem| named.contains(path.with_file_name(format!("{stem}.xml")).as_path()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_beside_a_named_scenario_are_left_out() {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let all = paths(&[
            "d/A-1_1_T-2.avoid-0.5.csv",
            "d/A-1_1_T-2.ego_trajectory.csv",
            "d/A-1_1_T-2.json",
            "d/A-1_1_T-2.solution.xml",
            "d/A-1_1_T-2.xml",
            "d/B-1_1_T-1.xml",
            "d/ego_trajectory.csv",
        ]);
        let wanted = paths(&["d/A-1_1_T-2.xml", "d/B-1_1_T-1.xml"]);
        assert_eq!(without_side_files(&all), wanted);
        // Alone, or of another folder's scenario, it is what is asked for.
        let alone = paths(&["d/A-1_1_T-2.solution.xml", "e/A-1_1_T-2.xml"]);
        assert_eq!(without_side_files(&alone), alone);
    }
}
