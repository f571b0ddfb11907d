//! Files that the program keeps: for the user alone, read where nothing can be written, and nothing left of a kill.
#![cfg(unix)]

use std::fs::Permissions;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::CUT_IN;
use super::support::program::{Ended, Home};

const LONG: Duration = Duration::from_secs(60);

fn set(path: &Path, mode: u32) {
    std::fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
}

fn mode(path: &Path) -> u32 {
    path.metadata().unwrap().permissions().mode() & 0o777
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn pipe(path: &Path) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.unwrap().success());
}

#[test]
fn what_was_asked_is_for_the_user_alone_also_in_a_folder_of_an_older_program() {
    let home = Home::new();
    let (data, store) = (home.data(), home.data().join("runs.sqlite"));
    home.run(&["ask", CUT_IN]).status(0);
    assert_eq!((mode(&data), mode(&store)), (0o700, 0o600));
    let draft = data.join("drafts/collision-ego.md");
    let env = home.config().join(".env");
    std::fs::create_dir(draft.parent().unwrap()).unwrap();
    std::fs::write(&draft, "x").unwrap();
    std::fs::write(&env, "OPENAI_API_KEY=x").unwrap();
    for file in [&store, &draft, &env] {
        set(file, 0o644);
    }
    set(&data, 0o755);
    home.run(&["runs", "list"]).status(0);
    assert_eq!([&store, &draft, &env].map(|file| mode(file)), [0o600; 3]);
    assert_eq!(mode(&data), 0o700);
}

/// The program as a user who may only read: this user, or another one where this is root.
fn reading(home: &Home, program: &Path, arguments: &[&str]) -> Ended {
    let mut command = home.command();
    if is_root(home) {
        let environment: Vec<_> = command
            .get_envs()
            .map(|(name, value)| (name.to_owned(), value.map(ToOwned::to_owned)))
            .collect();
        command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]);
        command.arg(program).current_dir(home.files());
        for (name, value) in environment {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
    }
    command.args(arguments).stdin(Stdio::null());
    Ended::of(&command.output().unwrap())
}

/// Whether permissions mean nothing to this user.
fn is_root(home: &Home) -> bool {
    let file = home.write("locked", "x");
    set(&file, 0o444);
    let root = std::fs::File::options().write(true).open(&file).is_ok();
    std::fs::remove_file(file).unwrap();
    root
}

#[test]
fn a_store_that_cannot_be_written_is_read() {
    let home = Home::new();
    home.run(&["ask", CUT_IN]).status(0);
    let store = home.data().join("runs.sqlite");
    let program = home.data().with_file_name("program");
    std::fs::copy(env!("CARGO_BIN_EXE_nearmiss"), &program).unwrap();
    for folder in [program.parent().unwrap(), &home.config(), &home.files()] {
        set(folder, 0o755);
    }
    let commands: [&[&str]; 9] = [
        &["runs", "list"],
        &["runs", "list", "--format=json"],
        &["runs", "show", "1"],
        &["runs", "export"],
        &["runs", "export", "--format", "csv"],
        &["runs", "ratings"],
        &["report"],
        &["evaluate", "list"],
        &["runs", "list", "planted"],
    ];
    // What is in the log only is there as well.
    for with_log in [false, true] {
        if with_log {
            let elsewhere = home.data().with_file_name("elsewhere");
            std::fs::create_dir(&elsewhere).unwrap();
            let moved = elsewhere.join("runs.sqlite");
            std::fs::copy(&store, &moved).unwrap();
            let connection = rusqlite::Connection::open(&moved).unwrap();
            connection
                .execute_batch("UPDATE runs SET notes = 'planted'")
                .unwrap();
            for ending in ["", "-wal"] {
                let name = format!("runs.sqlite{ending}");
                std::fs::copy(elsewhere.join(&name), home.data().join(name)).unwrap();
            }
        }
        let files = names(&home.data());
        assert_eq!(files.len(), 1 + usize::from(with_log), "{files:?}");
        files
            .iter()
            .for_each(|name| set(&home.data().join(name), 0o444));
        set(&home.data(), 0o555);
        let said = commands.map(|arguments| reading(&home, &program, arguments));
        let doctor = reading(&home, &program, &["doctor"]);
        assert!(doctor.stdout.contains("not writable"), "{doctor:?}");
        assert_eq!(names(&home.data()), files, "nothing is made");
        let refused = reading(&home, &program, &["runs", "pin", "1"]);
        refused.status(2).says(&["runs.sqlite"]);
        assert_eq!(said[8].stdout.contains(CUT_IN), with_log, "{:?}", said[8]);
        // What can be written says the same.
        set(&home.data(), 0o755);
        files
            .iter()
            .for_each(|name| set(&home.data().join(name), 0o644));
        for (arguments, said) in commands.iter().zip(said) {
            let written = home.run(arguments);
            assert_eq!(
                said.stdout, written.stdout,
                "{arguments:?}: {}",
                said.stderr
            );
            assert_eq!(
                said.status, written.status,
                "{arguments:?}: {}",
                said.stderr
            );
        }
    }
}

