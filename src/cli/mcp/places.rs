//! The folders that clients may see, and scenarios in them; nothing else of the machine's files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::scenes::{Ranks, Read, Scenes, Worst, as_is};
use nearmiss_base::system::{files_opened_by, shown_path};
use nearmiss_formats::{EgoSelection, Entry, EntryLocation, bundled, find, find_recording};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scenario, Scene};
use nearmiss_workflow::scene_with_ego;

/// The folders, and the scenes opened so far.
#[derive(Debug)]
pub struct Places {
    /// With symbolic links resolved.
    roots: Vec<PathBuf>,
    /// Where recordings have their maps by config.toml.
    maps: Option<PathBuf>,
    scenes: Scenes,
    ranks: Ranks,
    /// One scenario is read at a time, so that several large ones are not in memory at once.
    reading: Mutex<()>,
}

/// A scenario with its scene, or why it has none.
type Seen = (Arc<Scenario>, Result<Arc<Scene>, String>);

/// Why there is no scene.
enum NotOpened {
    /// It reads what clients may not see; the scenario where only its ego does.
    Outside(Option<Arc<Scenario>>),
    /// No ego was chosen and none recorded beside it can be used: why.
    NoEgo(String, Arc<Scenario>),
    /// In words.
    Unreadable(String),
}

impl NotOpened {
    fn words(&self) -> String {
        match self {
            Self::Outside(_) => "the scenario reads a file outside the folders of this server: its ego, map or table lies \
                              there, a link leads there, or it names the file; start the server with the folder above"
                .into(),
            Self::NoEgo(why, scenario) => {
                let possible = scenario.possible_egos();
                let some: Vec<String> = possible.iter().take(SHOWN).map(i64::to_string).collect();
                let more = if possible.len() > SHOWN { ", …" } else { "" };
                let ids = if some.is_empty() { String::new() } else { format!(": {}{more}", some.join(", ")) };
                format!("{why}; give `ego`, the id of an obstacle{ids}")
            }
            Self::Unreadable(why) => why.clone(),
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
            let resolved = folder
                .canonicalize()
                .map_err(|why| format!("{}: {why}", shown_path(folder)))?;
            if resolved.is_dir() {
                Ok(resolved)
            } else {
                Err(format!(
                    "{} is no folder; name the folder that scenarios may be opened from",
                    shown_path(folder)
                ))
            }
        };
        Ok(Self {
            roots: folders.iter().map(root).collect::<Result<_, _>>()?,
            maps: maps.and_then(|maps| maps.canonicalize().ok()),
            scenes: Scenes::default(),
            ranks: Ranks::default(),
            reading: Mutex::default(),
        })
    }

