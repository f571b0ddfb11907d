//! Works off cases in one process and writes down what it does, so that its parent knows where it ended.

use std::fs::{self, File};
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::Parser;
use fastrand::Rng;
use nearmiss::{cli, tui};

use super::mutate::mutated;
use super::{MEMORY, commands, small};

/// Most memory of one command, bytes.
pub const MOST_MEMORY: usize = 1 << 30;

/// Longest that one command may take; without optimisation everything is some ten times slower.
pub const LONGEST: Duration = Duration::from_secs(if cfg!(debug_assertions) { 60 } else { 10 });

/// Which cases, and where.
#[derive(Clone, Debug)]
pub struct Work {
    pub folder: PathBuf,
    pub first: u64,
    pub end: u64,
    /// Every command over every case, not a few of them.
    pub all: bool,
}

/// What a file says of a worker: a line when a command begins, one when it ended.
pub fn journal(folder: &Path) -> PathBuf {
    folder.join("journal")
}

/// Files of a case.
pub fn case_folder(folder: &Path, case: u64) -> PathBuf {
    folder.join(format!("case-{case}"))
}

/// Writes the mutated file of a case, and its ego.
pub fn write_case(folder: &Path, case: u64) -> (PathBuf, PathBuf) {
    let mut rng = Rng::with_seed(case);
    let own = small::scenario();
    let bundled;
    let scenario = match rng.usize(..12) {
        0 => {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
            bundled = fs::read_to_string(root.join("ZAM_Overtaking-1_1_T-1.xml")).expect("bundled");
            &bundled
        }
        _ => &own,
    };
    let folder = case_folder(folder, case);
    fs::create_dir_all(&folder).expect("a folder of our own");
    let file = folder.join("ZAM_Small-1_1_T-1.xml");
    fs::write(&file, mutated(&mut rng, scenario)).expect("a file of our own");
    let ego = folder.join("ZAM_Small-1_1_T-1.ego_trajectory.csv");
    fs::write(&ego, small::ego()).expect("a file of our own");
    (file, ego)
}

struct Now {
    begun: Instant,
    memory: usize,
}

static NOW: Mutex<Option<Now>> = Mutex::new(None);

/// Works off the cases.
pub fn work(work: &Work) {
    let mut journal = File::options()
        .append(true)
        .create(true)
        .open(journal(&work.folder))
        .expect("a file of our own");
    let watched = journal.try_clone().expect("a second handle");
    std::thread::spawn(move || watch(watched));
    for case in work.first..work.end {
        let (file, ego) = write_case(&work.folder, case);
        let out = case_folder(&work.folder, case);
        let mut rng = Rng::with_seed(!case);
        let mut numbers: Vec<usize> = (0..commands::COUNT).collect();
        rng.shuffle(&mut numbers);
        let count = if work.all { commands::COUNT } else { 5 };
        for number in numbers.into_iter().take(count) {
            let words = commands::words(number, &file, &ego, &out);
            let _ = writeln!(journal, "begin {case} {}", words[1..].join(" "));
            MEMORY.reset_peak_usage();
            let before = MEMORY.current_usage();
            *NOW.lock().expect("no panic holds it") = Some(Now {
                begun: Instant::now(),
                memory: before,
            });
            let ended = panic::catch_unwind(AssertUnwindSafe(|| run(&words)));
            let now = NOW.lock().expect("no panic holds it").take();
            let took = now.map_or(0, |now| now.begun.elapsed().as_millis());
            let peak = MEMORY.peak_usage().saturating_sub(before) >> 20;
            let ended = match ended {
                Ok(status) => format!("status {status}"),
                Err(panic) => format!("panic {}", words_of(&*panic)),
            };
            let _ = writeln!(journal, "end {took} ms {peak} MiB {ended}");
        }
        // It can be made again from its number.
        let _ = fs::remove_dir_all(out);
    }
    let _ = writeln!(journal, "done");
}

fn run(words: &[String]) -> u8 {
    let arguments = cli::Arguments::try_parse_from(words).expect("a command line without mistakes");
    let command = arguments.command.expect("a headless command");
    let workbench = cli::Workbench {
        themes: tui::themes,
        keys: tui::keys,
        key_bindings: tui::key_bindings,
        theme_mistakes: tui::theme_mistakes,
        terminal: tui::terminal_here,
        screen: tui::screen,
    };
    match cli::run(&command, &workbench) {
        Ok(()) => 0,
        Err(failure) => {
            assert!(
                !failure.message.trim().is_empty() || failure.status == 1,
                "an error without words"
            );
            failure.status
        }
    }
}

fn words_of(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("without words").replace('\n', " ")
}

/// Ends the process when a command takes too long or too much.
fn watch(mut journal: File) {
    loop {
        std::thread::sleep(Duration::from_millis(20));
        let Ok(now) = NOW.lock() else { continue };
        let Some(now) = &*now else { continue };
        let memory = MEMORY.current_usage().saturating_sub(now.memory);
        let why = if memory > MOST_MEMORY {
            format!("more than {} MiB", MOST_MEMORY >> 20)
        } else if now.begun.elapsed() > LONGEST {
            format!("longer than {} s", LONGEST.as_secs())
        } else {
            continue;
        };
        let _ = writeln!(journal, "end 0 ms 0 MiB broke {why}");
        std::process::exit(70);
    }
}
