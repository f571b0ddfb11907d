//! `nearmiss help` and `completions`: help for a command, topics of the manual, and what is generated from arguments.

use std::ffi::OsStr;
use std::io;
use std::path::Path;

use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory, ValueEnum};
use clap_complete::Shell;
use nearmiss_base::system::{did_you_mean, unknown};
use nearmiss_docs::{TOPICS, Topic, explaining, topic};
use nearmiss_drive::simulation::{planner_message_names, planner_message_schema};
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_workflow::annex::SafetyRequirement;
use nearmiss_workflow::experiment_schema;

use super::open::resolved;
use super::{Arguments, Failure, Outcome, drivers, generate, json, knobs, mcp, metrics, output};
use nearmiss_ask::llm::{Environment, QUIRKS, Registry};
use nearmiss_settings::{Config, Planning};

/// Arguments of `help`.
#[derive(Debug, clap::Args)]
pub struct Help {
    /// Topic or command, with its subcommands [default: list topics and commands].
    #[arg(value_name = "TOPIC|COMMAND")]
    words: Vec<String>,
    /// Print a JSON schema: with topic json of this output, with planners of a message such as `hello`, with
    /// experiments `experiment`, with requirements `requirement`.
    #[arg(long, value_name = "OUTPUT")]
    schema: Option<String>,
    /// Search all topics for lines that contain all WORDS; print each with its topic and section.
    #[arg(long, value_name = "WORDS", conflicts_with_all = ["words", "schema"])]
    find: Option<String>,
}

/// Runs `help`.
pub fn run(arguments: &Help) -> Outcome {
    let words = &arguments.words;
    if let Some(wanted) = &arguments.find {
        return find(wanted);
    }
    if let Some(name) = &arguments.schema {
        return schema(words, name);
    }
    let program = program();
    let Some(first) = words.first() else {
        let commands = commands(&program, |group| format!("{group}:"));
        return output::text(&format!(
            "{}{commands}\n`nearmiss help COMMAND` prints the help of a command, `nearmiss --help` that of the workbench.\n",
            topics()
        ));
    };
    if let (Some(topic), [_]) = (topic(first), &words[..]) {
        return output::text(&format!("{}{}", topic.text, generated(topic.name)));
    }
    let mut command = &program;
    for (at, word) in words.iter().enumerate() {
        let found = command.find_subcommand(word);
        command = found.ok_or_else(|| Failure::input(unknown_word(command, &words[..at], word)))?;
    }
    print(program, words)?;
    match explaining(first) {
        Some(topic) => output::text(&format!("\nManual: `nearmiss help {}`\n", topic.name)),
        None => Ok(()),
    }
}

/// A planner in Python that the tests drive.
const MINIMAL_PLANNER: &str = include_str!("../../tests/planners/minimal.py");

/// Lines that a search prints at most.
const MOST_FOUND: usize = 40;

/// Prints the lines of all topics that have these words, below their topic and section.
fn find(wanted: &str) -> Outcome {
    let wanted: Vec<String> = { wanted.split(|c: char| !c.is_alphanumeric()) }
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect();
    let (mut told, mut found) = (String::new(), 0);
    // Definitions come first.
    let defines = |topic: &&Topic| ["glossary", "measures"].contains(&topic.name);
    let all = TOPICS
        .iter()
        .filter(defines)
        .chain(TOPICS.iter().filter(|one| !defines(one)));
    for topic in all {
        let text = format!("{}{}", topic.text, generated(topic.name));
        let (mut section, mut said) = (String::new(), String::new());
        for line in text.lines() {
            if let Some(title) = line.strip_prefix("## ") {
                section = format!(" · {title}");
            }
            let lower = line.to_lowercase();
            let words: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).collect();
            let has = |wanted: &String| {
                { words.iter() }
                    .any(|word| word == wanted || word.strip_suffix('s') == Some(wanted))
            };
            if wanted.is_empty() || !wanted.iter().all(has) {
                continue;
            }
            found += 1;
            if found > MOST_FOUND {
                continue;
            }
            let place = format!("{}{section}\n", topic.name);
            if place != said {
                told += &place;
                said = place;
            }
            told += &format!("    {}\n", line.trim());
        }
    }
    if found == 0 {
        return Err(Failure::finding("no line of the manual has these words"));
    }
    output::text(&told)?;
    if found > MOST_FOUND {
        output::say(&format!(
            "nearmiss: {} more lines; add a word",
            found - MOST_FOUND
        ));
    }
    Ok(())
}

