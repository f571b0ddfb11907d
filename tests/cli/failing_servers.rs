//! `evaluate` where a server does not answer or refuses: its questions stay open, the others are asked.

use super::batches::{FINISH, telling};
use super::remote::delta;
use super::support::program::{Ended, Home};
use super::support::server::{Recorded, Script, Server};
use super::{BUNDLED, CUT_IN};

const SAYS: &str = r#"{"collision": true, "obstacles": [], "justification": "so"}"#;

/// Two providers at these addresses.
fn configure(home: &Home, lab: &str, other: &str) {
    let provider = |name: &str, url: &str| {
        format!("[provider.{name}]\nbase_url = \"{url}\"\nkey_env = []\nconcurrency = 1\n")
    };
    let config = provider("lab", lab) + &provider("other", other);
    home.write(home.config().join("config.toml"), config);
}

fn run(home: &Home, models: &str) -> Ended {
    let names = BUNDLED.map(|(name, _)| name);
    let options = ["--model", models, "--task", "collision", "--samples", "4"];
    let all = [&["evaluate"], &names[..], &options[..]].concat();
    tokio::task::block_in_place(|| home.run(&all))
}

fn resume(home: &Home) -> Ended {
    tokio::task::block_in_place(|| home.run(&["evaluate", "last"]))
}

/// Questions to a model that stand like this.
fn count(home: &Home, model: &str, state: &str) -> usize {
    let rows = home.rows("SELECT model, state FROM items");
    let is = |name: &str, row: &std::collections::BTreeMap<String, Option<String>>, is: &str| {
        row[name].as_deref() == Some(is)
    };
    let found = rows.iter();
    found
        .filter(|row| is("model", row, model) && is("state", row, state))
        .count()
}

