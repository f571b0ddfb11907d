//! Making scenarios dangerous: the search that is under way, and the variants that were made.

use std::sync::Arc;

use super::Model;
use crate::generation::Consequence;
use crate::scenario::{ContentHash, Transform};
use crate::tui::loaded::{Made, Opened, VariantShown, Working};
use crate::tui::message::making::MakeId;

/// Variants that are kept; beyond, the oldest go.
const MOST: usize = 8;

/// What is known of making beside what is open.
#[derive(Debug, Default)]
pub struct Maker {
    /// The search that is under way.
    pub under_way: Option<Search>,
    /// Variants that were made since the start, the oldest first; one of a scenario and change.
    kept: Vec<KeptVariant>,
    /// The last seed for each scenario and for the one obstacle that was allowed to attack.
    seeds: Vec<(ContentHash, Option<i64>, u64)>,
}

/// A search that is under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Search {
    /// Its number.
    pub id: MakeId,
    /// The place of the scenario in the list.
    pub place: usize,
    /// What it is at; nothing until it has begun.
    pub at: Option<Working>,
}

/// A variant that is kept, with its original.
#[derive(Debug)]
pub struct KeptVariant {
    /// The original with its planned ego.
    pub original: Box<Opened>,
    /// The variant.
    pub variant: Box<Opened>,
    /// The variant itself.
    pub made: Arc<Made>,
    /// The files that it was written to.
    pub saved: Option<String>,
}

impl Maker {
    /// Keeps a variant; one of the same scenario goes.
    pub fn keep(&mut self, original: Box<Opened>, variant: Box<Opened>, made: Arc<Made>) {
        let (hash, change) = (original.scenario.hash, original.change);
        self.kept.retain(|kept| !kept.is_of(hash, change));
        self.kept.push(KeptVariant {
            original,
            variant,
            made,
            saved: None,
        });
        if self.kept.len() > MOST {
            self.kept.remove(0);
        }
    }

    /// The variant of a scenario.
    #[must_use]
    pub fn find(&self, hash: ContentHash, change: Option<Transform>) -> Option<&KeptVariant> {
        self.kept.iter().find(|kept| kept.is_of(hash, change))
    }

    /// The variant was written to these files.
    pub fn saved(&mut self, made: &Arc<Made>, files: &str) {
        let mut kept = self.kept.iter_mut();
        if let Some(kept) = kept.find(|kept| Arc::ptr_eq(&kept.made, made)) {
            kept.saved = Some(files.into());
        }
    }

    /// Where the variant was written to.
    #[must_use]
    pub fn files(&self, made: &Arc<Made>) -> Option<&str> {
        let mut kept = self.kept.iter();
        let kept = kept.find(|kept| Arc::ptr_eq(&kept.made, made))?;
        kept.saved.as_deref()
    }

    /// A seed that was not used for this scenario and attacker: the same one would find the same again.
    pub fn next_seed(&mut self, hash: ContentHash, only: Option<i64>) -> u64 {
        let mut seeds = self.seeds.iter_mut();
        match seeds.find(|(of, who, _)| (*of, *who) == (hash, only)) {
            Some((_, _, seed)) => {
                *seed += 1;
                *seed
            }
            None => {
                self.seeds.push((hash, only, 1));
                1
            }
        }
    }

    /// Forgets all variants: what was measured on them holds no longer.
    pub fn forget(&mut self) {
        self.kept.clear();
    }
}

impl KeptVariant {
    fn is_of(&self, hash: ContentHash, change: Option<Transform>) -> bool {
        self.original.scenario.hash == hash && self.original.change == change
    }
}

/// What a search is at, in few words or with all its numbers.
#[must_use]
pub fn working_words(at: Option<Working>, whole: bool) -> String {
    match at {
        None => "generating".into(),
        Some(Working::Driving(_, 0) | Working::Showing(_, 0)) => "generating: the ego".into(),
        Some(Working::Driving(done, of)) => format!("generating: ego {done}/{of}"),
        Some(Working::Showing(done, of)) => format!("generating: variant {done}/{of}"),
        Some(Working::Proving) => "generating: ways out".into(),
        Some(Working::Searching(progress, of)) if !whole => {
            format!("generating {}/{of}", progress.tried)
        }
        Some(Working::Searching(progress, of)) => format!(
            "generating {}/{of}, {} refused, {} driven, best {}",
            progress.tried,
            progress.refused,
            progress.driven,
            progress.best.as_ref().map_or("none", consequence_words)
        ),
    }
}

/// What a change leads to, in words.
#[must_use]
pub fn consequence_words(consequence: &Consequence) -> &'static str {
    match consequence {
        Consequence::Collision(_) => "collision",
        Consequence::NearMiss => "near miss",
        Consequence::NoEffect => "no effect",
    }
}

impl Model {
    /// The variant that is shown, or beside whose original stands what is shown.
    #[must_use]
    pub fn variant(&self) -> Option<&VariantShown> {
        self.opened.as_ref()?.variant.as_ref()
    }
}
