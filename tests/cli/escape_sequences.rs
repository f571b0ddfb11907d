//! Escape sequences in every name and text that is not ours: no command obeys them.

use serde_json::json;

use super::remote::{delta, streamed};
use super::support::planted::{EVIL, IN_TOML, leaks, plant};
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

#[track_caller]
fn harmless(arguments: &[&str], ended: &Ended) {
    for (stream, text) in [("stdout", &ended.stdout), ("stderr", &ended.stderr)] {
        let leaks = leaks(text);
        assert!(
            leaks.is_empty(),
            "{arguments:?} on {stream}: {}",
            leaks.join("\n")
        );
    }
}

/// Runs every command that says something of what was planted; gives what they say.
#[track_caller]
fn all_of(home: &Home, commands: &[&[&str]]) -> String {
    let mut said = String::new();
    let mut wrong = Vec::new();
    for arguments in commands {
        let ended = home.run(arguments);
        for (stream, text) in [("stdout", &ended.stdout), ("stderr", &ended.stderr)] {
            wrong.extend(
                leaks(text)
                    .into_iter()
                    .map(|leak| format!("{arguments:?} on {stream}: {leak}")),
            );
            said.push_str(text);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    said
}

#[test]
fn nothing_planted_in_files_reaches_the_terminal() {
    let home = Home::new();
    let folder = plant(&home);
    let folder = folder.to_str().unwrap();
    let files = ["a", "b", "c", "d"].map(|name| format!("{folder}/{name}{EVIL}.xml"));
    let (evil_file, evil_id) = (format!("other{EVIL}.md"), format!("{EVIL}/x"));
    let mut commands: Vec<Vec<&str>> = Vec::new();
    for file in &files {
        for command in [
            &["inspect"][..],
            &["inspect", "--format=json"],
            &["metrics"],
            &["metrics", "--format", "json"],
            &["metrics", "--scene"],
            &["prompt", "describe", "--frame", "cartesian"],
            &["prompt", "describe", "--frame", "metrics", "--format=json"],
            &["prompt", "show"],
            &["prompt", "show", "--format=json"],
            &["ask"],
            &["ask", "--format=json"],
            &["evaluate"],
            &[],
        ] {
            commands.push([command, &[file.as_str()]].concat());
        }
    }
    for command in [
        &[folder][..],
        &["metrics", folder],
        &["evaluate", folder],
        &["prompt", "list"],
        &["prompt", "text", "collision-ego.md"],
        &["prompt", "text", &evil_file],
        &["prompt", "diff", "collision-ego.md"],
        &["prompt", "text", EVIL],
        &["models", "--offline"],
        &["models", "--offline", "--format=json"],
        &["config", "themes"],
        &["config", "themes", EVIL],
        &["config", "keys"],
        &["runs", "ratings"],
        &["runs", "ratings", "--format=json"],
        &["runs", "ratings", "--by", "prompt"],
        &["runs", "list"],
        &["inspect", EVIL],
        &["inspect", &files[0], "--ego", EVIL],
        &["ask", &files[0], "--model", &evil_id],
        &["ask", &files[0], "--model", EVIL],
        &[
            "metrics",
            &files[0],
            "-o",
            "no/such/\u{1b}]0;PWNED\u{7}/f.csv",
        ],
        &["runs", "import", EVIL],
        &["convert", &files[0]],
        &["render", &files[0], "-o", "no\u{1b}]0;PWNED\u{7}.xyz"],
        &["\u{1b}]0;PWNED\u{7}"],
        &["config", "keys", "\u{1b}]0;PWNED\u{7}"],
        &["ask", "--task", "\u{1b}]0;PWNED\u{7}"],
    ] {
        commands.push(command.to_vec());
    }
    let commands: Vec<&[&str]> = commands.iter().map(Vec::as_slice).collect();
    let said = all_of(&home, &commands);
    assert!(
        said.matches("PWNED").count() > commands.len(),
        "what was planted is spoken of"
    );
}

#[test]
fn nothing_planted_in_a_configuration_that_is_wrong_reaches_the_terminal() {
    let home = Home::new();
    let thresholds = format!("[\"{IN_TOML}\"]\n\"{IN_TOML}\" = 1\n");
    home.write(home.config().join("thresholds.toml"), thresholds);
    all_of(
        &home,
        &[&["metrics", "ZAM_CutIn-1_1_T-1"], &["metrics", "--list"]],
    );
    for text in [
        format!("theme = {EVIL}"),
        format!("\"{IN_TOML}\" = 1"),
        format!("theme = \"{IN_TOML}\"\nmodel = \"{IN_TOML}\"\n"),
        format!("[provider.\"{IN_TOML}\"]\ndialect = \"{IN_TOML}\"\n"),
    ] {
        home.write(home.config().join("config.toml"), text);
        let commands: [&[&str]; 6] = [
            &["models", "--offline"],
            &["ask", "ZAM_CutIn-1_1_T-1"],
            &["config", "themes"],
            &["config", "keys"],
            &["prompt", "list"],
            &["runs", "list"],
        ];
        all_of(&home, &commands);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nothing_that_a_server_says_reaches_the_terminal_from_the_store() {
    let home = Home::new();
    let verdict = json!({
        "collision": false,
        "obstacles": [{"id": 301, "risk_score": 2, "reason": EVIL}],
        "justification": EVIL,
    });
    let thinking = format!(
        "data: {}\n\n",
        json!({"model": EVIL, "choices": [{"index": 0, "delta": {"reasoning_content": EVIL}}]})
    );
    let reasoned = Script::chunked_events()
        .chunk(thinking)
        .chunk(delta(&verdict.to_string()))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks();
    let body = json!({"error": {"message": EVIL, "type": EVIL, "code": EVIL}}).to_string();
    let html = format!("<html>{EVIL}</html>");
    let scripts = vec![
        reasoned,
        streamed(EVIL),
        Script::json(400, &body),
        Script::json(401, &html),
    ];
    let server = Server::start(scripts).await;
    let model = format!("lab/tiny{EVIL}");
    for _ in 0..4 {
        let arguments = [
            "ask",
            super::CUT_IN,
            "--model",
            &model,
            "--base-url",
            server.base_url(),
            "--set=key_env=LAB_KEY",
            "--fresh",
        ];
        let ended =
            tokio::task::block_in_place(|| home.run_with(&arguments, &[("LAB_KEY", "sk-test-1")]));
        harmless(&arguments, &ended);
    }
    let said = tokio::task::block_in_place(|| {
        all_of(
            &home,
            &[
                &["runs", "note", "1", EVIL],
                &["runs", "list"],
                &["runs", "list", "--format=json"],
                &["runs", "show", "1"],
                &["runs", "show", "2"],
                &["runs", "show", "3"],
                &["runs", "show", "1", "--format=json"],
                &["runs", "list", "PWNED"],
                &["runs", "list", EVIL],
                &["runs", "export"],
                &["runs", "export", "--format", "csv"],
                &["runs", "export", "-o", "runs.csv"],
            ],
        )
    });
    assert!(said.matches("PWNED").count() > 12);
    assert_eq!(home.runs().len(), 4);
}
