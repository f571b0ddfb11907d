//! The folders that clients may see, and scenarios in them; nothing else of the machine's files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use crate::formats::{EgoSelection, Entry, EntryLocation, bundled, find, find_recording};
use crate::scenario::Scene;
use crate::system::shown_path;
use crate::workflow::{OpenRequest, open};

/// The folders, and the scenes opened so far.
#[derive(Debug)]
pub struct Places {
    /// With symbolic links resolved.
    roots: Vec<PathBuf>,
    scenes: Mutex<Scenes>,
}

/// Time and length of scenario and ego.
type Version = [Option<(SystemTime, u64)>; 2];

/// Scenes by the name that a client gave, with the version of their files.
type Scenes = HashMap<PathBuf, (Version, Arc<Scene>)>;

/// Scenes that are kept open.
const KEPT: usize = 64;

impl Places {
    /// These folders.
    ///
    /// # Errors
    /// One does not exist, or is no folder.
    pub fn new(folders: &[PathBuf]) -> Result<Self, String> {
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
            scenes: Mutex::default(),
        })
    }

    /// What may be opened, in words.
    pub fn words(&self) -> String {
        let roots = self.roots.iter().map(|root| shown_path(root));
        let roots: Vec<String> = roots.collect();
        match roots.is_empty() {
            true => "clients may open the bundled scenarios".into(),
            false => format!("clients may open scenarios below {}", roots.join(", ")),
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
        entries.retain(|entry| self.allowed(entry).is_ok());
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
            return Err(
                "`scenario` is no path; resources/list has those that can be opened".into(),
            );
        }
        for root in &self.roots {
            let candidate = root.join(name);
            // What lies outside is not even looked at, so that nothing is told of whether it exists.
            let Ok(resolved) = candidate.canonicalize() else {
                continue;
            };
            if self.holds(&resolved) && resolved.is_file() {
                let entry = Entry::of_file(&resolved);
                self.allowed(&entry)?;
                return Ok(entry);
            }
        }
        let by_name = |entry: &Entry| entry.name == name || self.name(entry) == name;
        if let Some(entry) = self.entries().into_iter().find(by_name) {
            return Ok(entry);
        }
        Err(format!(
            "no scenario `{shown}` in the folders of this server; resources/list has those that can be opened"
        ))
    }

    fn holds(&self, resolved: &Path) -> bool {
        self.roots.iter().any(|root| resolved.starts_with(root))
    }

    /// Whether the file and those that are read with it lie in the folders: those that begin with its name, its ego, and
    /// of recordings, which have maps and tables beside them, all in its folder.
    fn allowed(&self, entry: &Entry) -> Result<(), String> {
        let EntryLocation::File(path) = &entry.place else {
            return Ok(());
        };
        let outside = || {
            "the scenario, or a file beside it, is a link out of the folders of this server"
                .to_string()
        };
        let file = entry.file().unwrap_or_else(|| path.clone());
        let resolved = file.canonicalize().map_err(|why| why.to_string())?;
        if !self.holds(&resolved) {
            return Err(outside());
        }
        let (Some(folder), Some(stem)) = (file.parent(), file.file_stem()) else {
            return Ok(());
        };
        // A link that leads nowhere is not read.
        let leads_out = |path: &Path| path.canonicalize().is_ok_and(|to| !self.holds(&to));
        if find_recording(path).is_some_and(|ego| leads_out(&ego)) {
            return Err(outside());
        }
        let stem = stem.to_string_lossy().into_owned();
        let whole = entry.is_recording();
        let beside = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut links = beside.filter(|other| {
            let named = || other.file_name().to_string_lossy().starts_with(&stem);
            other.file_type().is_ok_and(|kind| kind.is_symlink()) && (whole || named())
        });
        match links.any(|link| leads_out(&link.path())) {
            true => Err(outside()),
            false => Ok(()),
        }
    }

    /// The scene of a scenario, with the ego recorded beside it.
    ///
    /// # Errors
    /// In words: it cannot be opened, or has no ego.
    pub fn scene(&self, name: &str) -> Result<Arc<Scene>, String> {
        let key = PathBuf::from(name);
        let known = |scenes: &Scenes| scenes.get(&key).cloned();
        let lock = || self.scenes.lock().unwrap_or_else(PoisonError::into_inner);
        // The ego may change without its scenario.
        let changed = |entry: &Entry| {
            let file = entry.file();
            let ego = file.as_deref().and_then(find_recording);
            [file, ego].map(|file| {
                let meta = std::fs::metadata(file?).ok()?;
                Some((meta.modified().ok()?, meta.len()))
            })
        };
        let entry = self.entry(name)?;
        let modified = changed(&entry);
        if let Some((when, scene)) = known(&lock())
            && when == modified
        {
            return Ok(scene);
        }
        let opened = open(&OpenRequest {
            entry: &entry,
            ego: &EgoSelection::Beside,
            transform: None,
            strict: true,
        });
        let scene = opened.map_err(|why| self.told(&why.to_string()))?.scene;
        let scene = scene.map_err(|why| why.to_string())?;
        let mut scenes = lock();
        if scenes.len() >= KEPT {
            scenes.clear();
        }
        scenes.insert(key, (modified, Arc::clone(&scene)));
        Ok(scene)
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
