//! Scenario generation: the running search and the finished variants.

use std::sync::Arc;

use crate::action::Action;
use crate::loaded::{
    AuthoringProgress, Authorship, GeneratedVariant, GenerationStage, Opened, SavedVariant,
    VariantShown,
};
use crate::model::{JobId, Model};
use nearmiss_drive::generation::Consequence;
use nearmiss_scene::scenario::{ContentHash, Transform};

/// Variants that are kept; beyond, the oldest go.
const MAX_KEPT: usize = 8;

/// State of generation beside the open scenario.
#[derive(Debug, Default)]
pub struct GenerationState {
    /// The search that is under way.
    pub under_way: Option<Search>,
    /// Variants that were made since the start, the oldest first; one of a scenario and change.
    kept: Vec<CachedVariant>,
    /// Searches and models without a dangerous result, the newest last; for each scenario and change a failure and a text.
    fruitless: Vec<(ContentHash, Option<Transform>, Fruitless)>,
    /// Models that have had their say about a scenario, with the one obstacle that was allowed to attack.
    heard_out: Vec<(ContentHash, Option<i64>, String)>,
    /// The place of the scenario to search in once it is open.
    pub wanted: Option<usize>,
    /// The last seed for each scenario and for the one obstacle that was allowed to attack.
    seeds: Vec<(ContentHash, Option<i64>, u64)>,
}

/// What came of it where there is no dangerous result: what a model wrote, or why the work failed.
pub(super) type Fruitless = Result<Arc<Authorship>, String>;

/// A search that is under way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Search {
    /// Its number.
    pub id: JobId,
    /// The place of the scenario in the list.
    pub place: usize,
    /// The current stage; `None` until it has started.
    pub at: Option<GenerationStage>,
    /// Why a model has not answered yet, where something is waited for.
    pub waits: Option<String>,
}

/// A variant that is kept, with its original.
#[derive(Debug)]
pub struct CachedVariant {
    /// The original with its planned ego.
    pub original: Box<Opened>,
    /// The variant.
    pub variant: Box<Opened>,
    /// The variant itself.
    pub made: Arc<GeneratedVariant>,
    /// The files that it was written to.
    pub saved: Option<String>,
}

impl GenerationState {
    /// Keeps a variant; one of the same scenario goes.
    pub fn keep(
        &mut self,
        original: Box<Opened>,
        variant: Box<Opened>,
        made: Arc<GeneratedVariant>,
    ) {
        let (hash, change) = (original.scenario.hash, original.change);
        self.kept.retain(|kept| !kept.is_of(hash, change));
        self.kept.push(CachedVariant {
            original,
            variant,
            made,
            saved: None,
        });
        if self.kept.len() > MAX_KEPT {
            self.kept.remove(0);
        }
    }

    /// A job under `id` about the scenario at a place of the list begins.
    pub fn begin(&mut self, id: JobId, place: usize) {
        self.under_way = Some(Search {
            id,
            place,
            at: None,
            waits: None,
        });
    }

    /// The variant of a scenario.
    #[must_use]
    pub fn find(&self, hash: ContentHash, change: Option<Transform>) -> Option<&CachedVariant> {
        self.kept.iter().find(|kept| kept.is_of(hash, change))
    }

    /// The variant was written to these files.
    pub fn saved(&mut self, made: &Arc<GeneratedVariant>, files: &str) {
        let mut kept = self.kept.iter_mut();
        if let Some(kept) = kept.find(|kept| Arc::ptr_eq(&kept.made, made)) {
            kept.saved = Some(files.into());
        }
    }

    /// How many variants were not written: they end with the program.
    #[must_use]
    pub fn unsaved(&self) -> usize {
        let lost = |kept: &&CachedVariant| kept.saved.is_none();
        self.kept.iter().filter(lost).count()
    }

