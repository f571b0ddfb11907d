//! The module map of the design holds in the source: imports, homes of outside crates, sizes, first lines.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod figures;
mod fixtures;
mod rules;
mod source;

use std::path::Path;

const MOST_LINES: usize = 800;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn none(complaints: &[String]) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

#[test]
fn imports_follow_the_design() {
    let files = rules::files(&root().join("src"));
    assert!(files.len() > 50, "the source was not found");
    let named: usize = files
        .iter()
        .map(|(p, t)| source::read(p, t).named.len())
        .sum();
    assert!(named > 500, "the checker sees only {named} paths");
    none(&rules::check(&files));
}

#[test]
fn every_file_says_first_what_it_is_for() {
    let files = rules::files(&root().join("src"));
    let silent = files.iter().filter(|(_, text)| !text.starts_with("//! "));
    none(
        &silent
            .map(|(path, _)| format!("{}: no `//!` in line 1", path.display()))
            .collect::<Vec<_>>(),
    );
}

#[test]
fn no_file_is_too_long() {
    let files = rules::files(&root().join("src"));
    let too_long = files.iter().filter_map(|(path, text)| {
        let lines = text.lines().count();
        (lines > MOST_LINES).then(|| format!("{}: {lines} lines", path.display()))
    });
    let mut complaints: Vec<_> = too_long.collect();
    let main = files
        .iter()
        .find(|(path, _)| path == Path::new("main.rs"))
        .unwrap();
    if main.1.lines().count() > 40 {
        complaints.push("main.rs: more than 40 lines".into());
    }
    none(&complaints);
}

#[test]
fn every_dependency_says_what_it_is_for() {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    none(&fixtures::without_purpose(&manifest));
}

/// Whether a line fills something up to a width that is a variable, other than digits of a count: widths of `format!`
/// have 16 bits, and a larger one panics.
fn fills_by_variable(line: &str) -> bool {
    let mut ends = line.match_indices("$}").map(|(at, _)| &line[..at]);
    ends.any(|before| {
        let spec = before.rsplit([':', '{']).next().unwrap_or_default();
        let name = spec.trim_start_matches(['<', '>', '^']);
        !spec.contains('.') && name != "digits" && name.starts_with(char::is_lowercase)
    })
}

#[test]
fn no_width_of_a_cell_comes_from_data() {
    for found in [r#"format!("{cell:>width$}")"#, r#"format!("{:w$}|", a)"#] {
        assert!(fills_by_variable(found), "{found}");
    }
    for fine in [r#"format!("{v:.decimals$}")"#, r#"format!("{:>NAME$}", a)"#] {
        assert!(!fills_by_variable(fine), "{fine}");
    }
    let files = rules::files(&root().join("src"));
    let complaints = files.iter().flat_map(|(path, text)| {
        let lines = text.lines().enumerate();
        let wide = lines.filter(|(_, line)| fills_by_variable(line));
        wide.map(move |(at, _)| {
            let place = format!("{}:{}", path.display(), at + 1);
            format!("{place}: a width from data; use `system::pad_end` or `system::pad_start`")
        })
    });
    none(&complaints.collect::<Vec<_>>());
}
