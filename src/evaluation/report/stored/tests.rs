//! Tests of which stored runs are counted, and how.

use super::*;
use crate::store::{Consumed, Origin, StoredTemplate};

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
        template: StoredTemplate::default(),
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
    let mut truth = Truth::default();
    truth.add_stored_geometry(&runs);
    let stored = stored(&runs, &truth, &SecondaryRuns::default());
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
    let found = stored(&runs, &truth, &SecondaryRuns::default());
    let truths: Vec<_> = found.scored.iter().map(|s| s.truth).collect();
    let collision = Some(Label::Collision(Some(7)));
    assert_eq!(truths, [Some(Label::Safe), collision, None]);
    let counts = [("b1".to_string(), 1), ("b2".to_string(), 1)];
    assert_eq!(found.of_batches, BTreeMap::from(counts));
    truth.layout.insert("a".into(), Label::Safe);
    let found = stored(&runs, &truth, &SecondaryRuns::default());
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
    let asides = SecondaryRuns {
        leads: [RunId(2)].into(),
        changed: [RunId(3)].into(),
        first: [RunId(1), RunId(5), RunId(7)].into(),
    };
    // The words were the same, and the changed scene was asked about first.
    runs.push(Outcome {
        scenario: Transform::Mirror.name("c"),
        ..outcome(7, "lab/x", RunState::Answered, Some(true))
    });
    let found = stored(&runs, &Truth::default(), &asides);
    let counted: Vec<_> = found.scored.iter().map(|s| s.run.map(|r| r.0)).collect();
    assert_eq!(counted, [Some(1), Some(5), Some(6), Some(7)]);
    assert_eq!(found.scored[3].scenario, "c");
    assert_eq!((found.other_leads, found.changed), (1, 2));
    assert_eq!(found.unlabelled, ["a", "b", "c"]);
    assert_eq!(found.several_windows, 1, "of a, with runs 1 and 5");
}

#[test]
fn labels_of_people_count_before_the_judge() {
    let runs = [
        outcome(1, "lab/x", RunState::Answered, Some(false)),
        outcome(2, judge::MODEL, RunState::Answered, Some(true)),
    ];
    let mut truth = Truth::default();
    truth.add_stored_geometry(&runs);
    truth.layout.insert("a".into(), Label::Safe);
    assert_eq!(
        stored(&runs, &truth, &SecondaryRuns::default()).scored[0].truth,
        Some(Label::Safe)
    );
    let unlabelled = stored(&runs, &Truth::default(), &SecondaryRuns::default());
    assert_eq!(unlabelled.unlabelled, ["a"]);
}
