//! What `generate` starts from: scenarios to attack, settings, and what of them decides what is made, so that it is reused.

use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use nearmiss_base::system::{self, unknown};
use nearmiss_drive::generation::MARK;
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_settings::{Config, Planning};
use nearmiss_study::evaluation::generating::{Method, RETRIES, Ranking, SAMPLES, VOTES};

use crate::{Failure, knobs, output, plan};

nearmiss_record::fields! {
    /// How a model is asked.
    pub struct AskSettings {
        "model" {
            /// Votes for the attacker [default: 3].
            votes: u32 = VOTES, Takes::Whole(1, 1000);
            /// Range in metres within which the model chooses the attacker [default: `attack_within` in config.toml].
            within: Option<f64>, Takes::Above(0.0, 1e6), "m";
            /// Motions to ask for [default: 5].
            samples: u32 = SAMPLES, Takes::Whole(1, 1000);
            /// Retries of a motion by the model [default: 2].
            retries: u32 = RETRIES, Takes::Whole(0, 100);
            /// Report the outcome of the drive back to the model.
            feedback: bool = true;
            /// Let the model grade its motions.
            grades: bool = true;
            /// Criterion that ranks the motions.
            rank: Ranking;
            /// Generate nothing if the model names no possible attacker.
            obey: bool;
        }
    }
}

/// Every key.
pub fn keys() -> impl Iterator<Item = String> {
    Planning::keys().chain(AskSettings::rows().iter().map(|row| row.key.into()))
}

/// What is set.
pub fn read(set: &[(String, String)], config: &Config) -> Result<(Planning, AskSettings), Failure> {
    let keys: Vec<String> = keys().collect();
    if let Some((key, _)) = set.iter().find(|(key, _)| !keys.contains(key)) {
        let keys = keys.iter().map(String::as_str);
        return Err(Failure::input(unknown("key", key, keys)));
    }
    let (asking, planning): (Vec<_>, Vec<_>) =
        { set.iter().cloned() }.partition(|(key, _)| AskSettings::row(key).is_ok());
    let asking = knobs::read(Layers::default(), &asking)?;
    Ok((plan::planning(&planning, config)?, asking))
}

impl AskSettings {
    /// How a model is asked.
    pub fn method(&self, config: &Config) -> Method {
        Method {
            votes: self.votes,
            within: self.within.unwrap_or(config.attack_within),
            samples: self.samples,
            retries: self.retries,
            feedback: self.feedback,
            grades: self.grades,
            rank: self.rank,
        }
    }
}

/// The attributes of the root element, and with them its `source`, lie within so many bytes.
const HEAD: u64 = 1 << 16;

/// More variants are not named each.
const MAX_VARIANTS_LISTED: usize = 5;

/// What of `entries`, found at `paths`, is to be attacked.
///
/// # Errors
/// Nothing but variants was found.
pub fn originals(mut entries: Vec<Entry>, paths: &[PathBuf]) -> Result<Vec<Entry>, Failure> {
    let mut seen = HashSet::new();
    // The same file by two ways: `a.xml` and `./a.xml`.
    entries.retain(|entry| match &entry.place {
        EntryLocation::File(path) => path.canonicalize().map_or(true, |real| seen.insert(real)),
        EntryLocation::Bundled(_) => true,
    });
    let mut variants = Vec::new();
    entries.retain(|entry| {
        let EntryLocation::File(path) = &entry.place else {
            return true;
        };
        let kept = paths.contains(path) || !is_variant(path);
        if !kept {
            variants.push(entry.name.clone());
        }
        kept
    });
    if variants.is_empty() {
        return Ok(entries);
    }
    let mut words = variants[..variants.len().min(MAX_VARIANTS_LISTED)].join(", ");
    if variants.len() > MAX_VARIANTS_LISTED {
        words = format!("{words} and {} more", variants.len() - MAX_VARIANTS_LISTED);
    }
    if entries.is_empty() {
        return Err(Failure::input(format!(
            "all scenarios are variants made by nearmiss ({words}); name a file to use it as an original"
        )));
    }
    let (count, are) = match variants.len() {
        1 => ("1 variant".into(), "is"),
        n => (format!("{n} variants"), "are"),
    };
    output::say(&format!(
        "nearmiss: {count} of earlier runs {are} skipped: {words}; name a file to use it as an original"
    ));
    Ok(entries)
}

/// Whether the head of a file says that nearmiss has made it. One that cannot be read is named when it is its turn.
fn is_variant(path: &Path) -> bool {
    let Ok(file) = system::open_file(path) else {
        return false;
    };
    let mut head = Vec::new();
    let read = file.take(HEAD).read_to_end(&mut head);
    read.is_ok() && head.windows(MARK.len()).any(|part| part == MARK.as_bytes())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_formats::find;

    #[test]
    fn variants_in_a_folder_are_left_out_unless_they_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let variant = format!("<commonRoad source=\"a field; {MARK}1.0: b\"/>");
        std::fs::write(path("original.xml"), "<commonRoad/>").unwrap();
        std::fs::write(path("variant.xml"), variant).unwrap();
        let names = |paths: &[PathBuf]| {
            let kept = originals(find(paths).unwrap().entries, paths);
            kept.map(|kept| kept.into_iter().map(|e| e.name).collect::<Vec<_>>())
        };
        let all = [folder.path().to_path_buf()];
        assert_eq!(names(&all).unwrap(), ["original"]);
        let both = [folder.path().to_path_buf(), path("variant.xml")];
        assert_eq!(names(&both).unwrap(), ["original", "variant"]);
        // The same file by another way is there once.
        let twice = [path("original.xml"), folder.path().join("./original.xml")];
        assert_eq!(names(&twice).unwrap(), ["original"]);
        std::fs::remove_file(path("original.xml")).unwrap();
        let failure = names(&all).unwrap_err();
        assert_eq!(failure.status, 2);
        assert!(failure.message.contains("all scenarios are variants"));
    }
}
