//! Pictures for models that see: what is drawn, sent in each dialect, counted, stored, exported and refused.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nearmiss::llm::Dialect;
use serde_json::Value;

use super::CUT_IN;
use super::support::dialects::{saying, script};
use super::support::program::{Ended, Home};
use super::support::server::{Recorded, Server};

const HARD_BRAKING: &str = "ZAM_HardBraking-1_1_T-1";

const VERDICT: &str =
    r#"{"collision": false, "obstacles": [], "justification": "The gap stays 2 m."}"#;

/// A server that always gives the same verdict.
async fn judge(dialect: Dialect) -> Server {
    Server::answering(move |_, _| Some(script(dialect).send(saying(dialect, VERDICT)))).await
}

fn ask(home: &Home, url: &str, dialect: Dialect, more: &[&str]) -> Ended {
    let of_server = [
        "--base-url",
        url,
        &format!("--set=dialect={}", dialect.name()),
        "--format=json",
    ];
    let all = [
        &["ask", CUT_IN, "--model", "lab/tiny"],
        &of_server[..],
        more,
    ]
    .concat();
    run(home, &all)
}

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// The picture of a window as `describe` writes it.
pub fn drawn(home: &Home, scenario: &str, more: &[&str]) -> Vec<u8> {
    let file = home.files().join("drawn.png");
    let name = file.display().to_string();
    let written = ["-o", &name, "--overwrite"];
    home.run(&[&["prompt", "describe", scenario], &written[..], more].concat())
        .status(0);
    std::fs::read(file).unwrap()
}

/// The image of a request in the documented place of its API, and the text beside it.
fn shown(dialect: Dialect, body: &Value) -> (Vec<u8>, String) {
    let user = |list: &Value| -> Value {
        let all = list.as_array().unwrap();
        all.iter().rfind(|m| m["role"] == "user").unwrap().clone()
    };
    let text = |value: &Value| value.as_str().unwrap().to_string();
    let url = |value: &Value| {
        let url = text(value);
        url.strip_prefix("data:image/png;base64,")
            .unwrap()
            .to_string()
    };
    let (base64, words) = match dialect {
        Dialect::OpenAiChat => {
            let content = &user(&body["messages"])["content"];
            assert_eq!(content[0]["type"], "image_url");
            (
                url(&content[0]["image_url"]["url"]),
                text(&content[1]["text"]),
            )
        }
        Dialect::OpenAiResponses => {
            let content = &user(&body["input"])["content"];
            assert_eq!(content[0]["type"], "input_image");
            (url(&content[0]["image_url"]), text(&content[1]["text"]))
        }
        Dialect::Anthropic => {
            let content = &user(&body["messages"])["content"];
            let source = &content[0]["source"];
            assert_eq!(
                (&content[0]["type"], &source["type"], &source["media_type"]),
                (&"image".into(), &"base64".into(), &"image/png".into())
            );
            (text(&source["data"]), text(&content[1]["text"]))
        }
        Dialect::Gemini => {
            let parts = &user(&body["contents"])["parts"];
            let data = &parts[0]["inlineData"];
            assert_eq!(data["mimeType"], "image/png");
            (text(&data["data"]), text(&parts[1]["text"]))
        }
        Dialect::Ollama => {
            let message = user(&body["messages"]);
            (text(&message["images"][0]), text(&message["content"]))
        }
    };
    (STANDARD.decode(base64).unwrap(), words)
}

#[test]
fn the_same_window_is_the_same_file_and_says_nothing_of_where_it_comes_from() {
    let home = Home::new();
    let first = drawn(&home, CUT_IN, &["--frame", "picture"]);
    assert!(first.starts_with(b"\x89PNG"));
    assert_eq!(first, drawn(&Home::new(), CUT_IN, &["--frame", "picture"]));
    // The words beside it change nothing about it; another window does, and so does north above.
    assert_eq!(first, drawn(&home, CUT_IN, &["--frame", "ego+picture"]));
    for other in [
        &["--frame", "picture", "--at", "20"][..],
        &["--frame", "picture", "--set=radius=15"],
        &["--frame", "cartesian+picture"],
    ] {
        assert_ne!(first, drawn(&home, CUT_IN, other), "{other:?}");
    }
    for told in [&b"CutIn"[..], b"ZAM", b"tEXt", b"iTXt"] {
        assert!(!first.windows(told.len()).any(|part| part == told));
    }
}

