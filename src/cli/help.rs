//! `nearmiss help`: help for a command, or a topic of the manual.

use std::ffi::OsStr;
use std::io;
use std::path::Path;

use clap::CommandFactory;

use super::open::resolved;
use super::{Arguments, Failure, Outcome, json, output};
use crate::docs::{TOPICS, explaining, topic};
use crate::system::{available, did_you_mean};

/// Arguments of `help`.
#[derive(Debug, clap::Args)]
pub struct Help {
    /// Topic or command, with its subcommands [default: list both].
    #[arg(value_name = "TOPIC|COMMAND")]
    words: Vec<String>,
    /// With the topic json: print the JSON schema of this output.
    #[arg(long, value_name = "OUTPUT")]
    schema: Option<String>,
}

/// Runs `help`.
pub fn run(arguments: &Help) -> Outcome {
    let words = &arguments.words;
    if let Some(name) = &arguments.schema {
        return schema(words, name);
    }
    let program = program();
    let Some(first) = words.first() else {
        return print(program.after_help(topics()), words);
    };
    if let (Some(topic), [_]) = (topic(first), &words[..]) {
        output::text(topic.text)?;
        return match topic.name {
            "json" => output::text(&vocabulary()),
            _ => Ok(()),
        };
    }
    let mut command = &program;
    for (at, word) in words.iter().enumerate() {
        let found = command.find_subcommand(word);
        command = found.ok_or_else(|| Failure::input(unknown(command, &words[..at], word)))?;
    }
    print(program, words)?;
    match explaining(first) {
        Some(topic) => output::text(&format!("\nManual: `nearmiss help {}`\n", topic.name)),
        None => Ok(()),
    }
}

/// The program's arguments; commands of commands have the `help` that comes with clap.
pub fn program() -> clap::Command {
    Arguments::command().mut_subcommands(|command| {
        if command.has_subcommands() {
            command.defer(|command| command.disable_help_subcommand(false))
        } else {
            command
        }
    })
}

/// Prints the JSON schema of an output.
fn schema(words: &[String], name: &str) -> Outcome {
    if !matches!(words, [topic] if topic == "json") {
        return Err(Failure::input(format!(
            "--schema belongs to the topic json: `nearmiss help json --schema {name}`"
        )));
    }
    let Some(schema) = json::document(name) else {
        let names = json::names();
        let known = available(name, names.iter().map(|(name, _)| name.as_str()));
        return Err(Failure::input(format!(
            "no schema `{name}`{known}; `nearmiss help json` lists them"
        )));
    };
    let text = serde_json::to_string_pretty(&schema).map_err(Failure::input)?;
    output::text(&format!("{text}\n"))
}

/// The outputs that have a schema, and the keys that mean the same in all of them.
fn vocabulary() -> String {
    let lines = |title: &str, all: Vec<(String, String)>| -> String {
        let lines = all.into_iter();
        let lines: String = lines
            .map(|(name, about)| format!("    {name:<18} {about}\n"))
            .collect();
        format!("\n## {title}\n\n{lines}")
    };
    lines("Outputs", json::names()) + &lines("Keys", json::keys())
}

/// The list of topics.
fn topics() -> String {
    let lines: String = TOPICS
        .iter()
        .map(|topic| format!("  {:<14} {}\n", topic.name, topic.about))
        .collect();
    format!(
        "Topics:\n{lines}\n`nearmiss help TOPIC` prints one, `nearmiss help COMMAND` the options of a command."
    )
}

/// Prints what `--help` after these words prints, in the terminal's colours.
fn print(program: clap::Command, words: &[String]) -> Outcome {
    let words = words.iter().map(String::as_str);
    let asked = ["nearmiss"].into_iter().chain(words).chain(["--help"]);
    match program
        .try_get_matches_from(asked)
        .map_err(|help| help.print())
    {
        Err(Err(e)) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::system("standard output", &e))
        }
        _ => Ok(()),
    }
}

/// The error for a first word that is probably a mistyped command: it is no path, no scenario, and like a command.
pub fn mistyped(program: &clap::Command, word: &OsStr) -> Option<Failure> {
    let said = word.to_str().filter(|word| !word.starts_with('-'))?;
    if program.find_subcommand(said).is_some() || resolved(Path::new(said)).is_ok() {
        return None;
    }
    let commands = program.get_subcommands().map(clap::Command::get_name);
    let meant = did_you_mean(said, commands);
    let message = format!("no command or file `{said}`{meant}");
    (!meant.is_empty()).then(|| Failure::input(message))
}

/// The message for an argument that is neither a subcommand nor a topic.
fn unknown(command: &clap::Command, before: &[String], word: &str) -> String {
    let commands = command.get_subcommands().map(clap::Command::get_name);
    let topics: Vec<&str> = TOPICS.iter().map(|topic| topic.name).collect();
    if !before.is_empty() {
        let commands: Vec<&str> = commands.collect();
        let path = before.join(" ");
        let there = match &commands[..] {
            [] => "; it has none".to_string(),
            all => format!(
                "{}\nCommands: {}",
                did_you_mean(word, all.iter().copied()),
                all.join(", ")
            ),
        };
        return format!("`nearmiss {path}` has no command `{word}`{there}");
    }
    if topic(word).is_some() {
        return format!("`{word}` is a topic; `nearmiss help {word}` prints all of it");
    }
    let all: Vec<&str> = topics.iter().copied().chain(commands).collect();
    format!(
        "no topic or command `{word}`{}\n`nearmiss help` lists both",
        did_you_mean(word, all)
    )
}
