//! Searches for scenarios in chunks, computes the facts of the list, and keeps the user's tags and views.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::features::jobs::notes;
use crate::loaded::{Facts, Ranked, Verdicts};
use crate::message::Effect;
use crate::model::{Job, JobKind, Model};
use crate::request::{Replies, Request};
use crate::services::{Queue, Services};
use crate::session::SavedLocation;
use nearmiss_base::system::crash::{self, ActivityGuard, trying};
use nearmiss_formats::{Entry, PassedOver, SearchResults, bundled};
use nearmiss_scene::judge;
use nearmiss_store::Store;
use nearmiss_workflow::find_in_pieces;

/// Finds the scenarios at these paths; the bundled ones for none.
#[derive(Debug)]
pub struct Find(pub Vec<PathBuf>);

/// News of the search.
#[derive(Debug)]
pub enum Found {
    /// All scenarios, or why there are none.
    All(Result<SearchResults, String>),
    /// More scenarios; the search continues.
    More(Vec<Entry>),
    /// The search has ended: what was passed over, or why nothing was found.
    Ended(Result<Vec<PassedOver>, String>),
}

impl Request for Find {
    type Reply = Found;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self(paths) = self;
        let pieces = replies.clone();
        services.background(replies, move || {
            if paths.is_empty() {
                return Found::All(Ok(bundled().into()));
            }
            let found = find_in_pieces(&paths, &mut |piece| {
                pieces.send(Found::More(piece));
            });
            Found::Ended(found.map_err(|error| error.to_string()))
        });
    }

    fn reply(model: &mut Model, found: Found) -> Vec<Effect> {
        match found {
            Found::All(found) => super::found(model, found),
            Found::More(entries) => super::listed(model, entries),
            Found::Ended(ended) => super::searched(model, ended),
        }
    }
}

/// The message for a scenario that is skipped.
const SKIPPED: &str =
    "the program crashed while reading or showing this scenario; it is read when you open it";

/// What guards the reading of a scenario for the list; `None` for one that the program crashed with. A panic meanwhile
/// is held against the scenario; that the program is killed is not, as many are read at once.
fn guarded(entry: &Entry, here: &Path) -> Option<ActivityGuard> {
    let subject = SavedLocation::from_entry(entry, here).subject();
    if crash::is_held(&subject) {
        return None;
    }
    let guard = trying(format!("reading {} for the list", entry.name), subject);
    guard.settle();
    Some(guard)
}

/// Works out the facts of scenarios, by their places in the list.
#[derive(Debug)]
pub enum Survey {
    /// Of these, instead of those that were asked for before.
    All(Vec<(usize, Entry)>),
    /// Of these too.
    More(Vec<(usize, Entry)>),
    /// Of those that are waited for, these first: they are on the screen.
    First(Vec<usize>),
    /// Of these, with what the store says now.
    Again(Vec<(usize, Entry)>),
    /// Of no more.
    Stop,
}

impl Request for Survey {
    type Reply = (usize, Result<Facts, String>);

    fn sent(&self, model: &mut Model) {
        match self {
            Self::All(entries) => notes::begin_survey(model, entries),
            Self::More(entries) => notes::extend_survey(model, entries),
            Self::First(_) | Self::Again(_) | Self::Stop => {}
        }
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let queue = services.state::<Queue<Self>>().clone();
        match self {
            Self::All(entries) => survey(services, &queue, entries, replies),
            Self::More(entries) => queue.add(entries),
            Self::First(places) => queue.first(places),
            Self::Again(entries) => {
                for (place, entry) in entries {
                    recount(services, place, entry, replies.clone());
                }
            }
            Self::Stop => queue.stop(),
        }
    }

    fn reply(model: &mut Model, (place, facts): Self::Reply) -> Vec<Effect> {
        notes::note_part(model, JobKind::Survey, place);
        model.list.survey(place, facts);
        Vec::new()
    }
}

/// Computes the facts of these scenarios; the first worker queries the store once for all.
fn survey(
    services: &Services,
    queue: &Queue<Survey>,
    entries: Vec<(usize, Entry)>,
    replies: Replies<Survey>,
) {
    let (ego, thresholds) = (services.ego.clone(), services.thresholds.clone());
    let (store, complaints) = (services.store.clone(), replies.clone());
    let verdicts: OnceLock<Verdicts> = OnceLock::new();
    let here = std::env::current_dir().unwrap_or_default();
    queue.replace(entries, replies, move |place, entry| {
        let verdicts = verdicts.get_or_init(|| {
            stored(store.as_deref(), None).unwrap_or_else(|error| {
                complaints.complain(error);
                Verdicts::default()
            })
        });
        let Some(_guard) = guarded(entry, &here) else {
            return (place, Err(SKIPPED.to_string()));
        };
        (place, Facts::read(entry, &ego, &thresholds, verdicts))
    });
}

/// Works out the facts of a scenario with what the store says now.
fn recount(services: &Services, place: usize, entry: Entry, replies: Replies<Survey>) {
    let (ego, thresholds) = (services.ego.clone(), services.thresholds.clone());
    let store = services.store.clone();
    tokio::task::spawn_blocking(move || {
        let hash = entry.read().map(|s| s.hash.to_string()).unwrap_or_default();
        match stored(store.as_deref(), Some((&hash, &entry.name))) {
            Ok(verdicts) => {
                replies.send((place, Facts::read(&entry, &ego, &thresholds, &verdicts)));
            }
            Err(error) => replies.complain(error),
        }
    });
}

/// Works out what the list is sorted by in scenarios, by their places in the list: the most dangerous value of a measure,
/// and what matters with the planner's ego where none is recorded.
#[derive(Debug)]
pub enum Rank {
    /// In these, for the order of this id.
    All(&'static str, Vec<(usize, Entry)>),
    /// In no more.
    Stop,
}

impl Request for Rank {
    /// The order's id, the place in the list, and what was worked out.
    type Reply = (&'static str, usize, Ranked);

    fn sent(&self, model: &mut Model) {
        match self {
            Self::All(order, entries) => notes::begin_ranking(model, order, entries),
            Self::Stop => notes::end_ranking(model),
        }
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let queue = services.state::<Queue<Self>>().clone();
        let Self::All(order, entries) = self else {
            return queue.stop();
        };
        let (ego, thresholds) = (services.ego.clone(), services.thresholds.clone());
        let planning = services.planning;
        let here = std::env::current_dir().unwrap_or_default();
        queue.replace(entries, replies, move |place, entry| {
            let Some(_guard) = guarded(entry, &here) else {
                return (order, place, Ranked::default());
            };
            let ranked = Ranked::read(entry, &ego, order, &planning, &thresholds);
            (order, place, ranked)
        });
    }

    fn reply(model: &mut Model, (order, place, ranked): Self::Reply) -> Vec<Effect> {
        notes::note_part(model, JobKind::Ranking(order), place);
        model.list.rank(order, place, ranked);
        Vec::new()
    }
}

/// The values that the list is sorted by, where they are not known with the facts; else an end of what is worked out for
/// another order.
#[must_use]
pub fn ranking(model: &Model) -> Option<Effect> {
    let list = &model.list;
    if let Some(measure) = list.ranking() {
        return Some(Rank::All(measure.id, list.entries()).into());
    }
    let of_another = |job: &Job| matches!(job.kind, JobKind::Ranking(of) if of != list.order.id());
    let mut jobs = model.jobs.all.iter();
    jobs.any(|job| job.is_running() && of_another(job))
        .then(|| Rank::Stop.into())
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
