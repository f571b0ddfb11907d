//! Tests of ground truths that batches store for runs.

use super::super::items::tests::item;
use super::*;

#[test]
fn of_several_batches_the_one_that_asked_says_what_is_true() {
    let store = Store::in_memory().unwrap();
    let safe = NewItem {
        collides: Some(false),
        obstacle: None,
        ..item("A", 0)
    };
    let changed = NewItem {
        transform: Some("mirror".into()),
        ..item("A", 1)
    };
    let first = store.begin_batch("{}", None, &[safe, changed]).unwrap();
    let second = store.begin_batch("{}", None, &[item("A", 0)]).unwrap();
    let mut asked = question();
    asked.batch = Some(second.to_string());
    let run = answered(&store, &asked, "yes");
    for (batch, place) in [(first, 0), (first, 1), (second, 0)] {
        store
            .set_item(batch, place, None, ItemState::Answered, Some(run), None)
            .unwrap();
    }
    let told = RunLabel {
        task: Task::Collision,
        run,
        batch: second,
        collides: true,
        obstacle: Some(7),
        drawn: false,
        facts: None,
    };
    assert_eq!(store.truths().unwrap(), [told]);
}
