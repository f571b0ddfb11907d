//! Stored runs compared with the ground truth.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use rayon::prelude::*;

use super::super::{AnswerStatus, Label, PromptConfig, Scored, TemplateVersion};
use super::consumption::count;
use super::truth::{QuestionKey, Truth};
use crate::description::Frame;
use crate::judge;
use crate::prompts::Techniques;
use crate::scenario::Transform;
use crate::store::{Key, Outcome, RunId, RunState, SecondaryRuns};
use crate::verdict::{Task, Verdict};

/// Runs of the store beside the truth.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stored {
    /// Those that can be counted.
    pub scored: Vec<Scored>,
    /// Runs that are still arriving, were cancelled, or broke off with the program: no answers, and no failures.
    pub unfinished: u32,
    /// Runs in whose place another one counts, see [`stored`].
    pub asked_again: u32,
    /// Runs to tasks that have no yes or no.
    pub other_tasks: u32,
    /// Runs that were asked in a way that this version does not know.
    pub unknown_ways: u32,
    /// Runs at other leads than the first one of their batch.
    pub other_leads: u32,
    /// Runs about changed scenes.
    pub changed: u32,
    /// Scenarios that one way of asking was asked about with several windows in the safety task.
    pub several_windows: u32,
    /// Answers beside the truth of their batch, by batch.
    pub of_batches: BTreeMap<String, u32>,
    /// Scenarios without a truth.
    pub unlabelled: Vec<String>,
}

/// Sets runs beside the truth, in the order of the runs. The verdicts are those that were stored.
///
/// Where the same question was asked again, for the same sample, the newest whole answer counts, and without one the
/// newest failure. Other leads and changed scenes of batches are other questions, and are left out as in the report of
/// a batch. The built-in judge's verdict on a question is that of its run on the same file, task and, for safety,
/// window.
#[must_use]
pub fn stored(outcomes: &[Outcome], truth: &Truth, asides: &SecondaryRuns) -> Stored {
    let original = originals(outcomes, asides);
    let outcomes = || {
        outcomes
            .iter()
            .map(|one| original.get(&one.run).unwrap_or(one))
    };
    let mut counted: Vec<(&Outcome, PromptConfig)> = Vec::with_capacity(outcomes().len());
    let mut stored = Stored::default();
    let mut places: HashMap<Identity<'_>, usize> = HashMap::with_capacity(outcomes().len());
    for outcome in outcomes() {
        if !Task::VERDICTS.contains(&outcome.task) {
            stored.other_tasks += 1;
        } else if !is_over(outcome.state) {
            stored.unfinished += 1;
        } else if is_changed(outcome, asides) {
            stored.changed += 1;
        } else if asides.leads.contains(&outcome.run) {
            stored.other_leads += 1;
        } else if let Some(way) = way(outcome) {
            match places.entry(identity(outcome)) {
                Entry::Vacant(place) => {
                    place.insert(counted.len());
                    counted.push((outcome, way));
                }
                Entry::Occupied(place) => {
                    stored.asked_again += 1;
                    let before = &mut counted[*place.get()];
                    if is_answer(outcome) || !is_answer(before.0) {
                        *before = (outcome, way);
                    }
                }
            }
        } else {
            stored.unknown_ways += 1;
        }
    }
    stored.several_windows = several_windows(&counted);
    let statuses: Vec<AnswerStatus> = counted
        .par_iter()
        .map(|(outcome, _)| status(outcome))
        .collect();
    let keys: Vec<QuestionKey> = counted
        .par_iter()
        .map(|(outcome, _)| QuestionKey::from(*outcome))
        .collect();
    let mut references: HashMap<&QuestionKey, &Verdict> = HashMap::new();
    for (((_, way), status), key) in counted.iter().zip(&statuses).zip(&keys) {
        if let (AnswerStatus::Verdict(verdict), judge::MODEL) = (status, way.model.as_str()) {
            references.insert(key, verdict);
        }
    }
    if let Some(verdicts) = &truth.judge {
        references.extend(verdicts);
    }
    let references: Vec<Option<Verdict>> = keys
        .iter()
        .map(|key| references.get(key).map(|verdict| (*verdict).clone()))
        .collect();
    let mut of_batches: BTreeMap<String, u32> = BTreeMap::new();
    for batch in counted.iter().filter_map(|(one, _)| truth.batch_of(one)) {
        *of_batches.entry(batch.to_string()).or_default() += 1;
    }
    let truths: Vec<Option<Label>> = counted
        .iter()
        .zip(&statuses)
        .map(|((outcome, _), status)| truth.label(outcome, status.verdict()))
        .collect();
    stored.of_batches = of_batches;
    let mut unlabelled: Vec<String> = counted
        .iter()
        .zip(&truths)
        .filter(|(_, truth)| truth.is_none())
        .map(|((outcome, _), _)| outcome.scenario.clone())
        .collect();
    unlabelled.sort_unstable();
    unlabelled.dedup();
    stored.unlabelled = unlabelled;
    let parts = counted
        .into_iter()
        .zip(statuses)
        .zip(references)
        .zip(truths);
    stored.scored = parts
        .map(|((((outcome, way), status), reference), truth)| Scored {
            scenario: outcome.scenario.clone(),
            way,
            sample: outcome.sample,
            truth,
            status,
            reference,
            consumed: outcome.consumed,
            run: Some(outcome.run),
        })
        .collect();
    stored
}

