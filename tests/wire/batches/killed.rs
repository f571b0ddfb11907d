//! The program killed while it hands a batch over: what is written down then, and how it goes on.

use super::support::batches::Creation;
use super::support::program::{Ended, Home};
use super::*;

/// Runs the program with the key; it must not say it.
pub fn run(home: &Home, arguments: &[&str]) -> Ended {
    let variables = [("LAB_KEY", KEY), ("NO_PROXY", "127.0.0.1")];
    let ended = tokio::task::block_in_place(|| home.run_with(arguments, &variables));
    assert!(!ended.stdout.contains(KEY) && !ended.stderr.contains(KEY));
    ended
}

/// A configured provider.
pub fn configured(name: &str, provider: &Provider, dialect: Dialect) -> String {
    format!(
        "[provider.{name}]\ndialect = \"{}\"\nbase_url = \"{}\"\nkey_env = \"LAB_KEY\"\n",
        dialect.name(),
        provider.base_url()
    )
}

pub const ASKED: [&str; 9] = [
    "evaluate",
    "ZAM_RedLight-1_1_T-1",
    "ZAM_CutIn-1_1_T-1",
    "--task",
    "collision",
    "--set",
    "max_tokens=500",
    "--batch",
    "--model",
];

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn killed_between_handing_over_and_fetching_nothing_is_lost_or_sent_twice() {
    for dialect in DIALECTS {
        // The id of the first one's batch comes back, that of the second one's does not.
        let (first, second) = (Provider::start().await, Provider::start().await);
        first.world().state = "in_progress".into();
        second.world().state = "in_progress".into();
        second.world().creation = Creation::Stalled;
        let home = Home::new();
        let config = configured("a", &first, dialect) + &configured("b", &second, dialect);
        home.write(home.config().join("config.toml"), config);
        let mut command = home.command();
        let variables = [("LAB_KEY", KEY), ("NO_PROXY", "127.0.0.1")];
        command.args(ASKED).arg("a/tiny,b/tiny").envs(variables);
        command.stderr(std::process::Stdio::null());
        let mut child = command.spawn().unwrap();
        let begun = std::time::Instant::now();
        while second.world().batches.is_empty() {
            assert!(begun.elapsed() < Duration::from_secs(60), "nothing arrived");
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        child.kill().unwrap();
        tokio::task::block_in_place(|| child.wait()).unwrap();

        let rows = home.rows("SELECT state, remote_id, tag FROM provider_batches ORDER BY id");
        let states: Vec<_> = rows
            .iter()
            .map(|row| (row["state"].as_deref().unwrap(), row["remote_id"].is_some()))
            .collect();
        assert_eq!(states, [("submitted", true), ("submitting", false)]);
        // People are told that there may be one, and what to look for.
        let tag = rows[1]["tag"].clone().unwrap();
        let (there, _) = second.world().batches[0].items[0].clone();
        assert!(there.starts_with(&tag), "{there}");
        let begins = format!("question ids starting with {tag}; ");
        let listed = run(&home, &["runs", "batches"]).status(0).stdout;
        let lost = [
            "no id came back",
            &begins,
            "`nearmiss runs batches collect 2`",
        ];
        assert!(lost.iter().all(|words| listed.contains(words)), "{listed}");
        assert_eq!(listed.matches("no id came back").count(), 1, "{listed}");
        run(&home, &["evaluate", "b1"]).status(1).says(&[
            "4 of them submitted to providers",
            "batch 2: no id came back",
            &begins,
        ]);
        run(&home, &["evaluate", "b1", "--batch"]).says(&["4 of them submitted to providers"]);

        for provider in [&first, &second] {
            let mut world = provider.world();
            world.creation = Creation::Answered;
            world.state = "completed".into();
        }
        run(&home, &["runs", "batches", "collect", "--wait"]).status(0);
        let table = run(&home, &["evaluate", "b1", "--format=json"])
            .status(0)
            .json();
        for cell in table["cells"].as_array().unwrap() {
            let counts = (&cell["n"], &cell["failed"]);
            assert_eq!(counts, (&2.into(), &0.into()), "{dialect:?} {table}");
        }
        for provider in [&first, &second] {
            assert_eq!(provider.world().batches.len(), 1, "sent once");
        }
        assert_eq!(home.runs().len(), 4, "each is one run");
    }
}
