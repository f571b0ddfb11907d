//! Servers that give back what they were sent, in every form and place: none of it is shown or kept. And what is not
//! sent at all, since others could read it.

use serde_json::{Value, json};

use super::CUT_IN;
use super::support::program::{Ended, Home};
use super::support::secret::{leak, quoted};
use super::support::server::{Script, Server};

const KEY: &str = "sk-test/9f8e7d6c+5b4a3210=x";
const TEAM: &str = "Bearer t3am-9f8e7d6c";
const QUERY: &str = "tok3n-in-the-query";
const SECRETS: [&str; 3] = [KEY, "t3am-9f8e7d6c", QUERY];

/// What a server says in one answer; all of it is put between quotation marks as it stands.
struct Words {
    model: String,
    reasoning: String,
    text: String,
    refusal: String,
    finish: String,
}

/// A string of JSON around text whose escapes are meant to be escapes.
fn string(text: &str) -> Value {
    serde_json::from_str(&format!("\"{text}\"")).unwrap()
}

/// Pieces of a few letters.
fn pieces(text: &str) -> Vec<String> {
    let letters: Vec<char> = text.chars().collect();
    letters.chunks(7).map(|c| c.iter().collect()).collect()
}

/// The events of an answer in a dialect.
fn events(dialect: &str, words: &Words) -> Vec<Value> {
    let (model, finish) = (string(&words.model), string(&words.finish));
    let mut events = Vec::new();
    let mut each = |text: &str, event: &dyn Fn(String) -> Value| {
        events.extend(pieces(text).into_iter().map(event));
    };
    match dialect {
        "openai_chat" => {
            let delta = |key: &'static str| {
                let model = model.clone();
                move |text: String| json!({"model": model, "choices": [{"index": 0, "delta": {key: text}}]})
            };
            each(&words.reasoning, &delta("reasoning_content"));
            each(&words.text, &delta("content"));
            each(&words.refusal, &delta("refusal"));
            events.push(json!({"choices": [{"index": 0, "delta": {}, "finish_reason": finish}]}));
        }
        "openai_responses" => {
            let delta =
                |kind: &'static str| move |text: String| json!({"type": kind, "delta": text});
            each(
                &words.reasoning,
                &delta("response.reasoning_summary_text.delta"),
            );
            each(&words.text, &delta("response.output_text.delta"));
            each(&words.refusal, &delta("response.refusal.delta"));
            events.push(json!({"type": "response.incomplete", "response": {"model": model, "status": "incomplete",
                "incomplete_details": {"reason": finish}}}));
        }
        "gemini" => {
            let part = |thought: bool| {
                let model = model.clone();
                move |text: String| json!({"modelVersion": model, "candidates": [{"content": {"parts": [{"text": text, "thought": thought}]}}]})
            };
            each(&words.reasoning, &part(true));
            each(&words.text, &part(false));
            events.push(json!({"candidates": [{"finishReason": finish}]}));
        }
        "anthropic" => {
            events.push(json!({"type": "message_start", "message": {"model": model}}));
            let mut each = |text: &str, event: &dyn Fn(String) -> Value| {
                events.extend(pieces(text).into_iter().map(event));
            };
            let delta = |kind: &'static str, key: &'static str| move |text: String| json!({"type": "content_block_delta", "index": 0, "delta": {"type": kind, key: text}});
            each(&words.reasoning, &delta("thinking_delta", "thinking"));
            each(&words.text, &delta("text_delta", "text"));
            events.push(json!({"type": "message_delta", "delta": {"stop_reason": finish}}));
            events.push(json!({"type": "message_stop"}));
        }
        _ => {
            let message = |key: &'static str| {
                let model = model.clone();
                move |text: String| json!({"model": model, "message": {key: text}, "done": false})
            };
            each(&words.reasoning, &message("thinking"));
            each(&words.text, &message("content"));
            events.push(json!({"model": model, "done": true, "done_reason": finish}));
        }
    }
    events
}

fn script(dialect: &str, events: &[Value]) -> Script {
    let (head, before, after) = match dialect {
        "ollama" => (Script::lines(), "", "\n"),
        _ => (Script::events(), "data: ", "\n\n"),
    };
    let lines = events.iter().map(|event| format!("{before}{event}{after}"));
    head.send(lines.collect::<String>())
}

