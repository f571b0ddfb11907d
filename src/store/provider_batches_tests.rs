//! Tests of provider batches in the store alone.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::RunState;

fn question(sample: u32) -> NewRun {
    NewRun {
        sample,
        ..crate::tests::question()
    }
}

fn opened(store: &Store, runs: &[NewRun]) -> Option<ReadyBatch> {
    let batch = NewProviderBatch {
        model: "lab/x".into(),
        address: "http://a".into(),
    };
    store.open_provider_batch(&batch, runs).unwrap()
}

#[test]
fn a_question_is_handed_over_once_and_settled_once() {
    let store = Store::in_memory().unwrap();
    let first = opened(&store, &[question(0), question(0), question(1)]).unwrap();
    let granted: Vec<bool> = first.requests.iter().map(Option::is_some).collect();
    assert_eq!(
        granted,
        [true, false, true],
        "the same question twice is one"
    );
    assert_eq!(opened(&store, &[question(1)]), None);
    assert_eq!(store.provider_batches().unwrap().len(), 1);
    let (run, _) = first.requests[0].clone().unwrap();
    assert!(matches!(store.claim(&question(0), false).unwrap(), Claim::Taken(r) if r == run));

    let ending = Ending::bare(RunState::Answered);
    for first in [true, false] {
        let settled = store
            .settle(run, &[AnswerPiece::Answer("yes")], &ending)
            .unwrap();
        assert_eq!(settled, first);
        assert_eq!(store.run(run).unwrap().unwrap().answer, "yes");
    }
    let rest = Ending::bare(RunState::Failed);
    let closed = store.close_provider_batch(first.id, ProviderBatchState::Ended, None, &rest);
    assert_eq!(closed.unwrap(), 1);
    let batch = store.provider_batch(first.id).unwrap().unwrap();
    assert_eq!(
        (batch.state, batch.requests, batch.done),
        (ProviderBatchState::Ended, 2, 2)
    );
    // What failed is free, what is answered is not asked.
    let again = opened(&store, &[question(0), question(1)]).unwrap();
    assert!(again.requests[0].is_none() && again.requests[1].is_some());
}

#[test]
fn a_batch_that_was_given_up_is_not_sent_and_one_that_is_there_is_known() {
    let store = Store::in_memory().unwrap();
    let batch = opened(&store, &[question(0)]).unwrap();
    assert!(store.about_to_submit(batch.id).unwrap());
    let rest = Ending::bare(RunState::Failed);
    let state = ProviderBatchState::NotSent;
    store
        .close_provider_batch(batch.id, state, Some("gone"), &rest)
        .unwrap();
    assert!(!store.about_to_submit(batch.id).unwrap());
    let other = opened(&store, &[question(1)]).unwrap();
    assert_ne!(other.tag, batch.tag);
    store.submitted(other.id, "batch_1").unwrap();
    store.cancelling(other.id).unwrap();
    let kept = store.provider_batch(other.id).unwrap().unwrap();
    assert_eq!(kept.remote_id.as_deref(), Some("batch_1"));
    assert_eq!(kept.state, ProviderBatchState::Cancelling);
    assert!(!store.about_to_submit(other.id).unwrap());
}
