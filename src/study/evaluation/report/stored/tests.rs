//! Tests of which stored runs are counted, and how.
#![allow(clippy::unwrap_used)]

use super::super::truth::BatchTruth;
use super::*;
use nearmiss_store::{Consumed, Origin, RunState, StoredTemplate};

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
        with_tools: false,
        state,
        verdict: collision.map(verdict),
        reading: None,
        error: None,
        finish: None,
        most_usd: None,
        consumed: Consumed::default(),
        claims: nearmiss_store::ClaimCounts::default(),
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
    assert_eq!((stored.asked_again, stored.unfinished), (4, 0));
    assert_eq!(stored.scored[0].superseded.len(), 4, "all were paid for");
    // The judge's own answer to the collision task is the exact geometry.
    let first = &stored.scored[0];
    assert_eq!(first.truth, Some(Label::Collision(None)));
    assert!(first.reference.as_ref().is_some_and(|v| v.dangerous));
}

#[test]
fn a_cut_answer_counts_as_failed_whatever_it_says_and_what_was_cancelled_as_not_asked() {
    let cut = |finish: &str, model: &str| Outcome {
        finish: Some(finish.into()),
        ..outcome(1, model, RunState::Truncated, Some(true))
    };
    let runs = [
        cut("length", "lab/a"),
        cut("content_filter", "lab/b"),
        outcome(1, "lab/c", RunState::Cancelled, None),
        outcome(1, "lab/d", RunState::Answered, None),
    ];
    let found = stored(&runs, &Truth::default(), &SecondaryRuns::default());
    let status = |place: usize| &found.scored[place].status;
    for (place, why) in [(0, "token limit"), (1, "content filter")] {
        assert!(
            matches!(status(place), AnswerStatus::Failed(said) if said.contains(why)),
            "{:?}",
            status(place)
        );
    }
    assert!(matches!(status(2), AnswerStatus::Unasked(_)));
    assert!(matches!(status(3), AnswerStatus::Unparsed(_)));
    assert_eq!(found.unfinished, 1);
}

fn told(run: i64, batch: &str, label: Label, critical: &[i64]) -> (RunId, BatchTruth) {
    let truth = BatchTruth {
        by_score: false,
        batch: batch.into(),
        label,
        critical: critical.to_vec(),
    };
    (RunId(run), truth)
}

#[test]
fn a_drawn_window_has_its_own_truth_whatever_is_said_of_its_scenario() {
    let early = Outcome {
        task: Task::Safety,
        window: Some((0, 9)),
        ..outcome(1, "lab/x", RunState::Answered, Some(true))
    };
    let runs = [
        early.clone(),
        Outcome {
            run: RunId(2),
            window: Some((40, 49)),
            ..early.clone()
        },
        Outcome {
            run: RunId(3),
            window: Some((50, 59)),
            ..early
        },
    ];
    let collision = Label::Collision(Some(7));
    let mut truth = Truth::default();
    truth
        .labels
        .read(b"scenario,obstacle_id\na,8\n", "truth.csv")
        .unwrap();
    truth.layout.insert("a".into(), Label::Collision(None));
    let of = |truth: &Truth| {
        let found = stored(&runs, truth, &SecondaryRuns::default());
        let truths: Vec<_> = found
            .scored
            .iter()
            .map(|s| (s.truth, s.critical.clone()))
            .collect();
        (truths, found.of_batches)
    };
    let labelled = (Some(Label::Collision(Some(8))), vec![8]);
    assert_eq!(
        of(&truth).0,
        vec![labelled.clone(); 3],
        "no window was drawn"
    );
    truth.windows = [
        told(1, "b1", Label::Safe, &[]),
        told(2, "b1", collision, &[7, 9]),
    ]
    .into();
    let (truths, batches) = of(&truth);
    let drawn = [(Some(Label::Safe), vec![]), (Some(collision), vec![7, 9])];
    assert_eq!(truths, [&drawn[..], &[labelled]].concat());
    assert_eq!(batches, BTreeMap::from([("b1".to_string(), 2)]));
}

