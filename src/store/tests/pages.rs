//! Tests of paginated lists, and of the neighbours of a run.

use super::*;

/// A run that was asked at this time, of this model.
fn asked_at(store: &Store, created_ms: i64, model: &str, verdict: Option<bool>) -> RunId {
    let run = NewRun {
        model: model.into(),
        ..question()
    };
    let id = answered(store, &run, "the lead car brakes");
    let connection = store.lock();
    let set = |sql: &str| assert_eq!(connection.execute(sql, (created_ms, id.0)).unwrap(), 1);
    set("UPDATE runs SET created_ms = ?1 WHERE id = ?2");
    if verdict.is_none() {
        set("UPDATE runs SET verdict = NULL, updated_ms = ?1 WHERE id = ?2");
    }
    id
}

#[test]
fn a_list_is_read_page_by_page_in_both_directions() {
    let store = Store::in_memory().unwrap();
    // Two at the same time each, and the numbers in another order than the times.
    let mut times: Vec<i64> = (0..7).map(|n| 1000 + 10 * ((n * 3) % 7 / 2)).collect();
    let ids: Vec<_> = times
        .iter()
        .map(|t| asked_at(&store, *t, "local/x", Some(true)).0)
        .collect();
    let mut expected: Vec<(i64, i64)> = times.drain(..).zip(ids.clone()).collect();
    expected.sort_unstable_by(|a, b| b.cmp(a));
    let all = Filter::default();
    let keys = |page: &Page| {
        page.rows
            .iter()
            .map(|r| (r.created_ms, r.run))
            .collect::<Vec<_>>()
    };
    let first = store.page(&all, Edge::Newest, 3).unwrap();
    assert_eq!((keys(&first), first.more), (expected[..3].to_vec(), true));
    let at = |n: usize| Cursor {
        created_ms: expected[n].0,
        run: expected[n].1,
    };
    let next = store.page(&all, Edge::Older(at(2)), 3).unwrap();
    assert_eq!((keys(&next), next.more), (expected[3..6].to_vec(), true));
    let last = store.page(&all, Edge::Older(at(5)), 3).unwrap();
    assert_eq!((keys(&last), last.more), (expected[6..].to_vec(), false));
    let back = store.page(&all, Edge::Newer(at(3)), 2).unwrap();
    assert_eq!((keys(&back), back.more), (expected[1..3].to_vec(), true));
    let end = store.page(&all, Edge::Oldest, 2).unwrap();
    assert_eq!((keys(&end), end.more), (expected[5..].to_vec(), true));
    let again = store.page(&all, Edge::From(at(5)), 9).unwrap();
    assert_eq!((keys(&again), again.more), (expected[5..].to_vec(), false));
    assert_eq!(store.count_to(&all, 100).unwrap(), 7);
    assert_eq!(store.count_to(&all, 5).unwrap(), 5, "counted no further");
    store.delete(RunId(ids[0]), true).unwrap();
    assert_eq!(store.count_to(&all, 100).unwrap(), 6);
}

#[test]
fn words_and_filters_page_too() {
    let store = Store::in_memory().unwrap();
    let one = asked_at(&store, 1000, "local/x", Some(true));
    let two = asked_at(&store, 2000, "lab/Large", None);
    store.pin(two, true).unwrap();
    store.note(two, "odd").unwrap();
    let found = |line: &str| {
        let page = store
            .page(&Filter::read(line).unwrap(), Edge::Newest, 9)
            .unwrap();
        page.rows.iter().map(|r| r.run).collect::<Vec<_>>()
    };
    assert_eq!(found("brak"), [two.0, one.0], "the beginning of a word");
    assert_eq!(found("brak odd"), [two.0]);
    assert_eq!(found("model:large"), [two.0]);
    assert_eq!(found("LARGE"), [two.0], "a part of the model's name");
    assert_eq!(
        found("lar brak"),
        [two.0],
        "one of the model, one of the answer"
    );
    assert_eq!(found("local"), [one.0]);
    assert_eq!(found("large local"), [] as [i64; 0], "all words");
    assert_eq!(found("odd large"), [two.0], "the note and the model");
    let three = asked_at(&store, 3000, "lab/later", Some(true));
    assert_eq!(found("later"), [three.0], "a model that came since");
    store.note(one, "larger than life").unwrap();
    assert_eq!(found("large"), [two.0, one.0], "a model or a text");
    assert_eq!(
        store.count_to(&Filter::read("large").unwrap(), 9).unwrap(),
        2
    );
    store.delete(three, true).unwrap();
    assert_eq!(found("verdict:dangerous"), [one.0]);
    assert_eq!(found("verdict:none"), [two.0]);
    assert_eq!(found("pinned"), [two.0]);
    assert_eq!(found("task:safety"), [] as [i64; 0]);
    let filter = Filter::read("brakes").unwrap();
    let at = Cursor {
        created_ms: 0,
        run: two.0,
    };
    let rest = store.page(&filter, Edge::Older(at), 9).unwrap();
    assert_eq!(rest.rows.len(), 1);
    assert!(
        rest.rows[0]
            .excerpt
            .as_deref()
            .is_some_and(|e| e.contains("[brakes]"))
    );
}

#[test]
fn what_others_write_changes_the_version_of_the_data() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.sqlite");
    let (reader, writer) = (Store::open(&path).unwrap(), Store::open(&path).unwrap());
    let before = reader.version_of_data().unwrap();
    assert_eq!(reader.version_of_data().unwrap(), before);
    answered(&writer, &question(), "x");
    assert_ne!(reader.version_of_data().unwrap(), before);
}

#[test]
fn the_built_in_verdict_on_the_same_question_is_found() {
    let store = Store::in_memory().unwrap();
    let id = answered(&store, &question(), "x");
    let run = store.run(id).unwrap().unwrap();
    let judge = "reference/geometry";
    assert_eq!(store.verdict_beside(&run, judge).unwrap(), None);
    let reference = NewRun {
        model: judge.into(),
        parameters: "{}".into(),
        window: Some((5, 9)),
        ..question()
    };
    answered(&store, &reference, "y");
    assert_eq!(store.verdict_beside(&run, judge).unwrap(), Some(true));
    let other = NewRun {
        ego: "2".into(),
        ..question()
    };
    let other = answered(&store, &other, "z");
    let other = store.run(other).unwrap().unwrap();
    assert_eq!(
        store.verdict_beside(&other, judge).unwrap(),
        None,
        "another ego"
    );
}
