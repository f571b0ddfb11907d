//! The English of the manual and of help texts: short sentences, and words that CONTRIBUTING.md replaces by others.

use clap::CommandFactory;
use nearmiss::cli::Arguments;
use nearmiss::docs::TOPICS;

/// Words of a sentence at most.
const LONGEST: usize = 30;

/// What is not written, and what is instead.
const INSTEAD: &[(&str, &str)] = &[
    ("lends", "offers"),
    ("its kin", "name them"),
    ("is held to", "is checked against"),
    ("are held to", "are checked against"),
    ("ways of asking", "configurations"),
    ("way of asking", "configuration"),
    ("e.g.", "for example"),
    ("i.e.", "that is"),
    ("in order to", "to"),
    ("utilize", "use"),
    ("simply", "leave it out"),
    ("please", "leave it out"),
    ("and/or", "say which"),
];

/// The sentences of prose in Markdown: no code, no tables, no headings, without markup.
fn sentences(text: &str) -> Vec<String> {
    let (mut prose, mut is_code) = (String::new(), false);
    for line in text.lines() {
        if line.starts_with("```") {
            is_code = !is_code;
            prose += ".\n";
        } else if !is_code {
            let is_own = line.trim().is_empty()
                || line.starts_with(['#', '|', '-', '!', '<'])
                || line.trim_start().starts_with(|c: char| c.is_ascii_digit());
            if is_own {
                prose += ".\n";
            }
            if !line.starts_with(['#', '|']) {
                prose += line;
                prose += " ";
            }
        }
    }
    let mut plain = String::new();
    let mut is_quoted = false;
    for c in prose.chars() {
        match c {
            '`' => {
                if !is_quoted {
                    plain += "code";
                }
                is_quoted = !is_quoted;
            }
            _ if is_quoted => {}
            '\n' => plain.push(' '),
            c => plain.push(c),
        }
    }
    let ends = [". ", ": ", "; ", "? ", " · "];
    let mut all = vec![plain];
    for end in ends {
        all = { all.iter() }
            .flat_map(|text| text.split(end).map(str::to_owned))
            .collect();
    }
    all
}

/// What is wrong with a text.
fn faults(place: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for sentence in sentences(text) {
        let words = sentence.split_whitespace().count();
        if words > LONGEST {
            found.push(format!("{place}: {words} words: {}", sentence.trim()));
        }
        let lower = format!(" {} ", sentence.to_lowercase());
        for (word, instead) in INSTEAD {
            if lower.contains(&format!(" {word} ")) || lower.contains(&format!(" {word},")) {
                found.push(format!("{place}: `{word}`: {instead}: {}", sentence.trim()));
            }
        }
    }
    found
}

/// The help of a command, its options and its subcommands.
fn help(command: &clap::Command, path: &str, found: &mut Vec<String>) {
    let texts = command.get_arguments().filter_map(|one| {
        let about = one.get_long_help().or(one.get_help())?;
        Some((one.get_id().to_string(), about.to_string()))
    });
    for (name, text) in texts {
        found.extend(faults(&format!("{path} {name}"), &text));
    }
    for one in command.get_subcommands() {
        help(one, &format!("{path} {}", one.get_name()), found);
    }
}

#[test]
fn sentences_are_short_and_words_are_those_of_the_trade() {
    let readme =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap();
    let mut found = faults("README.md", &readme);
    for topic in TOPICS {
        found.extend(faults(topic.name, topic.text));
    }
    help(&Arguments::command(), "nearmiss", &mut found);
    assert!(found.is_empty(), "{}:\n{}", found.len(), found.join("\n"));
}
