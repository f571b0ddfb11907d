//! Stored runs compared with the ground truth.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use rayon::prelude::*;

use super::super::{
    AnswerState, AnswerStatus, Attempt, AxisValues, Cluster, CountedAs, Label, PromptConfig,
    Scored, TemplateVersion,
};
use super::cell::count;
use super::truth::{QuestionKey, Truth};
use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{Key, Outcome, RunId, SecondaryRuns, attempt_rank};

/// Runs of the store beside the truth.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stored {
    /// Those that can be counted.
    pub scored: Vec<Scored>,
    /// Of those that can be counted, questions whose answers are still arriving, were cancelled, or broke off with the
    /// program: they count as not asked.
    pub unfinished: u32,
    /// Runs in whose place another one counts, see [`stored`]; what they cost is with that one.
    pub asked_again: u32,
    /// Runs to tasks that have no yes or no.
    pub other_tasks: u32,
    /// Runs that were asked in a way that this version does not know.
    pub unknown_ways: u32,
    /// Answers to questions of a test split that is not complete.
    pub locked: u32,
    /// Runs at other leads than the first one of their batch.
    pub other_leads: u32,
    /// Runs about changed scenes.
    pub changed: u32,
    /// Scenarios that one way of asking was asked about with several windows in the safety task.
    pub several_windows: u32,
    /// Answers beside the truth of their batch, by batch.
    pub of_batches: BTreeMap<String, u32>,
    /// Scenarios of answers without a truth.
    pub unlabelled: Vec<String>,
    /// How many answers these are.
    pub without_truth: u32,
}

impl Stored {
    /// Which runs are not counted, and how many: `30 repeats of a question, …`; and what command shows them.
    #[must_use]
    pub fn left_out(&self) -> Vec<(String, Option<&'static str>)> {
        let all = [
            (
                self.asked_again,
                "repeats of a question, one of whose answers counts; their costs are counted",
                None,
            ),
            (self.other_tasks, "of tasks without a yes or no", None),
            (
                self.unknown_ways,
                "with a frame or techniques unknown to this version",
                None,
            ),
            (
                self.other_leads,
                "at further leads of their batch",
                Some("`nearmiss evaluate BATCH` shows them"),
            ),
            (
                self.locked,
                "of test splits that are not complete",
                Some("`nearmiss report --batch ID` shows how far they are"),
            ),
            (
                self.changed,
                "about transformed scenes",
                Some("`nearmiss evaluate BATCH` shows them"),
            ),
        ];
        let some = all.into_iter().filter(|(count, ..)| *count > 0);
        some.map(|(count, what, shown)| (format!("{count} {what}"), shown))
            .collect()
    }
}

/// Sets runs beside the truth, in the order of the runs. The verdicts are those that were stored.
///
/// Where the same question was asked again, for the same sample, one attempt counts, see `attempt_rank`, and what the others
/// cost is added to it. A question whose attempts were all cancelled or interrupted, or are arriving, counts as not
/// asked. Other leads and changed scenes of batches are other questions, and are left out as in the report of
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
    let mut stored = Stored::default();
    let mut questions: Vec<Attempts<'_>> = Vec::with_capacity(outcomes().len());
    let mut places: HashMap<Identity<'_>, usize> = HashMap::with_capacity(outcomes().len());
    for outcome in outcomes() {
        if !Task::VERDICTS.contains(&outcome.task) {
            stored.other_tasks += 1;
        } else if asides.locked.contains(&outcome.run) {
            stored.locked += 1;
        } else if is_changed(outcome, asides) {
            stored.changed += 1;
        } else if asides.leads.contains(&outcome.run) {
            stored.other_leads += 1;
        } else if let Some(configuration) =
            configuration(outcome, asides.settings.get(&outcome.run))
        {
            match places.entry(identity(outcome, truth)) {
                Entry::Vacant(place) => {
                    place.insert(questions.len());
                    questions.push(Attempts::first(outcome, configuration));
                }
                Entry::Occupied(place) => {
                    stored.asked_again += 1;
                    questions[*place.get()].take(outcome);
                }
            }
        } else {
            stored.unknown_ways += 1;
        }
    }
    let (counted, superseded): (Vec<(&Outcome, PromptConfig)>, Vec<Vec<Attempt>>) = questions
        .into_iter()
        .map(|one| ((one.counts, one.configuration), one.superseded))
        .unzip();
    let counted = tools_told_apart(counted);
    stored.several_windows = several_windows(&counted);
    let statuses: Vec<AnswerStatus> = counted
        .par_iter()
        .map(|(outcome, _)| status(outcome))
        .collect();
    let unfinished = statuses
        .iter()
        .filter(|one| matches!(one, AnswerStatus::Unasked(_)));
    stored.unfinished = count(unfinished.count());
    let keys: Vec<QuestionKey> = counted
        .par_iter()
        .map(|(outcome, _)| QuestionKey::from(*outcome))
        .collect();
    let mut references: HashMap<&QuestionKey, &Verdict> = HashMap::new();
    for (((_, configuration), status), key) in counted.iter().zip(&statuses).zip(&keys) {
        if let (AnswerStatus::Verdict(verdict), judge::MODEL) =
            (status, configuration.model.as_str())
        {
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
    for batch in counted
        .iter()
        .filter_map(|(one, _)| truth.deciding_batch(one))
    {
        *of_batches.entry(batch.to_string()).or_default() += 1;
    }
    let truths: Vec<Option<(Label, Vec<i64>)>> = counted
        .iter()
        .map(|(outcome, _)| truth.lookup(outcome))
        .collect();
    stored.of_batches = of_batches;
    let mut unlabelled: Vec<String> = counted
        .iter()
        .zip(&truths)
        .filter(|(_, truth)| truth.is_none())
        .map(|((outcome, _), _)| outcome.scenario.clone())
        .collect();
    stored.without_truth = count(unlabelled.len());
    unlabelled.sort_unstable();
    unlabelled.dedup();
    stored.unlabelled = unlabelled;
    let parts = counted
        .into_iter()
        .zip(statuses)
        .zip(references)
        .zip(truths)
        .zip(superseded);
    stored.scored = parts
        .map(
            |(((((outcome, configuration), status), reference), truth), superseded)| {
                let (truth, critical) = truth.unzip();
                Scored {
                    scenario: outcome.scenario.clone(),
                    configuration,
                    sample: outcome.sample,
                    truth,
                    critical: critical.unwrap_or_default(),
                    status,
                    reference,
                    window: QuestionKey::window(outcome.task, outcome.window),
                    consumed: outcome.consumed,
                    most_usd: outcome.most_usd,
                    superseded,
                    run: Some(outcome.run),
                    claims: outcome.claims,
                    cluster: Cluster::default(),
                }
            },
        )
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
    let safety = counted
        .iter()
        .filter(|(_, configuration)| configuration.task == Task::Safety);
    for (outcome, configuration) in safety {
        let of_scenario = windows
            .entry((configuration, &outcome.scenario))
            .or_default();
        of_scenario.extend(outcome.window);
    }
    let several = windows.iter().filter(|(_, windows)| windows.len() > 1);
    let names: BTreeSet<&str> = several.map(|((_, name), _)| *name).collect();
    count(names.len())
}

/// The attempts at one question.
struct Attempts<'a> {
    counts: &'a Outcome,
    configuration: PromptConfig,
    superseded: Vec<Attempt>,
}