    /// What may be opened, in words.
    pub fn words(&self) -> String {
        let roots = self.roots.iter().map(|root| shown_path(root));
        let roots: Vec<String> = roots.collect();
        if roots.is_empty() {
            "clients may open the bundled scenarios".into()
        } else {
            format!(
                "clients may open scenarios below {} and the bundled ones",
                roots.join(", ")
            )
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
        if earlier.iter().any(|root| root.join(below).exists()) {
            format!("{}:{}", place + 1, below.display())
        } else {
            below.display().to_string()
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
            return Err("`scenario` is no path; list_scenarios has the names".into());
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
            "no scenario `{shown}` in the folders of this server; list_scenarios has the names"
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
    /// it names; its ego is an obstacle, or else recorded. With `needs_ego` also whether one was recorded.
    ///
    /// # Errors
    /// In words: it reads a file outside, or the ego is missing.
    pub fn check(&self, entry: &Entry, ego: Option<i64>, needs_ego: bool) -> Result<(), String> {
        match self.opened(entry, ego) {
            Err(why @ NotOpened::Outside(_)) => Err(why.words()),
            Err(why @ NotOpened::NoEgo(..)) if needs_ego => Err(why.words()),
            // Why it cannot be opened is better said by the command that needs it.
            Ok(_) | Err(NotOpened::NoEgo(..) | NotOpened::Unreadable(_)) => Ok(()),
        }
    }

    /// A scenario, and its scene with an obstacle as its ego, else the ego recorded beside it; or why it has no ego.
    ///
    /// # Errors
    /// In words: it cannot be opened.
    pub fn scene(&self, entry: &Entry, ego: Option<i64>) -> Result<Seen, String> {
        match self.opened(entry, ego) {
            Ok(scene) => Ok((Arc::clone(&scene.scenario), Ok(scene))),
            Err(why) => match &why {
                NotOpened::Outside(Some(scenario)) | NotOpened::NoEgo(_, scenario) => {
                    Ok((Arc::clone(scenario), Err(why.words())))
                }
                _ => Err(why.words()),
            },
        }
    }

    /// The most severe moment of a scenario: of its recorded ego, else of any two road users.
    ///
    /// # Errors
    /// In words: it cannot be opened, or its recorded ego lies outside.
    pub fn worst(&self, entry: &Entry, thresholds: &Thresholds) -> Result<Option<Worst>, String> {
        let place = entry.display();
        let recorded = entry.file().as_deref().and_then(find_recording);
        if let Some(known) = self.ranks.get(&place, recorded.as_deref()) {
            return Ok(known);
        }
        let _reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let (scenario, mut files) = self.read(entry).map_err(|why| why.words())?;
        let scene = match self.with_ego(entry, &scenario, None) {
            Ok((scene, _)) => Some(scene),
            // Another would be taken for the ego.
            Err(why @ NotOpened::Outside(_)) => return Err(why.words()),
            Err(_) => None,
        };
        let worst = Worst::all(&scenario, scene.as_deref(), thresholds)
            .into_iter()
            .next();
        files.extend(recorded.as_deref().map(as_is));
        self.ranks.keep(place, files, worst.clone());
        Ok(worst)
    }

    fn opened(&self, entry: &Entry, obstacle: Option<i64>) -> Result<Arc<Scene>, NotOpened> {
        let name = entry.display();
        let recorded = entry.file().as_deref().and_then(find_recording);
        let kept = || self.scenes.get(&name, obstacle, recorded.as_deref());
        if let Some((_, Some(scene))) = kept() {
            return Ok(scene);
        }
        let _reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let scenario = match kept() {
            Some((_, Some(scene))) => return Ok(scene),
            Some((scenario, None)) => scenario,
            None => {
                let (scenario, files) = self.read(entry)?;
                self.scenes.keep(&name, files, &scenario);
                scenario
            }
        };
        let (scene, files) = self.with_ego(entry, &scenario, obstacle)?;
        self.scenes.keep_scene(&name, obstacle, files, &scene);
        Ok(scene)
    }

    /// Reads a scenario, from these files.
    fn read(&self, entry: &Entry) -> Result<(Arc<Scenario>, Vec<Read>), NotOpened> {
        let (read, files) = files_opened_by(|| entry.read());
        let files = self.allowed(files).ok_or(NotOpened::Outside(None))?;
        let scenario = read.map_err(|why| NotOpened::Unreadable(self.told(&why.to_string())))?;
        Ok((scenario, files))
    }

    /// A scenario with its ego, read from these files.
    fn with_ego(
        &self,
        entry: &Entry,
        scenario: &Arc<Scenario>,
        obstacle: Option<i64>,
    ) -> Result<(Arc<Scene>, Vec<Read>), NotOpened> {
        let selection = obstacle.map_or(EgoSelection::Beside, EgoSelection::Obstacle);
        let (scene, files) = files_opened_by(|| scene_with_ego(entry, scenario, &selection));
        let without = || Arc::clone(scenario);
        let files = self
            .allowed(files)
            .ok_or_else(|| NotOpened::Outside(Some(without())))?;
        let scene = scene.map_err(|why| match (self.told(&why.to_string()), obstacle) {
            (why, None) => NotOpened::NoEgo(why, without()),
            (why, Some(_)) => NotOpened::Unreadable(why),
        })?;
        let none = || NotOpened::NoEgo("the scenario has no recorded ego".into(), without());
        Ok((scene.map_err(|_| none())?, files))
    }

    /// What `work` gives, if it reads no file that clients may not see.
    ///
    /// # Errors
    /// In words: it does.
    pub fn within<T>(&self, work: impl FnOnce() -> T) -> Result<T, String> {
        let (done, files) = files_opened_by(work);
        match self.allowed(files) {
            Some(_) => Ok(done),
            None => Err(NotOpened::Outside(None).words()),
        }
    }

    /// Files that were read, as they are, if clients may see all of them.
    fn allowed(&self, files: Vec<PathBuf>) -> Option<Vec<Read>> {
        let may_read = |file: &PathBuf| {
            let resolved = file.canonicalize();
            resolved.is_ok_and(|file| self.holds(&file) || self.is_map(&file))
        };
        { files.iter().all(may_read) }.then(|| files.iter().map(|file| as_is(file)).collect())
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
