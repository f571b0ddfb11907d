//! The same rows in the workbench: it lives on and says what to do, and its terminal gets nothing raw or secret.

use std::time::{Duration, Instant};

use super::support::program::Home;
use super::support::session::Session;
use super::{ADVICE, End, KEY, LIMIT, Row, SCENARIO, configured};

/// Asks in the workbench until the run is kept.
pub fn run(row: &Row, url: &str) {
    let home = Home::new();
    configured(&home, url, row.dialect);
    let (config, data) = (home.config(), home.data());
    let environment = [
        ("NEARMISS_CONFIG", config.to_str().unwrap()),
        ("NEARMISS_DATA", data.to_str().unwrap()),
        ("LAB_KEY", KEY),
    ];
    let mut session = Session::start_with(160, 45, &environment, &[SCENARIO]);
    session.see("car 301");
    let begun = Instant::now();
    session.press("r");
    let kept = loop {
        session.receive(Duration::from_millis(200));
        assert!(
            begun.elapsed() < LIMIT,
            "{}: it does not end:\n{}",
            row.name,
            session.screen.screen().contents()
        );
        let mut runs = home.runs();
        if let Some(run) = runs
            .pop()
            .filter(|run| run["state"].as_deref() != Some("running"))
        {
            break run;
        }
    };
    // The run is kept before it is shown, and what arrived is still being drawn.
    let verdict = kept["verdict"].is_some();
    let why = kept["error"]
        .as_ref()
        .or(kept["reading"].as_ref())
        .map(String::as_str)
        .unwrap_or_default();
    let said = loop {
        let said = right_side(&session);
        let going = ["arriving…", "waiting…"].iter().any(|w| said.contains(w));
        let advised = ADVICE.iter().any(|word| said.contains(word));
        let told = match row.end {
            End::Says(words) => verdict || why.contains(words) || said.contains(words),
            End::Verdict | End::Any => true,
        };
        if !going && said.contains("built-in") && (verdict || advised) && told {
            break said;
        }
        assert!(begun.elapsed() < LIMIT, "{}: shows `{said}`", row.name);
        session.receive(Duration::from_millis(100));
    };
    match row.end {
        End::Verdict => assert!(verdict, "{}: {why}", row.name),
        End::Says(words) => assert!(
            !verdict && (why.contains(words) || said.contains(words)),
            "{}: not `{words}`: {why}",
            row.name
        ),
        End::Any => {}
    }
    // Where the frame is older than the store, the first one only warns that a question is running.
    while session.child.try_wait().unwrap().is_none() {
        assert!(begun.elapsed() < 2 * LIMIT, "{}: it does not end", row.name);
        session.press("q");
        for _ in 0..10 {
            session.receive(Duration::from_millis(50));
        }
    }
    assert_eq!(session.end(), 0, "{}", row.name);
    session.is_restored();
    let raw = String::from_utf8_lossy(&session.raw);
    assert!(!raw.contains(KEY), "{}: the key", row.name);
    // Sequences that the table's servers send and the program does not.
    for sequence in ["\u{1b}]0;", "\u{1b}]52;", "\u{9b}"] {
        assert!(!raw.contains(sequence), "{}: {sequence:?}", row.name);
    }
    let found = home.files_with(KEY);
    assert!(found.is_empty(), "{}: the key is in {found:?}", row.name);
}

/// The words of the verdict and the reasoning, in lines as long as they are.
fn right_side(session: &Session) -> String {
    let rows = session.screen.screen().rows(104, 56);
    let text: Vec<String> = rows
        .map(|row| row.trim_matches(|c: char| !c.is_alphanumeric()).to_string())
        .collect();
    text.join(" ")
}
