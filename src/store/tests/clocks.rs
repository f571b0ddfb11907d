//! Tests of adjusted clocks: claims still expire, and the last answer stays the newest.

use super::super::database::now_ms;
use super::*;

const HOUR: i64 = 60 * 60 * 1000;

/// Sets the clock back by an hour for everything that the store has so far.
fn set_back(store: &Store) {
    let sql = "UPDATE claims SET until_ms = until_ms + ?1 WHERE until_ms < 9223372036854775807";
    let connection = store.lock();
    connection.execute(sql, [HOUR]).unwrap();
    connection
        .execute("UPDATE runs SET created_ms = created_ms + ?1", [HOUR])
        .unwrap();
}

fn until(store: &Store, run: RunId) -> i64 {
    let sql = "SELECT until_ms FROM claims WHERE run = ?1";
    store
        .lock()
        .query_row(sql, [run.0], |row| row.get(0))
        .unwrap()
}

#[test]
fn a_dead_claim_of_the_future_ends_with_its_lease() {
    let store = Store::in_memory().unwrap();
    let dead = granted(&store, &question(), false);
    set_back(&store);
    let claimed = store.claim(&question(), false).unwrap();
    assert_eq!(claimed, Claim::Taken(dead), "it may be alive");
    let lease = i64::try_from(LEASE.as_millis()).unwrap();
    assert!(until(&store, dead) <= now_ms() + lease);
    // Looking again does not make it longer.
    let before = until(&store, dead);
    store.claim(&question(), false).unwrap();
    assert_eq!(until(&store, dead), before);
    abandon(&store, dead);
    assert!(matches!(
        store.claim(&question(), false).unwrap(),
        Claim::Granted(run) if run != dead
    ));
}

#[test]
fn opening_a_store_shortens_claims_of_the_future() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.sqlite");
    let store = Store::open(&path).unwrap();
    let dead = granted(&store, &question(), false);
    set_back(&store);
    drop(store);
    let store = Store::open(&path).unwrap();
    let lease = i64::try_from(LEASE.as_millis()).unwrap();
    assert!(until(&store, dead) <= now_ms() + lease);
}

#[test]
fn questions_with_a_provider_are_claimed_for_ever() {
    let store = Store::in_memory().unwrap();
    let batch = NewProviderBatch {
        model: "lab/x".into(),
        address: "http://a".into(),
    };
    let opened = store.open_provider_batch(&batch, &[question()]).unwrap();
    let run = opened.unwrap().requests[0].clone().unwrap().0;
    set_back(&store);
    let claimed = store.claim(&question(), false).unwrap();
    assert_eq!(claimed, Claim::Taken(run));
    assert_eq!(until(&store, run), i64::MAX);
}

#[test]
fn the_last_answer_is_the_newest_whatever_the_clock_said() {
    let store = Store::in_memory().unwrap();
    answered(&store, &question(), "old");
    set_back(&store);
    let newer = answered(&store, &question(), "new");
    let key = question().key();
    let found = store.answer_to(&question()).unwrap().unwrap();
    assert_eq!((found.id, found.answer.as_str()), (newer, "new"));
    let item = NewItem {
        key,
        ..crate::items::tests::item("A", 0)
    };
    let batch = store.begin_batch("{}", None, &[item]).unwrap();
    let items = store.items_with_answers(batch).unwrap();
    assert_eq!(items[0].1.as_ref().map(|found| found.run), Some(newer));
}