/// What comes behind the text of a topic, from the code.
fn generated(topic: &str) -> String {
    let keys = |title: &str, keys: String| format!("\n## {title}\n\n{keys}");
    match topic {
        "json" => vocabulary(),
        "experiments" => keys("Keys", knobs::keys::<Experiment>()),
        "requirements" => keys("Keys", knobs::keys::<SafetyRequirement>()),
        "planners" => format!("\n```python\n{MINIMAL_PLANNER}```\n{}", planner_messages()),
        "preventability" => keys("Each driver", drivers::page()),
        "tools" => nearmiss_study::tools::table(),
        "measures" => keys("Each measure", metrics::list::shipped()),
        "configuration" => {
            keys("Keys of config.toml", knobs::keys::<Config>())
                + &keys("Keys of [planner]", knobs::keys::<Planning>())
        }
        "providers" => keys("Providers", providers()) + &keys("Quirks", quirks()),
        "mcp-server" => keys("Tools", mcp::tools()),
        _ => String::new(),
    }
}

/// The built-in providers: address, and the variables of the key.
fn providers() -> String {
    let registry = Registry::lenient(&toml::Table::new(), Path::new(""));
    let all = registry
        .addresses(&Environment::from_lookup(|_| None))
        .into_iter();
    let lines = all.map(|one| {
        format!(
            "    {:<14} {:<50} {}\n",
            one.provider,
            one.url,
            one.keys.join(" or ")
        )
    });
    lines.collect()
}

/// How servers and models differ, as `quirks = { … }` of a provider or model says it.
fn quirks() -> String {
    let lines = QUIRKS.iter().map(|(name, about)| {
        let about =
            textwrap::fill(&about.replace("  ", " "), 66).replace('\n', &format!("\n{:30}", ""));
        format!("    {name:<25} {}\n", about.trim())
    });
    lines.collect()
}

/// The program's arguments, with commands in groups; commands of commands have the `help` that comes with clap.
pub fn program() -> clap::Command {
    let program = Arguments::command().mut_subcommands(|command| {
        if command.has_subcommands() {
            command.defer(|command| command.disable_help_subcommand(false))
        } else {
            command
        }
    });
    let header = *program.get_styles().get_header();
    let title = |words: &str| format!("{header}{words}:{header:#}");
    let commands = commands(&program, title);
    let [arguments, options] = ["Arguments", "Options"].map(title);
    program.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n{commands}\n{arguments}\n{{positionals}}\n\n{options}\n{{options}}{{after-help}}"
    ))
}

/// What people do with the program, each with its commands.
const GROUPS: &[(&str, &[&str])] = &[
    ("Look", &["inspect", "describe", "render", "convert"]),
    ("Measure", &["metrics", "corpus"]),
    ("Ask", &["ask", "prompt", "models"]),
    ("Evaluate", &["evaluate", "report", "check", "runs", "tune"]),
    (
        "Drive and attack",
        &["plan", "generate", "drivers", "annex"],
    ),
    ("Serve", &["mcp"]),
    ("Set up", &["doctor", "config", "completions", "help"]),
];

/// Commands of versions before, and what they are now.
const MOVED: &[(&str, &str)] = &[
    ("batches", "runs batches"),
    ("experiment", "runs export` and `runs import"),
    ("export", "runs export"),
    ("find", "corpus find"),
    ("import", "runs import"),
    ("index", "corpus index"),
    ("keys", "config keys"),
    ("man", "completions man"),
    ("prompts", "prompt"),
    ("ratings", "runs ratings"),
    ("sample", "corpus sample"),
    ("templates", "prompt list"),
    ("themes", "config themes"),
];

