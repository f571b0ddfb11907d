//! Counts a batch by its own ground truth, piece by piece, and lists the batches to choose from.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use super::scored::{BatchTemplates, read};
use super::spec::Spec;
use super::variant::Variant;
use crate::evaluation::{AnswerOutcome, Label, Lead, PromptConfig, Results, Scored};
use crate::scenario::Transform;
use crate::store::{BatchId, Progress, Store, StoreError};
use crate::verdict::Task;

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
}

impl std::fmt::Display for AnswerSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Everything => f.write_str("everything in the store"),
            Self::Batch(id, BatchPart::Plain) => write!(f, "batch {id}"),
            Self::Batch(id, BatchPart::Lead(Lead::Paper)) => write!(f, "batch {id}, lead end"),
            Self::Batch(id, BatchPart::Lead(lead)) => write!(f, "batch {id}, lead {lead} s"),
            Self::Batch(id, BatchPart::Changed(change)) => write!(f, "batch {id}, scenes {change}"),
        }
    }
}

impl BatchPart {
    /// Whether a question is one of them, where `first` is the first lead of the batch.
    fn holds(self, variant: &Variant, first: Option<Lead>) -> bool {
        match self {
            Self::Plain => {
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
            Ok(spec) => spec.truth.words(),
            Err(why) => format!("as the batch has it ({why})"),
        };
        let matrix = spec.ok().map(|spec| spec.matrix);
        let parts = matrix.iter().flat_map(|matrix| {
            let leads = matrix.more_leads.iter().map(|lead| BatchPart::Lead(*lead));
            let changes = matrix.transforms.iter();
            leads.chain(changes.map(|change| BatchPart::Changed(*change)))
        });
        for part in std::iter::once(BatchPart::Plain).chain(parts) {
            found.push(CountingChoice {
                counting: AnswerSet::Batch(batch.id, part),
                truth: truth.clone(),
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

/// The truth about an answer, where another one than that of its batch counts.
pub type OtherTruth<'a> = &'a (dyn Fn(&Scored) -> Option<Label> + Sync);

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
        return Err(StoreError::Word(format!("there is no batch {id}")));
    };
    let spec = Spec::from_json(&batch.spec);
    let spec = spec.map_err(|why| StoreError::Word(why.to_string()))?;
    let first = spec.matrix.request.lead;
    let mut ways: BTreeMap<PromptConfig, Vec<AnswerOutcome>> = BTreeMap::new();
    let mut templates = BatchTemplates::default();
    let (mut unasked, mut from) = (0, 0);
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let mut piece = store.some_items_with_answers(id, from, Some(PIECE))?;
        let Some((last, _)) = piece.last() else { break };
        from = last.place + 1;
        piece.retain(|(item, _)| Task::VERDICTS.contains(&item.asked.task));
        templates.note(&piece);
        for (variant, mut scored) in read(&piece)? {
            if !part.holds(&variant, first) {
                continue;
            }
            if let Some(other) = other {
                scored.truth = other(&scored);
            }
            match AnswerOutcome::of_scored(&scored) {
                Some(counted) => ways.entry(scored.way).or_default().push(counted),
                None => unasked += 1,
            }
        }
    }
    let rows = ways.into_iter().map(|(mut way, all)| {
        templates.name(&mut way);
        Results::new(way, all)
    });
    Ok(Some(BatchResults {
        rows: rows.collect(),
        unasked,
    }))
}
