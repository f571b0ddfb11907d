//! Tests of stored verdicts for lists of many scenarios.

use super::*;

#[test]
fn verdicts_are_the_newest_of_each_model_and_way_of_asking() {
    let store = Store::in_memory().unwrap();
    let first = answered(&store, &question(), "a");
    let other = |model: &str, techniques: &str| NewRun {
        model: model.into(),
        techniques: techniques.into(),
        ..question()
    };
    answered(&store, &other("local/x", "cot"), "b");
    answered(&store, &other("reference/geometry", "base"), "c");
    let elsewhere = NewRun {
        scenario: "ZAM_B-1".into(),
        scenario_hash: Some("other".into()),
        ..question()
    };
    answered(&store, &elsewhere, "d");
    let safe = Verdict {
        task: Task::Collision,
        dangerous: false,
        obstacles: vec![],
        justification: "it does not".into(),
    };
    let again = granted(&store, &question(), true);
    let ending = Ending {
        verdict: Some(ParsedAnswer::Verdict(safe)),
        ..Ending::bare(RunState::Answered)
    };
    store.finish(again, &ending).unwrap();
    let failed = granted(&store, &question(), true);
    store
        .finish(failed, &Ending::bare(RunState::Failed))
        .unwrap();
    let all = store.verdicts("reference/geometry", None).unwrap();
    assert_eq!(all.len(), 3);
    let mut here = store
        .verdicts("reference/geometry", Some(("h", "ZAM_A-1")))
        .unwrap();
    here.sort_by_key(|verdict| verdict.dangerous);
    let said: Vec<bool> = here.iter().map(|verdict| verdict.dangerous).collect();
    assert_eq!(said, [false, true], "the newest of base, and that of cot");
    assert_eq!(here[0].window, Some((3, 12)));
    store.delete(again, true).unwrap();
    store.delete(first, true).unwrap();
    let left = store.verdicts("reference/geometry", Some(("h", "ZAM_A-1")));
    assert_eq!(left.unwrap().len(), 1);
}
