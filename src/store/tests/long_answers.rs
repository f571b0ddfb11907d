//! Tests of reading long and deleted answers for display.

use super::*;

#[test]
fn long_texts_of_old_stores_are_shortened_to_be_looked_at_and_whole_for_export() {
    let store = Store::in_memory().unwrap();
    let text = "é".repeat(MOST_SHOWN);
    let id = answered(&store, &question(), &text);
    let whole = store.run(id).unwrap().unwrap();
    assert_eq!(whole.answer.len(), text.len());
    let question = question();
    let listed = store.of_scenario("h", &question.scenario, question.task, 9);
    let shown = store.run_shown(id).unwrap().unwrap();
    let replayed = store.answer_to(&question).unwrap().unwrap();
    for run in [&listed.unwrap()[0], &shown, &replayed] {
        assert!(run.answer.len() < MOST_SHOWN + 200, "{}", run.answer.len());
        let (_, end) = run.answer.rsplit_once('\n').unwrap();
        let said = format!("{} bytes are in the store", text.len());
        assert!(end.contains(&said) && end.contains("runs show"), "{end}");
        assert_eq!(run.ending, whole.ending, "the verdict is that of the whole");
    }
}

#[test]
fn many_long_texts_are_shortened_more() {
    let store = Store::in_memory().unwrap();
    let text = "x".repeat(MOST_SHOWN);
    for _ in 0..8 {
        answered(&store, &question(), &text);
    }
    let question = question();
    let runs = store
        .of_scenario("h", &question.scenario, question.task, 9)
        .unwrap();
    let bytes: usize = runs.iter().map(|run| run.answer.len()).sum();
    assert_eq!(runs.len(), 8);
    assert!(bytes < 5 * MOST_SHOWN, "{bytes}");
    assert_eq!(runs[0].answer, text, "the newest is there as it is");
}

#[test]
fn the_question_of_a_deleted_answer_waits_again() {
    let store = Store::in_memory().unwrap();
    let item = |sample| NewItem {
        key: question().key(),
        ..crate::items::tests::item("A", sample)
    };
    let keyless = NewItem {
        key: None,
        ..item(1)
    };
    let batch = store.begin_batch("{}", None, &[item(0), keyless]).unwrap();
    let run = answered(&store, &question(), "yes");
    let key = question().key();
    for (place, key) in [(0, key.as_ref()), (1, None)] {
        let state = ItemState::Answered;
        store
            .set_item(batch, place, key, state, Some(run), None)
            .unwrap();
    }
    let states = || {
        let items = store.items(batch).unwrap();
        let again = store.items_with_answers(batch).unwrap();
        assert!(again.iter().map(|(item, _)| item).eq(&items));
        let counted = store.batches().unwrap().remove(0).1;
        let states: Vec<_> = items.iter().map(|item| item.state).collect();
        (states, counted.answered, counted.waiting)
    };
    let (answered, waiting) = (ItemState::Answered, ItemState::Waiting);
    assert_eq!(states(), (vec![answered; 2], 2, 0));
    store.delete(run, true).unwrap();
    assert_eq!(states(), (vec![waiting; 2], 0, 2));
    store.delete(run, false).unwrap();
    assert_eq!(states(), (vec![answered; 2], 2, 0));
    let cut = ItemState::Truncated;
    store
        .set_item(batch, 0, key.as_ref(), cut, Some(run), Some("cut off"))
        .unwrap();
    assert_eq!(states().0[0], cut);
    store.delete(run, true).unwrap();
    assert_eq!(states().0[0], waiting);
}
