//! A long job seen from outside: progress for a person, and what an interrupt leaves behind.
#![cfg(unix)]

use std::time::{Duration, Instant};

use super::metrics::names;
use super::support::program::{Ended, Home, contains};
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

#[test]
fn an_interrupt_leaves_no_half_file() {
    let home = Home::new();
    let (xml, ego) = (bundled_xml(CUT_IN), bundled_ego(CUT_IN));
    for i in 0..600 {
        home.write(format!("all/s{i:03}.xml"), &xml);
        home.write(format!("all/s{i:03}.ego_trajectory.csv"), &ego);
    }
    let before = names(&home.files());
    let child = home.start(&["metrics", "all", "-o", "t.csv"]);
    let begun = Instant::now();
    while !writes_into(&child, &home.files()) {
        assert!(
            begun.elapsed() < Duration::from_secs(20),
            "nothing was begun"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    interrupt(&child);
    let ended = Ended::of(&child.wait_with_output().unwrap())
        .status(130)
        .says(&["interrupted", "no file"]);
    assert_eq!(ended.stdout, "");
    assert_eq!(names(&home.files()), before);
}

/// Whether a program has a file of a folder open that it may write to. On Linux it has no name before it is whole.
fn writes_into(child: &std::process::Child, folder: &std::path::Path) -> bool {
    let open = std::fs::read_dir(format!("/proc/{}/fd", child.id()));
    let Ok(open) = open else {
        // Elsewhere it is a file beside the one to be.
        return names(folder).iter().any(|name| name.ends_with(".part"));
    };
    let mut files = open
        .flatten()
        .filter_map(|fd| std::fs::read_link(fd.path()).ok())
        .map(|file| file.to_string_lossy().into_owned());
    files.any(|file| file.starts_with(&*folder.to_string_lossy()) && file.ends_with("(deleted)"))
}

#[test]
fn an_interrupt_ends_a_table_that_nobody_reads_on() {
    let home = Home::new();
    let bundled: Vec<_> = BUNDLED.iter().map(|(name, _)| *name).collect();
    let mut child = home.start(&[&["metrics"], &bundled[..]].concat());
    // The first bytes are there; the pipe holds far less than the table.
    let mut first = [0; 8];
    let stdout = child.stdout.as_mut().unwrap();
    std::io::Read::read_exact(stdout, &mut first).unwrap();
    assert_eq!(&first, b"scenario");
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

pub fn interrupt(child: &std::process::Child) {
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status()
        .unwrap();
    assert!(sent.success());
}

#[test]
fn progress_is_shown_to_a_person_only() {
    use portable_pty::{CommandBuilder, PtySize, native_pty_system};
    use std::io::Read;
    let home = Home::new();
    let size = PtySize {
        rows: 24,
        cols: 80,
        pixel_width: 0,
        pixel_height: 0,
    };
    let terminal = native_pty_system().openpty(size).unwrap();
    let mut command = CommandBuilder::new(env!("CARGO_BIN_EXE_nearmiss"));
    command.cwd(home.files());
    command.env("TERM", "xterm-256color");
    command.env("NEARMISS_CONFIG", home.config());
    command.env("NEARMISS_DATA", home.data());
    command.args(["metrics", "-o", "t.csv"]);
    command.args(BUNDLED.iter().map(|(name, _)| *name));
    let mut child = terminal.slave.spawn_command(command).unwrap();
    drop(terminal.slave);
    let mut reader = terminal.master.try_clone_reader().unwrap();
    let reading = std::thread::spawn(move || {
        let mut shown = Vec::new();
        // The end of a pseudo-terminal is an error on some systems.
        let _ = reader.read_to_end(&mut shown);
        shown
    });
    assert!(child.wait().unwrap().success());
    drop(terminal.master);
    let shown = reading.join().unwrap();
    assert!(
        contains(&shown, b"/8 scenarios"),
        "{}",
        String::from_utf8_lossy(&shown)
    );
    let mut screen = vt100::Parser::default();
    screen.process(&shown);
    let left = screen.screen().contents();
    let left: Vec<&str> = left.trim().lines().collect();
    assert!(
        matches!(left[..], [provenance] if provenance.starts_with("nearmiss: Provenance: ")),
        "the bar is cleared at the end: {left:?}"
    );
}