/// What a server answers that quotes all it was sent, in one way after the other.
fn scripts(dialect: &str) -> Vec<Script> {
    let all = quoted(&SECRETS);
    let verdict = format!(
        "{{\"collision\": true, \"obstacles\": [{{\"id\": 301, \"risk_score\": 1, \"reason\": \"close {all}\"}}], \"justification\": \"It {all} cuts in.\"}}"
    );
    let words = |text: &str, refusal: &str, finish: &str| Words {
        model: all.clone(),
        reasoning: format!("You sent {all}."),
        text: text.to_owned(),
        refusal: refusal.to_owned(),
        finish: finish.to_owned(),
    };
    let stop = if dialect == "anthropic" {
        "end_turn"
    } else {
        "stop"
    };
    let stop = if dialect == "gemini" { "STOP" } else { stop };
    let answer = events(dialect, &words(&verdict, "", stop));
    let refused = events(dialect, &words("", &format!("No: {all}"), stop));
    let odd = events(dialect, &words(&verdict, "", &all));
    let error = json!({"error": {"message": string(&all), "code": string(&all), "type": KEY}});
    let mut broken = answer[..answer.len() - 1].to_vec();
    broken.push(error.clone());
    // It breaks off inside the key, all but one letter of which had come.
    let almost = format!("You sent {}", &KEY[..KEY.len() - 1]);
    let almost = &events(dialect, &words(&almost, "", stop));
    let raw = format!("{{\"error\": {{\"message\": \"{all}\"}}}}");
    vec![
        script(dialect, &answer),
        script(dialect, &refused),
        script(dialect, &odd),
        script(dialect, &broken),
        script(dialect, &almost[..almost.len() - 2]),
        script(dialect, &answer[..3]).send(format!("data: {all}\n\n")),
        Script::json(400, &raw),
        Script::json(401, &error.to_string()),
        Script::answer(403, &[("X-Key", KEY)], &format!("<p>{all}</p>")),
        Script::json(200, &raw),
        Script::answer(302, &[("Location", &format!("/{KEY}?key={KEY}"))], ""),
    ]
}

fn home(dialect: &str, server: &Server) -> Home {
    let home = Home::new();
    let config = format!(
        "[provider.lab]\ndialect = \"{dialect}\"\nbase_url = \"{}?token={QUERY}\"\nkey_env = \"LAB_KEY\"\n\
         header_env = {{ X-Team = \"LAB_TEAM\" }}\nattempts = 1\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    home
}

#[track_caller]
fn run(home: &Home, arguments: &[&str]) -> Ended {
    let variables = [("LAB_KEY", KEY), ("LAB_TEAM", TEAM)];
    let ended = tokio::task::block_in_place(|| home.run_with(arguments, &variables));
    for text in [&ended.stdout, &ended.stderr] {
        let leak = leak(&SECRETS, text.as_bytes());
        assert_eq!(leak, None, "{arguments:?}: {text}");
    }
    ended
}

/// Every file that the program wrote.
fn files(home: &Home) -> Vec<std::path::PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![home.data(), home.files()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path)
            } else {
                found.push(path)
            }
        }
    }
    found
}

async fn nothing_comes_back(dialect: &str) {
    let scripts = scripts(dialect);
    let server = Server::start(scripts.clone()).await;
    let home = home(dialect, &server);
    let mut said = String::new();
    for number in 0..scripts.len() {
        let json = [
            "ask",
            CUT_IN,
            "--model",
            "lab/tiny",
            "--fresh",
            "--format=json",
        ];
        let arguments = if number % 2 == 0 {
            &json[..]
        } else {
            &json[..5]
        };
        let ended = run(&home, arguments);
        said += &ended.stdout;
        said += &ended.stderr;
    }
    let requests = server.requests();
    assert_eq!(requests.len(), scripts.len(), "each was asked: {said}");
    assert!(requests[0].path.contains(QUERY));
    assert_eq!(requests[0].header("x-team"), Some(TEAM));
    assert!(said.contains("[key]"), "{said}");
    assert_eq!(home.runs().len(), scripts.len());
    assert!(home.runs()[0]["verdict"].is_some(), "{:?}", home.runs()[0]);
    for number in 1..=scripts.len() {
        run(&home, &["runs", "show", &number.to_string()]);
    }
    for more in [
        &["runs", "list", "--format=json"][..],
        &["runs", "show", "1", "--format=json"],
        &["runs", "export", "-o", "runs.jsonl"],
        &["runs", "export", "-o", "runs.csv"],
        &["config", "print"],
    ] {
        run(&home, more);
    }
    let files = files(&home);
    assert!(files.len() >= 3, "{files:?}");
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        assert_eq!(leak(&SECRETS, &bytes), None, "{}", file.display());
    }
}

