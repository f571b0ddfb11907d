//! Mutated scenarios through every command, many in one process: nothing panics, takes long, or takes much memory.
//!
//! `NEARMISS_MUTATED_CASES=4000 NEARMISS_MUTATED_SEED=7 cargo test --release --test mutated` tries other and more
//! ones, every command over each. A file that broke something is kept, and its place said.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod commands;
mod markup;
mod mutate;
mod small;
mod worker;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use peak_alloc::PeakAlloc;
use worker::{Work, case_folder, journal};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Set where this process works off cases.
const WORK: &str = "NEARMISS_MUTATED_WORK";

fn number(name: &str) -> Option<u64> {
    let value = std::env::var(name).ok()?;
    Some(
        value
            .parse()
            .unwrap_or_else(|_| panic!("{name}={value} is no number")),
    )
}

/// The unchanged scenario does what it should in every command, or mutations of it would say little.
#[test]
fn the_scenario_itself_is_sound() {
    let scenario =
        nearmiss::formats::commonroad::read(small::scenario().as_bytes(), "small").unwrap();
    assert_eq!(scenario.obstacles.len(), 5);
    assert_eq!(scenario.network.lanelets.len(), 3);
    assert_eq!(scenario.planning_problems.len(), 1);
    let bad: Vec<_> = scenario
        .diagnostics
        .iter()
        .map(|d| format!("{}: {}", d.line, d.message))
        .collect();
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn mutated_scenarios_break_no_command() {
    if let Ok(text) = std::env::var(WORK) {
        let mut parts = text.splitn(4, ' ');
        let mut next = || parts.next().unwrap();
        let (first, end, all) = (
            next().parse().unwrap(),
            next().parse().unwrap(),
            next() == "all",
        );
        worker::work(&Work {
            folder: PathBuf::from(next()),
            first,
            end,
            all,
        });
        return;
    }
    let wished = number("NEARMISS_MUTATED_CASES");
    let seed = number("NEARMISS_MUTATED_SEED").unwrap_or(1);
    let cases = wished.unwrap_or(300);
    let first = seed.checked_mul(1_000_000).expect("a smaller seed");
    let (all, workers) = (wished.is_some(), 2);
    let share = cases.div_ceil(workers);
    let temporary = tempfile::tempdir().unwrap();
    let outcomes: Vec<Outcome> = std::thread::scope(|scope| {
        let tasks: Vec<_> = (0..workers)
            .map(|i| {
                let folder = temporary.path().join(format!("worker-{i}"));
                let end = (first + (i + 1) * share).min(first + cases);
                let work = Work {
                    folder,
                    first: first + i * share,
                    end,
                    all,
                };
                scope.spawn(move || watched(work))
            })
            .collect();
        tasks.into_iter().map(|t| t.join().unwrap()).collect()
    });
    let runs: usize = outcomes.iter().map(|o| o.runs).sum();
    let mut statuses = BTreeMap::<&str, usize>::new();
    for (status, count) in outcomes.iter().flat_map(|o| &o.statuses) {
        *statuses.entry(status).or_default() += count;
    }
    let broken: Vec<&String> = outcomes.iter().flat_map(|o| &o.broken).collect();
    println!(
        "{cases} files, {runs} commands: {statuses:?}; slowest {} ms, most memory {} MiB",
        outcomes.iter().map(|o| o.slowest).max().unwrap_or(0),
        outcomes.iter().map(|o| o.largest).max().unwrap_or(0)
    );
    assert!(
        broken.is_empty(),
        "{} of {runs} commands broke:\n{broken:#?}",
        broken.len()
    );
    // Mutations that leave nothing readable would test the reader alone.
    let done = statuses.get("status 0").copied().unwrap_or(0);
    assert!(
        done * 5 > runs,
        "only {done} of {runs} commands had something to do"
    );
}

#[derive(Default)]
struct Outcome {
    runs: usize,
    statuses: BTreeMap<String, usize>,
    broken: Vec<String>,
    slowest: u64,
    largest: u64,
}

/// Has the cases worked off by a process, and by another one where that ends before its time.
fn watched(mut work: Work) -> Outcome {
    let home = work.folder.join("home");
    std::fs::create_dir_all(&home).unwrap();
    let mut outcome = Outcome::default();
    while work.first < work.end {
        let all = if work.all { "all" } else { "few" };
        let told = format!(
            "{} {} {all} {}",
            work.first,
            work.end,
            work.folder.display()
        );
        let errors = std::fs::File::create(work.folder.join("errors")).unwrap();
        let mut command = Command::new(std::env::current_exe().unwrap());
        command
            .args([
                "--exact",
                "mutated::mutated_scenarios_break_no_command",
                "--nocapture",
            ])
            .env(WORK, told)
            .current_dir(&home)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(errors);
        for name in [
            "HOME",
            "XDG_CONFIG_HOME",
            "XDG_DATA_HOME",
            "XDG_STATE_HOME",
            "XDG_CACHE_HOME",
        ] {
            command.env(name, &home);
        }
        let status = command.status().unwrap();
        let text = std::fs::read_to_string(journal(&work.folder)).unwrap();
        std::fs::remove_file(journal(&work.folder)).unwrap();
        let done = outcome.take(&work, &text, &format!("the process ended: {status}"));
        match done {
            None => break,
            Some(case) => work.first = case + 1,
        }
    }
    outcome
}

impl Outcome {
    /// Takes a worker's journal in; the case in which it ended, if it did not come to its end.
    fn take(&mut self, work: &Work, text: &str, ended: &str) -> Option<u64> {
        let mut last: Option<(u64, &str)> = None;
        for line in text.lines() {
            if line == "done" {
                return None;
            }
            if let Some(begun) = line.strip_prefix("begin ") {
                let (case, command) = begun.split_once(' ').unwrap();
                last = Some((case.parse().unwrap(), command));
                self.runs += 1;
                continue;
            }
            let words: Vec<&str> = line.splitn(6, ' ').collect();
            self.slowest = self.slowest.max(words[1].parse().unwrap());
            self.largest = self.largest.max(words[3].parse().unwrap());
            let what = words[5];
            match what.strip_prefix("status ") {
                Some(_) => *self.statuses.entry(what.to_owned()).or_default() += 1,
                None => {
                    let (case, command) = last.expect("what ends has begun");
                    self.breaks(work, case, command, what);
                }
            }
            if !what.starts_with("broke") {
                last = last.map(|(case, _)| (case, ""));
            } else {
                return last.map(|(case, _)| case);
            }
        }
        let (case, command) = last.unwrap_or((work.first, "before the first command"));
        self.breaks(work, case, command, ended);
        Some(case)
    }

    fn breaks(&mut self, work: &Work, case: u64, command: &str, why: &str) {
        let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutated");
        let (file, _) = worker::write_case(&kept, case);
        let from = case_folder(&work.folder, case);
        let to = case_folder(&kept, case);
        let command = command.replace(&*from.to_string_lossy(), &to.to_string_lossy());
        self.broken
            .push(format!("{why}\n  nearmiss {command}\n  {}", file.display()));
    }
}