    /// Where the variant was written to.
    #[must_use]
    pub fn files(&self, made: &Arc<GeneratedVariant>) -> Option<&str> {
        let kept = self
            .kept
            .iter()
            .find(|kept| Arc::ptr_eq(&kept.made, made))?;
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

    /// Keeps what came of it without a dangerous result.
    pub(super) fn keep_fruitless(&mut self, of: (ContentHash, Option<Transform>), got: Fruitless) {
        // What a model wrote was paid for: a failure after it does not replace it.
        self.fruitless.retain(|(hash, change, before)| {
            (*hash, *change) != of || before.is_ok() != got.is_ok()
        });
        self.fruitless.push((of.0, of.1, got));
        if self.fruitless.len() > MAX_KEPT {
            self.fruitless.drain(..1);
        }
    }

    /// What came of it for a scenario without a dangerous result, the newest first.
    fn fruitless(&self, of: (ContentHash, Option<Transform>)) -> impl Iterator<Item = &Fruitless> {
        let all = self.fruitless.iter().rev();
        all.filter(move |(hash, change, _)| (*hash, *change) == of)
            .map(|(_, _, got)| got)
    }

    /// Whether a model has had its say about this: the same would come from the store.
    #[must_use]
    pub fn was_heard(&self, hash: ContentHash, only: Option<i64>, model: &str) -> bool {
        let mut all = self.heard_out.iter();
        all.any(|(of, who, said)| (*of, *who) == (hash, only) && said == model)
    }

    /// A model has had its say.
    pub fn heard_out(&mut self, hash: ContentHash, only: Option<i64>, model: &str) {
        if !self.was_heard(hash, only, model) {
            self.heard_out.push((hash, only, model.into()));
        }
    }

    /// Forgets all variants: what was measured on them holds no longer.
    pub fn forget(&mut self) {
        self.kept.clear();
        self.fruitless.clear();
    }
}

impl CachedVariant {
    /// The planner that was attacked: 0 is the built-in one, then those of the configuration.
    #[must_use]
    pub fn planner(&self) -> usize {
        let planned = self.variant.planned.as_ref();
        planned.map_or(0, |planned| planned.planner)
    }

