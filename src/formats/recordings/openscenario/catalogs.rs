//! Catalogs of a scenario: folders of files with entries that it refers to.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use super::parameters;
use crate::commonroad::ReadError;
use crate::recordings::named_files::named_file;
use crate::recordings::opendrive::tree::{self, Node};
use crate::recordings::report::Report;
use nearmiss_base::system;

/// Files of a folder of catalogs that are looked into.
const MOST_CATALOGS: usize = 100;

/// The element that holds parameters.
const PARAMETERS: &str = "ParameterDeclarations";

/// The name of a catalog and of an entry of it.
type Key = (String, String);

/// The catalogs of a scenario, each file of which is read once, when the first entry is looked for.
pub struct Catalogs {
    folders: Vec<PathBuf>,
    read: Option<HashMap<Key, Node>>,
    /// What of the entries that are used was not, by entry.
    unused: BTreeMap<Key, Vec<(String, usize)>>,
}

impl Catalogs {
    /// Those that a document names; their folders are named from that of its file.
    pub fn of(root: &Node, file: &Path) -> Self {
        let locations = root
            .child("CatalogLocations")
            .into_iter()
            .flat_map(Node::children);
        let folders = locations.filter_map(|l| l.child("Directory")?.text("path"));
        Self {
            folders: folders.map(|folder| named_file(file, folder)).collect(),
            read: None,
            unused: BTreeMap::new(),
        }
    }

    /// An entry with the values of its parameters; nothing where its folder or entry is not there.
    pub fn entry(&mut self, reference: &Node, report: &Report) -> Result<Option<Node>, ReadError> {
        let key = key(reference)?;
        let read = self.read.get_or_insert_with(|| all(&self.folders, report));
        let found = read.get(&key).cloned();
        found
            .map(|entry| parameters::assigned(entry, reference))
            .transpose()
    }

    /// Notes what of an entry was not used, once it was.
    pub fn account(&mut self, reference: &Node, entry: &Node) {
        if let Ok(key) = key(reference) {
            self.unused
                .entry(key)
                .or_insert_with(|| entry.unused(&[PARAMETERS]));
        }
    }

    /// Reports what of the entries was not used.
    pub fn report(self, report: &Report) {
        for (kind, _) in self.unused.into_values().flatten() {
            // Its line is one of another file.
            report.unused(kind, 0);
        }
    }

    /// What a reference names, in words.
    pub fn words(reference: &Node) -> Result<String, ReadError> {
        let (catalog, entry) = key(reference)?;
        Ok(format!("`{entry}` of the catalog `{catalog}`"))
    }
}

fn key(reference: &Node) -> Result<Key, ReadError> {
    let word = |name: &str| Ok::<String, ReadError>(reference.needed(name)?.to_string());
    Ok((word("catalogName")?, word("entryName")?))
}

/// All entries of the files of some folders; the first of those with the same names.
fn all(folders: &[PathBuf], report: &Report) -> HashMap<Key, Node> {
    let mut all = HashMap::new();
    let mut seen = Vec::new();
    for folder in folders {
        let Ok(files) = folder.read_dir() else {
            continue;
        };
        let is_xosc = |f: &PathBuf| {
            f.extension()
                .is_some_and(|x| x.eq_ignore_ascii_case("xosc"))
        };
        let mut files: Vec<_> = files.flatten().map(|f| f.path()).filter(is_xosc).collect();
        files.sort();
        if files.len() > MOST_CATALOGS {
            let folder = folder.display();
            report.note(format!(
                "only the first {MOST_CATALOGS} catalogs of {folder} are read"
            ));
        }
        for path in files.into_iter().take(MOST_CATALOGS) {
            if seen.contains(&path) {
                continue;
            }
            let shown = path.display().to_string();
            seen.push(path.clone());
            // A scenario may lie among catalogs; what is broken is told of only where it is one that was asked for.
            let Ok(bytes) = system::read_file(&path, system::LARGEST) else {
                continue;
            };
            let read = match tree::read(&bytes, &shown, "OpenSCENARIO") {
                Ok(read) => read,
                Err(error) => {
                    report.note(format!("catalog not read: {error}"));
                    continue;
                }
            };
            let Some(catalog) = read.into_child("Catalog") else {
                continue;
            };
            let name = catalog.text("name").unwrap_or_default().to_string();
            for entry in catalog.into_children() {
                let key = (
                    name.clone(),
                    entry.text("name").unwrap_or_default().to_string(),
                );
                all.entry(key).or_insert(entry);
            }
        }
    }
    all
}