macro_rules! nothing_comes_back {
    ($($name:ident: $dialect:literal),*) => {$(
        #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
        async fn $name() {
            nothing_comes_back($dialect).await;
        }
    )*};
}

nothing_comes_back!(
    nothing_comes_back_from_chat_completions: "openai_chat",
    nothing_comes_back_from_responses: "openai_responses",
    nothing_comes_back_from_gemini: "gemini",
    nothing_comes_back_from_anthropic: "anthropic",
    nothing_comes_back_from_ollama: "ollama"
);

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_secret_is_no_name_of_a_model() {
    let all = quoted(&SECRETS);
    let body = format!(
        "{{\"data\": [{{\"id\": \"good-1\"}}, {{\"id\": \"{KEY}\", \"name\": \"{all}\"}}, {{\"id\": \"{all}\"}}, {{\"id\": \"x-{KEY}\"}}]}}"
    );
    let server = Server::answering(move |_, _| Some(Script::json(200, &body))).await;
    let home = home("openai_chat", &server);
    let listed = run(&home, &["models", "--all", "--format=json"])
        .status(0)
        .stdout;
    assert!(listed.contains("lab/good-1"), "{listed}");
    assert!(!listed.contains("[key]"), "{listed}");
    run(&home, &["models", "--all"]).status(0);
    run(&home, &["doctor", "--online"]);
    assert_eq!(server.requests().len(), 3);
}

#[test]
fn no_secret_is_sent_where_others_can_read_it() {
    let home = Home::new();
    let marker = home.files().join("was-run");
    let command = format!("touch '{}'; echo {KEY}", marker.display());
    // 192.0.2.0/24 is nowhere: a request would wait for the connection.
    let config = format!(
        "[provider.lab]\nbase_url = \"http://192.0.2.1:9/v1\"\nkey_env = \"LAB_KEY\"\n\
         [provider.head]\nbase_url = \"http://192.0.2.1:9/v1\"\nheader_env = {{ X-Team = \"LAB_TEAM\" }}\n\
         [provider.printed]\nbase_url = \"http://192.0.2.1:9/v1\"\nkey_command = {}\n",
        toml::Value::String(command)
    );
    home.write(home.config().join("config.toml"), &config);
    let variables = [("LAB_KEY", KEY), ("LAB_TEAM", TEAM)];
    for (name, what) in [
        ("lab", "the key from LAB_KEY"),
        ("head", "`X-Team`"),
        ("printed", "the command `touch`"),
    ] {
        let model = format!("{name}/tiny");
        for arguments in [
            &["ask", CUT_IN, "--model", &model][..],
            &[
                "evaluate",
                CUT_IN,
                "--model",
                &model,
                "--set",
                "max_tokens=9",
                "--batch",
            ],
        ] {
            let ended = home.run_with(arguments, &variables);
            let allow = format!("allow_http = true for [provider.{name}]");
            let ended = ended.says(&[
                "http://192.0.2.1:9",
                what,
                "unencrypted",
                "https://",
                &allow,
            ]);
            assert_eq!(leak(&SECRETS, ended.stderr.as_bytes()), None, "{ended:?}");
            if arguments[0] == "ask" {
                assert_eq!(ended.status, Some(2), "{ended:?}");
            }
        }
    }
    assert!(
        !marker.exists(),
        "no command is asked for a key that is not sent"
    );
    let doctor = home.run_with(&["doctor"], &variables).status(1);
    assert!(doctor.stdout.contains("allow_http"), "{}", doctor.stdout);
    let ended = home.run_with(
        &[
            "evaluate",
            CUT_IN,
            "--model",
            "lab/tiny",
            "--set",
            "base_url=http://me:hunter22@127.0.0.1:1",
        ],
        &variables,
    );
    ended
        .status(2)
        .says(&["--set base_url", "password", "config.toml"]);
    assert!(home.files_with("hunter22").is_empty());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_goes_to_this_machine_passes_no_proxy() {
    let server = Server::answering(|_, _| Some(Script::json(400, "{}"))).await;
    let proxy = Server::answering(|_, _| Some(Script::json(400, "{}"))).await;
    let home = home("openai_chat", &server);
    let variables = [
        ("LAB_KEY", KEY),
        ("HTTP_PROXY", proxy.base_url()),
        ("http_proxy", proxy.base_url()),
    ];
    let arguments = ["ask", CUT_IN, "--model", "lab/tiny"];
    tokio::task::block_in_place(|| home.run_with(&arguments, &variables)).status(1);
    assert_eq!((server.requests().len(), proxy.requests().len()), (1, 0));
}
