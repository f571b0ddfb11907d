//! The folders that clients may see, and scenarios in them; nothing else of the machine's files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::scenes::{Read, Scenes, as_is};
use crate::formats::{EgoSelection, Entry, EntryLocation, bundled, find, find_recording};
use crate::scenario::Scene;
use crate::system::{files_opened_by, shown_path};
use crate::workflow::scene_of;

/// The folders, and the scenes opened so far.
#[derive(Debug)]
pub struct Places {
    /// With symbolic links resolved.
    roots: Vec<PathBuf>,
    /// Where recordings have their maps by config.toml.
    maps: Option<PathBuf>,
    scenes: Scenes,
    /// One scenario is read at a time, so that several large ones are not in memory at once.
    reading: Mutex<()>,
}

/// Why there is no scene.
enum NotOpened {
    /// It reads what clients may not see.
    Outside,
    /// No ego was chosen and none recorded beside it can be used: why, and which obstacles may be it.
    NoEgo(String, Vec<i64>),
    /// In words.
    Unreadable(String),
}

impl NotOpened {
    fn words(self) -> String {
        match self {
            Self::Outside => "the scenario reads a file outside the folders of this server: its ego, map or table lies \
                              there, a link leads there, or it names the file; start the server with the folder above"
                .into(),
            Self::NoEgo(why, possible) => {
                let some: Vec<String> = possible.iter().take(SHOWN).map(i64::to_string).collect();
                let more = if possible.len() > SHOWN { ", …" } else { "" };
                let ids = match some.is_empty() {
                    true => String::new(),
                    false => format!(": {}{more}", some.join(", ")),
                };
                format!("{why}; give `ego`, the id of an obstacle{ids}")
            }
            Self::Unreadable(why) => why,
        }
    }
}

/// Possible egos that an error names.
const SHOWN: usize = 8;

impl Places {
    /// These folders; `maps` is where recordings may have maps besides.
    ///
    /// # Errors
    /// One does not exist, or is no folder.
    pub fn new(folders: &[PathBuf], maps: Option<&Path>) -> Result<Self, String> {
        let root = |folder: &PathBuf| {
            let resolved = folder.canonicalize();
            let resolved = resolved.map_err(|why| format!("{}: {why}", shown_path(folder)))?;
            match resolved.is_dir() {
                true => Ok(resolved),
                false => Err(format!(
                    "{} is no folder; name the folder that scenarios may be opened from",
                    shown_path(folder)
                )),
            }
        };
        Ok(Self {
            roots: folders.iter().map(root).collect::<Result<_, _>>()?,
            maps: maps.and_then(|maps| maps.canonicalize().ok()),
            scenes: Scenes::default(),
            reading: Mutex::default(),
        })
    }

    /// What may be opened, in words.
    pub fn words(&self) -> String {
        let roots = self.roots.iter().map(|root| shown_path(root));
        let roots: Vec<String> = roots.collect();
        match roots.is_empty() {
            true => "clients may open the bundled scenarios".into(),
            false => format!(
                "clients may open scenarios below {} and the bundled ones",
                roots.join(", ")
            ),
        }
    }

    /// Every scenario: those below the folders, or else the bundled ones.
    pub fn entries(&self) -> Vec<Entry> {
        if self.roots.is_empty() {
            return bundled();
        }
        let found = find(&self.roots).map(|found| found.entries);
        let mut entries = found.unwrap_or_default();
        // A search may follow links.
        entries.retain(|entry| self.is_inside(entry));
        entries
    }

    /// The name of a scenario for clients: its path below its folder, or the name of a bundled one.
    pub fn name(&self, entry: &Entry) -> String {
        let EntryLocation::File(path) = &entry.place else {
            return entry.name.clone();
        };
        let mut roots = self.roots.iter().enumerate();
        let below = roots.find_map(|(place, root)| Some((place, path.strip_prefix(root).ok()?)));
        let Some((place, below)) = below else {
            return path.display().to_string();
        };
        let earlier = &self.roots[..place];
        // Of the same path below two folders, the later one has the number of its folder before it.
        match earlier.iter().any(|root| root.join(below).exists()) {
            true => format!("{}:{}", place + 1, below.display()),
            false => below.display().to_string(),
        }
    }

    /// How commands of this program name a scenario.
    pub fn argument(entry: &Entry) -> String {
        match &entry.place {
            EntryLocation::File(path) => path.display().to_string(),
            EntryLocation::Bundled(_) => entry.name.clone(),
        }
    }

