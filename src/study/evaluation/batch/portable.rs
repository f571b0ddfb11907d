//! A batch without the folders of this machine: what reports and bundles say of its files.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::experiment::Experiment;
use super::spec::Spec;
use super::truth::TruthSource;
use nearmiss_formats::{EgoSelection, Entry, EntryLocation};

/// Stands for a folder without a name, such as `/`.
const NAMELESS: &str = "scenarios";

impl Spec {
    /// The same with names in the place of paths, each once, and without user, password and query in its address. The
    /// portable form of a portable spec is itself.
    #[must_use]
    pub fn portable(&self) -> Self {
        Self {
            experiment: Experiment {
                scenarios: names(&self.experiment.scenarios),
                truth: self.experiment.truth.as_ref().map(|truth| match truth {
                    TruthSource::Files(files) => TruthSource::Files(names(files)),
                    other => other.clone(),
                }),
                base_url: self.experiment.base_url.as_deref().map(plain_address),
                ..self.experiment.clone()
            },
            ego: match &self.ego {
                EgoSelection::File {
                    path,
                    planning_problem,
                } => EgoSelection::File {
                    path: names(std::slice::from_ref(path)).remove(0),
                    planning_problem: *planning_problem,
                },
                EgoSelection::Planner(drives) => EgoSelection::Planner(drives.portable()),
                other => other.clone(),
            },
            drawn_from: { self.drawn_from.iter() }
                .map(|path| self.portable_path(path))
                .collect(),
            ..self.clone()
        }
    }

    /// The path of a question's scenario under the names of [`Self::portable`]; the name of a bundled one as it is.
    #[must_use]
    pub fn portable_path(&self, path: &str) -> String {
        let path = Path::new(path);
        if matches!(Entry::of_argument(path).place, EntryLocation::Bundled(_)) {
            return path.display().to_string();
        }
        let named = names(&self.experiment.scenarios);
        let mut below: Vec<(usize, PathBuf)> = Vec::new();
        for (root, name) in self.experiment.scenarios.iter().zip(named) {
            if let Ok(rest) = path.strip_prefix(root) {
                let whole = if rest.as_os_str().is_empty() {
                    name
                } else {
                    name.join(rest)
                };
                below.push((root.components().count(), whole));
            }
        }
        let nearest = below.into_iter().max_by_key(|(depth, _)| *depth);
        let found = nearest.map_or_else(|| name_of(path), |(_, whole)| whole);
        found.display().to_string().replace('\\', "/")
    }
}

/// The last part of a path.
fn name_of(path: &Path) -> PathBuf {
    path.file_name().unwrap_or(NAMELESS.as_ref()).into()
}

/// The last parts of paths; where two are alike, the second one has a number.
fn names(paths: &[PathBuf]) -> Vec<PathBuf> {
    let mut taken = BTreeSet::new();
    let each = paths.iter().map(|path| {
        let name = name_of(path);
        let mut unique = name.clone();
        let mut number = 2;
        while !taken.insert(unique.clone()) {
            unique = numbered(&name, number);
            number += 1;
        }
        unique
    });
    each.collect()
}

/// `labels.csv` as `labels-2.csv`.
pub fn numbered(name: &Path, number: usize) -> PathBuf {
    let stem = name.file_stem().unwrap_or_default().to_string_lossy();
    match name.extension() {
        Some(end) => name.with_file_name(format!("{stem}-{number}.{}", end.to_string_lossy())),
        None => name.with_file_name(format!("{stem}-{number}")),
    }
}

/// An address without user, password, query and fragment, which may hold secrets.
fn plain_address(url: &str) -> String {
    let url = url.split(['?', '#']).next().unwrap_or_default();
    let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
    let (place, path) = rest
        .split_once('/')
        .map_or((rest, None), |(a, b)| (a, Some(b)));
    let host = place.rsplit('@').next().unwrap_or_default();
    let scheme = if scheme.is_empty() {
        String::new()
    } else {
        format!("{scheme}://")
    };
    match path {
        Some(path) => format!("{scheme}{host}/{path}"),
        None => format!("{scheme}{host}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_apart_and_stay_when_named_again() {
        let paths = ["/a/rec", "/b/rec", "/c/x.xml", "/d/x.xml", "/"].map(PathBuf::from);
        let told = names(&paths);
        let wanted = ["rec", "rec-2", "x.xml", "x-2.xml", "scenarios"].map(PathBuf::from);
        assert_eq!(told, wanted);
        assert_eq!(names(&told), wanted);
    }

    #[test]
    fn addresses_lose_what_may_be_secret() {
        for (url, plain) in [
            ("https://ada:secret@host:1/v1?key=k#f", "https://host:1/v1"),
            ("http://localhost:8080/v1", "http://localhost:8080/v1"),
            ("ada@host/v1", "host/v1"),
        ] {
            assert_eq!(plain_address(url), plain);
        }
    }
}
