//! A batch's answers with their ground truth: parsed again from their texts, failed ones included.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::question_builder::obstacle;
use super::truth::Truth;
use super::variant::Variant;
use crate::description::Frame;
use crate::evaluation::{
    AnswerStatus, Label, LabelError, Lead, PromptConfig, Scored, TemplateVersion,
};
use crate::formats::Entry;
use crate::judge;
use crate::prompts::Techniques;
use crate::scenario::Transform;
use crate::store::{BatchId, Consumed, Item, ItemState, NewItem, NewestAnswer, Store, StoreError};
use crate::verdict::{self, Task, Verdict};

/// The answers of a batch, those about its scenes as they are and with the first lead apart from the others.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Answers {
    /// About the scenes as they are, with the first lead: what is right or wrong is counted of these.
    pub plain: Vec<Scored>,
    /// About changed scenes, called as [`Transform::name`] says, with the ids of the originals.
    pub changed: Vec<Scored>,
    /// About the scenes as they are, at every lead that has a name, the first one, too; none of batches with fewer
    /// than two.
    pub leads: Vec<(Lead, Scored)>,
    /// The places of the plain ones in the batch, in the same order.
    pub places: Vec<u64>,
    /// Those that are not among the plain ones.
    pub others: usize,
}

/// Every yes-or-no question of a batch with its answer, in order: the newest complete answer to the same request and
/// sample, else why there is none.
///
/// Verdicts are parsed from the stored texts, so that a better parser finds more in them without asking again.
///
/// # Errors
/// The store cannot be read, or holds words that this version does not know.
pub fn answers(store: &Store, batch: BatchId) -> Result<Answers, StoreError> {
    let mut found = store.items_with_answers(batch)?;
    found.retain(|(item, _)| Task::VERDICTS.contains(&item.asked.task));
    let mut all = read(&found)?;
    let mut templates = BatchTemplates::default();
    templates.note(&found);
    all.iter_mut()
        .for_each(|(_, scored)| templates.name(&mut scored.way));
    let places = found.iter().map(|(item, _)| item.place);
    // Of every scenario the first lead stands before the others. Where leads were added to a batch without one, what it
    // was begun with comes first.
    let without = |(variant, scored): &(Variant, Scored)| {
        scored.way.task == Task::Safety && *variant == Variant::default()
    };
    let first = match all.iter().any(without) {
        true => None,
        false => all.iter().find_map(|(variant, _)| variant.lead),
    };
    let questions = all.len();
    let mut sorted = Answers::default();
    for ((variant, scored), place) in all.into_iter().zip(places) {
        if variant.transform.is_some() {
            sorted.changed.push(scored);
            continue;
        }
        if let Some(lead) = variant.lead {
            sorted.leads.push((lead, scored.clone()));
        }
        if variant.lead.is_none() || variant.lead == first {
            sorted.plain.push(scored);
            sorted.places.push(place);
        }
    }
    sorted.others = questions - sorted.plain.len();
    let scored = &mut sorted.plain;
    let reference: Vec<(String, Task, Verdict)> = scored
        .iter()
        .filter(|one| one.way.model == judge::MODEL)
        .filter_map(|one| match &one.status {
            AnswerStatus::Verdict(verdict) => {
                Some((one.scenario.clone(), one.way.task, verdict.clone()))
            }
            AnswerStatus::Unparsed(_) | AnswerStatus::Failed(_) | AnswerStatus::Unasked(_) => None,
        })
        .collect();
    let of: std::collections::HashMap<_, _> = reference
        .iter()
        .map(|(scenario, task, verdict)| ((scenario.as_str(), *task), verdict))
        .collect();
    for one in scored {
        one.reference = of
            .get(&(one.scenario.as_str(), one.way.task))
            .map(|v| (*v).clone());
    }
    Ok(sorted)
}

/// The templates that a batch asks with, by task and frame: it pins one version of each, which its answers tell.
#[derive(Debug, Default)]
pub(super) struct BatchTemplates(BTreeMap<(Task, String), TemplateVersion>);

impl BatchTemplates {
    /// Notes what these questions were asked with.
    pub fn note(&mut self, found: &[(Item, Option<NewestAnswer>)]) {
        for (item, answer) in found {
            let (Some(frame), Some(answer)) = (&item.asked.frame, answer) else {
                continue;
            };
            if let Some(version) = TemplateVersion::of(&answer.template) {
                let place = (item.asked.task, frame.clone());
                self.0.entry(place).or_insert(version);
            }
        }
    }

    /// Gives a way of asking the version of its template.
    pub fn name(&self, way: &mut PromptConfig) {
        let frame = way.frame.map(|frame| frame.name().to_string());
        let place = frame.map(|frame| (way.task, frame));
        way.template = place.and_then(|place| self.0.get(&place).cloned());
    }
}