/// An address without a listener.
fn nowhere() -> String {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    format!("http://{}", listener.local_addr().unwrap())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_that_is_not_there_is_left_alone_and_the_others_go_on() {
    let other = Server::answering(|_, _| Some(telling(SAYS))).await;
    let home = Home::new();
    configure(&home, &nowhere(), other.base_url());
    run(&home, "lab/a,lab/b,other/tiny").status(1).says(&[
        "lab: not asked further after 5 questions in a row without an answer: ",
        "cannot reach lab",
        "27 questions stay open",
        "of 48 questions, 32 without a complete answer; `nearmiss evaluate b1`",
    ]);
    assert_eq!(count(&home, "other/tiny", "answered"), 16);
    let of = |state| count(&home, "lab/a", state) + count(&home, "lab/b", state);
    assert_eq!((of("failed"), of("waiting")), (5, 27));
    // Who was asked little is held against no requirement.
    home.run(&["report", "--batch", "last", "--require", "n >= 1"])
        .status(1)
        .says(&["not met: every question asked (b1): 27 questions not asked yet"]);
    // It is there again, and nothing that was answered is asked again.
    let lab = Server::answering(|_, _| Some(telling(SAYS))).await;
    configure(&home, lab.base_url(), other.base_url());
    resume(&home).status(0);
    assert_eq!((of("answered"), lab.requests().len()), (32, 32));
    assert_eq!(other.requests().len(), 16);
    home.run(&["report", "--batch", "last", "--require", "n >= 1"])
        .status(0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_server_cut_has_no_verdict_in_any_report() {
    let usage =
        r#"data: {"choices": [], "usage": {"prompt_tokens": 1024, "completion_tokens": 9}}"#;
    let cut = move |_: usize, _: &Recorded| {
        let said = Script::chunked_events()
            .chunk(delta(SAYS))
            .chunk(FINISH)
            .chunk(format!("{usage}\n\n"));
        Some(said.chunk("data: [DONE]\n\n").end_of_chunks())
    };
    let server = Server::answering(cut).await;
    let home = Home::new();
    configure(&home, server.base_url(), &nowhere());
    let asked = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/a",
        "--task",
        "collision",
    ];
    tokio::task::block_in_place(|| home.run(&asked)).status(0);
    for report in [&["report", "--batch", "last"][..], &["report"]] {
        let said = home
            .run(&[report, &["--format", "json"]].concat())
            .status(0);
        let json: serde_json::Value = serde_json::from_str(&said.stdout).unwrap();
        let cells = json["cells"].as_array().unwrap();
        let cell = cells.iter().find(|cell| cell["model"] == "lab/a").unwrap();
        assert_eq!(
            (&cell["unparsed"], &cell["tp"]),
            (&1.into(), &0.into()),
            "{cell}"
        );
    }
}

/// Of a form, first the bounds are left out, then the form; who asks again begins with what was taken.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_that_refuses_bounds_gets_the_schema_without_and_one_that_refuses_it_none() {
    for (refused, wanted) in [
        ("maxLength", ["bounds in the form"].as_slice()),
        ("json_schema", &["bounds in the form", "form of the answer"]),
    ] {
        let server = Server::answering(move |_, request| {
            let has = String::from_utf8_lossy(&request.body).contains(refused);
            Some(if has {
                Script::json(400, r#"{"error": {"message": "unsupported json_schema"}}"#)
            } else {
                telling(SAYS)
            })
        })
        .await;
        let home = Home::new();
        configure(&home, server.base_url(), &nowhere());
        let asked = ["ask", CUT_IN, "--model", "lab/a", "--task", "collision"];
        tokio::task::block_in_place(|| home.run(&asked))
            .status(0)
            .says(wanted);
        let bodies = server.requests();
        let bodies: Vec<String> = { bodies.iter() }
            .map(|request| String::from_utf8_lossy(&request.body).into_owned())
            .collect();
        assert_eq!(bodies.len(), wanted.len() + 1);
        assert!(bodies[0].contains("maxLength") && bodies[0].contains("maxItems"));
        assert!(!bodies[1].contains("maxLength") && bodies[1].contains("json_schema"));
        assert_eq!(
            bodies[wanted.len()].contains("json_schema"),
            refused == "maxLength"
        );
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_that_closes_each_connection_counts_as_none_and_one_that_does_so_at_times_does_not()
 {
    // Four in a row, then an answer, and so on.
    let rough = Server::answering(|number, _| match number % 5 {
        4 => Some(telling(SAYS)),
        _ => Some(Script::silent()),
    })
    .await;
    let mute = Server::answering(|_, _| Some(Script::silent())).await;
    let home = Home::new();
    configure(&home, rough.base_url(), mute.base_url());
    let ended = run(&home, "lab/a,other/a").status(1).says(&[
        "other: not asked further after 5 questions",
        "11 questions stay open",
    ]);
    assert!(!ended.stderr.contains("lab: not asked"), "{}", ended.stderr);
    assert_eq!(count(&home, "lab/a", "waiting"), 0);
    assert_eq!((rough.requests().len(), mute.requests().len()), (16, 5));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_model_that_is_refused_is_asked_once_and_the_others_of_its_server_go_on() {
    for (status, words, asked) in [
        (401, "requires a key", 1),
        (404, "does not know model", 1),
        (402, "exhausted", 1),
        (403, "after 5 questions in a row", 5),
    ] {
        let server = Server::answering(move |_, request| {
            Some(if request.json()["model"] == "bad" {
                Script::json(status, r#"{"error": {"message": "not you"}}"#)
            } else {
                telling(SAYS)
            })
        })
        .await;
        let home = Home::new();
        configure(&home, server.base_url(), &nowhere());
        let open = format!("{} questions stay open", 16 - asked);
        run(&home, "lab/bad,lab/good").status(1).says(&[
            "lab/bad: not asked further",
            words,
            "not you",
            &open,
        ]);
        assert_eq!(count(&home, "lab/good", "answered"), 16, "{status}");
        let failed = count(&home, "lab/bad", "failed");
        assert_eq!((failed, server.requests().len()), (asked, 16 + asked));
        // What was never asked has its turn before what failed.
        resume(&home)
            .status(1)
            .says(&["lab/bad: not asked further"]);
        assert_eq!(count(&home, "lab/bad", "failed"), 2 * asked, "{status}");
    }
}
