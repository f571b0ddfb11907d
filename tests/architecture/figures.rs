//! The figures of the house: lines, files, rows that only list a field again, doors. None gets worse unnoticed.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use super::{root, rules};

/// Where they are kept. `NEARMISS_WRITE_FIGURES=1` writes them anew.
const KEPT: &str = "tests/architecture/figures.toml";

type Figures = BTreeMap<String, usize>;

#[test]
fn figures_get_no_worse() {
    let measured = measured();
    for (name, value) in &measured {
        println!("{name} = {value}");
    }
    let path = root().join(KEPT);
    if std::env::var_os("NEARMISS_WRITE_FIGURES").is_some() {
        std::fs::write(&path, toml::to_string(&measured).unwrap()).unwrap();
    }
    let kept: Figures = toml::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let worse = measured.iter().filter_map(|(name, now)| {
        let before = kept.get(name)?;
        (now > before).then(|| format!("{name}: {now}, before {before}"))
    });
    let mut complaints: Vec<String> = worse.collect();
    if !complaints.is_empty() {
        complaints.push(format!(
            "worth it? `NEARMISS_WRITE_FIGURES=1 cargo test --test architecture figures` writes {KEPT} anew"
        ));
    }
    super::none(&complaints);
    assert!(measured.keys().eq(kept.keys()), "{KEPT} has other figures");
}

fn measured() -> Figures {
    let mut figures = Figures::new();
    let mut add = |name: &str, count: usize| *figures.entry(name.into()).or_default() += count;
    for (path, text) in rules::files(&root().join("src")) {
        if is_test(&path) {
            continue;
        }
        let code = code(&text);
        add("code_lines", code.len());
        add("files", 1);
        let json = code.iter().filter(|line| line.contains("json!("));
        add("json_macros", json.count());
        add("values_by_key", code.iter().map(|line| keys(line)).sum());
        add("shadowed_chains", shadowed(&code));
        let tuples = code.iter().filter(|line| has_tuple_parameter(line));
        add("tuple_parameters", tuples.count());
    }
    let (commands, options) = doors();
    add("commands", commands);
    add("options", options);
    figures
}

fn is_test(path: &Path) -> bool {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let in_tests = path.components().any(|part| part.as_os_str() == "tests");
    // Messages are generated.
    in_tests || stem == "tests" || stem.ends_with("_tests") || stem == "messages"
}

/// Lines that are neither blank nor comments, before the module of tests.
fn code(text: &str) -> Vec<&str> {
    let code = text.split("\n#[cfg(test)]\nmod ").next().unwrap_or(text);
    let lines = code.lines().map(str::trim);
    lines
        .filter(|line| !line.is_empty() && !line.starts_with("//"))
        .collect()
}

/// How often a line reads a JSON value by a literal key: `value["key"]`.
fn keys(line: &str) -> usize {
    let after = line.split("[\"").skip(1);
    let is_key = |rest: &&str| {
        let key = rest.split("\"]").next().unwrap_or_default();
        key.len() < rest.len()
            && !key.is_empty()
            && key.chars().all(|c| c.is_ascii_lowercase() || c == '_')
    };
    after.filter(is_key).count()
}

/// How often a value is named anew only to call a method of itself: `let x = a; let x = x.b();`.
fn shadowed(code: &[&str]) -> usize {
    let name = |line: &&str| {
        let rest = line.strip_prefix("let ")?;
        let (name, value) = rest
            .strip_prefix("mut ")
            .unwrap_or(rest)
            .split_once(" = ")?;
        let plain = name.chars().all(|c| c.is_alphanumeric() || c == '_');
        plain.then(|| (name.to_owned(), value.to_owned()))
    };
    let pairs = code.windows(2).filter_map(|pair| {
        let (first, _) = name(&pair[0])?;
        let (second, value) = name(&pair[1])?;
        Some(pair[0].ends_with(';') && first == second && value.starts_with(&format!("{first}.")))
    });
    pairs.filter(|is| *is).count()
}

/// Whether a line has a parameter that is a tuple, `(a, b): (A, B)`, which hides how many parameters there are.
fn has_tuple_parameter(line: &str) -> bool {
    let Some((pattern, _)) = line.split_once("): (") else {
        return false;
    };
    let names = pattern.rsplit('(').next().unwrap_or_default();
    let in_function = pattern.starts_with('(') || pattern.contains("fn ");
    let is_name = |c: char| c.is_alphanumeric() || "_, ".contains(c);
    in_function && names.contains(", ") && names.chars().all(is_name)
}

/// Commands of the program, and the options of all pages of help.
fn doors() -> (usize, usize) {
    let mut options = 0;
    let mut pages: Vec<Vec<String>> = vec![Vec::new()];
    let mut top = 0;
    while let Some(page) = pages.pop() {
        let text = help(&page);
        // What every command takes is counted once.
        let own = match text.split_once("\nTables of tracks:") {
            Some((own, _)) if !page.is_empty() => own,
            _ => &text,
        };
        options += own.lines().filter(|line| is_option(line)).count();
        let mut inner = commands(&text);
        if page.is_empty() {
            top = inner.len();
        } else {
            inner.retain(|name| name != "help");
        }
        pages.extend(inner.into_iter().map(|name| [&page[..], &[name]].concat()));
    }
    (top, options)
}

fn help(page: &[String]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nearmiss"));
    let output = command.args(page).arg("--help").output().unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The commands that a page of help lists, under any heading but those of arguments and options.
fn commands(help: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut listed = false;
    for line in help.lines() {
        if line.starts_with(|c: char| c.is_ascii_uppercase()) {
            let others = ["Usage", "Arguments", "Options"];
            listed = line.ends_with(':') && !others.iter().any(|other| line.starts_with(other));
        } else if let (true, Some(rest)) = (listed, line.strip_prefix("  ")) {
            let name = rest.split("  ").next().unwrap_or_default();
            let is_name = name.starts_with(|c: char| c.is_ascii_lowercase())
                && name.chars().all(|c| c.is_ascii_lowercase() || c == '-');
            names.extend(is_name.then(|| name.to_owned()));
        }
    }
    names
}

fn is_option(line: &str) -> bool {
    let line = line.trim_start();
    let long = match line.split_once(", ") {
        Some((short, long)) if short.len() == 2 => long,
        _ => line,
    };
    long.starts_with("--") && !long.starts_with("--help") && !long.starts_with("--version")
}
