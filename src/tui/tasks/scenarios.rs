//! Searches for scenarios in chunks, computes the facts of the list, and keeps the user's tags.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use super::super::loaded::{Facts, Verdicts, worst_of};
use super::super::message::Msg;
use super::super::session::SavedLocation;
use super::Tasks;
use nearmiss_base::system::activity::{self, ActivityGuard, Subject, trying};
use nearmiss_formats::{Entry, bundled};
use nearmiss_scene::judge;
use nearmiss_settings::Tags;
use nearmiss_store::Store;
use nearmiss_workflow::find_in_pieces;

/// The message for a scenario that is skipped.
const HELD: &str =
    "the program crashed while reading or showing this scenario; it is read when you open it";

/// A panic meanwhile is held against the scenario; that the program is killed is not, as many are read at once.
fn surveying(entry: &Entry, subject: Subject) -> ActivityGuard {
    let doing = trying(format!("reading {} for the list", entry.name), subject);
    doing.settle();
    doing
}

impl Tasks {
    /// Finds the scenarios at these paths, and says of them as they are found; the bundled ones for none.
    pub(super) fn find(&self, paths: Vec<PathBuf>) {
        let sender = self.sender.clone();
        self.background(move || {
            if paths.is_empty() {
                return Msg::Found(Ok(bundled().into()));
            }
            let found = find_in_pieces(&paths, &mut |piece| {
                // The receiver is gone once the loop has ended.
                let _ = sender.send(Msg::Listed(piece));
            });
            Msg::Searched(found.map_err(|error| error.to_string()))
        });
    }

    /// Computes the facts of these scenarios; the first worker queries the store once for all.
    pub(super) fn survey(&self, entries: Vec<(usize, Entry)>) {
        let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
        let (store, sender) = (self.store.clone(), self.sender.clone());
        let verdicts: OnceLock<Verdicts> = OnceLock::new();
        let here = std::env::current_dir().unwrap_or_default();
        let work = move |place: usize, entry: &Entry| {
            let verdicts = verdicts.get_or_init(|| {
                stored(store.as_deref(), None).unwrap_or_else(|error| {
                    let _ = sender.send(Msg::Complaint(error));
                    Verdicts::default()
                })
            });
            let subject = SavedLocation::from_entry(entry, &here).subject();
            if activity::is_held(&subject) {
                return Msg::Surveyed(place, Err(HELD.to_string()));
            }
            let _doing = surveying(entry, subject);
            Msg::Surveyed(place, Facts::read(entry, &ego, &thresholds, verdicts))
        };
        self.survey.replace(entries, Arc::new(work));
    }

    /// Works out the facts of these with what the store says now.
    pub(super) fn recount(&self, entries: Vec<(usize, Entry)>) {
        for (place, entry) in entries {
            let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
            let store = self.store.clone();
            self.background(move || {
                let hash = entry.read().map(|s| s.hash.to_string()).unwrap_or_default();
                match stored(store.as_deref(), Some((&hash, &entry.name))) {
                    Ok(verdicts) => {
                        Msg::Surveyed(place, Facts::read(&entry, &ego, &thresholds, &verdicts))
                    }
                    Err(error) => Msg::Complaint(error),
                }
            });
        }
    }

    /// Works out the most dangerous value of a measure in these scenarios.
    pub(super) fn rank(&self, measure: &'static str, entries: Vec<(usize, Entry)>) {
        let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
        let here = std::env::current_dir().unwrap_or_default();
        let work = move |place: usize, entry: &Entry| {
            let subject = SavedLocation::from_entry(entry, &here).subject();
            if activity::is_held(&subject) {
                return Msg::Ranked(measure, place, None);
            }
            let _doing = surveying(entry, subject);
            Msg::Ranked(measure, place, worst_of(entry, &ego, measure, &thresholds))
        };
        self.ranking.replace(entries, Arc::new(work));
    }

    pub(super) fn read_tags(&self) {
        let path = self.folders.tags();
        self.background(move || Msg::Tags(Tags::read(&path)));
    }

    pub(super) fn change_tags(&self, scenario: String, tags: Vec<String>) {
        let path = self.folders.tags();
        self.background(move || Msg::Tags(Tags::change(&path, &scenario, tags)));
    }
}

/// Stored verdicts, yes or no, without the built-in judge's own answers.
fn stored(store: Option<&Store>, of: Option<(&str, &str)>) -> Result<Verdicts, String> {
    let Some(store) = store else {
        return Ok(Verdicts::default());
    };
    let verdicts = store
        .verdicts(judge::MODEL, of)
        .map_err(|e| format!("stored answers are not counted: {e}"))?;
    Ok(verdicts.into())
}
