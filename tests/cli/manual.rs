//! The manual: its topics, and whether the commands in it and in README.md are ones that there are.

use std::collections::BTreeSet;
use std::path::Path;

use clap::{CommandFactory, Parser};
use nearmiss::cli::Arguments;
use nearmiss::docs::TOPICS;

use super::support::program::Home;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Every page: its name and text.
fn pages() -> Vec<(String, String)> {
    let others =
        ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|name| (name.to_string(), read(name)));
    let topics = TOPICS
        .iter()
        .map(|topic| (topic.name.to_string(), topic.text.to_string()));
    others.into_iter().chain(topics).collect()
}

fn commands() -> Vec<String> {
    let program = Arguments::command();
    let all = program.get_subcommands();
    all.map(|command| command.get_name().to_string()).collect()
}

#[test]
fn no_example_names_a_model_that_ends() {
    let registry = nearmiss::llm::Registry::new(&toml::Table::new()).unwrap();
    let mut named = 0;
    for (page, text) in pages().iter().filter(|(page, _)| page != "CHANGELOG.md") {
        let words = text.split(|c: char| !c.is_ascii_alphanumeric() && !"/.-_:".contains(c));
        let ids = words.filter(|word| registry.unlisted(word).is_none() && word.contains('/'));
        for id in ids {
            named += usize::from(id.starts_with("openai/"));
            assert_eq!(registry.retirement(id), None, "{page}: {id}");
        }
    }
    assert!(named > 5, "{named}");
}

#[test]
fn every_topic_is_printed_and_listed() {
    let home = Home::new();
    let list = home.run(&["help"]).status(0).stdout;
    // Topics come first, then the commands, without any options.
    let (topics, listed) = list.split_once("\n\n").unwrap();
    for command in commands() {
        assert!(listed.contains(&format!("\n  {command} ")), "{command}");
    }
    assert!(!list.contains("--format=json"), "{list}");
    let (_, topics) = topics.split_once(":\n").unwrap();
    let listed: Vec<&str> = topics
        .lines()
        .map(|line| line.split_whitespace().next().unwrap())
        .collect();
    let known: Vec<&str> = TOPICS.iter().map(|topic| topic.name).collect();
    assert_eq!(listed, known);
    for topic in TOPICS {
        let printed = home.run(&["help", topic.name]).status(0);
        // Behind the text of `json` come its schemas.
        assert!(printed.stdout.starts_with(topic.text), "{}", topic.name);
        assert!(
            [
                "configuration",
                "measures",
                "providers",
                "mcp-server",
                "json",
                "experiments",
                "planners",
                "preventability",
                "requirements",
                "tools"
            ]
            .contains(&topic.name)
                || printed.stdout == topic.text
        );
        assert!(topic.text.starts_with("# ") && topic.text.ends_with('\n'));
        assert!(topic.text.lines().count() <= 200, "{} is long", topic.name);
        assert!(
            !commands().iter().any(|command| command == topic.name),
            "{} is a command, too",
            topic.name
        );
    }
    let pages = |folder: &str| {
        let entries = std::fs::read_dir(root().join(folder)).unwrap();
        let is_page = |path: &std::path::PathBuf| path.extension().is_some_and(|x| x == "md");
        entries
            .map(|entry| entry.unwrap().path())
            .filter(is_page)
            .count()
    };
    let files = pages("src/docs") + pages("src/docs/tasks");
    assert_eq!(files, TOPICS.len(), "a file is in no table");
}

#[test]
fn commands_keep_their_help() {
    let home = Home::new();
    let same = |help: &[&str], flag: &[&str]| {
        let (help, flag) = (home.run(help).status(0), home.run(flag).status(0));
        assert!(help.stdout.starts_with(&flag.stdout), "{}", help.stdout);
        help.stdout
    };
    let metrics = same(&["help", "metrics"], &["metrics", "--help"]);
    assert!(metrics.ends_with("\nManual: `nearmiss help measures`\n"));
    same(&["help", "runs", "show"], &["runs", "show", "--help"]);
    same(&["runs", "help", "show"], &["runs", "show", "--help"]);
    let commands = commands();
    let explained = TOPICS.iter().flat_map(|topic| topic.commands);
    for command in explained {
        assert!(commands.iter().any(|known| known == command), "{command}");
    }
}

