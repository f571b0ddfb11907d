//! Runs of the store beside the truth.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use rayon::prelude::*;

use super::super::{Label, Labels, Said, Scored, Way};
use super::consumption::count;
use crate::judge;
use crate::prompts::Techniques;
use crate::scenario::Transform;
use crate::store::{Asides, Key, Outcome, RunId, RunState};
use crate::text::Frame;
use crate::verdict::{Task, Verdict};

/// What is true about scenarios, from several sources: the first that says something counts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Truth {
    /// Labels of people.
    pub labels: Labels,
    /// What batches say of their scenarios, by run, with the name of the batch.
    pub of_batches: HashMap<RunId, (String, Label)>,
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

/// Of one question: scenario, task and window.
type Question<'a> = (&'a str, &'a str, Task, Option<(i64, i64)>);

/// Sets runs beside the truth, in the order of the runs. The verdicts are those that were stored.
///
/// Where the same question was asked again, for the same sample, the newest whole answer counts, and without one the
/// newest failure. Other leads and changed scenes of batches are other questions, and are left out as in the report of
/// a batch. The built-in judge's verdict on a question is that of its run on the same file, task and, for safety, window.
#[must_use]
pub fn stored(outcomes: &[Outcome], truth: &Truth, asides: &Asides) -> Stored {
    let mut counted: Vec<(&Outcome, Way)> = Vec::with_capacity(outcomes.len());
    let mut stored = Stored::default();
    let mut places: HashMap<Identity<'_>, usize> = HashMap::with_capacity(outcomes.len());
    for outcome in outcomes {
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
    let mut of_batches: BTreeMap<String, u32> = BTreeMap::new();
    let mut label = |outcome: &Outcome| {
        let name = outcome.scenario.as_str();
        if let Some(label) = truth.labels.of(name) {
            return Some(label);
        }
        if let Some((batch, label)) = truth.of_batches.get(&outcome.run) {
            *of_batches.entry(batch.clone()).or_default() += 1;
            return Some(*label);
        }
        let found = truth.found.get(name).copied();
        found.or_else(|| judged.get(name).copied().filter(|_| truth.judged))
    };
    let references: Vec<Option<Verdict>> = counted
        .iter()
        .map(|(outcome, _)| references.get(&question(outcome)).map(|v| (*v).clone()))
        .collect();
    let truths: Vec<Option<Label>> = counted.iter().map(|(o, _)| label(o)).collect();
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

/// Whether a run is about a changed scene, of a batch or by the name that such scenes have.
fn is_changed(outcome: &Outcome, asides: &Asides) -> bool {
    asides.changed.contains(&outcome.run) || Transform::of_name(&outcome.scenario).1.is_some()
}

/// Of how many scenarios one way of asking has answers to the safety task about several windows: each is a question of
/// its own, and all are counted.
fn several_windows(counted: &[(&Outcome, Way)]) -> u32 {
    let mut windows: BTreeMap<(&Way, &str), BTreeSet<(i64, i64)>> = BTreeMap::new();
    let safety = counted.iter().filter(|(_, way)| way.task == Task::Safety);
    for (outcome, way) in safety {
        let of_scenario = windows.entry((way, &outcome.scenario)).or_default();
        of_scenario.extend(outcome.window);
    }
    let several = windows.iter().filter(|(_, windows)| windows.len() > 1);
    let names: BTreeSet<&str> = several.map(|((_, name), _)| *name).collect();
    count(names.len())
}

/// Whether a run has come to an end that says something about its model.
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

/// What makes two runs answers to the same question and of the same sample.
type Identity<'a> = (Question<'a>, &'a str, [&'a str; 3], Option<Key>, u32);

