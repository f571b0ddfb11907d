//! The checker itself: small files with forbidden and allowed imports, so that it is known to be able to fail.

use std::path::{Path, PathBuf};

use super::rules;
use super::source::{self, Target};

/// Dependency lines of a manifest that carry no comment.
pub fn without_purpose(manifest: &str) -> Vec<String> {
    let mut dependencies = false;
    let mut found = Vec::new();
    for (number, line) in manifest.lines().enumerate() {
        let line = line.trim();
        if line.starts_with('[') {
            dependencies = line.trim_end_matches(']').ends_with("dependencies");
        } else if dependencies
            && line.contains('=')
            && !line.starts_with('#')
            // The workspace says it, once.
            && !line.contains(".workspace = true")
            && !line.contains(" # ")
        {
            found.push(format!(
                "Cargo.toml:{}: no comment says what it is for: {line}",
                number + 1
            ));
        }
    }
    found
}

fn check(path: &str, text: &str) -> Vec<String> {
    rules::check(&[(PathBuf::from(path), text.to_string())])
}

fn refused(path: &str, text: &str) {
    assert!(!check(path, text).is_empty(), "{path} may not say: {text}");
}

fn accepted(path: &str, text: &str) {
    assert_eq!(check(path, text), [""; 0], "{path} may say: {text}");
}

#[test]
fn forbidden_arrows_between_modules_are_found() {
    for (path, text) in [
        ("base/geometry/pose.rs", "use crate::system::visible;"),
        ("ask/llm/client.rs", "use crate::prompts::Library;"),
        ("scene/scenario/mod.rs", "fn f() { crate::metrics::g() }"),
        (
            "scene/scenario/mod.rs",
            "use crate::{scenario::Scene, metrics::{risk::{Risk}, Series}};",
        ),
        (
            "scene/metrics/risk.rs",
            "use super::super::description::Frame;",
        ),
        (
            "scene/metrics/risk.rs",
            "mod deep { fn f() -> super::super::super::judge::Judgement {} }",
        ),
        ("scene/verdict/mod.rs", "pub use crate::judge as j;"),
        ("scene/judge/mod.rs", "use crate::corpus::*;"),
        ("drive/simulation/mod.rs", "use crate::generation::Attack;"),
        ("scene/surprise/mod.rs", "use crate::scenario::Scene;"),
        ("main.rs", "use nearmiss::geometry::Point;"),
        (
            "scene/description/mod.rs",
            "#[cfg(test)] mod tests { use crate::judge::J; } use crate::judge::J;",
        ),
        (
            "scene/description/mod.rs",
            "#[cfg(test)] use crate::judge::{J}; use crate::judge::J;",
        ),
        (
            "scene/description/mod.rs",
            "const C: char = '\"'; use crate::judge::J; const D: char = '\"';",
        ),
    ] {
        refused(path, text);
    }
}

#[test]
fn allowed_arrows_are_left_alone() {
    for (path, text) in [
        (
            "scene/metrics/mod.rs",
            "use crate::scenario::{self, Scene};",
        ),
        (
            "scene/scenario/mod.rs",
            "use nearmiss_base::geometry::Point;",
        ),
        (
            "scene/metrics/risk.rs",
            "use super::relation::Relation; use crate::scenario::Scene;",
        ),
        ("scene/judge/mod.rs", "use crate::verdict::Verdict;"),
        (
            "cli/ask.rs",
            "use super::{Failure, output}; use crate::open;",
        ),
        (
            "main.rs",
            "use nearmiss::cli; fn main() { nearmiss::tui::run() }",
        ),
        (
            "scene/scenario/pose.rs",
            "// use crate::judge::J;\n/* crate::judge /* crate::metrics */ */",
        ),
        (
            "scene/scenario/pose.rs",
            "const S: &str = \"use crate::judge::J;\"; const R: &str = r#\"crate::judge\"#;",
        ),
        (
            "scene/scenario/pose.rs",
            "#[cfg(test)]\n#[allow(x)]\nmod tests { use crate::judge::J; }",
        ),
        (
            "scene/scenario/pose.rs",
            "fn f<'a>(x: &'a str) -> &'a str { x }",
        ),
    ] {
        accepted(path, text);
    }
}

#[test]
fn outside_crates_stay_at_home() {
    for (path, text) in [
        ("cli/mod.rs", "use ratatui::text::Line;"),
        ("cli/mod.rs", "fn f() { crossterm::terminal::size(); }"),
        ("tui/views/map.rs", "use crossterm::event::Event;"),
        ("tui/views/map.rs", "use ratatui::crossterm::event::Event;"),
        ("study/evaluation/case.rs", "use reqwest::Url;"),
        ("scene/scenario/library.rs", "use quick_xml::Reader;"),
        (
            "study/evaluation/case.rs",
            "fn f(c: &rusqlite::Connection) {}",
        ),
        ("scene/description/mod.rs", "use minijinja::Environment;"),
        ("scene/metrics/distance.rs", "use parry2d_f64::query;"),
    ] {
        refused(path, text);
    }
    for (path, text) in [
        ("tui/views/map.rs", "use ratatui::text::Line;"),
        ("tui/keymap/mod.rs", "use crossterm::event::KeyEvent;"),
        ("tui/terminal.rs", "use ratatui::crossterm::execute;"),
        ("ask/llm/client.rs", "use reqwest::Url;"),
        ("formats/commonroad/xml.rs", "use quick_xml::Reader;"),
        ("base/geometry/convert.rs", "use parry2d_f64::math::Pose;"),
    ] {
        accepted(path, text);
    }
}