    /// The scenario with a name: a path below a folder, or the name of a bundled one.
    ///
    /// # Errors
    /// In words: there is none, or it is outside the folders.
    pub fn entry(&self, name: &str) -> Result<Entry, String> {
        let shown: String = name.chars().take(200).collect();
        if let Some(entry) = bundled().into_iter().find(|entry| entry.name == name) {
            return Ok(entry);
        }
        if name.is_empty() || name.contains('\0') || name.len() > 4096 {
            return Err("`scenario` is no path; resources/list has the names of scenarios".into());
        }
        for root in &self.roots {
            let candidate = root.join(name);
            // What lies outside is not even looked at, so that nothing is told of whether it exists.
            let Ok(resolved) = candidate.canonicalize() else {
                continue;
            };
            if self.holds(&resolved) && resolved.is_file() {
                return Ok(Entry::of_file(&resolved));
            }
        }
        let by_name = |entry: &Entry| entry.name == name || self.name(entry) == name;
        if let Some(entry) = self.entries().into_iter().find(by_name) {
            return Ok(entry);
        }
        Err(format!(
            "no scenario `{shown}` in the folders of this server; resources/list has the names of scenarios"
        ))
    }

    fn holds(&self, resolved: &Path) -> bool {
        self.roots.iter().any(|root| resolved.starts_with(root))
    }

    /// Whether the file of a scenario lies in the folders, wherever a link leads.
    fn is_inside(&self, entry: &Entry) -> bool {
        let resolved = entry.file().map(|file| file.canonicalize());
        resolved.is_none_or(|file| file.is_ok_and(|file| self.holds(&file)))
    }

    /// Whether nothing outside the folders is read to open a scenario: maps, tables and egos that lie beside it, and what
    /// it names. With `recorded_ego` also whether an ego was recorded beside it.
    ///
    /// # Errors
    /// In words: it reads a file outside, or the ego is missing.
    pub fn check(&self, entry: &Entry, recorded_ego: bool) -> Result<(), String> {
        match self.opened(entry, None) {
            Err(NotOpened::Outside) => Err(NotOpened::Outside.words()),
            Err(why @ NotOpened::NoEgo(..)) if recorded_ego => Err(why.words()),
            // Why it cannot be opened is better said by the command that needs it.
            Ok(_) | Err(NotOpened::NoEgo(..) | NotOpened::Unreadable(_)) => Ok(()),
        }
    }

    /// The scene of a scenario, with an obstacle as its ego, else the ego recorded beside it.
    ///
    /// # Errors
    /// In words: it cannot be opened, or has no ego.
    pub fn scene(&self, name: &str, ego: Option<i64>) -> Result<Arc<Scene>, String> {
        let entry = self.entry(name)?;
        self.opened(&entry, ego).map_err(NotOpened::words)
    }

    fn opened(&self, entry: &Entry, obstacle: Option<i64>) -> Result<Arc<Scene>, NotOpened> {
        let name = entry.display();
        let selection = obstacle.map_or(EgoSelection::Beside, EgoSelection::Obstacle);
        let recorded = entry.file().as_deref().and_then(find_recording);
        let kept = || self.scenes.get(&name, obstacle, recorded.as_deref());
        if let Some((_, Some(scene))) = kept() {
            return Ok(scene);
        }
        let _reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let unreadable = |why: String| NotOpened::Unreadable(self.told(&why));
        let scenario = match kept() {
            Some((_, Some(scene))) => return Ok(scene),
            Some((scenario, None)) => scenario,
            None => {
                let (read, files) = files_opened_by(|| entry.read());
                let files = self.allowed(files)?;
                let scenario = read.map_err(|why| unreadable(why.to_string()))?;
                self.scenes.keep(&name, files, &scenario);
                scenario
            }
        };
        let (scene, files) = files_opened_by(|| scene_of(entry, &scenario, &selection));
        let files = self.allowed(files)?;
        let scene = scene.map_err(|why| match obstacle {
            None => NotOpened::NoEgo(self.told(&why.to_string()), Vec::new()),
            Some(_) => unreadable(why.to_string()),
        })?;
        let scene = scene.map_err(|_| {
            let why = "the scenario has no recorded ego".to_string();
            NotOpened::NoEgo(why, scenario.possible_egos())
        })?;
        self.scenes.keep_scene(&name, obstacle, files, &scene);
        Ok(scene)
    }

    /// Files that were read, as they are, if clients may see all of them.
    fn allowed(&self, files: Vec<PathBuf>) -> Result<Vec<Read>, NotOpened> {
        let may_read = |file: &PathBuf| {
            let resolved = file.canonicalize();
            resolved.is_ok_and(|file| self.holds(&file) || self.is_map(&file))
        };
        match files.iter().all(may_read) {
            true => Ok(files.iter().map(|file| as_is(file)).collect()),
            false => Err(NotOpened::Outside),
        }
    }

    /// Whether the user says in config.toml that maps are there.
    fn is_map(&self, resolved: &Path) -> bool {
        { self.maps.as_ref() }.is_some_and(|maps| resolved.starts_with(maps))
    }

    /// An error without the folders of this machine.
    pub fn told(&self, words: &str) -> String {
        let mut words = words.to_string();
        for root in &self.roots {
            words = words.replace(&format!("{}/", root.display()), "");
        }
        words
    }
}
