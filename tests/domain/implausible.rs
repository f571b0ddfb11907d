//! Input that can be read but cannot be true: each fault is reported with its line, or refused.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod egos;
use crate::protobuf::encode;
mod encodings;
mod rows;
mod valid;

use nearmiss::formats::commonroad::{ReadError, read};
use nearmiss::scenario::Scenario;

/// One untruth.
pub struct Row {
    /// The element in which it is, from the line that begins it; empty for the whole file.
    pub inside: &'static str,
    /// What is replaced there, first found.
    pub from: &'static str,
    /// By what.
    pub to: &'static str,
    /// Words of what is said; for an error they begin with `!`.
    pub words: &'static str,
    /// The beginning of the text, within the element, at whose line it is said; the element itself where empty.
    pub at: &'static str,
}

/// The scenario with one untruth, and the line at which it is to be said.
fn untrue(row: &Row) -> (String, usize) {
    let text = valid::scenario();
    let start = text
        .find(row.inside)
        .unwrap_or_else(|| panic!("there is no {}", row.inside));
    let (before, rest) = text.split_at(start);
    assert!(rest.contains(row.from), "{}: no {}", row.inside, row.from);
    let text = format!("{before}{}", rest.replacen(row.from, row.to, 1));
    let at = start + text[start..].find(row.at).expect(row.at);
    let line = 1 + text[..at].matches('\n').count();
    (text, line)
}

fn xml(text: &str) -> Result<Scenario, ReadError> {
    read(text.as_bytes(), "untrue.xml")
}

#[test]
fn of_what_is_true_nothing_is_said() {
    let scenario = xml(&valid::scenario()).unwrap();
    assert_eq!(scenario.diagnostics, []);
    let bytes = encode::single::encode(&scenario);
    let again = read(&bytes, "true.pb").unwrap();
    assert_eq!(again.diagnostics, []);
}

#[test]
fn each_untruth_is_said_with_its_line_or_refused() {
    assert!(rows::ROWS.len() >= 60);
    let mut wrong = Vec::new();
    for row in rows::ROWS {
        let (text, line) = untrue(row);
        let of = format!("{} {} → {}", row.inside, row.from, row.to);
        match (xml(&text), row.words.strip_prefix('!')) {
            (Err(error), Some(words)) => {
                if !error.message.contains(words) || error.line != line {
                    wrong.push(format!("{of}: line {line}, `{words}`: {error}"));
                }
            }
            (Err(error), None) => wrong.push(format!("{of}: {error}")),
            (Ok(_), Some(words)) => wrong.push(format!("{of}: read, instead of `{words}`")),
            (Ok(scenario), None) => {
                let said = scenario.diagnostics;
                let hit = said
                    .iter()
                    .any(|d| d.message.contains(row.words) && d.line == line);
                if !hit {
                    wrong.push(format!("{of}: line {line}, `{}`: {said:#?}", row.words));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn protobuf_says_the_same_of_the_same_scenario() {
    let (mut wrong, mut compared) = (Vec::new(), 0);
    for row in rows::ROWS.iter().filter(|r| !r.words.starts_with('!')) {
        let (text, _) = untrue(row);
        let Ok(scenario) = xml(&text) else { continue };
        // Protobuf requires a body, and has no negative durations and offsets.
        let mut lights = scenario.network.lights.iter();
        let negative = lights.any(|l| l.offset < 0 || l.cycle.iter().any(|p| p.duration < 0));
        let bodiless = scenario.obstacles.iter().any(|o| o.footprint.is_none());
        if bodiless || negative {
            continue;
        }
        let named = |d: &&nearmiss::scenario::Diagnostic| {
            let first = d.message.split(' ').next().unwrap_or_default();
            matches!(
                first,
                "lanelet" | "sign" | "light" | "intersection" | "obstacle" | "planning"
            )
        };
        let bytes = encode::single::encode(&scenario);
        let Ok(again) = read(&bytes, "untrue.pb") else {
            continue;
        };
        for said in scenario.diagnostics.iter().filter(named) {
            compared += 1;
            let same = again.diagnostics.iter().find(|d| d.message == said.message);
            match same {
                None => wrong.push(format!("{}: {:#?}", said.message, again.diagnostics)),
                Some(same) => assert!(same.element.contains('['), "{same}"),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    assert!(compared > 50, "only {compared} were compared");
}