    fn is_of(&self, hash: ContentHash, change: Option<Transform>) -> bool {
        self.original.scenario.hash == hash && self.original.change == change
    }
}

/// Ids in words: 1, 2 and 3.
#[must_use]
pub fn listed(ids: &[i64]) -> String {
    let words: Vec<String> = ids.iter().map(i64::to_string).collect();
    match &words[..] {
        [] => "none".into(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Describes the stage of a search, briefly or with all its numbers.
#[must_use]
pub fn working_words(at: Option<GenerationStage>, whole: bool) -> String {
    match at {
        None => "generating".into(),
        Some(GenerationStage::Driving(done, of)) => {
            driving_words("the original", (done, of), whole)
        }
        Some(GenerationStage::Showing(done, of)) => driving_words("the variant", (done, of), whole),
        Some(GenerationStage::Writing(at)) => writing_words(&at, whole),
        Some(GenerationStage::Trying(done, of)) if whole => {
            format!("generating: driving against motion {} of {of}", done + 1)
        }
        Some(GenerationStage::Trying(done, of)) => {
            format!("driving against motion {}/{of}", done + 1)
        }
        Some(GenerationStage::Proving) if whole => {
            "generating: looking for ways an ideal driver avoids it".into()
        }
        Some(GenerationStage::Proving) => "can it be avoided?".into(),
        Some(GenerationStage::Searching(progress, of)) if !whole => {
            format!("trying motion {}/{of}", progress.tried)
        }
        Some(GenerationStage::Searching(progress, of)) => format!(
            "generating: motion {} of {of}, {} refused, {} driven, best {}",
            progress.tried,
            progress.refused,
            progress.driven,
            progress.best.as_ref().map_or("none", consequence_words)
        ),
    }
}

/// Describes the progress of the ego's drive, once it has started.
fn driving_words(what: &str, (done, of): (usize, usize), whole: bool) -> String {
    match (of, whole) {
        (0, true) => format!("generating: driving {what}"),
        (0, false) => format!("driving {what}"),
        (_, true) => format!("generating: driving {what}, step {done} of {of}"),
        (_, false) => format!("driving {what}, step {done}/{of}"),
    }
}

/// Describes a model's progress.
fn writing_words(at: &AuthoringProgress, whole: bool) -> String {
    if at.begun == 0 {
        return match at.of_votes {
            0 | 1 => "model: chooses the attacker".into(),
            of => format!("model: chooses the attacker, vote {}/{of}", at.votes),
        };
    }
    if at.grades.1 > 0 {
        return format!("model: grades motion {}/{}", at.grades.0, at.grades.1);
    }
    let mut words = if at.driving {
        format!("driving against motion {}/{}", at.begun, at.of)
    } else {
        format!("model: writes motion {}/{}", at.begun, at.of)
    };
    if whole {
        if at.retry > 0 {
            words.push_str(&format!(", try {}", at.retry + 1));
        }
        words.push_str(&format!(", {} passed, {} refused", at.passed, at.refused));
        if at.sent_back > 0 {
            words.push_str(&format!(", {} told what came of it", at.sent_back));
        }
    }
    words
}

/// Describes the outcome of a change.
#[must_use]
pub fn consequence_words(consequence: &Consequence) -> &'static str {
    match consequence {
        Consequence::Collision(_) => "collision",
        Consequence::PlannerError(_) => "error of the planner",
        Consequence::NearMiss => "near miss",
        Consequence::NoEffect => "no effect",
    }
}

impl Model {
    /// A model's output for the open scenario without a dangerous result.
    #[must_use]
    pub fn unwritten(&self) -> Option<&Arc<Authorship>> {
        let mut all = self.generation.fruitless(self.made_of()?);
        all.find_map(|got| got.as_ref().ok())
    }

    /// The key of the open scenario's variants: that of its original.
    #[must_use]
    pub fn made_of(&self) -> Option<(ContentHash, Option<Transform>)> {
        let opened = self.opened.as_deref()?;
        let hash = match &opened.variant {
            Some(shown) => shown.made.original(),
            None => opened.scenario.hash,
        };
        Some((hash, opened.change))
    }

    /// The variant that is shown, or beside whose original stands what is shown.
    #[must_use]
    pub fn variant(&self) -> Option<&VariantShown> {
        self.opened.as_ref()?.variant.as_ref()
    }

    /// The variant that was opened from a file, by the manifest beside it.
    #[must_use]
    pub fn saved(&self) -> Option<&SavedVariant> {
        self.opened.as_ref()?.saved.as_deref()
    }

    /// What is known of a variant that was opened from a file.
    #[must_use]
    pub fn saved_variant(&self, saved: &SavedVariant) -> String {
        let what = match &saved.origin.ids()[..] {
            [one] => format!("a saved variant: {one} has a new motion"),
            several => format!("a saved variant: {} have new motions", listed(several)),
        };
        match &saved.original {
            Ok(_) => format!(
                "{what}; {} opens the original {}, {} shows it beside",
                self.look.key(Action::SwitchVariant),
                saved.origin.manifest.original.benchmark_id,
                self.look.key(Action::SplitMap)
            ),
            Err(why) => format!("{what}; {why}"),
        }
    }

    /// Why there is no variant to show, and what to do.
    #[must_use]
    pub fn without_variant(&self) -> String {
        if self.generation.under_way.is_some() {
            return "the variant is still being made".into();
        }
        if self.opened.is_none() {
            return "no scenario is open".into();
        }
        let generate = self.look.key(Action::Generate);
        let kept = self
            .made_of()
            .and_then(|(hash, change)| self.generation.find(hash, change));
        match kept {
            Some(_) => format!(
                "the variant is not shown: {generate} or {} shows it",
                self.look.key(Action::SwitchVariant)
            ),
            None => match self
                .opened
                .as_ref()
                .and_then(|opened| opened.saved.as_ref())
            {
                Some(saved) => self.saved_variant(saved),
                None => match self
                    .made_of()
                    .and_then(|of| self.generation.fruitless(of).next())
                {
                    Some(Err(why)) => failed_words(why),
                    _ => format!("no variant was made; {generate} makes the scenario dangerous"),
                },
            },
        }
    }
}

/// Why the work failed, and how to try again: the key depends on whether a model was asked.
pub(super) fn failed_words(why: &str) -> String {
    format!("no variant was made: {why}; the same key tries again")
}
