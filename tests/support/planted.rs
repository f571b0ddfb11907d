//! A home in which every name and text that people, files and models choose holds escape sequences.

use std::path::{Path, PathBuf};

use super::program::Home;
use nearmiss::store::{Choice, NewRating, RatedAnswer, Store};
use nearmiss::verdict::Task;

/// A title, a cursor movement, the one-byte form of one, and marks that turn the direction of writing.
pub const EVIL: &str = "\u{1b}]0;PWNED\u{7}\u{1b}[66;6H\u{9b}66;6H\u{202e}\u{2066}\u{61c}PWNED";

/// The same in a TOML string.
pub const IN_TOML: &str =
    "\\u001b]0;PWNED\\u0007\\u001b[66;6H\\u009b66;6H\\u202e\\u2066\\u061cPWNED";

/// What of it must not reach a terminal, whatever else is written there.
pub const NEEDLES: [&str; 6] = [
    "\u{1b}]0;",
    "\u{1b}[66;6H",
    "\u{9b}",
    "\u{202e}",
    "\u{2066}",
    "\u{61c}",
];

/// What of the planted things is in some text, with what stands before it.
pub fn leaks(text: &str) -> Vec<String> {
    let found = NEEDLES.iter().filter_map(|needle| {
        let at = text.find(needle)?;
        let before: String = text[..at].chars().rev().take(80).collect();
        let before: String = before.chars().rev().collect();
        Some(format!("{needle:?} after {before:?}"))
    });
    found.collect()
}

fn shipped(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// Plants them; gives the folder of the scenarios.
pub fn plant(home: &Home) -> PathBuf {
    let folder = home.files().join(format!("in{EVIL}"));
    let good = shipped("scenarios/ZAM_CutIn-1_1_T-1.xml");
    let named = good
        .replacen("benchmarkID=\"", &format!("benchmarkID=\"{EVIL}"), 1)
        .replacen("author=\"", &format!("author=\"{EVIL}"), 1)
        .replacen("source=\"", &format!("source=\"{EVIL}"), 1);
    home.write(folder.join(format!("a{EVIL}.xml")), &named);
    let ego = shipped("scenarios/ZAM_CutIn-1_1_T-1.ego_trajectory.csv");
    home.write(folder.join(format!("a{EVIL}.ego_trajectory.csv")), ego);
    home.write(
        folder.join(format!("b{EVIL}.xml")),
        format!("<commonRoad {EVIL}"),
    );
    home.write(
        folder.join(format!("c{EVIL}.xml")),
        good.replacen("<x>", &format!("<x>{EVIL}"), 1),
    );
    home.write(folder.join(format!("d{EVIL}.xml")), "");

    let config = |name: &str| home.config().join(name);
    let template = shipped("prompts/collision-ego.md");
    let summary = template.find("summary = \"").map_or(0, |at| at + 11);
    let evil = format!(
        "{}{IN_TOML}{}\n{EVIL}\n",
        &template[..summary],
        &template[summary..]
    );
    home.write(config("prompts/collision-ego.md"), &evil);
    home.write(config(&format!("prompts/other{EVIL}.md")), &evil);
    home.write(
        config(&format!("prompts/broken{EVIL}.md")),
        format!("+++\nname = {EVIL}\n+++\n{{% for {EVIL}"),
    );
    home.write(
        config(&format!("themes/mine{EVIL}.toml")),
        format!("dark = true\n[roles]\n\"{IN_TOML}\" = \"{IN_TOML}\"\n"),
    );
    home.write(
        config("keymap.toml"),
        format!("[global]\n\"{IN_TOML}\" = \"{IN_TOML}\"\nplay = \"{IN_TOML}\"\n"),
    );
    home.write(
        config("tags.toml"),
        format!("\"a{IN_TOML}\" = [\"{IN_TOML}\"]\n\"{IN_TOML}\" = [\"{IN_TOML}\"]\n"),
    );
    let provider = format!(
        "theme = \"{IN_TOML}\"\nmodel = \"{IN_TOML}/x\"\nperson = \"{IN_TOML}\"\n[provider.lab]\ndialect = \"openai_chat\"\nbase_url = \"http://127.0.0.1:9/{IN_TOML}\"\nmodels = [\"{IN_TOML}\"]\n"
    );
    home.write(config("config.toml"), provider);
    home.write(home.data().join(format!("drafts/{EVIL}.md")), &evil);
    home.write(
        home.data().join("drafts/collision-ego.md"),
        format!("{template}\nA draft {EVIL}\n"),
    );
    rate(home);
    folder
}

fn rate(home: &Home) {
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    let answer = |model: &str, reason: Option<&str>| RatedAnswer {
        run: None,
        model: format!("{model}{EVIL}"),
        prompt: format!("ego{EVIL}"),
        wrong: reason.is_some(),
        reason: reason.map(str::to_string),
        template: None,
    };
    for choice in [Choice::Best(0), Choice::Best(1), Choice::Tie] {
        let rating = NewRating {
            person: EVIL.into(),
            scenario: EVIL.into(),
            task: Task::Collision,
            blind: true,
            seed: 9,
            choice,
            notes: EVIL.into(),
            answers: vec![answer("lab/a", None), answer("lab/b", Some(EVIL))],
        };
        store.rate(&rating).unwrap();
    }
}