/// Options of versions before that are no key of `--set` by their name, and what they are now.
const MOVED_OPTIONS: &[(&str, &str)] = &[
    ("--ablation", "--rows techniques --against base"),
    ("--add-lead", "--set leads=S"),
    ("--add-model", "--model MODEL"),
    ("--add-techniques", "--techniques TECHNIQUES"),
    ("--add-transform", "--set transforms=CHANGES"),
    ("--against", "a second --planner"),
    ("--csv", "--format csv"),
    ("--frame", "--set frames=FRAME"),
    ("--json", "--format json"),
    ("--lead", "--set leads=S"),
    ("--leaks", "--dry-run=leaks"),
    ("--list", "nearmiss evaluate list"),
    ("--no-feedback", "--set feedback=off"),
    ("--no-grades", "--set grades=off"),
    ("--planning-problem", "--ego FILE#ID"),
    ("--print", "--format toml"),
    ("--print-config", "nearmiss config print"),
    ("--questions", "--dry-run=questions"),
    ("--resume", "nearmiss evaluate BATCH"),
    ("--split-seed", "--set split.seed=N"),
    ("--test-share", "--set split.test=SHARE"),
    ("--to", "--format FORMAT"),
    ("--transform", "--set transforms=CHANGES"),
    ("--toml", "--format toml"),
];

/// What an option is now that is not known any more, of the command that `words` name.
pub fn moved_option(error: &clap::Error, words: &[String]) -> Option<String> {
    let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let moved = MOVED_OPTIONS.iter().find(|(old, _)| old == option);
    let now = match moved {
        Some((_, now)) => (*now).to_string(),
        None => format!("--set {}=VALUE", set_by(option, words)?),
    };
    Some(format!("`{option}` is `{now}` now"))
}

/// The key of `--set` that has the name of an option, where the command has one.
fn set_by(option: &str, words: &[String]) -> Option<String> {
    let program = program();
    let mut command = &program;
    for word in words {
        match command.find_subcommand(word) {
            Some(next) => command = next,
            None => break,
        }
    }
    let mut options = command.get_arguments();
    if !options.any(|option| option.get_long() == Some("set")) {
        return None;
    }
    let key = option.strip_prefix("--")?.replace('-', "_");
    let keys: Vec<String> = match command.get_name() {
        "plan" | "generate" => generate::keys().collect(),
        "tune" => knobs::names_for_tune().collect(),
        _ => knobs::names().map(Into::into).collect(),
    };
    keys.into_iter()
        .find(|known| known.rsplit('.').next() == Some(&key))
}

/// Prints the JSON schema of an output.
fn schema(words: &[String], name: &str) -> Outcome {
    let topic = match words {
        [topic] if ["json", "planners"].contains(&topic.as_str()) => topic.as_str(),
        [topic] if FILES.iter().any(|file| file.topic == topic) => topic.as_str(),
        _ => {
            return Err(Failure::input(format!(
                "--schema needs the topic json, experiments, requirements or planners: `nearmiss help {} --schema {name}`",
                topic_of_schema(name)
            )));
        }
    };
    let file = FILES.iter().find(|file| file.topic == topic);
    let schema = match topic {
        "json" => json::document(name),
        "planners" => planner_message_schema(name),
        _ => file
            .filter(|file| file.name == name)
            .map(|file| (file.schema)()),
    };
    let Some(schema) = schema else {
        let names: Vec<String> = match topic {
            "json" => json::names().into_iter().map(|(name, _)| name).collect(),
            "planners" => planner_message_names()
                .map(|(name, _)| name.into())
                .collect(),
            _ => file.iter().map(|file| file.name.to_string()).collect(),
        };
        let unknown = unknown("schema", name, names.iter().map(String::as_str));
        return Err(Failure::input(format!(
            "{unknown}\n`nearmiss help {topic}` lists all"
        )));
    };
    let text = serde_json::to_string_pretty(&schema).map_err(Failure::input)?;
    output::text(&format!("{text}\n"))
}

/// The topic that has this schema.
fn topic_of_schema(name: &str) -> &'static str {
    let mut messages = planner_message_names();
    if let Some(file) = FILES.iter().find(|file| file.name == name) {
        file.topic
    } else if messages.any(|(message, _)| message == name) {
        "planners"
    } else {
        "json"
    }
}