/// Answers to first questions that were asked about a changed scene, as that leaves the words the same: under the
/// name of the scene as it is.
fn originals(outcomes: &[Outcome], asides: &SecondaryRuns) -> HashMap<RunId, Outcome> {
    let original = |one: &Outcome| match Transform::of_name(&one.scenario) {
        (name, Some(_)) if asides.first.contains(&one.run) => {
            let scenario = name.to_string();
            Some((
                one.run,
                Outcome {
                    scenario,
                    ..one.clone()
                },
            ))
        }
        _ => None,
    };
    outcomes.iter().filter_map(original).collect()
}

/// Whether a run is about a changed scene, of a batch or by the name that such scenes have.
fn is_changed(outcome: &Outcome, asides: &SecondaryRuns) -> bool {
    asides.changed.contains(&outcome.run) || Transform::of_name(&outcome.scenario).1.is_some()
}

/// Of how many scenarios one way of asking has answers to the safety task about several windows: each is a question of
/// its own, and all are counted.
fn several_windows(counted: &[(&Outcome, PromptConfig)]) -> u32 {
    let mut windows: BTreeMap<(&PromptConfig, &str), BTreeSet<(i64, i64)>> = BTreeMap::new();
    let safety = counted.iter().filter(|(_, way)| way.task == Task::Safety);
    for (outcome, way) in safety {
        let of_scenario = windows.entry((way, &outcome.scenario)).or_default();
        of_scenario.extend(outcome.window);
    }
    let several = windows.iter().filter(|(_, windows)| windows.len() > 1);
    let names: BTreeSet<&str> = several.map(|((_, name), _)| *name).collect();
    count(names.len())
}

/// Whether a run ended in a state that counts for its model.
fn is_over(state: RunState) -> bool {
    match state {
        RunState::Answered | RunState::Truncated | RunState::Failed => true,
        RunState::Running | RunState::Interrupted | RunState::Cancelled => false,
    }
}

/// Whether there is an answer, whatever it says.
fn is_answer(outcome: &Outcome) -> bool {
    outcome.state != RunState::Failed
}

/// Identifies runs that answer the same question with the same sample.
type Identity<'a> = (QuestionKey, [&'a str; 4], Option<Key>, u32);

fn identity(outcome: &Outcome) -> Identity<'_> {
    let how = [
        outcome.frame.as_str(),
        outcome.techniques.as_str(),
        outcome.model.as_str(),
        outcome.template.template_hash.as_str(),
    ];
    let key = outcome.key.clone();
    (QuestionKey::from(outcome), how, key, outcome.sample)
}

/// How a run was asked; `None` if its words are not known.
fn way(outcome: &Outcome) -> Option<PromptConfig> {
    let is_judge = outcome.model == judge::MODEL;
    let (frame, techniques) = match is_judge {
        true => (None, None),
        false => (
            Some(Frame::parse(&outcome.frame)?),
            Some(Techniques::parse(&outcome.techniques).ok()?),
        ),
    };
    Some(PromptConfig {
        task: outcome.task,
        frame,
        techniques,
        model: outcome.model.clone(),
        template: TemplateVersion::of(&outcome.template).filter(|_| !is_judge),
    })
}

fn status(outcome: &Outcome) -> AnswerStatus {
    let verdict = outcome.verdict.as_deref();
    // A verdict that could be read counts, however the answer ended.
    if let Some(verdict) = verdict.and_then(|json| serde_json::from_str::<Verdict>(json).ok()) {
        return AnswerStatus::Verdict(verdict);
    }
    let why = |text: &Option<String>| text.clone().unwrap_or_default();
    match outcome.state {
        RunState::Answered | RunState::Truncated => AnswerStatus::Unparsed(why(&outcome.reading)),
        _ => AnswerStatus::Failed(why(&outcome.error)),
    }
}

#[cfg(test)]
mod tests;