#[test]
fn what_there_is_not_is_refused_with_what_was_probably_meant() {
    let home = Home::new();
    let ended = home.run(&["help", "mesures"]).status(2).says(&[
        "`mesures`",
        "did you mean `measures`?",
        "`nearmiss help` lists",
    ]);
    assert!(ended.stdout.is_empty());
    // Commands and options of before are answered with those of today.
    home.run(&["find", "cut-ins"])
        .status(2)
        .says(&["`find` is `corpus find` now"]);
    home.run(&["inspect", "--json"])
        .status(2)
        .says(&["`--json` is `--format json` now"]);
    for (asked, now) in [
        (
            "evaluate x --resume b1",
            "`--resume` is `nearmiss evaluate BATCH` now",
        ),
        ("evaluate x --lead 1", "`--lead` is `--set leads=S` now"),
        (
            "evaluate x --max-tokens 9",
            "`--max-tokens` is `--set max_tokens=VALUE` now",
        ),
        (
            "tune x.toml --rounds 2",
            "`--rounds` is `--set tune.rounds=VALUE` now",
        ),
        (
            "generate x --votes 3",
            "`--votes` is `--set votes=VALUE` now",
        ),
        ("templates", "`templates` is `prompt list` now"),
    ] {
        let words: Vec<&str> = asked.split(' ').collect();
        home.run(&words).status(2).says(&[now]);
    }
    let ended = home.run(&["help", "generat"]).status(2);
    ended.says(&["did you mean `generate`"]);
    let ended = home.run(&["help", "xyzzy"]).status(2);
    assert!(!ended.stderr.contains("did you mean"), "{}", ended.stderr);
    let ended = home.run(&["help", "runs", "shwo"]).status(2);
    ended.says(&[
        "unknown command `runs shwo`; did you mean `show`",
        "`nearmiss runs --help` lists all",
    ]);
    let ended = home.run(&["help", "measures", "ttc"]).status(2);
    ended.says(&["`measures` is a topic"]);
    let ended = home.run(&["help", "ask", "json"]).status(2);
    ended.says(&["`nearmiss ask` has no subcommands"]);
}

/// The words of a line as a shell takes them, up to what ends the command.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in line.chars() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, ' ') => words.extend(word.take()),
            (None, '#') if word.is_none() => break,
            (None, '|' | ';' | '&' | '>') => break,
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

/// The command lines of the program in a page's blocks of shell.
fn lines(text: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for block in text.split("```sh\n").skip(1) {
        let (block, _) = block.split_once("```").unwrap();
        for line in block.replace("\\\n", " ").lines() {
            let line = line.trim_start();
            let line = line.strip_prefix("if ").unwrap_or(line);
            let words = words(line);
            if words.first().is_some_and(|word| word == "nearmiss") {
                found.push(words);
            }
        }
    }
    found
}

#[test]
fn every_command_line_in_the_manual_parses() {
    let mut named = BTreeSet::new();
    let mut wrong = Vec::new();
    for (page, text) in pages() {
        for line in lines(&text) {
            let line: Vec<String> = line
                .iter()
                .map(|word| word.replace("$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT", "1/4"))
                .collect();
            if let Err(error) = Arguments::try_parse_from(&line)
                && error.use_stderr()
            {
                wrong.push(format!("{page}: {}\n{error}", line.join(" ")));
            }
            named.extend(line.into_iter().nth(1));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for command in commands() {
        assert!(named.contains(&command), "no page shows `{command}`");
    }
}

#[test]
fn what_pages_refer_to_is_there() {
    let known: Vec<String> = TOPICS.iter().map(|topic| topic.name.to_string()).collect();
    let known = [known, commands()].concat();
    for (page, text) in pages() {
        for (_, rest) in text
            .match_indices("`nearmiss help ")
            .map(|(at, m)| text.split_at(at + m.len()))
        {
            let (word, _) = rest.split_once('`').unwrap();
            let word = word
                .split_once(" --schema")
                .map_or(word, |(topic, _)| topic);
            let fine = known.iter().any(|name| name == word)
                || ["TOPIC", "COMMAND", "--find WORDS"].contains(&word);
            assert!(fine, "{page}: nearmiss help {word}");
        }
        let file = TOPICS
            .iter()
            .find(|topic| topic.name == page)
            .map(|topic| topic.file);
        let folder = match file {
            None => "",
            Some(file) if file.starts_with("tasks/") => "src/docs/tasks",
            Some(_) => "src/docs",
        };
        for link in text.split("](").skip(1) {
            let (link, _) = link.split_once(')').unwrap();
            let there = link.starts_with("https://") || root().join(folder).join(link).exists();
            assert!(there, "{page}: {link}");
        }
    }
    let readme = read("README.md");
    for topic in TOPICS {
        assert!(
            readme.contains(&format!("(src/docs/{})", topic.file)),
            "{}",
            topic.name
        );
    }
    for command in commands() {
        let (_, table) = readme.split_once("## Commands").unwrap();
        assert!(table.contains(&format!("`{command}`")), "{command}");
    }
}

#[test]
fn the_readme_is_short() {
    let lines = read("README.md").lines().count();
    assert!(lines <= 125, "{lines} lines");
}

#[test]
fn the_manual_is_searched_and_short() {
    let home = Home::new();
    let found = home
        .run(&["help", "--find", "closing speed"])
        .status(0)
        .stdout;
    assert!(found.lines().any(|line| !line.starts_with(' ')), "{found}");
    assert!(found.to_lowercase().contains("closing speed"), "{found}");
    let defined = home.run(&["help", "--find", "headway"]).status(0).stdout;
    assert!(defined.starts_with("measures"), "{defined}");
    home.run(&["help", "--find", "xyzzy"])
        .status(1)
        .says(&["no line of the manual"]);
    // What is pasted from the program, and reference pages, do not count.
    let words = |text: &str| {
        let mut is_output = false;
        let own = text.lines().filter(|line| {
            is_output = match *line {
                "```console" => true,
                "```" => false,
                _ => is_output,
            };
            !is_output || line.starts_with("$ ")
        });
        own.flat_map(str::split_whitespace).count()
    };
    let all: usize = TOPICS.iter().map(|topic| words(topic.text)).sum();
    let all = all + words(&read("README.md"));
    assert!(all <= 18_000, "{all} words");
}
