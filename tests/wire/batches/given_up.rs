//! Batches whose results the provider has no more.

use super::killed::{ASKED, configured, run};
use super::support::program::Home;
use super::*;

/// A home with a batch of two questions at this provider.
fn handed(provider: &Provider, dialect: Dialect) -> Home {
    let home = Home::new();
    let config = configured("lab", provider, dialect);
    home.write(home.config().join("config.toml"), config);
    run(&home, &[&ASKED[..], &["lab/tiny"]].concat())
        .status(0)
        .says(&["2 questions with the provider"]);
    home
}

fn states(home: &Home) -> Vec<String> {
    let runs = home.runs().into_iter();
    runs.map(|run| run["state"].clone().unwrap()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_the_provider_deleted_can_be_given_up_and_asked_again() {
    for dialect in DIALECTS {
        // All of the batch, by either word for it; or its results alone, where they are apart.
        for status in [Some(404), Some(410), None] {
            if (dialect, status) == (Dialect::Gemini, None) {
                continue;
            }
            let provider = Provider::start().await;
            let home = handed(&provider, dialect);
            {
                let mut world = provider.world();
                (world.refuse, world.without_results) = (status, status.is_none());
                world.words = "no such batch".into();
            }
            run(&home, &["runs", "batches", "collect"])
                .status(1)
                .says(&[
                    "no longer has it",
                    "`nearmiss runs batches give-up 1` frees its questions",
                ]);
            assert_eq!(states(&home), ["running", "running"], "nothing by itself");
            run(&home, &["runs", "batches", "give-up", "1"])
                .status(0)
                .says(&[
                    "given up; 2 questions can be asked again: `nearmiss evaluate b1`",
                    "may pay twice",
                ]);
            assert_eq!(
                states(&home),
                ["failed", "failed"],
                "{dialect:?} {status:?}"
            );
            let listed = run(&home, &["runs", "batches"]).status(0).stdout;
            assert!(
                listed.contains("failed") && listed.contains("given up: "),
                "{listed}"
            );
            run(&home, &["runs", "batches", "give-up", "1"])
                .status(0)
                .says(&["already finished"]);
            {
                let mut world = provider.world();
                (world.refuse, world.without_results) = (None, false);
            }
            run(&home, &["evaluate", "b1", "--batch"])
                .status(0)
                .says(&["2 questions with the provider as 2"]);
            run(&home, &["runs", "batches", "collect", "--wait"]).status(0);
            let table = run(&home, &["evaluate", "b1", "--format=json"]).status(0);
            assert_eq!(table.json()["cells"][0]["failed"], 0, "{dialect:?}");
            assert_eq!(provider.world().batches.len(), 2);
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_provider_that_refuses_keeps_no_other_from_its_questions() {
    let (first, second) = (Provider::start().await, Provider::start().await);
    first.world().refuse = Some(401);
    let home = Home::new();
    let dialect = Dialect::OpenAiChat;
    let config = configured("a", &first, dialect) + &configured("b", &second, dialect);
    home.write(home.config().join("config.toml"), config);
    run(&home, &[&ASKED[..], &["a/tiny,b/tiny"]].concat())
        .status(1)
        .says(&[
            "a/tiny: ",
            "rejected the key",
            "b/tiny: 2 questions with the provider",
            "not everything could be submitted for 1 model",
            "evaluate b1",
        ]);
    assert_eq!(second.world().batches.len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_may_still_come_is_given_up_by_force_only() {
    let provider = Provider::start().await;
    provider.world().state = "in_progress".into();
    let home = handed(&provider, Dialect::OpenAiChat);
    run(&home, &["runs", "batches", "give-up", "1"])
        .status(2)
        .says(&["may still be answered", "batches cancel 1", "--force"]);
    provider.world().refuse = Some(401);
    run(&home, &["runs", "batches", "give-up", "1"])
        .status(2)
        .says(&["rejected the key", "--force"]);
    run(&home, &["runs", "batches", "give-up", "9"])
        .status(2)
        .says(&["no batch 9"]);
    assert_eq!(states(&home), ["running", "running"]);
    run(&home, &["runs", "batches", "give-up", "1", "--force"])
        .status(0)
        .says(&["2 questions can be asked again"]);
    assert_eq!(states(&home), ["failed", "failed"]);

    // What can be had is taken instead.
    let provider = Provider::start().await;
    let home = handed(&provider, Dialect::Anthropic);
    run(&home, &["runs", "batches", "give-up", "1"])
        .status(0)
        .says(&["2 results stored, 0 questions without a result"]);
    assert_eq!(states(&home), ["answered", "answered"]);
}
