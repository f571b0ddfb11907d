//! `nearmiss help`: help for a command, or a topic of the manual.

use std::io;

use clap::CommandFactory;

use super::{Arguments, Failure, Outcome, output};
use crate::docs::{TOPICS, explaining, topic};
use crate::system::did_you_mean;

/// Arguments of `help`.
#[derive(Debug, clap::Args)]
pub struct Help {
    /// Topic or command, with its subcommands [default: list both].
    #[arg(value_name = "TOPIC|COMMAND")]
    words: Vec<String>,
}

/// Runs `help`.
pub fn run(arguments: &Help) -> Outcome {
    let words = &arguments.words;
    let program = program();
    let Some(first) = words.first() else {
        return print(program.after_help(topics()), words);
    };
    if let (Some(topic), [_]) = (topic(first), &words[..]) {
        return output::text(topic.text);
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
