//! Tests of stored verdicts for lists of many scenarios.

use super::*;

#[test]
fn every_verdict_counts_but_those_that_another_answer_supersedes() {
    let store = Store::in_memory().unwrap();
    let first = answered(&store, &question(), "a");
    let other = |model: &str, techniques: &str| NewRun {
        model: model.into(),
        techniques: techniques.into(),
        messages: format!(r#"[{{"role":"user","content":"{techniques}"}}]"#),
        ..question()
    };
    answered(&store, &other("local/x", "cot"), "b");
    answered(&store, &other("reference/geometry", "base"), "c");
    // The same model, asked the same way with an edited template.
    let edited = NewRun {
        template_hash: "edited".into(),
        messages: r#"[{"role":"user","content":"edited"}]"#.into(),
        ..question()
    };
    let edited = answered(&store, &edited, "e");
    let elsewhere = NewRun {
        scenario: "ZAM_B-1".into(),
        scenario_hash: Some("other".into()),
        messages: r#"[{"role":"user","content":"elsewhere"}]"#.into(),
        ..question()
    };
    answered(&store, &elsewhere, "d");
    let safe = Verdict {
        task: Task::Collision,
        dangerous: false,
        obstacles: vec![],
        justification: "it does not".into(),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
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
    assert_eq!(all.len(), 4);
    let mut here = store
        .verdicts("reference/geometry", Some(("h", "ZAM_A-1")))
        .unwrap();
    here.sort_by_key(|verdict| verdict.dangerous);
    let said: Vec<bool> = here.iter().map(|verdict| verdict.dangerous).collect();
    assert_eq!(
        said,
        [false, true, true],
        "the newer of the same request, the edited one, that of cot"
    );
    assert_eq!(here[0].window, Some((3, 12)));
    store.delete(again, true).unwrap();
    store.delete(first, true).unwrap();
    store.delete(edited, true).unwrap();
    let left = store.verdicts("reference/geometry", Some(("h", "ZAM_A-1")));
    assert_eq!(left.unwrap().len(), 1);
}