/// Answers to questions of a batch, in order, with the variant each is about.
///
/// # Errors
/// The store holds words that this version does not know.
pub(super) fn read(
    found: &[(Item, Option<NewestAnswer>)],
) -> Result<Vec<(Variant, Scored)>, StoreError> {
    let one = |(item, found): &(Item, Option<NewestAnswer>)| {
        let variant = Variant::from_item(&item.asked).map_err(StoreError::Word)?;
        let scored = one(item, found.as_ref())?;
        Ok((variant, told_back(item, variant.transform, scored)))
    };
    found.par_iter().map(one).collect()
}

/// An answer about a changed scene under its name, with the ids of the original. New numbers can be told back only as
/// long as the scenario can be read as it was.
fn told_back(item: &Item, change: Option<Transform>, mut scored: Scored) -> Scored {
    let Some(change) = change else { return scored };
    scored.scenario = change.name(&scored.scenario);
    if !matches!(change, Transform::Renumber(_))
        || !matches!(scored.status, AnswerStatus::Verdict(_))
    {
        return scored;
    }
    let asked = &item.asked;
    let read = Entry::of_argument(std::path::Path::new(&asked.path)).read();
    match read.map_err(|error| error.to_string()) {
        Ok(scenario) if asked.scenario_hash == Some(scenario.hash.to_string()) => {
            scored.mapped_back(&change.ids(&scenario))
        }
        Ok(_) => {
            let why = "its numbers cannot be told back: the scenario is no longer the same";
            scored.status = AnswerStatus::Failed(why.into());
            scored
        }
        Err(why) => {
            scored.status = AnswerStatus::Failed(format!("its numbers cannot be told back: {why}"));
            scored
        }
    }
}

fn one(item: &Item, found: Option<&NewestAnswer>) -> Result<Scored, StoreError> {
    let asked = &item.asked;
    let status = match found {
        Some(found) => match verdict::parse(asked.task, &found.text) {
            Ok(parsed) => AnswerStatus::Verdict(parsed.verdict),
            Err(why) => AnswerStatus::Unparsed(why.to_string()),
        },
        None => without_answer(item),
    };
    Ok(Scored {
        scenario: asked.scenario.clone(),
        way: way_of(asked).map_err(StoreError::Word)?,
        sample: asked.sample,
        truth: label_of(asked),
        status,
        reference: None,
        consumed: found.map_or_else(Consumed::default, |found| found.consumed),
        run: found.map(|found| found.run).or(item.run),
    })
}

/// Why a question has no whole answer: it was asked and none came, or it was not asked.
fn without_answer(item: &Item) -> AnswerStatus {
    let why = |usual: &str| item.error.clone().unwrap_or_else(|| usual.into());
    match item.state {
        ItemState::Answered => AnswerStatus::Failed(why("the answer was deleted from the store")),
        ItemState::Truncated | ItemState::Failed => {
            AnswerStatus::Failed(why("no whole answer came"))
        }
        ItemState::Waiting => AnswerStatus::Unasked(why("it was not asked yet")),
        ItemState::Unaskable => {
            AnswerStatus::Unasked(why("no question can be made of the scenario"))
        }
    }
}
/// Another truth of a question: its place in the batch, whether the ego collides, and with whom.
pub type Relabelled = (u64, Option<bool>, Option<i64>);

/// The same answers beside another truth: by place in the batch, whether the ego collides, and with whom.
///
/// The `builder` opens scenarios where the truth needs their scene.
///
/// # Errors
/// A label names an obstacle that its scenario does not have.
pub fn retold(
    items: &[Item],
    truth: &Truth,
    builder: &super::QuestionBuilder,
) -> Result<Vec<Relabelled>, LabelError> {
    items
        .par_iter()
        .map(|item| {
            let entry = Entry::of_argument(std::path::Path::new(&item.asked.path));
            let scene = match truth {
                Truth::Geometry => builder.open(&entry).ok(),
                Truth::Labels(labels) if labels.names_an_obstacle(&entry.name) => {
                    builder.open(&entry).ok()
                }
                Truth::Layout(_) | Truth::Labels(_) | Truth::Known(_) => None,
            };
            let scene = scene.as_ref().map(|reading| &*reading.scene);
            truth.fits(&entry, scene)?;
            let label = truth.label(&entry, scene);
            Ok((item.place, label.map(Label::collides), obstacle(label)))
        })
        .collect()
}

/// How a question was asked.
///
/// # Errors
/// A word that this version does not know.
pub fn way_of(asked: &NewItem) -> Result<PromptConfig, String> {
    let frame = asked.frame.as_deref().map(|word| {
        Frame::parse(word).ok_or_else(|| format!("the frame {word} is not known to this version"))
    });
    Ok(PromptConfig {
        task: asked.task,
        frame: frame.transpose()?,
        techniques: asked
            .techniques
            .as_deref()
            .map(Techniques::parse)
            .transpose()?,
        model: asked.model.clone(),
        template: None,
    })
}

/// The ground truth stored by the batch.
#[must_use]
pub fn label_of(asked: &NewItem) -> Option<Label> {
    asked.collides.map(|collides| match collides {
        true => Label::Collision(asked.obstacle),
        false => Label::Safe,
    })
}