#[test]
fn what_follows_the_window_leaves_no_trace() {
    let home = Home::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for (name, last) in [(CUT_IN, 20), (HARD_BRAKING, 15)] {
        let read =
            |ending: &str| std::fs::read_to_string(folder.join(format!("{name}{ending}"))).unwrap();
        let whole = home.write(format!("{name}.xml"), read(".xml"));
        home.write(
            format!("{name}.ego_trajectory.csv"),
            read(".ego_trajectory.csv"),
        );
        let at = last.to_string();
        let asked = [
            &["--frame", "picture"][..],
            &["--frame", "trajectory+picture", "--obstacle", "301"],
        ]
        .map(|frame| [frame, &["--at", &at, "--history", "10"]].concat());
        let of_whole =
            { asked.each_ref() }.map(|asked| drawn(&home, &whole.display().to_string(), asked));

        // The same recording, cut off behind the window.
        let step = |state: &str| -> Option<i64> {
            let time = state.split("<time>").nth(1)?;
            time.split("<exact>")
                .nth(1)?
                .split('<')
                .next()?
                .trim()
                .parse()
                .ok()
        };
        let xml = read(".xml");
        let mut parts = xml.split("<state>");
        let mut cut = parts.next().unwrap().to_string();
        for part in parts {
            let (state, behind) = part.split_once("</state>").unwrap();
            if step(state).is_none_or(|step| step <= last) {
                cut.push_str(&format!("<state>{state}</state>"));
            }
            cut.push_str(behind);
        }
        assert!(cut.len() < xml.len());
        let rows = read(".ego_trajectory.csv");
        let kept = rows.lines().filter(|row| {
            let step = row
                .split(',')
                .nth(1)
                .and_then(|step| step.parse::<i64>().ok());
            step.is_none_or(|step| step <= last)
        });
        let kept: Vec<&str> = kept.collect();
        assert!(kept.len() < rows.lines().count());
        let there = home.write(format!("cut/{name}.xml"), cut);
        home.write(format!("cut/{name}.ego_trajectory.csv"), kept.join("\n"));
        let of_cut =
            { asked.each_ref() }.map(|asked| drawn(&home, &there.display().to_string(), asked));
        assert!(of_whole == of_cut, "{name}");
        assert!(of_cut[0] != of_cut[1]);
    }
}