impl<'a> Attempts<'a> {
    fn first(counts: &'a Outcome, configuration: PromptConfig) -> Self {
        Self {
            counts,
            configuration,
            superseded: Vec::new(),
        }
    }

    fn take(&mut self, mut other: &'a Outcome) {
        let place = |one: &Outcome| (attempt_rank(one.state), one.run);
        if place(other) > place(self.counts) {
            std::mem::swap(&mut self.counts, &mut other);
        }
        self.superseded.push(Attempt {
            consumed: other.consumed,
            most_usd: other.most_usd,
        });
    }
}

/// Identifies runs that answer the same question with the same sample.
type Identity<'a> = (
    QuestionKey,
    [&'a str; 4],
    Option<Key>,
    Option<(i64, i64)>,
    u32,
);

fn identity<'a>(outcome: &'a Outcome, truth: &Truth) -> Identity<'a> {
    let how = [
        outcome.frame.as_str(),
        outcome.techniques.as_str(),
        outcome.model.as_str(),
        outcome.template.template_hash.as_str(),
    ];
    let key = outcome.key.clone();
    // The key tells windows apart. The built-in judge has none: drawn windows are questions of their own to it, too, also
    // of the collision task.
    let drawn = key.is_none() && truth.windows.contains_key(&outcome.run);
    let window = outcome.window.filter(|_| drawn);
    (QuestionKey::from(outcome), how, key, window, outcome.sample)
}

/// How a run was asked, under these values of axes of its batch; `None` if its words are not known.
fn configuration(outcome: &Outcome, settings: Option<&String>) -> Option<PromptConfig> {
    let settings = settings
        .map(|words| words.parse::<AxisValues>())
        .transpose()
        .ok()?;
    let is_judge = outcome.model == judge::MODEL;
    let (frame, techniques) = if is_judge {
        (None, None)
    } else {
        (
            Some(Frame::parse(&outcome.frame)?),
            Some(Techniques::parse(&outcome.techniques).ok()?),
        )
    };
    Some(PromptConfig {
        task: outcome.task,
        frame,
        techniques,
        model: outcome.model.clone(),
        settings: settings.unwrap_or_default(),
        template: TemplateVersion::from_stored(&outcome.template).filter(|_| !is_judge),
    })
}

/// Where some answers were given with tools, all ways say whether theirs were: batches whose questions all had tools, or
/// none, do not say it.
fn tools_told_apart(mut counted: Vec<(&Outcome, PromptConfig)>) -> Vec<(&Outcome, PromptConfig)> {
    if counted.iter().any(|(outcome, _)| outcome.with_tools) {
        let asked = counted
            .iter_mut()
            .filter(|(_, configuration)| configuration.frame.is_some());
        for (outcome, configuration) in asked {
            configuration
                .settings
                .tools
                .get_or_insert(outcome.with_tools);
        }
    }
    counted
}

fn status(outcome: &Outcome) -> AnswerStatus {
    let verdict = outcome
        .verdict
        .as_deref()
        .and_then(|json| serde_json::from_str::<Verdict>(json).ok());
    let finish = outcome.finish.as_deref();
    let state = AnswerState::of_run(outcome.state, finish, verdict.is_some());
    let why = |said: &Option<String>| said.clone().unwrap_or_else(|| state.reason(finish).into());
    match (state.counted_as(), verdict) {
        (CountedAs::Verdict, Some(verdict)) => AnswerStatus::Verdict(verdict),
        (CountedAs::Verdict | CountedAs::Unparsed, _) => {
            AnswerStatus::Unparsed(why(&outcome.reading))
        }
        (CountedAs::Failed | CountedAs::Nothing, _) => AnswerStatus::Failed(why(&outcome.error)),
        (CountedAs::Unasked, _) => AnswerStatus::Unasked(why(&outcome.error)),
    }
}

#[cfg(test)]
mod tests;