/// A kind of file that users write, with a schema for their editors.
struct WrittenFile {
    topic: &'static str,
    name: &'static str,
    schema: fn() -> serde_json::Value,
}

const FILES: &[WrittenFile] = &[
    WrittenFile {
        topic: "experiments",
        name: "experiment",
        schema: experiment_schema,
    },
    WrittenFile {
        topic: "requirements",
        name: "requirement",
        schema: SafetyRequirement::schema,
    },
];

/// The messages of the planner protocol.
fn planner_messages() -> String {
    let lines = planner_message_names().map(|(name, about)| format!("    {name:<15} {about}\n"));
    format!("\n## Messages\n\n{}", lines.collect::<String>())
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
    format!("Topics of the manual, `nearmiss help TOPIC`:\n{lines}")
}

/// The commands in groups, below their titles.
fn commands(program: &clap::Command, title: impl Fn(&str) -> String) -> String {
    let line = |name: &&str| {
        let about = program
            .find_subcommand(name)
            .and_then(clap::Command::get_about);
        let about = about.map(ToString::to_string).unwrap_or_default();
        format!("  {name:<14} {about}\n")
    };
    let groups = GROUPS.iter().map(|(group, names)| {
        let lines: String = names.iter().map(line).collect();
        format!("\n{}\n{lines}", title(group))
    });
    groups.collect()
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
    if let Some((_, now)) = MOVED.iter().find(|(old, _)| *old == said) {
        return Some(Failure::input(format!("`{said}` is `{now}` now")));
    }
    let commands = program.get_subcommands().map(clap::Command::get_name);
    let meant = did_you_mean(said, commands);
    let message =
        format!("unknown command or file `{said}`{meant}\n`nearmiss help` lists all commands");
    (!meant.is_empty()).then(|| Failure::input(message))
}

/// The message for an argument that is neither a subcommand nor a topic.
fn unknown_word(command: &clap::Command, before: &[String], word: &str) -> String {
    let commands = command.get_subcommands().map(clap::Command::get_name);
    let topics: Vec<&str> = TOPICS.iter().map(|topic| topic.name).collect();
    if !before.is_empty() {
        let commands: Vec<&str> = commands.collect();
        let path = before.join(" ");
        if commands.is_empty() {
            return format!("`nearmiss {path}` has no subcommands");
        }
        let meant = did_you_mean(word, commands);
        return format!(
            "unknown command `{path} {word}`{meant}\n`nearmiss {path} --help` lists all"
        );
    }
    if topic(word).is_some() {
        return format!("`{word}` is a topic without subtopics: `nearmiss help {word}`");
    }
    let all: Vec<&str> = topics.iter().copied().chain(commands).collect();
    format!(
        "unknown topic or command `{word}`{}\n`nearmiss help` lists all",
        did_you_mean(word, all)
    )
}

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// Shell to print completions for, or man for the manual page.
    #[arg(value_enum, value_name = "SHELL|man")]
    kind: Generated,
}

/// What is generated.
#[derive(Debug, Clone, Copy)]
enum Generated {
    Shell(Shell),
    Man,
}

impl ValueEnum for Generated {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self::Shell(Shell::Bash),
            Self::Shell(Shell::Elvish),
            Self::Shell(Shell::Fish),
            Self::Shell(Shell::PowerShell),
            Self::Shell(Shell::Zsh),
            Self::Man,
        ]
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        match self {
            Self::Shell(shell) => shell.to_possible_value(),
            Self::Man => Some("man".into()),
        }
    }
}

/// Runs `completions`.
pub fn completions(arguments: &Completions) -> Outcome {
    let mut bytes = Vec::new();
    let mut program = Arguments::command();
    match arguments.kind {
        Generated::Shell(shell) => {
            clap_complete::generate(shell, &mut program, "nearmiss", &mut bytes);
        }
        Generated::Man => clap_mangen::Man::new(program)
            .render(&mut bytes)
            .map_err(Failure::input)?,
    }
    output::text(&String::from_utf8_lossy(&bytes))
}
