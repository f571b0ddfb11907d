//! What goes wrong between a batch and its store: lost words, crashes, refusals, hostile texts.

use nearmiss::llm::Budget;

use super::support::batches::Creation;
use super::support::secret::{leak, quoted};
use super::*;

const TEAM: &str = "t3am-9f8e7d6c";
const SECRETS: [&str; 2] = [KEY, TEAM];

/// What of a server's words must reach neither store nor people.
fn clean(text: &str) {
    assert_eq!(leak(&SECRETS, text.as_bytes()), None, "{text}");
    assert!(!text.contains('\u{1b}'), "{text:?}");
}

#[tokio::test]
async fn a_batch_whose_id_was_lost_is_found_and_not_sent_again() {
    for dialect in DIALECTS {
        let mut bench = Bench::new(dialect).await;
        // Another batch of as many questions, which is none of ours.
        let other = Bench::new(dialect).await;
        other.submit(2).await.unwrap();
        let strange = other.provider.world().batches[0].clone();
        bench.provider.world().batches.push(strange);
        bench.provider.world().creation = Creation::Lost;
        let lost = bench.submit(2).await.unwrap_err();
        let RemoteError::Unknown { batch, .. } = lost else {
            panic!("{lost}")
        };
        bench.reopen();
        bench.provider.world().creation = Creation::Answered;
        let again = bench.submit(2).await.unwrap();
        assert_eq!((again.handed, again.taken), (0, 2), "{dialect:?}");
        assert_eq!(bench.provider.world().batches.len(), 2);
        let ended = bench.collect(batch).await.unwrap();
        assert_eq!(ended, over(ProviderBatchState::Ended, 2, 0), "{dialect:?}");
        bench.each_has_its_own();
    }
}

#[tokio::test]
async fn a_program_that_dies_while_it_submits_submits_once() {
    for dialect in DIALECTS {
        let mut bench = Bench::new(dialect).await;
        {
            let mut world = bench.provider.world();
            world.creation = Creation::Stalled;
            world.state = "in_progress".into();
        }
        tokio::select! {
            done = bench.submit(2) => panic!("{done:?}"),
            () = created(&bench) => {}
        }
        bench.reopen();
        let [batch] = &bench.store.provider_batches().unwrap()[..] else {
            panic!("one batch is written down")
        };
        let id = batch.id;
        assert_eq!(
            (batch.state, &batch.remote_id),
            (ProviderBatchState::Submitting, &None)
        );
        // Anthropic's cannot be told while it is worked on, so that nothing is done yet.
        let working = bench.collect(id).await.unwrap();
        match dialect {
            Dialect::Anthropic => assert_eq!(working, Progress::Unknown),
            _ => assert!(matches!(working, Progress::Working { .. }), "{working:?}"),
        }
        assert_eq!(bench.submit(2).await.unwrap().taken, 2);
        bench.provider.world().state = String::new();
        assert_eq!(
            bench.collect(id).await.unwrap(),
            over(ProviderBatchState::Ended, 2, 0),
            "{dialect:?}"
        );
        assert_eq!(bench.provider.world().batches.len(), 1);
        bench.each_has_its_own();
    }
}

