//! Finds a variant's original, which the manifest beside the variant names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use crate::cli::open::entry;
use crate::cli::{Failure, output};
use crate::formats::{Entry, EntryLocation, bundled, commonroad};
use crate::render::Variation;
use crate::scenario::Scenario;
use crate::system;

/// A variant's original, and how the two differ.
pub struct Original {
    scenario: Arc<Scenario>,
    attacker: i64,
    from: i64,
}

/// A manifest's statements.
struct Papers {
    id: String,
    sha256: String,
    attacker: i64,
    from: i64,
    /// Where the original was when the variant was made, seen from the folder that was the current one then.
    made_of: Option<PathBuf>,
}

impl Original {
    /// The original of an entry; `None` if there is no manifest of `nearmiss generate` beside it.
    ///
    /// # Errors
    /// The original is not available, and why.
    pub fn find(entry: &Entry) -> Result<Option<Self>, String> {
        let EntryLocation::File(file) = &entry.place else {
            return Ok(None);
        };
        let Some(papers) = Papers::beside(file) else {
            return Ok(None);
        };
        let scenario = papers.original(file).ok_or_else(|| {
            let made_of = papers.made_of.as_ref().map_or(String::new(), |path| {
                format!("nor {}, ", output::visible(&path.display().to_string()))
            });
            format!(
                "the original {} (SHA-256 {}) is neither beside it, nor a folder above, {made_of}nor one of the \
                 bundled scenarios; --original FILE says where it is",
                output::visible(&papers.id),
                output::visible(&papers.sha256)
            )
        })?;
        Ok(Some(papers.with(scenario)))
    }

    /// The scenario that `--original` names for an entry.
    ///
    /// # Errors
    /// It cannot be read, there is no manifest beside the entry, or it names another original.
    pub fn named(variant: &Entry, original: &Path) -> Result<Self, Failure> {
        let about = match &variant.place {
            EntryLocation::File(file) => Papers::beside(file),
            _ => None,
        };
        let papers = about.ok_or_else(|| {
            Failure::input(format!(
                "--original: {} has no manifest of `nearmiss generate` (NAME.json) beside it",
                variant.display()
            ))
        })?;
        let scenario = entry(original)?.read().map_err(Failure::input)?;
        match papers.are_of(&scenario) {
            true => Ok(papers.with(scenario)),
            false => Err(Failure::input(format!(
                "--original {}: its SHA-256 is {}, and {} was made of {} with {}",
                original.display(),
                scenario.hash,
                variant.display(),
                output::visible(&papers.id),
                output::visible(&papers.sha256)
            ))),
        }
    }

    /// Both motions of the attacker, in a variant of this.
    pub fn variation<'a>(&'a self, variant: &'a Scenario) -> Option<Variation<'a>> {
        Some(Variation {
            recorded: self.scenario.obstacle(self.attacker)?,
            changed: variant.obstacle(self.attacker)?,
            from: self.from,
            shows_changed: true,
        })
    }
}

impl Papers {
    /// What lies beside a scenario under its name; other JSON says nothing about it.
    fn beside(file: &Path) -> Option<Self> {
        let text = system::read_text(&file.with_extension("json"), system::LARGEST_TEXT).ok()?;
        let said: Value = serde_json::from_str(&text).ok()?;
        let about = said["variant"].as_str()?;
        if file.file_name()?.to_str()? != about {
            return None;
        }
        let original = &said["original"];
        Some(Self {
            id: original["benchmark_id"].as_str()?.into(),
            sha256: original["sha256"].as_str()?.into(),
            attacker: said["attacker"].as_i64()?,
            from: said["change"]["from_step"].as_i64()?,
            made_of: said["made"]["line"]["file"].as_str().map(PathBuf::from),
        })
    }

    fn with(self, scenario: Arc<Scenario>) -> Original {
        Original {
            scenario,
            attacker: self.attacker,
            from: self.from,
        }
    }

    fn are_of(&self, scenario: &Scenario) -> bool {
        scenario.hash.to_string() == self.sha256
    }

    /// The original, byte for byte.
    fn original(&self, file: &Path) -> Option<Arc<Scenario>> {
        let same = |scenario: &Scenario| self.are_of(scenario);
        let own = bundled().into_iter().filter(|entry| entry.name == self.id);
        let mut own = own.filter_map(|entry| entry.read().ok());
        if let Some(scenario) = own.find(|scenario| same(scenario)) {
            return Some(scenario);
        }
        let folder = file.parent()?;
        let above = folder.join("..");
        let mut places = [folder, &above]
            .map(|folder| folder.join(self.file()))
            .to_vec();
        if let Some(made_of) = &self.made_of {
            // As it was said then, and with OUT and the originals beside each other also from any other folder.
            places.extend([made_of.clone(), above.join(made_of)]);
        }
        // A manifest may name anything; reading what is not a file may never end.
        let files = places.iter().filter(|path| path.is_file());
        let mut there = files.filter_map(|path| commonroad::read_file(path).ok());
        there.find(same).map(Arc::new)
    }

    /// The name of its file; an id that leads into other folders has none.
    fn file(&self) -> PathBuf {
        let name = Path::new(&self.id).file_name().unwrap_or_default();
        let mut name = name.to_os_string();
        name.push(".xml");
        name.into()
    }
}