#[test]
fn the_parts_of_the_terminal_keep_apart() {
    for (path, text) in [
        ("tui/views/map.rs", "use super::super::update::update;"),
        ("tui/views/map.rs", "use super::super::terminal::Guard;"),
        ("tui/views/map.rs", "use crate::services::Services;"),
        ("tui/views/map.rs", "use super::super::Pane;"),
        (
            "tui/views/mod.rs",
            "use super::{model::Model, services::Services};",
        ),
        ("tui/update/actions.rs", "use super::super::views::map;"),
        (
            "tui/update/actions.rs",
            "fn f() { crate::terminal::bell() }",
        ),
        ("tui/update.rs", "use super::run::Loop;"),
        ("tui/model/list.rs", "use crate::run::turn;"),
        ("tui/services/jobs.rs", "use super::super::update;"),
        ("tui/services.rs", "use super::features::history;"),
        ("tui/model/list.rs", "use crate::views::list;"),
        ("tui/widgets/plot.rs", "use super::super::views::risk;"),
        ("tui/widgets/plot.rs", "use crate::features::Screen;"),
        ("tui/features/help.rs", "use super::history::HistoryScreen;"),
        ("tui/features/help.rs", "use crate::features::jobs;"),
        ("tui/features/help.rs", "use crate::views::draw;"),
        (
            "tui/features/history/draw.rs",
            "use crate::services::Services;",
        ),
        (
            "tui/features/history/state.rs",
            "use crate::message::Effect;",
        ),
        ("tui/views/map.rs", "fn f() { println!(\"x\"); }"),
        (
            "tui/update/mod.rs",
            "use std::io; fn f() { io::stdout().flush(); }",
        ),
        (
            "tui/mod.rs",
            "use std::io::{Write, stderr}; fn f() { stderr().lock(); }",
        ),
    ] {
        refused(path, text);
    }
    for (path, text) in [
        (
            "tui/views/map.rs",
            "use super::super::{model::Model, theme::Theme}; use nearmiss_scene::judge::judge;",
        ),
        (
            "tui/views/map.rs",
            "use super::widgets; use super::list; use crate::widgets::plot;",
        ),
        (
            "tui/features/history/mod.rs",
            "use super::{Screen, Step}; use crate::features::jobs; use crate::model::Model;",
        ),
        ("tui/model.rs", "use super::features::Screens;"),
        (
            "tui/update/actions.rs",
            "use super::super::{action::Action, message::Effect}; use super::open;",
        ),
        (
            "tui/features/answers/request.rs",
            "use crate::services::Services; use nearmiss_study::evaluation::run;",
        ),
        (
            "tui/run.rs",
            "use super::{services::Services, terminal::Screen, update::update, views};",
        ),
        (
            "tui/mod.rs",
            "mod services; mod views; use services::Services; fn f() { views::draw() }",
        ),
        ("tui/terminal.rs", "fn f() { std::io::stdout(); }"),
        (
            "tui/services/ask.rs",
            "fn f(c: &mut Command) { c.stdout(Stdio::null()); }",
        ),
    ] {
        accepted(path, text);
    }
}

#[test]
fn files_for_tests_are_not_checked() {
    let file = |path: &str, text: &str| (PathBuf::from(path), text.to_string());
    let tests = file("ask/llm/chat_tests.rs", "use crate::prompts::Library;");
    let named = file(
        "ask/llm/chat.rs",
        "#[cfg(test)]\n#[path = \"chat_tests.rs\"]\nmod tests;",
    );
    assert!(rules::check(&[named, tests.clone()]).is_empty());
    assert!(!rules::check(&[tests]).is_empty());
    let plain = file("ask/llm/chat.rs", "#[cfg(test)] mod tests;");
    assert!(
        rules::check(&[
            plain,
            file("ask/llm/chat/tests.rs", "use crate::prompts::Library;")
        ])
        .is_empty()
    );
}

#[test]
fn paths_are_read_as_the_language_means_them() {
    let text = "mod child;\nuse crate::{a::{self, b::C as D}, e::*};\nfn f() { child::g::<u8>(); x.y::<u8>() }";
    let source = source::read(Path::new("top/mod.rs"), text);
    let inside = |path: &str| Target::Inside(path.split("::").map(str::to_string).collect());
    let found: Vec<_> = source
        .named
        .iter()
        .map(|n| (n.line, n.target.clone()))
        .collect();
    assert_eq!(
        found,
        [
            (2, inside("top::a")),
            (2, inside("top::a::b::C")),
            (2, inside("top::e::*")),
            (3, inside("top::child::g"))
        ]
    );
}

#[test]
fn a_dependency_without_a_purpose_is_found() {
    let manifest = "[package]\nname = \"x\"\n[dependencies]\n# group\na = \"1\" # for this\nb = \"1\"\n[dev-dependencies]\nc = { version = \"1\" }\n[lints]\nd = 1\n";
    assert_eq!(without_purpose(manifest).len(), 2);
}
