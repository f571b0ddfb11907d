//! What comes from outside is shown, never obeyed; and a reader that goes away is no reason to panic.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use serde_json::json;

use super::remote::{ask, streamed};
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};
use super::{CUT_IN, bundled_ego, bundled_xml};

/// Sets a title, clears the screen, and the one-byte form of the same.
const EVIL: &str = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{9b}31m";

#[track_caller]
fn harmless(text: &str) {
    let bad = text
        .char_indices()
        .find(|(_, c)| c.is_control() && !matches!(c, '\n' | '\t'));
    if let Some((at, c)) = bad {
        let around: String = text[..at].chars().rev().take(60).collect();
        panic!(
            "{c:?} comes behind {:?}",
            around.chars().rev().collect::<String>()
        );
    }
}

#[track_caller]
fn both_harmless(ended: &Ended) {
    harmless(&ended.stdout);
    harmless(&ended.stderr);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn control_characters_of_a_model_are_shown() {
    let home = Home::new();
    let verdict = json!({
        "collision": false,
        "obstacles": [{"id": 301, "risk_score": 2, "reason": EVIL}],
        "justification": format!("because {EVIL}"),
    });
    let words = format!("no verdict {EVIL} here");
    let scripts = [verdict.to_string(), words].map(|text| streamed(&text));
    let server = Server::start([scripts.clone(), scripts].concat()).await;
    let url = server.base_url();
    let json = ["--fresh", "--format=json"];
    for (more, status) in [(&json[..1], 0), (&json[..1], 1), (&json, 0), (&json, 1)] {
        let ended = ask(&home, url, more).status(status);
        both_harmless(&ended);
        if more.len() > 1 {
            let text = ended.json().to_string();
            assert!(text.contains("owned"), "{text}");
        }
    }
    let kept = home.runs()[1]["answer"].clone().unwrap();
    assert!(
        kept.contains(EVIL),
        "the store keeps what was said, byte for byte"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn control_characters_of_a_server_are_shown() {
    let home = Home::new();
    let body = json!({"error": {"message": EVIL}}).to_string();
    let server = Server::start(vec![Script::json(400, &body), Script::json(400, &body)]).await;
    for more in [&[][..], &["--format=json"]] {
        both_harmless(&ask(&home, server.base_url(), more).status(1));
    }
}

#[test]
fn control_characters_of_a_file_are_shown() {
    let home = Home::new();
    let good = bundled_xml(CUT_IN);
    let named = good
        .replacen("benchmarkID=\"", &format!("benchmarkID=\"{EVIL}"), 1)
        .replacen("author=\"", &format!("author=\"{EVIL}"), 1);
    home.write("named.xml", named);
    home.write("named.ego_trajectory.csv", bundled_ego(CUT_IN));
    home.write("value.xml", good.replacen("<x>", &format!("<x>{EVIL}"), 1));
    home.write("element.xml", format!("<{EVIL}/>"));
    home.write(
        "kind.xml",
        good.replacen("<type>", &format!("<type>{EVIL}"), 1),
    );
    for file in ["named.xml", "value.xml", "element.xml", "kind.xml"] {
        for arguments in [
            &["inspect", file][..],
            &["inspect", "--format=json", file],
            &["metrics", file],
            &["prompt", "describe", file],
            &["prompt", "show", file],
            &["prompt", "show", "--format=json", file],
            &["ask", file],
            &[file],
        ] {
            both_harmless(&home.run(arguments));
        }
    }
}

#[test]
fn control_characters_of_a_file_name_are_shown() {
    let home = Home::new();
    let name = "a\u{1b}[31mb";
    home.write(format!("in/{name}.xml"), bundled_xml(CUT_IN));
    home.write(format!("in/{name}.ego_trajectory.csv"), bundled_ego(CUT_IN));
    home.write(format!("in/broken{name}.xml"), "<commonRoad");
    let file = &format!("in/{name}.xml");
    for arguments in [
        &["in"][..],
        &["metrics", "in"],
        &["metrics", "in", "--format", "json"],
        &["inspect", &format!("in/broken{name}.xml")],
        &["inspect", file],
        &["prompt", "show", file],
        &["ask", file],
    ] {
        both_harmless(&home.run(arguments));
    }
}

#[test]
fn a_reader_that_closes_the_pipe_is_no_panic() {
    let home = Home::new();
    let all: Vec<&str> = super::BUNDLED.iter().map(|(name, _)| *name).collect();
    let mut arguments = vec!["metrics"];
    arguments.extend(&all);
    let mut child = home.start(&arguments);
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert!(line.starts_with("scenario,"));
    Ended::of(&child.wait_with_output().unwrap()).status(0);
    for arguments in [
        &["inspect", CUT_IN, "--format=json"][..],
        &["ask", CUT_IN],
        &["completions", "man"],
        &["prompt", "describe", CUT_IN],
        &[],
    ] {
        let mut child = home.start(arguments);
        drop(child.stdout.take());
        Ended::of(&child.wait_with_output().unwrap()).status(0);
    }
}

#[test]
fn nobody_listening_to_errors_is_no_panic() {
    let home = Home::new();
    for (arguments, status) in [
        (&["inspect", "nowhere.xml"][..], 2),
        (&[], 0),
        (&["prompt", "show", CUT_IN], 0),
        (&["metrics", "nowhere"], 2),
    ] {
        let mut command = home.command();
        command
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        drop(child.stderr.take());
        assert_eq!(child.wait().unwrap().code(), Some(status), "{arguments:?}");
    }
}
