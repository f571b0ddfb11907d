//! A batch that is begun in the workbench: the command line lists it, goes on with it and reports it.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::support::program::Home;
use super::support::server::{Script, Server};
use super::{PATIENCE, Session};

/// An answer as a server streams it.
fn yes() -> Script {
    let verdict = json!({"collision": true, "obstacles": [], "justification": "so it is"});
    let delta = json!({
        "model": "small",
        "choices": [{"index": 0, "delta": {"content": verdict.to_string()}}],
    });
    Script::chunked_events()
        .chunk(format!("data: {delta}\n\n"))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

/// The bodies of the questions so far; the workbench also asks which models there are.
fn questions(server: &Server) -> Vec<String> {
    let requests = server.requests().into_iter();
    let questions = requests.filter(|request| request.path.ends_with("/chat/completions"));
    questions
        .map(|request| String::from_utf8_lossy(&request.body).into_owned())
        .collect()
}

/// Asks about all bundled scenarios with a template that is not saved, and leaves when the fourth answer does not come.
fn begin(home: &Home, server: &Server) {
    let (config, data) = (home.config(), home.data());
    home.write(
        config.join("config.toml"),
        format!(
            "model = \"lab/small\"\nconcurrency = 1\n[provider.lab]\nbase_url = \"{}\"\nkey_env = []\nattempts = 1\n",
            server.base_url()
        ),
    );
    let template = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/prompts/collision-ego.md"
    ));
    let draft = template
        .unwrap()
        .replace("Did the ego's", "Be brief. Did the ego's");
    home.write(data.join("drafts/collision-ego.md"), draft);
    let environment = [
        ("NEARMISS_CONFIG", config.to_str().unwrap()),
        ("NEARMISS_DATA", data.to_str().unwrap()),
    ];
    let mut session = Session::start_with(120, 40, &environment, &[]);
    session.see("The body of car 301 overlaps");
    session.press(" aa");
    session.see("8, 1 at once");
    session.press("\r");
    let begun = Instant::now();
    while questions(server).len() < 4 {
        assert!(begun.elapsed() < PATIENCE, "three are answered");
        session.receive(Duration::from_millis(50));
    }
    while session.child.try_wait().unwrap().is_none() {
        assert!(begun.elapsed() < 2 * PATIENCE, "it does not end");
        // The first one warns that questions are running.
        session.press("q");
        session.receive(Duration::from_millis(100));
    }
    assert_eq!(session.end(), 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_of_the_workbench_is_one_of_the_command_line() {
    let asked = AtomicUsize::new(0);
    let server = Server::answering(move |_, request| {
        let is_question = request.path.ends_with("/chat/completions");
        let number = is_question.then(|| asked.fetch_add(1, Ordering::SeqCst))?;
        Some(match number {
            3 => Script::chunked_events().await_close(),
            _ => yes(),
        })
    })
    .await;
    let home = Home::new();
    tokio::task::block_in_place(|| begin(&home, &server));
    let run = |arguments: &[&str]| tokio::task::block_in_place(|| home.run(arguments));
    let listed = run(&["evaluate", "list"]).status(0);
    for words in ["b1 ", "3 of 8 answered", "lab/small", "8 scenarios"] {
        assert!(listed.stdout.contains(words), "{words}: {}", listed.stdout);
    }
    let resumed = run(&["evaluate", "b1", "--format=json"]).status(0);
    let cell = &resumed.json()["cells"][0];
    // Two of the eight scenarios end in a collision.
    let counted = ["n", "tp", "fp", "fn", "tn"].map(|name| cell[name].as_u64());
    assert_eq!(counted, [8, 2, 6, 0, 0].map(Some), "{cell}");
    let questions = questions(&server);
    assert_eq!(questions.len(), 9, "what was answered is not asked again");
    for body in &questions {
        assert!(body.contains("Be brief."), "the draft: {body}");
    }
    let report: Value = run(&["report", "--batch", "b1", "--format=json"])
        .status(0)
        .json();
    assert_eq!(report["batch"], "b1");
    assert_eq!(report["asked"]["models"], json!(["lab/small"]));
    let asked = home.runs();
    assert_eq!(asked.len(), 9, "one was cancelled");
    assert!(
        asked
            .iter()
            .all(|run| run["batch"].as_deref() == Some("b1"))
    );
}
