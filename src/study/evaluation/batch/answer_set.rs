//! Counts a batch by its own ground truth, piece by piece, and by the built-in judge's verdicts on its questions.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use nearmiss_base::system::without_folders;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{BatchId, Item, NewItem, Progress, SceneRecord, SplitPart, Store, StoreError};
use rayon::prelude::*;

use super::question_builder::{QuestionBuilder, Variant};
use super::scored::{Answers, BatchTemplates, configuration_of_item, label_of_item, read};
use super::spec::Spec;
use super::test_split::TestSplit;
use crate::evaluation::results::CountedWay;
use crate::evaluation::{Label, Lead, PromptConfig, Results, Scored};

/// Which answers are counted, and so against which ground truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnswerSet {
    /// All stored answers.
    Everything,
    /// A part of a batch of `evaluate`, which has a ground truth of its own.
    Batch(BatchId, BatchPart),
}

/// Part of a batch's questions: each part covers every scenario once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BatchPart {
    /// The scenes as they are, with the first lead: what `report` counts.
    Plain,
    /// The scenes as they are, at another lead.
    Lead(Lead),
    /// The scenes after this change.
    Changed(Transform),
    /// The plain questions of a part of a split.
    Split(SplitPart),
}

/// An entry of the list of choices.
#[derive(Debug, Clone, PartialEq)]
pub struct CountingChoice {
    /// What.
    pub counting: AnswerSet,
    /// Of a batch: its own ground truth in words, or why it is unknown.
    pub truth: String,
    /// Of a batch: when it was begun, milliseconds since 1970, UTC.
    pub created_ms: Option<i64>,
    /// Of a batch: how far it is.
    pub progress: Progress,
}

/// Results of a part of a batch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BatchResults {
    /// A row for each way of asking.
    pub rows: Vec<Results>,
    /// Questions that were not asked, or not yet, or cannot be asked at all; they are not counted.
    pub unasked: usize,
    /// Runs that are not counted, see [`Stored::left_out`](crate::evaluation::report::Stored::left_out); empty for a batch.
    pub left_out: Vec<String>,
    /// How far the test split is that may not be counted yet; `None` where the rows are all there is.
    pub locked: Option<String>,
}

impl std::fmt::Display for AnswerSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Everything => f.write_str("everything in the store"),
            Self::Batch(id, BatchPart::Plain) => write!(f, "batch {id}"),
            Self::Batch(id, BatchPart::Lead(Lead::Paper)) => write!(f, "batch {id}, lead end"),
            Self::Batch(id, BatchPart::Lead(lead)) => write!(f, "batch {id}, lead {lead} s"),
            Self::Batch(id, BatchPart::Split(part)) => {
                write!(f, "batch {id}, {} split", part.name())
            }
            Self::Batch(id, BatchPart::Changed(change)) => {
                write!(f, "batch {id}, transform {change}")
            }
        }
    }
}

impl BatchPart {
    /// Whether a question is one of them, where `first` is the first lead of the batch.
    fn holds(self, variant: &Variant, first: Option<Lead>) -> bool {
        match self {
            Self::Plain | Self::Split(_) => {
                variant.transform.is_none() && (variant.lead.is_none() || variant.lead == first)
            }
            Self::Lead(lead) => variant.transform.is_none() && variant.lead == Some(lead),
            Self::Changed(change) => variant.transform == Some(change),
        }
    }
}

/// The choices: the batches, newest first, each whole and then its other parts; all answers last.
///
/// # Errors
/// The store cannot be read.
pub fn offers(store: &Store) -> Result<Vec<CountingChoice>, StoreError> {
    let mut found = Vec::new();
    for (batch, progress) in store.batches()? {
        let spec = Spec::from_json(&batch.spec);
        let truth = match &spec {
            Ok(spec) => spec.truth_summary(),
            Err(why) => format!("truth of the batch ({why})"),
        };
        let test = TestSplit::open(store, &batch, false)?;
        let looks = test.as_ref().and_then(TestSplit::looks_note);
        let experiment = spec.ok().map(|spec| spec.experiment);
        let parts = experiment.iter().flat_map(|experiment| {
            let leads = experiment.more_leads().iter();
            let leads = leads.map(|lead| BatchPart::Lead(*lead));
            let changes = experiment.transforms.iter();
            leads.chain(changes.map(|change| BatchPart::Changed(*change)))
        });
        // Leads and changes are counted of the dev part of a split.
        let first = match test {
            Some(_) => &[
                BatchPart::Split(SplitPart::Dev),
                BatchPart::Split(SplitPart::Test),
            ][..],
            None => &[BatchPart::Plain],
        };
        for part in first.iter().copied().chain(parts) {
            let looks = looks
                .as_ref()
                .filter(|_| part == BatchPart::Split(SplitPart::Test));
            found.push(CountingChoice {
                counting: AnswerSet::Batch(batch.id, part),
                truth: match looks {
                    Some(looks) => format!("{truth}; {looks}"),
                    None => truth.clone(),
                },
                created_ms: Some(batch.created_ms),
                progress,
            });
        }
    }
    found.push(CountingChoice {
        counting: AnswerSet::Everything,
        truth: String::new(),
        created_ms: None,
        progress: Progress::default(),
    });
    Ok(found)
}