#[test]
fn reading_makes_no_store() {
    let home = Home::new();
    for arguments in [
        &["runs", "list"][..],
        &["runs", "export"],
        &["runs", "ratings"],
        &["report"],
    ] {
        home.run(arguments);
        assert_eq!(names(&home.data()), [""; 0], "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn nothing_stays_of_files_that_a_killed_program_was_writing() {
    let home = Home::new();
    let all: Vec<&str> = super::BUNDLED.iter().map(|(name, _)| *name).collect();
    for arguments in [
        &["plan", "--log", "log.jsonl"][..],
        &["metrics", "-o", "table.csv"],
    ] {
        let mut child = home.start(&[arguments, &all[..]].concat());
        // A file without a name is open as one that is gone.
        let open = || {
            let descriptors = std::fs::read_dir(format!("/proc/{}/fd", child.id())).unwrap();
            let mut targets = descriptors.filter_map(|d| std::fs::read_link(d.ok()?.path()).ok());
            targets.any(|target| target.starts_with(home.files()))
        };
        let begun = Instant::now();
        while !open() {
            assert!(begun.elapsed() < LONG, "{arguments:?}: it opens no file");
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        let status = child.wait().unwrap();
        assert_eq!(status.signal(), Some(9), "{arguments:?}: it was too fast");
        assert_eq!(names(&home.files()), [""; 0], "{arguments:?}");
    }
}

/// Ends within a minute, whatever lies in its way.
fn ends(home: &Home, arguments: &[&str]) -> Ended {
    let mut child = home.start(arguments);
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > LONG {
            child.kill().unwrap();
            panic!("{arguments:?} waits");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Ended::of(&child.wait_with_output().unwrap())
}

#[test]
fn no_pipe_device_or_loop_in_the_place_of_a_file_is_waited_for() {
    // Where each file of the user's lies, and the commands that read it.
    let places: [(&str, &[&[&str]]); 9] = [
        (
            "data/runs.sqlite",
            &[&["doctor"], &["runs", "list"], &["ask", CUT_IN]],
        ),
        ("data/tags.toml", &[&["doctor"]]),
        ("config/config.toml", &[&["doctor"], &["config", "print"]]),
        ("config/keymap.toml", &[&["doctor"], &["config", "keys"]]),
        (
            "config/thresholds.toml",
            &[&["doctor"], &["metrics", CUT_IN]],
        ),
        (
            "config/themes/mine.toml",
            &[&["doctor"], &["config", "themes"]],
        ),
        (
            "config/prompts/mine.md",
            &[&["doctor"], &["prompt", "list"]],
        ),
        (
            "config/prompts/chosen.toml",
            &[&["doctor"], &["prompt", "list"]],
        ),
        ("config/.env", &[&["doctor"], &["models"]]),
    ];
    type Put = fn(&Path);
    let put: [(&str, Put); 5] = [
        ("pipe", pipe),
        ("device", |path| symlink("/dev/zero", path).unwrap()),
        ("folder", |path| std::fs::create_dir(path).unwrap()),
        ("dangling link", |path| {
            symlink("/nowhere/at/all", path).unwrap()
        }),
        ("loop", |path| {
            symlink(path.file_name().unwrap(), path).unwrap()
        }),
    ];
    for (place, commands) in places {
        for (what, put) in put {
            let home = Home::new();
            let path = home.data().with_file_name(place);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            put(&path);
            for arguments in commands {
                let ended = ends(&home, arguments);
                let said = ended.stdout.clone() + &ended.stderr;
                // A store may be made where a link leads, and folders of this name hold no templates.
                let silent = ["dangling link", "folder"].contains(&what);
                let name = path.file_name().unwrap().to_str().unwrap();
                assert!(
                    silent || said.contains(name),
                    "{what} {place} {arguments:?}: {said}"
                );
            }
        }
    }
}

#[test]
fn no_pipe_or_device_that_is_named_is_waited_for() {
    let home = Home::new();
    pipe(&home.files().join("pipe"));
    symlink("/dev/zero", home.files().join("zero")).unwrap();
    symlink("loop", home.files().join("loop")).unwrap();
    for file in ["pipe", "zero", "loop", "nowhere"] {
        for arguments in [
            &["inspect", file][..],
            &["metrics", file],
            &["prompt", "describe", file],
            &["ask", file],
            &["plan", file],
            &["generate", file],
            &["render", file],
            &["convert", file],
            &["runs", "import", file],
            &["prompt", "describe", CUT_IN, "--ego", file],
            &["metrics", CUT_IN, "--thresholds", file],
            &["evaluate", CUT_IN, "--truth", file],
        ] {
            ends(&home, arguments).status(2).says(&[file]);
        }
    }
}