#[test]
fn what_cannot_be_written_is_said() {
    let home = Home::new();
    let file = home.files().join("a.png").display().to_string();
    home.run(&["prompt", "describe", CUT_IN, "--frame", "ego", "-o", &file])
        .status(2)
        .says(&["the ego frame has no picture", "--frame picture"]);
    home.run(&[
        "prompt", "describe", CUT_IN, "--frame", "picture", "-o", &file,
    ])
    .status(0);
    home.run(&[
        "prompt", "describe", CUT_IN, "--frame", "picture", "-o", &file,
    ])
    .status(2)
    .says(&["a.png", "--overwrite"]);
    let text = home.files().join("a.txt").display().to_string();
    home.run(&["prompt", "describe", CUT_IN, "-o", &text])
        .status(0);
    assert!(std::fs::read_to_string(&text).unwrap().contains("m/s"));
    home.run(&["prompt", "describe", CUT_IN, "--frame", "pictures"])
        .status(2)
        .says(&["picture"]);
    let document = home
        .run(&[
            "prompt",
            "describe",
            CUT_IN,
            "--frame",
            "picture",
            "--format=json",
        ])
        .status(0)
        .json();
    assert_eq!(document["picture"]["height"], 768);
    assert_eq!(document["picture"]["sha256"].as_str().unwrap().len(), 64);
    // The options of the words go with the words, beside a picture too.
    home.run(&[
        "prompt",
        "describe",
        CUT_IN,
        "--frame",
        "ego+picture",
        "--set=axes=lane",
    ])
    .status(0);
    home.run(&[
        "prompt",
        "describe",
        CUT_IN,
        "--frame",
        "picture",
        "--set=axes=lane",
    ])
    .status(2);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_dialect_is_sent_the_picture_and_its_answer_is_not_asked_for_again() {
    for dialect in Dialect::ALL {
        let home = Home::new();
        let server = judge(dialect).await;
        let url = server.base_url();
        let file = tokio::task::block_in_place(|| drawn(&home, CUT_IN, &["--frame", "picture"]));
        let alone = ask(&home, url, dialect, &["--frame", "picture"])
            .status(0)
            .json();
        assert_eq!(
            (&alone["dangerous"], &alone["frame"]),
            (&false.into(), &"picture".into())
        );
        ask(&home, url, dialect, &["--frame", "ego+picture"]).status(0);
        let bodies: Vec<Value> = server.requests().iter().map(Recorded::json).collect();
        let (image, words) = shown(dialect, &bodies[0]);
        assert_eq!(image, file, "{dialect:?}");
        assert!(words.contains("The picture shows the scene from above"));
        assert!(
            !words.contains("v rel long"),
            "no words of the scene: {words}"
        );
        let (image, words) = shown(dialect, &bodies[1]);
        assert_eq!(image, file);
        assert!(words.contains("v rel long") && words.contains("The picture shows"));

        let again = ask(&home, url, dialect, &["--frame", "picture"])
            .status(0)
            .json();
        assert_eq!(again["run"], alone["run"]);
        assert_eq!(server.requests().len(), 2);
        // Messages name it, and the store has it once.
        let rows = home.rows("SELECT messages, frame FROM runs ORDER BY id");
        let messages = rows[0]["messages"].as_deref().unwrap();
        assert!(
            messages.contains("\"sha256\"") && messages.len() < 20_000,
            "{messages}"
        );
        assert_eq!(rows[1]["frame"].as_deref(), Some("ego+picture"));
        let images = home.rows("SELECT sha256, hex(bytes) AS bytes FROM images");
        assert_eq!(images.len(), 1);
        assert!(messages.contains(images[0]["sha256"].as_deref().unwrap()));
        let kept = images[0]["bytes"].as_deref().unwrap();
        assert_eq!(kept.len(), 2 * file.len());
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_model_that_does_not_see_is_refused_before_anything_is_sent() {
    let dialect = Dialect::OpenAiChat;
    let server = judge(dialect).await;
    let home = Home::new();
    let blind = "[provider.lab]\nquirks = { images = false }\n";
    home.write(home.config().join("config.toml"), blind);
    ask(
        &home,
        server.base_url(),
        dialect,
        &["--frame", "ego+picture"],
    )
    .status(2)
    .says(&["tiny takes no pictures", "images = true"]);
    assert_eq!(server.requests().len(), 0);
    ask(&home, server.base_url(), dialect, &["--frame", "ego"]).status(0);
    assert_eq!(home.rows("SELECT id FROM runs").len(), 1, "no run of it");
}

const PRICES: &str = "max_tokens = 100\n[provider.lab]\nquirks = { image_tokens = { each = 50000 } }\n[[provider.lab.prices]]\nmodel = \"tiny*\"\ninput = 1000\noutput = 0\n";

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_picture_is_counted_before_it_is_sent() {
    let dialect = Dialect::OpenAiChat;
    let server = judge(dialect).await;
    let home = Home::new();
    let settings = format!(
        "base_url = \"{}\"\ndialect = \"openai_chat\"",
        server.base_url()
    );
    let config = PRICES.replacen("[provider.lab]", &format!("[provider.lab]\n{settings}"), 1);
    home.write(home.config().join("config.toml"), config);
    let dry = |frames: &str| {
        let frames = format!("frames={frames}");
        let all = [
            "evaluate",
            CUT_IN,
            "--model",
            "lab/tiny",
            "--set",
            &frames,
            "--dry-run",
        ];
        let ended = run(&home, &all).status(0);
        let text = ended.stdout + &ended.stderr;
        let after = text
            .split("at most $")
            .nth(1)
            .unwrap_or_else(|| panic!("{text}"));
        let number: String = after
            .chars()
            .take_while(|c| "0123456789.".contains(*c))
            .collect();
        number.trim_end_matches('.').parse::<f64>().unwrap()
    };
    // 50,000 tokens at 1000 dollars a million.
    let (words, both) = (dry("ego"), dry("ego+picture"));
    assert!(both - words > 50.0 && both - words < 52.0, "{words} {both}");
    let refused = ask(
        &home,
        server.base_url(),
        dialect,
        &[
            "--frame",
            "picture",
            "--budget",
            "40",
            "--set=max_tokens=100",
        ],
    );
    refused.status(2).says(&["budget"]);
    assert_eq!(server.requests().len(), 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_has_pictures_as_frames_and_its_export_carries_them() {
    let dialect = Dialect::OpenAiChat;
    let server = judge(dialect).await;
    let home = Home::new();
    let config = format!(
        "[provider.lab]\nbase_url = \"{}\"\ndialect = \"openai_chat\"\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), &config);
    let all = ["evaluate", CUT_IN, HARD_BRAKING, "--model", "lab/tiny"];
    let frames = [
        "--set",
        "frames=ego,picture,ego+picture",
        "--task",
        "collision",
        "--format=json",
    ];
    let rows = run(&home, &[&all[..], &frames].concat()).status(0).stdout;
    for frame in ["\"ego\"", "\"picture\"", "\"ego+picture\""] {
        assert!(rows.contains(frame), "{frame}: {rows}");
    }
    assert_eq!(server.requests().len(), 6);
    run(&home, &["evaluate", "last"]).status(0);
    assert_eq!(server.requests().len(), 6, "nothing is asked twice");
    assert_eq!(home.rows("SELECT sha256 FROM images").len(), 2);

    let file = home.files().join("all.jsonl").display().to_string();
    run(&home, &["runs", "export", "-o", &file]).status(0);
    let lines = std::fs::read_to_string(&file).unwrap();
    let images = lines
        .lines()
        .filter(|line| line.contains("\"nearmiss_image\""));
    let images: Vec<Value> = images
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(images.len(), 2, "each once");
    let schema = run(&home, &["help", "json", "--schema", "image"]).status(0);
    let schema = serde_json::from_str(&schema.stdout).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    assert!(
        images.iter().all(|image| validator.is_valid(image)),
        "{images:?}"
    );
    let shown = home.files().join("shown.png").display().to_string();
    let asked = "SELECT id FROM runs WHERE frame = 'picture' ORDER BY id";
    let id = home.rows(asked)[0]["id"].clone().unwrap();
    run(&home, &["runs", "show", &id, "-o", &shown]).status(0);
    assert!(std::fs::read(&shown).unwrap().starts_with(b"\x89PNG"));
    let asked = "SELECT id FROM runs WHERE frame = 'ego' ORDER BY id";
    let id = home.rows(asked)[0]["id"].clone().unwrap();
    run(&home, &["runs", "show", &id, "-o", &shown])
        .status(2)
        .says(&["asked without a picture"]);
    let other = Home::new();
    run(&other, &["runs", "import", &file]).status(0);
    let hashes = |home: &Home| home.rows("SELECT sha256, hex(bytes) AS b FROM images ORDER BY 1");
    assert_eq!(hashes(&other), hashes(&home));

    // The same as an experiment file, whose answers are there; its bundle carries the pictures, too.
    home.write(
        "seen.toml",
        format!(
            "title = \"Seen\"\nscenarios = [\"{CUT_IN}\", \"{HARD_BRAKING}\"]\nmodels = [\"lab/tiny\"]\ntasks = [\"collision\"]\nframes = [\"ego\", \"picture\", \"ego+picture\"]\n"
        ),
    );
    run(&home, &["evaluate", "seen.toml"]).status(0);
    assert_eq!(server.requests().len(), 6, "all of it was asked before");
    run(
        &home,
        &[
            "runs",
            "export",
            "--format=bundle",
            "--batch",
            "last",
            "-o",
            "seen.nearmiss",
        ],
    )
    .status(0);
    let third = Home::new();
    let bundle = home.files().join("seen.nearmiss").display().to_string();
    run(&third, &["runs", "import", &bundle]).status(0);
    assert_eq!(hashes(&third), hashes(&home));
    let report = run(&third, &["report", "--batch", "last", "--format=json"])
        .status(0)
        .stdout;
    assert!(report.contains("ego+picture"), "{report}");
}
