//! Readers that close the pipe before everything is written: every command ends as quietly as if they had read it all.

use std::process::Stdio;

use super::CUT_IN;
use super::support::program::{Ended, Home};

/// Commands that write to standard output, in all their formats.
const WRITING: &[&[&str]] = &[
    &[],
    &["--help"],
    &["--version"],
    &["config", "print"],
    &["runs", "export", "--help"],
    &["inspect", CUT_IN],
    &["inspect", CUT_IN, "--format=json"],
    &["inspect", CUT_IN, CUT_IN, "--diff"],
    &["convert", CUT_IN],
    &["metrics", CUT_IN],
    &["metrics", CUT_IN, "--format", "json"],
    &["metrics", CUT_IN, "--format", "parquet"],
    &["metrics", CUT_IN, "--format", "arrow"],
    &["corpus", "index", CUT_IN, "-o", "-"],
    &["corpus", "show", "index"],
    &["corpus", "show", "index", "--format=json"],
    &["corpus", "rate", "index"],
    &["corpus", "rate", "index", "--events", "--format=csv"],
    &["corpus", "sample", "index"],
    &["corpus", "sample", "index", "--format=json"],
    &["corpus", "find", "manoeuvre:cut_in", "--index", "index"],
    &[
        "corpus",
        "find",
        "manoeuvre:cut_in",
        "--filter-only",
        "--format=json",
    ],
    &["prompt", "describe", CUT_IN],
    &["prompt", "show", CUT_IN],
    &["prompt", "list"],
    &["ask", CUT_IN],
    &["ask", CUT_IN, "--format=json"],
    &["models"],
    &["evaluate", CUT_IN],
    &["evaluate", "list"],
    &["tune", "tune.toml", "--dry-run"],
    &["tune", "tune.toml", "--dry-run", "--format=json"],
    &["runs", "batches"],
    &["report"],
    &["runs", "list"],
    &["runs", "list", "--format=json"],
    &["runs", "show", "1"],
    &["runs", "show", "1", "--format=json"],
    &["runs", "ratings"],
    &["runs", "ratings", "export"],
    &["runs", "ratings", "export", "--format", "csv"],
    &["runs", "export"],
    &["runs", "export", "--format", "jsonl"],
    &["runs", "export", "--format", "csv"],
    &["render", CUT_IN],
    &["render", CUT_IN, "--format", "png"],
    &["plan", CUT_IN],
    &["plan", CUT_IN, "--format=json"],
    &["plan", CUT_IN, "-o", "-"],
    &["config", "themes"],
    &["config", "keys"],
    &["doctor"],
    &["completions", "bash"],
    &["completions", "man"],
    &["help"],
    &["help", "workbench"],
];

#[test]
fn a_closed_pipe_changes_neither_the_status_nor_what_is_said() {
    let home = Home::new();
    for _ in 0..2 {
        home.run(&["ask", CUT_IN, "--fresh"]).status(0);
    }
    home.run(&["corpus", "index", CUT_IN, "-o", "index"])
        .status(0);
    let names = super::BUNDLED.map(|(name, _)| format!("\"{name}\""));
    let tune = format!(
        "scenarios = [{}]\nmodels = [\"local/default\"]\ntasks = [\"collision\"]\nbudget = 1\n\
         split = {{ test = 0.2, seed = 6 }}\n",
        names.join(", ")
    );
    home.write("tune.toml", tune);
    let mut writing = 0;
    for arguments in WRITING {
        let mut read = home.command();
        read.args(*arguments);
        let read = read.output().unwrap();
        writing += usize::from(!read.stdout.is_empty());
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut closed = home.command();
        closed
            .args(*arguments)
            .stdout(writer)
            .stderr(Stdio::piped());
        let closed = closed.spawn().unwrap().wait_with_output().unwrap();
        assert_eq!(closed.status, read.status, "{arguments:?}: {closed:?}");
        // Pictures go to standard output as well; words never do.
        let said = String::from_utf8_lossy(&closed.stderr);
        assert!(
            !said.contains("pipe") && !said.contains("panicked"),
            "{arguments:?}: {said}"
        );
    }
    // Lists of what there is not yet are empty.
    assert!(writing + 5 > WRITING.len(), "{writing} commands write");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_no_closed_pipe() {
    let home = Home::new();
    home.run(&["ask", CUT_IN]).status(0);
    for arguments in [
        &["runs", "export"][..],
        &["runs", "export", "--format", "csv"],
        &["metrics", CUT_IN],
        &["runs", "list"],
        &["--help"],
        &["--version"],
        &["ask", "--help"],
        &["help", "store"],
        &["completions", "man"],
        &["completions", "bash"],
    ] {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let mut command = home.command();
        command
            .args(arguments)
            .stdout(full.unwrap())
            .stderr(Stdio::piped());
        let ended = Ended::of(&command.spawn().unwrap().wait_with_output().unwrap());
        ended.status(2).says(&["no space"]);
    }
}