#[test]
fn drawn_windows_of_the_collision_task_are_questions_of_their_own() {
    let judged = |run, window| Outcome {
        window: Some(window),
        ..outcome(run, judge::MODEL, RunState::Answered, Some(false))
    };
    let runs = [judged(1, (0, 9)), judged(2, (20, 29)), judged(3, (30, 39))];
    let counted = |truth: &Truth| {
        let found = stored(&runs, truth, &SecondaryRuns::default());
        (found.scored.len(), found.asked_again)
    };
    let mut truth = Truth::default();
    assert_eq!(counted(&truth), (1, 2), "one recording");
    truth.windows = [
        told(1, "b1", Label::Safe, &[]),
        told(2, "b1", Label::Safe, &[]),
    ]
    .into();
    assert_eq!(counted(&truth), (3, 0));
}

#[test]
fn an_answer_of_a_batch_is_held_against_the_truth_of_that_batch() {
    let of = |run| Outcome {
        model: format!("lab/{run}"),
        ..outcome(run, "", RunState::Answered, Some(true))
    };
    let runs = [of(1), of(2), of(3)];
    let mut truth = Truth {
        of_batches: [
            told(1, "b1", Label::Safe, &[]),
            told(2, "b2", Label::Collision(Some(7)), &[7]),
        ]
        .into(),
        ..Truth::default()
    };
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
        settings: [(RunId(6), "effort low".to_string())].into(),
        locked: [RunId(8)].into(),
    };
    // Of a test split that is not complete.
    runs.push(outcome(8, "lab/x", RunState::Answered, Some(true)));
    // The words were the same, and the changed scene was asked about first.
    runs.push(Outcome {
        scenario: Transform::Mirror.name("c"),
        ..outcome(7, "lab/x", RunState::Answered, Some(true))
    });
    let found = stored(&runs, &Truth::default(), &asides);
    let counted: Vec<_> = found.scored.iter().map(|s| s.run.map(|r| r.0)).collect();
    assert_eq!(counted, [Some(1), Some(5), Some(6), Some(7)]);
    assert_eq!(found.scored[3].scenario, "c");
    let settings = |place: usize| found.scored[place].configuration.settings.to_stored();
    assert_eq!(settings(2).as_deref(), Some("effort low"));
    assert_eq!((settings(1), found.locked), (None, 1));
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

#[test]
fn answers_with_tools_are_a_way_of_their_own_whatever_their_batches_say() {
    let with_tools = Outcome {
        with_tools: true,
        key: Some(Key::digest(&"b".into())),
        ..outcome(2, "lab/x", RunState::Answered, Some(true))
    };
    let runs = [
        outcome(1, "lab/x", RunState::Answered, Some(true)),
        with_tools,
        outcome(3, "lab/y", RunState::Answered, Some(true)),
        outcome(4, judge::MODEL, RunState::Answered, Some(true)),
    ];
    let tools = |runs: &[Outcome], of_axes: &[(i64, &str)]| -> Vec<Option<bool>> {
        let settings = of_axes
            .iter()
            .map(|(run, said)| (RunId(*run), (*said).into()));
        let asides = SecondaryRuns {
            settings: settings.collect(),
            ..SecondaryRuns::default()
        };
        let found = stored(runs, &Truth::default(), &asides);
        let each = found
            .scored
            .iter()
            .map(|one| one.configuration.settings.tools);
        each.collect()
    };
    let apart = [Some(false), Some(true), Some(false), None];
    assert_eq!(tools(&runs, &[]), apart);
    assert_eq!(tools(&runs, &[(2, "tools on"), (3, "tools off")]), apart);
    let without = [runs[0].clone(), runs[2].clone(), runs[3].clone()];
    assert_eq!(tools(&without, &[]), [None; 3]);
}
