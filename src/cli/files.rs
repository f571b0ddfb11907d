//! Files of scenarios: how tables call them, and those that only lie beside a scenario.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use nearmiss_formats::Entry;
use nearmiss_workflow::convert::WriteError;

use super::output;
use super::{Failure, Outcome};

/// The files of scenarios that are read, which are never written over.
#[derive(Debug)]
pub struct Inputs(HashSet<PathBuf>);

impl Inputs {
    /// Those of these scenarios.
    pub fn of(entries: &[Entry]) -> Self {
        // Of a long recording there are many scenarios.
        let files: HashSet<PathBuf> = entries.iter().filter_map(Entry::file).collect();
        Self(
            files
                .iter()
                .filter_map(|file| file.canonicalize().ok())
                .collect(),
        )
    }

    /// Whether a file is one of them.
    pub fn have(&self, path: &Path) -> bool {
        path.canonicalize().is_ok_and(|file| self.0.contains(&file))
    }

    /// Refuses a file to write that is one of them.
    pub fn spare(&self, output: Option<&Path>) -> Outcome {
        match output.filter(|path| self.have(path)) {
            None => Ok(()),
            Some(path) => Err(Failure::input(WriteError::Input(path.to_path_buf()))),
        }
    }
}

/// What printed tables call scenarios: by their names, or by their files where several have the name.
#[derive(Debug, Default)]
pub struct Labels {
    /// Names that several have.
    shared: HashSet<String>,
    longest: usize,
}

impl Labels {
    /// Of these scenarios.
    pub fn new(entries: &[Entry]) -> Self {
        let shared = shared(entries).into_keys();
        let mut labels = Self {
            shared: shared.map(output::visible).collect(),
            longest: 0,
        };
        let lengths = entries.iter().map(|entry| {
            let (name, file) = (output::visible(&entry.name), entry.display());
            labels.of(&name, &file).chars().count()
        });
        labels.longest = lengths.max().unwrap_or(0);
        labels
    }

    /// The label of a scenario.
    pub fn of(&self, name: &str, file: &str) -> String {
        if self.shared.contains(name) && !file.is_empty() {
            output::visible(file)
        } else {
            name.to_string()
        }
    }

    /// Characters of the longest one.
    pub fn longest(&self) -> usize {
        self.longest
    }
}

/// The scenarios whose name several have, by it.
fn shared(entries: &[Entry]) -> BTreeMap<&str, Vec<&Entry>> {
    let mut by_name: BTreeMap<&str, Vec<&Entry>> = BTreeMap::new();
    for entry in entries {
        by_name.entry(&entry.name).or_default().push(entry);
    }
    by_name.retain(|_, of_name| of_name.len() > 1);
    by_name
}

/// Says which files have the same name.
pub fn say_shared_names(entries: &[Entry]) {
    let shared = shared(entries);
    let Some((name, of_name)) = shared.first_key_value() else {
        return;
    };
    let files: Vec<String> = of_name.iter().map(|entry| entry.display()).collect();
    let more = match shared.len() - 1 {
        0 => String::new(),
        n => format!("; so have files of {}", output::counted(n, "other name")),
    };
    output::say(&format!(
        "nearmiss: {} have the same name, {name}: tell them apart by file and hash{more}",
        files.join(" and ")
    ));
}

/// What follows the name of the scenario in the names of such files. Drives of ideal drivers have a time, too.
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
    fn files_of_one_name_are_called_by_their_paths() {
        let entries = ["a/x.xml", "b/x.xml", "b/y.xml"].map(|path| Entry::of_file(Path::new(path)));
        let labels = Labels::new(&entries);
        let label = |entry: &Entry| labels.of(&entry.name, &entry.display());
        assert_eq!(entries.each_ref().map(label), ["a/x.xml", "b/x.xml", "y"]);
        assert_eq!(labels.longest(), 7);
        assert_eq!(Labels::new(&entries[1..]).of("x", "b/x.xml"), "x");
    }

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
