//! Counts a batch by its own ground truth, piece by piece, and lists the batches to choose from.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use super::scored::{BatchTemplates, read};
use super::spec::Spec;
use super::test_split::TestSplit;
use super::variant::Variant;
use crate::evaluation::results::CountedWay;
use crate::evaluation::{Label, Lead, PromptConfig, Results, Scored};
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{BatchId, Progress, SplitPart, Store, StoreError};

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
            Ok(spec) => spec.truth_words(),
            Err(why) => format!("truth of the batch ({why})"),
        };
        let test = TestSplit::of(store, &batch, false)?;
        let looks = test.as_ref().and_then(TestSplit::looks_words);
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
    let wanted = match (TestSplit::of(store, &batch, false)?, part) {
        (None, _) => None,
        (Some(test), BatchPart::Split(SplitPart::Test)) if test.is_locked() => {
            return Ok(Some(BatchResults {
                locked: Some(test.words()),
                ..BatchResults::default()
            }));
        }
        (Some(_), BatchPart::Split(part)) => Some(part),
        (Some(_), _) => Some(SplitPart::Dev),
    };
    let (first, protocol) = (spec.experiment.lead(), spec.experiment.protocol);
    let mut ways: BTreeMap<PromptConfig, CountedWay> = BTreeMap::new();
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
                scored.tell(other(&scored));
            }
            protocol.count(&mut scored);
            // The way of a question is written for its row alone.
            let way = if ways.contains_key(&scored.way) {
                ways.get_mut(&scored.way)
            } else {
                Some(ways.entry(scored.way.clone()).or_default())
            };
            unasked += usize::from(way.is_some_and(|way| !way.take(&scored)));
        }
    }
    let rows = ways.into_iter().filter_map(|(mut way, all)| {
        templates.name(&mut way);
        all.results(way)
    });
    Ok(Some(BatchResults {
        rows: rows.collect(),
        unasked,
        locked: None,
    }))
}
