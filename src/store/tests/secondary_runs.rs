//! Tests of secondary runs: other leads and changed scenes.

use super::super::items::tests::item;
use super::*;

#[test]
fn other_leads_and_changed_scenes_are_told_from_first_questions() {
    let store = Store::in_memory().unwrap();
    let asked = |lead: Option<&str>, change: Option<&str>| NewItem {
        task: Task::Safety,
        lead: lead.map(Into::into),
        transform: change.map(Into::into),
        key: None,
        ..item("A", 0)
    };
    let half = Some("0.5");
    let begun = [
        asked(half, None),
        asked(Some("1"), None),
        asked(half, Some("mirror")),
        // The words are those of the first question: it is not asked again.
        asked(half, Some("rotate:90")),
    ];
    let first = store.begin_batch("{}", None, &begun).unwrap();
    // Leads were added to a batch without one.
    let later = [asked(None, None), asked(half, None)];
    let second = store.begin_batch("{}", None, &later).unwrap();
    let runs: Vec<RunId> = (0..5)
        .map(|_| answered(&store, &question(), "yes"))
        .collect();
    for (batch, place, run) in [
        (first, 0, 0),
        (first, 1, 1),
        (first, 2, 2),
        (first, 3, 0),
        (second, 0, 3),
        (second, 1, 4),
    ] {
        let (state, run) = (ItemState::Answered, Some(runs[run]));
        store
            .set_item(batch, place, None, state, run, None)
            .unwrap();
    }
    let wanted = SecondaryRuns {
        leads: [runs[1], runs[4]].into(),
        changed: [runs[2]].into(),
        first: [runs[0], runs[3]].into(),
        ..SecondaryRuns::default()
    };
    assert_eq!(store.asides().unwrap(), wanted);
    // Another batch asks at that lead first.
    let third = store.begin_batch("{}", None, &[asked(None, None)]).unwrap();
    store
        .set_item(third, 0, None, ItemState::Answered, Some(runs[1]), None)
        .unwrap();
    assert_eq!(store.asides().unwrap().leads, [runs[4]].into());
}

#[test]
fn an_answer_to_the_same_request_is_known_by_its_key() {
    let store = Store::in_memory().unwrap();
    let run = answered(&store, &question(), "yes");
    let key = store.run(run).unwrap().unwrap().key;
    assert!(key.is_some());
    let changed = NewItem {
        transform: Some("mirror".into()),
        key: key.clone(),
        ..item("A", 0)
    };
    store.begin_batch("{}", None, &[changed]).unwrap();
    assert_eq!(store.asides().unwrap().changed, [run].into());
    let plain = NewItem {
        key,
        ..item("A", 0)
    };
    store.begin_batch("{}", None, &[plain]).unwrap();
    let first = SecondaryRuns {
        first: [run].into(),
        ..SecondaryRuns::default()
    };
    assert_eq!(store.asides().unwrap(), first);
}