fn identity(outcome: &Outcome) -> Identity<'_> {
    let how = [
        outcome.frame.as_str(),
        outcome.techniques.as_str(),
        outcome.model.as_str(),
    ];
    let key = outcome.key.clone();
    (question(outcome), &outcome.ego, how, key, outcome.sample)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::{Consumed, Origin};

    fn outcome(run: i64, model: &str, state: RunState, collision: Option<bool>) -> Outcome {
        let verdict = |yes: bool| {
            serde_json::json!({"task": "collision", "collision": yes, "obstacles": [], "justification": ""}).to_string()
        };
        Outcome {
            run: RunId(run),
            key: None,
            scenario: "a".into(),
            scenario_hash: None,
            ego: "1".into(),
            origin: Origin::Asked,
            source: None,
            task: Task::Collision,
            frame: "ego".into(),
            techniques: "cp".into(),
            window: None,
            model: model.into(),
            sample: 0,
            state,
            verdict: collision.map(verdict),
            reading: None,
            error: None,
            consumed: Consumed::default(),
        }
    }

    #[test]
    fn a_question_that_was_asked_again_counts_once() {
        let runs = [
            outcome(1, "lab/x", RunState::Failed, None),
            outcome(2, "lab/x", RunState::Answered, Some(false)),
            outcome(3, "lab/x", RunState::Answered, Some(true)),
            outcome(4, "lab/x", RunState::Failed, None),
            outcome(5, "lab/x", RunState::Cancelled, None),
            outcome(6, "lab/y", RunState::Failed, None),
            outcome(7, judge::MODEL, RunState::Answered, Some(true)),
        ];
        let truth = Truth {
            judged: true,
            ..Truth::default()
        };
        let stored = stored(&runs, &truth, &Asides::default());
        let counted: Vec<_> = stored.scored.iter().map(|s| s.run.map(|r| r.0)).collect();
        assert_eq!(counted, [Some(3), Some(6), Some(7)]);
        assert_eq!((stored.asked_again, stored.unfinished), (3, 1));
        // The judge's own answer to the collision task is the exact geometry.
        let first = &stored.scored[0];
        assert_eq!(first.truth, Some(Label::Collision(None)));
        assert!(first.reference.as_ref().is_some_and(|v| v.dangerous));
    }

    #[test]
    fn an_answer_of_a_batch_is_held_against_the_truth_of_that_batch() {
        let of = |run| Outcome {
            model: format!("lab/{run}"),
            ..outcome(run, "", RunState::Answered, Some(true))
        };
        let runs = [of(1), of(2), of(3)];
        let mut truth = Truth::default();
        let mut tell =
            |run, batch: &str, label| truth.of_batches.insert(RunId(run), (batch.into(), label));
        tell(1, "b1", Label::Safe);
        tell(2, "b2", Label::Collision(Some(7)));
        let found = stored(&runs, &truth, &Asides::default());
        let truths: Vec<_> = found.scored.iter().map(|s| s.truth).collect();
        let collision = Some(Label::Collision(Some(7)));
        assert_eq!(truths, [Some(Label::Safe), collision, None]);
        let counts = [("b1".to_string(), 1), ("b2".to_string(), 1)];
        assert_eq!(found.of_batches, BTreeMap::from(counts));
        truth.found.insert("a".into(), Label::Safe);
        let found = stored(&runs, &truth, &Asides::default());
        assert_eq!(
            found.scored[1].truth, collision,
            "the batch's own counts first"
        );
        assert_eq!(found.scored[2].truth, Some(Label::Safe));
    }

    #[test]
    fn other_leads_and_changed_scenes_are_other_questions() {
        let mut runs: Vec<Outcome> = (1..=6)
            .map(|run| Outcome {
                task: Task::Safety,
                window: Some((run, run + 9)),
                ..outcome(run, "lab/x", RunState::Answered, Some(true))
            })
            .collect();
        // Asked in the workbench, without a batch.
        runs[3].scenario = Transform::Mirror.name("a");
        runs[5].scenario = "b".into();
        let asides = Asides {
            leads: [RunId(2)].into(),
            changed: [RunId(3)].into(),
        };
        let found = stored(&runs, &Truth::default(), &asides);
        let counted: Vec<_> = found.scored.iter().map(|s| s.run.map(|r| r.0)).collect();
        assert_eq!(counted, [Some(1), Some(5), Some(6)]);
        assert_eq!((found.other_leads, found.changed), (1, 2));
        assert_eq!(found.unlabelled, ["a", "b"]);
        assert_eq!(found.several_windows, 1, "of a, with runs 1 and 5");
    }

    #[test]
    fn labels_of_people_count_before_the_judge() {
        let runs = [
            outcome(1, "lab/x", RunState::Answered, Some(false)),
            outcome(2, judge::MODEL, RunState::Answered, Some(true)),
        ];
        let mut truth = Truth {
            judged: true,
            ..Truth::default()
        };
        truth.found.insert("a".into(), Label::Safe);
        assert_eq!(
            stored(&runs, &truth, &Asides::default()).scored[0].truth,
            Some(Label::Safe)
        );
        let nobody = stored(&runs, &Truth::default(), &Asides::default());
        assert_eq!(nobody.unlabelled, ["a"]);
    }
}
