//! The reference pages of the manual, `src/docs/reference`: what the program prints of its commands, keys, measures and outputs.
//! `NEARMISS_WRITE_MANUAL=1` writes them.

use std::path::Path;

use clap::CommandFactory;
use nearmiss::cli::Arguments;

use super::support::program::Home;

/// What is printed by a command, as a section.
fn section(home: &Home, title: &str, command: &[&str]) -> String {
    let printed = home.run(command).status(0).stdout;
    format!(
        "## {title}\n\n`nearmiss {}` prints this.\n\n```text\n{}\n```\n\n",
        command.join(" "),
        printed.trim_end()
    )
}

/// What comes behind the text of a topic.
fn behind(home: &Home, topic: &str) -> String {
    let printed = home.run(&["help", topic]).status(0).stdout;
    let text = nearmiss::docs::topic(topic).unwrap().text;
    printed[text.len()..].trim_start().to_owned() + "\n"
}

/// The help of a command and of its subcommands.
fn commands(home: &Home, command: &clap::Command, path: &[&str], told: &mut String) {
    for one in command.get_subcommands() {
        let name = one.get_name();
        if name == "help" && !path.is_empty() {
            continue;
        }
        let path = [path, &[name]].concat();
        *told += &section(home, &path.join(" "), &[&["help"], &path[..]].concat());
        commands(home, one, &path, told);
    }
}

fn pages() -> Vec<(&'static str, String)> {
    let home = Home::new();
    let mut all = "# Commands and options\n\n".to_owned();
    commands(&home, &Arguments::command(), &[], &mut all);
    let measures = "# Measures\n\n".to_owned()
        + &section(&home, "Of an obstacle at a step", &["metrics", "--list"])
        + &section(
            &home,
            "Of a scene at a step",
            &["metrics", "--list", "--scene"],
        );
    let keys = "# Keys of the workbench\n\n".to_owned()
        + &section(&home, "Default keymap", &["config", "keys"]);
    let mut topics = "# Files, protocols and outputs\n\n".to_owned();
    for topic in nearmiss::docs::TOPICS {
        let told = behind(&home, topic.name);
        if !told.trim().is_empty() {
            let told = told
                .replace("\n## ", "\n### ")
                .replace("## ", "### ")
                .replace("####", "###");
            topics += &format!("## {}\n\n{told}\n", topic.name);
        }
    }
    vec![
        ("commands.md", all),
        ("measures.md", measures),
        ("keys.md", keys),
        ("files.md", topics),
    ]
}

#[test]
fn the_reference_is_what_the_program_prints() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/docs/reference");
    let write = std::env::var_os("NEARMISS_WRITE_MANUAL").is_some();
    for (name, text) in pages() {
        let text = text.trim_end().to_owned() + "\n";
        let path = folder.join(name);
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        if write {
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(&path, &text).unwrap();
            continue;
        }
        let diff = similar::TextDiff::from_lines(&before, &text);
        assert!(
            before == text,
            "{}: NEARMISS_WRITE_MANUAL=1 writes it\n{}",
            path.display(),
            diff.unified_diff()
        );
    }
}