/// Questions whose texts are at hand at once.
const PIECE: u32 = 2000;

/// The truth about an answer with the critical obstacles, where another one than that of its batch counts.
pub type OtherTruth<'a> = &'a (dyn Fn(&Scored) -> Option<(Label, Vec<i64>)> + Sync);

/// Counts a part of a batch: verdicts are read anew from the stored texts, as for a report. Nothing where it was told
/// to stop.
///
/// # Errors
/// The store cannot be read, holds words that this version does not know, or has no such batch.
pub fn counted(
    store: &Store,
    id: BatchId,
    part: BatchPart,
    other: Option<OtherTruth<'_>>,
    stop: &AtomicBool,
) -> Result<Option<BatchResults>, StoreError> {
    let Some(batch) = store.batch(id)? else {
        return Err(StoreError::Word(format!("no batch {id}")));
    };
    let spec = Spec::from_json(&batch.spec).map_err(|why| StoreError::Word(why.to_string()))?;
    let wanted = match (TestSplit::open(store, &batch, false)?, part) {
        (None, _) => None,
        (Some(test), BatchPart::Split(SplitPart::Test)) if test.is_locked() => {
            return Ok(Some(BatchResults {
                locked: Some(test.summary()),
                ..BatchResults::default()
            }));
        }
        (Some(_), BatchPart::Split(part)) => Some(part),
        (Some(_), _) => Some(SplitPart::Dev),
    };
    let (first, protocol) = (spec.experiment.lead(), spec.experiment.protocol);
    let mut configurations: BTreeMap<PromptConfig, CountedWay> = BTreeMap::new();
    let mut templates = BatchTemplates::default();
    let (mut unasked, mut from) = (0, 0);
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let mut piece = store.some_items_with_answers(id, from, Some(PIECE))?;
        let runs = store.question_runs(id, from, Some(PIECE))?;
        let Some((last, _)) = piece.last() else { break };
        from = last.place + 1;
        piece.retain(|(item, _)| Task::VERDICTS.contains(&item.asked.task));
        piece.retain(|(item, _)| wanted.is_none() || item.asked.split == wanted);
        templates.note(&piece);
        for (variant, mut scored) in read(&piece, &runs)? {
            if !part.holds(&variant, first) {
                continue;
            }
            if let Some(other) = other {
                scored.set_truth(other(&scored));
            }
            protocol.count(&mut scored);
            // The way of a question is written for its row alone.
            let configuration = if configurations.contains_key(&scored.configuration) {
                configurations.get_mut(&scored.configuration)
            } else {
                Some(
                    configurations
                        .entry(scored.configuration.clone())
                        .or_default(),
                )
            };
            unasked += usize::from(
                configuration.is_some_and(|configuration| !configuration.take(&scored)),
            );
        }
    }
    let rows = configurations
        .into_iter()
        .filter_map(|(mut configuration, all)| {
            templates.name(&mut configuration);
            all.results(configuration)
        });
    Ok(Some(BatchResults {
        rows: rows.collect(),
        unasked,
        ..BatchResults::default()
    }))
}

/// A scenario that the judge could not be asked about, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnjudgedScenario {
    /// Its name.
    pub scenario: String,
    /// The reason.
    pub why: String,
}

/// The settings that make the judge's verdicts on one scenario differ.
type VerdictKey<'a> = (
    Task,
    Option<&'a str>,
    Option<&'a str>,
    Option<&'a str>,
    Option<(i64, i64)>,
);

/// The built-in judge's verdict on a question, or why it could not be asked.
pub type Judgement = Result<Verdict, String>;

/// What came of asking the built-in judge about the answers without its verdict.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Judgements {
    /// By place in the batch.
    pub all: BTreeMap<u64, Judgement>,
    /// Scenarios that it could not be asked about, by name.
    pub unjudged: Vec<UnjudgedScenario>,
}