/// Waits until the provider has a batch.
async fn created(bench: &Bench) {
    while bench.provider.world().batches.is_empty() {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}

#[tokio::test]
async fn a_batch_that_never_arrived_is_given_up_after_a_while() {
    for dialect in DIALECTS {
        let bench = Bench::new(dialect).await;
        bench.provider.world().creation = Creation::Lost;
        let lost = bench.submit(1).await.unwrap_err();
        let RemoteError::Unknown { batch, .. } = lost else {
            panic!("{lost}")
        };
        bench.provider.world().batches.clear();
        assert_eq!(bench.collect(batch).await.unwrap(), Progress::Unknown);
        let file = rusqlite::Connection::open(bench.folder.path().join("runs.sqlite")).unwrap();
        let sql = "UPDATE provider_batches SET submitted_ms = submitted_ms - 600000";
        file.execute(sql, []).unwrap();
        assert_eq!(bench.collect(batch).await.unwrap(), Progress::NotSent);
        assert_eq!(bench.states(), [RunState::Failed]);
        bench.provider.world().creation = Creation::Answered;
        assert_eq!(bench.submit(1).await.unwrap().handed, 1);
    }
}

#[tokio::test]
async fn a_crash_between_two_results_takes_none_twice() {
    for dialect in DIALECTS {
        // With the whole length told, and without, where a cut file looks like a whole one.
        for told in [true, false] {
            let mut bench = Bench::new(dialect).await;
            let id = bench.submit(3).await.unwrap().batches[0];
            {
                let mut world = bench.provider.world();
                world.cut = Some((2, told));
                world.in_a_file = true;
            }
            let short = bench.collect(id).await.unwrap_err();
            if told {
                assert!(matches!(short, RemoteError::Provider(_)), "{short}")
            } else {
                assert!(
                    matches!(short, RemoteError::Short { given: 2, .. }),
                    "{short}"
                )
            }
            let running =
                |states: &[RunState]| states.iter().filter(|s| **s == RunState::Running).count();
            assert_eq!(running(&bench.states()), 1, "{dialect:?}");
            bench.reopen();
            bench.provider.world().cut = None;
            let rest = bench.collect(id).await.unwrap();
            assert_eq!(rest, over(ProviderBatchState::Ended, 1, 0));
            assert_eq!(bench.states(), [RunState::Answered; 3]);
            bench.each_has_its_own();
        }
    }
}

#[tokio::test]
async fn refusals_for_the_moment_are_tried_again() {
    for dialect in DIALECTS {
        let bench = Bench::new(dialect).await;
        // The first request of each kind; the numbers count the refused ones, too.
        bench.provider.world().busy = [0, 2, 4, 6, 8].into();
        let id = bench.submit(2).await.unwrap().batches[0];
        let ended = bench.collect(id).await.unwrap();
        assert_eq!(ended, over(ProviderBatchState::Ended, 2, 0), "{dialect:?}");
        assert_eq!(bench.provider.world().batches.len(), 1);
    }
}

#[tokio::test]
async fn a_refused_batch_leaves_its_questions_free() {
    for dialect in DIALECTS {
        let bench = Bench::new(dialect).await;
        {
            let mut world = bench.provider.world();
            world.refuse = Some(401);
            world.words = format!("no such key {KEY}\u{1b}[2J\u{7}");
        }
        let refused = bench.submit(2).await.unwrap_err();
        clean(&refused.to_string());
        assert!(
            refused.to_string().contains("no such key [key]"),
            "{refused}"
        );
        let batches = bench.store.provider_batches().unwrap();
        assert_eq!(batches[0].state, ProviderBatchState::NotSent);
        clean(batches[0].problem.as_deref().unwrap());
        for run in bench.runs() {
            assert_eq!(run.ending.state, RunState::Failed);
            let error = run.ending.error.unwrap();
            assert!(error.starts_with("nothing was sent: "), "{error}");
            clean(&error);
        }
        bench.provider.world().refuse = None;
        assert_eq!(bench.submit(2).await.unwrap().handed, 2);
    }
}

#[tokio::test]
async fn neither_keys_nor_escape_sequences_come_back() {
    for dialect in DIALECTS {
        for state in ["completed", "failed"] {
            let mut bench = Bench::new(dialect).await;
            bench.model.endpoint.headers = vec![("x-team".into(), TEAM.into())];
            {
                let mut world = bench.provider.world();
                world.fates = vec![Fate::Errored, Fate::Answered];
                // What of it is an escape of JSON is so in the string, and again when the string is read as JSON.
                world.words = format!("you sent {}\u{1b}]0;x\u{7}", quoted(&SECRETS));
                world.state = "in_progress".into();
            }
            let id = bench.submit(2).await.unwrap().batches[0];
            // Anthropic knows no batch that failed as a whole.
            bench.provider.world().state = state.into();
            bench.collect(id).await.unwrap();
            for run in bench.runs() {
                assert_eq!(leak(&SECRETS, run.answer.as_bytes()), None);
                if let Some(error) = &run.ending.error {
                    clean(error);
                }
            }
            let batches = bench.store.provider_batches().unwrap();
            if let Some(problem) = &batches[0].problem {
                clean(problem);
            }
            for file in std::fs::read_dir(bench.folder.path()).unwrap() {
                let bytes = std::fs::read(file.unwrap().path()).unwrap();
                assert_eq!(leak(&SECRETS, &bytes), None, "{dialect:?}");
            }
        }
    }
}

#[tokio::test]
async fn a_result_that_nobody_asked_for_is_left_alone_and_one_that_lacks_fails() {
    for dialect in DIALECTS {
        let bench = Bench::new(dialect).await;
        bench.provider.world().state = "in_progress".into();
        let id = bench.submit(2).await.unwrap().batches[0];
        {
            let mut world = bench.provider.world();
            let body = world.batches[0].items[0].1.clone();
            world.batches[0].items.push(("somebody-else".into(), body));
            world.fates = vec![Fate::Answered, Fate::Forgotten, Fate::Answered];
            world.state = String::new();
        }
        let ended = bench.collect(id).await.unwrap();
        assert_eq!(ended, over(ProviderBatchState::Ended, 1, 1), "{dialect:?}");
        assert_eq!(bench.states(), [RunState::Answered, RunState::Failed]);
    }
}

#[tokio::test]
async fn a_budget_holds_for_all_questions_together() {
    let mut bench = Bench::new(Dialect::Anthropic).await;
    bench.model.endpoint.budget = Some(Budget::new(0.02));
    let few = bench.submit(1).await.unwrap();
    assert_eq!(few.handed, 1);
    let refused = bench.submit(40).await.unwrap_err().to_string();
    assert!(refused.contains("raise the budget"), "{refused}");
    assert_eq!(bench.provider.world().batches.len(), 1);
}
