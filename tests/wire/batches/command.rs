//! `nearmiss runs batches` from outside.

use super::support::program::Home;
use super::*;

/// A home whose store has a batch with the provider, which calls itself `lab`.
async fn home(provider: &Provider, dialect: Dialect) -> (Home, ProviderBatchId) {
    let home = Home::new();
    let config = format!(
        "[provider.lab]\ndialect = \"{}\"\nbase_url = \"{}\"\nkey_env = \"LAB_KEY\"\n",
        dialect.name(),
        provider.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    let store = Arc::new(Store::open(&home.data().join("runs.sqlite")).unwrap());
    let model = ModelJudge {
        id: "lab/tiny".into(),
        name: "tiny".into(),
        endpoint: endpoint(provider.base_url(), dialect),
        client: Client::direct(),
        parameters: Parameters::default(),
    };
    let done = submit(&questions(2), &model, &store).await.unwrap();
    (home, done.batches[0])
}

#[tokio::test(flavor = "multi_thread")]
async fn batches_are_listed_cancelled_and_collected() {
    for dialect in DIALECTS {
        let provider = Provider::start().await;
        provider.world().state = "in_progress".into();
        let (home, id) = home(&provider, dialect).await;
        let id = id.to_string();
        let run = |arguments: &[&str]| {
            let ended = tokio::task::block_in_place(|| {
                home.run_with(arguments, &[("LAB_KEY", KEY), ("NO_PROXY", "127.0.0.1")])
            });
            assert!(!ended.stdout.contains(KEY) && !ended.stderr.contains(KEY));
            ended
        };
        let listed = run(&["runs", "batches"]).status(0).stdout;
        assert!(
            listed.contains("submitted") && listed.contains("0/2"),
            "{listed}"
        );
        let document = run(&["runs", "batches", "--format=json"]).status(0).json();
        assert_eq!(document["state"], "submitted");
        run(&["runs", "batches", "collect"])
            .status(0)
            .says(&["working on it"]);
        run(&["runs", "batches", "cancel", &id])
            .status(0)
            .says(&["asked the provider to stop"]);
        run(&["runs", "batches", "collect", &id])
            .status(0)
            .says(&["batch 1"]);

        provider.world().fates = vec![Fate::Answered, Fate::Cancelled];
        provider.world().state = "cancelled".into();
        run(&["runs", "batches", "collect", "--wait"])
            .status(0)
            .says(&["cancelled"]);
        let document = run(&["runs", "batches", "--format=json"]).json();
        assert_eq!(document["results"], 2, "{document}");
        assert_eq!(document["state"], "cancelled");
        let states: Vec<_> = home
            .runs()
            .iter()
            .map(|run| run["state"].clone().unwrap())
            .collect();
        assert_eq!(states, ["answered", "cancelled"]);
        run(&["runs", "batches", "collect"])
            .status(0)
            .says(&["no batch is open at a provider"]);
        run(&["runs", "batches", "cancel", &id])
            .status(0)
            .says(&["already finished"]);
        assert!(home.files_with(KEY).is_empty());
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_done_is_said() {
    let provider = Provider::start().await;
    let (home, _) = home(&provider, Dialect::Anthropic).await;
    let run = |arguments: &[&str]| tokio::task::block_in_place(|| home.run(arguments));
    run(&["runs", "batches", "collect", "7"])
        .status(2)
        .says(&["no batch 7"]);
    // Without its key nothing can be asked; the batch stays.
    run(&["runs", "batches", "collect"])
        .status(1)
        .says(&["LAB_KEY"]);
    let elsewhere = "[provider.lab]\ndialect = \"anthropic\"\nbase_url = \"http://127.0.0.1:9\"\n";
    home.write(home.config().join("config.toml"), elsewhere);
    run(&["runs", "batches", "collect"])
        .status(2)
        .says(&["was sent to", "base_url"]);
    home.write(home.config().join("config.toml"), "");
    run(&["runs", "batches", "cancel", "1"])
        .status(2)
        .says(&["lab"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn evaluate_hands_its_questions_over_and_counts_what_came_back() {
    for dialect in DIALECTS {
        let provider = Provider::start().await;
        provider.world().state = "in_progress".into();
        let home = Home::new();
        let config = format!(
            "[provider.lab]\ndialect = \"{}\"\nbase_url = \"{}\"\nkey_env = \"LAB_KEY\"\n",
            dialect.name(),
            provider.base_url()
        );
        home.write(home.config().join("config.toml"), config);
        let run = |arguments: &[&str]| {
            tokio::task::block_in_place(|| {
                home.run_with(arguments, &[("LAB_KEY", KEY), ("NO_PROXY", "127.0.0.1")])
            })
        };
        let asked = [
            "evaluate",
            "ZAM_RedLight-1_1_T-1",
            "ZAM_CutIn-1_1_T-1",
            "--model",
            "lab/tiny,reference/geometry",
            "--task",
            "collision",
            "--set",
            "max_tokens=500",
            "--batch",
        ];
        // The built-in judge answers at once; the others are with the provider.
        let first = run(&asked)
            .status(1)
            .says(&["2 questions with the provider", "evaluate b1"]);
        assert!(!first.stderr.contains(KEY));
        // Going on neither sends anything nor waits for it.
        run(&["evaluate", "b1"])
            .status(1)
            .says(&["2 of them submitted to providers"]);
        assert_eq!(home.runs().len(), 4);
        provider.world().fates = vec![Fate::Answered; 2];
        provider.world().state = "completed".into();
        run(&["runs", "batches", "collect", "--wait"]).status(0);
        let table = run(&["evaluate", "b1", "--format=json"]).status(0).json();
        let cells = table["cells"].as_array().unwrap();
        let cell = cells
            .iter()
            .find(|cell| cell["model"] == "lab/tiny")
            .unwrap();
        assert_eq!(
            (&cell["n"], &cell["failed"]),
            (&2.into(), &0.into()),
            "{table}"
        );
        let report = run(&["report", "--batch", "b1", "--format=json"])
            .status(0)
            .json();
        assert!(report["cells"].as_array().unwrap().len() >= 2, "{report}");
        assert_eq!(home.runs().len(), 4, "nothing was asked twice");
    }
}