impl Judgements {
    /// How many verdicts there are.
    #[must_use]
    pub fn verdicts(&self) -> usize {
        self.all.values().filter(|one| one.is_ok()).count()
    }
}

/// Sets the built-in judge's verdict beside those plain answers of a batch that have none, as the batch asks: from the
/// records of a bundle, else from the scenarios, each of which is opened once, those of several at once. `builder` is
/// needed for the latter only.
#[must_use]
pub fn with_judge_verdicts(
    answers: &mut Answers,
    items: &[Item],
    builder: impl FnOnce() -> Result<QuestionBuilder, String>,
) -> Judgements {
    let by_place: HashMap<u64, &Item> = items.iter().map(|item| (item.place, item)).collect();
    let mut all: BTreeMap<u64, Judgement> = BTreeMap::new();
    let mut missing: BTreeMap<&str, Vec<(u64, &NewItem)>> = BTreeMap::new();
    for (one, place) in answers.plain.iter().zip(&answers.places) {
        let (None, Some(item)) = (&one.reference, by_place.get(place)) else {
            continue;
        };
        match item.asked.scene.as_ref().and_then(SceneRecord::judgement) {
            Some(known) => drop(all.insert(*place, known)),
            None => {
                let of_file = missing.entry(item.asked.path.as_str()).or_default();
                of_file.push((*place, &item.asked));
            }
        }
    }
    if !missing.is_empty() {
        let builder = builder();
        let judged: Vec<Vec<(u64, Judgement)>> = missing
            .par_iter()
            .map(|(path, asked)| match &builder {
                Ok(builder) => of_scenario(path, asked, builder),
                Err(why) => asked
                    .iter()
                    .map(|(at, _)| (*at, Err(why.clone())))
                    .collect(),
            })
            .collect();
        all.extend(judged.into_iter().flatten());
    }
    for (one, place) in answers.plain.iter_mut().zip(&answers.places) {
        if let Some(Ok(verdict)) = all.get(place) {
            one.reference = Some(verdict.clone());
        }
    }
    let mut unjudged: BTreeMap<(&str, &str), &String> = BTreeMap::new();
    for (place, judgement) in &all {
        if let (Err(why), Some(item)) = (judgement, by_place.get(place)) {
            let scenario = (item.asked.scenario.as_str(), item.asked.path.as_str());
            unjudged.entry(scenario).or_insert(why);
        }
    }
    let unjudged = unjudged
        .into_iter()
        .map(|((scenario, _), why)| UnjudgedScenario {
            scenario: scenario.into(),
            why: why.clone(),
        })
        .collect();
    Judgements { all, unjudged }
}

fn of_scenario(
    path: &str,
    asked: &[(u64, &NewItem)],
    builder: &QuestionBuilder,
) -> Vec<(u64, Judgement)> {
    let entry = Entry::of_argument(Path::new(path));
    let scene = builder.open(&entry).map(|reading| reading.scene);
    // Many questions are about the same file.
    let hash = scene.as_ref().ok();
    let hash = hash.map(|scene| scene.scenario.hash.to_string());
    let mut known: HashMap<VerdictKey<'_>, Judgement> = HashMap::new();
    let each = asked.iter().map(|&(at, asked)| {
        let verdict = match &scene {
            Err(why) => Err(why.clone()),
            Ok(_) if asked.scenario_hash != hash => {
                Err("the file has changed since it was asked about".into())
            }
            Ok(scene) => known
                .entry(about(asked))
                .or_insert_with(|| {
                    let configuration = PromptConfig {
                        model: String::new(),
                        ..configuration_of_item(asked)?
                    };
                    let variant = Variant::from_item(asked)?;
                    builder.judged(
                        &entry,
                        scene,
                        &configuration,
                        &variant,
                        label_of_item(asked),
                    )
                })
                .clone(),
        };
        // The same words wherever the file lies.
        (at, verdict.map_err(|why| with_file_name(&why, path)))
    });
    each.collect()
}

/// A reason without the folders of its scenario.
fn with_file_name(why: &str, path: &str) -> String {
    let name = Path::new(path)
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    without_folders(&why.replace(path, &name))
}

/// The window depends on the lead, and on what the template of the frame and the techniques say; the judge itself on
/// neither.
fn about(asked: &NewItem) -> VerdictKey<'_> {
    let (frame, techniques) = (asked.frame.as_deref(), asked.techniques.as_deref());
    match asked.task {
        // The judge looks at the whole recording.
        task if task.is_about_all_steps() => (task, None, None, None, None),
        _ => (
            asked.task,
            frame,
            techniques,
            asked.lead.as_deref(),
            asked.window,
        ),
    }
}
