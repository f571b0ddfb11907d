//! Runs of the store beside the truth.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::super::{Label, Labels, Said, Scored, Way};
use crate::judge;
use crate::prompts::Techniques;
use crate::store::{Outcome, RunState};
use crate::text::Frame;
use crate::verdict::{Task, Verdict};

/// What is true about scenarios, from several sources: the first that says something counts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Truth {
    /// Labels of people.
    pub labels: Labels,
    /// By name, worked out: of the exact geometry, or of the folder a scenario lies in.
    pub found: BTreeMap<String, Label>,
    /// Whether the built-in judge's stored verdicts on the collision task, the exact geometry of whole recordings,
    /// count where nothing else does.
    pub judged: bool,
}

/// Runs of the store beside the truth.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stored {
    /// Those that can be counted.
    pub scored: Vec<Scored>,
    /// Runs that are still arriving, were cancelled, or broke off with the program: no answers, and no failures.
    pub unfinished: u32,
    /// Runs to tasks that have no yes or no.
    pub other_tasks: u32,
    /// Runs that were asked in a way that this version does not know.
    pub unknown_ways: u32,
    /// Scenarios without a truth.
    pub unlabelled: Vec<String>,
}

/// Of one question: scenario, task and window.
type Question<'a> = (&'a str, &'a str, Task, Option<(i64, i64)>);

/// Sets runs beside the truth, in the order of the runs. The verdicts are those that were stored.
///
/// The built-in judge's verdict on a question is that of its run on the same file, task and, for safety, window.
#[must_use]
pub fn stored(outcomes: &[Outcome], truth: &Truth) -> Stored {
    let mut counted: Vec<(&Outcome, Way)> = Vec::with_capacity(outcomes.len());
    let mut stored = Stored::default();
    for outcome in outcomes {
        if !Task::VERDICTS.contains(&outcome.task) {
            stored.other_tasks += 1;
        } else if !is_over(outcome.state) {
            stored.unfinished += 1;
        } else if let Some(way) = way(outcome) {
            counted.push((outcome, way));
        } else {
            stored.unknown_ways += 1;
        }
    }
    let said: Vec<Said> = counted
        .par_iter()
        .map(|(outcome, _)| said(outcome))
        .collect();
    let mut references: HashMap<Question<'_>, &Verdict> = HashMap::new();
    let mut judged: HashMap<&str, Label> = HashMap::new();
    for ((outcome, way), said) in counted.iter().zip(&said) {
        let Said::Verdict(verdict) = said else {
            continue;
        };
        if way.model != judge::MODEL {
            continue;
        }
        references.insert(question(outcome), verdict);
        if outcome.task == Task::Collision {
            let label = match verdict.dangerous {
                true => Label::Collision(verdict.obstacles.first().map(|o| o.id)),
                false => Label::Safe,
            };
            judged.insert(&outcome.scenario, label);
        }
    }
    let label = |name: &str| {
        let found = truth
            .labels
            .of(name)
            .or_else(|| truth.found.get(name).copied());
        found.or_else(|| judged.get(name).copied().filter(|_| truth.judged))
    };
    let references: Vec<Option<Verdict>> = counted
        .iter()
        .map(|(outcome, _)| references.get(&question(outcome)).map(|v| (*v).clone()))
        .collect();
    let truths: Vec<Option<Label>> = counted.iter().map(|(o, _)| label(&o.scenario)).collect();
    let mut unlabelled: Vec<String> = counted
        .iter()
        .zip(&truths)
        .filter(|(_, truth)| truth.is_none())
        .map(|((outcome, _), _)| outcome.scenario.clone())
        .collect();
    unlabelled.sort_unstable();
    unlabelled.dedup();
    stored.unlabelled = unlabelled;
    let parts = counted.into_iter().zip(said).zip(references).zip(truths);
    stored.scored = parts
        .map(|((((outcome, way), said), reference), truth)| Scored {
            scenario: outcome.scenario.clone(),
            way,
            sample: outcome.sample,
            truth,
            said,
            reference,
            consumed: outcome.consumed,
            run: Some(outcome.run),
        })
        .collect();
    stored
}

/// Whether a run has come to an end that says something about its model.
fn is_over(state: RunState) -> bool {
    match state {
        RunState::Answered | RunState::Truncated | RunState::Failed => true,
        RunState::Running | RunState::Interrupted | RunState::Cancelled => false,
    }
}

fn question(outcome: &Outcome) -> Question<'_> {
    let window = match outcome.task {
        // The judge looks at the whole recording.
        Task::Collision => None,
        _ => outcome.window,
    };
    let hash = outcome.scenario_hash.as_deref().unwrap_or_default();
    (&outcome.scenario, hash, outcome.task, window)
}

/// How a run was asked; nothing where its words are not known.
fn way(outcome: &Outcome) -> Option<Way> {
    let is_judge = outcome.model == judge::MODEL;
    let (frame, techniques) = match is_judge {
        true => (None, None),
        false => (
            Some(Frame::parse(&outcome.frame)?),
            Some(Techniques::parse(&outcome.techniques).ok()?),
        ),
    };
    Some(Way {
        task: outcome.task,
        frame,
        techniques,
        model: outcome.model.clone(),
    })
}

fn said(outcome: &Outcome) -> Said {
    let verdict = outcome.verdict.as_deref();
    // A verdict that could be read counts, however the answer ended.
    if let Some(verdict) = verdict.and_then(|json| serde_json::from_str::<Verdict>(json).ok()) {
        return Said::Verdict(verdict);
    }
    let why = |text: &Option<String>| text.clone().unwrap_or_default();
    match outcome.state {
        RunState::Answered | RunState::Truncated => Said::Unparsed(why(&outcome.reading)),
        _ => Said::Failed(why(&outcome.error)),
    }
}
