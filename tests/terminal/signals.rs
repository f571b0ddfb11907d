//! What terminals, shells and people do to a program: signals, storms of sizes, large pastes, few colours, hanging up.

use std::io::Write;
use std::time::{Duration, Instant};

use super::{PATIENCE, Session};

fn signal(session: &Session, name: &str) {
    let id = session.child.process_id().unwrap().to_string();
    let sent = std::process::Command::new("kill")
        .args([&format!("-{name}"), id.as_str()])
        .status();
    assert!(sent.unwrap().success());
}

#[test]
fn every_signal_that_ends_it_gives_the_terminal_back() {
    for name in ["INT", "TERM", "QUIT", "HUP"] {
        let mut session = Session::start(100, 30, &[]);
        session.see("scenarios 8");
        signal(&session, name);
        assert_eq!(session.end(), 0, "{name}");
        session.is_restored();
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_stop_from_outside_gives_the_terminal_back_and_continuing_takes_it_again() {
    let mut session = Session::start(100, 30, &[]);
    session.see("scenarios 8");
    let id = session.child.process_id().unwrap();
    for _ in 0..2 {
        signal(&session, "TSTP");
        let begun = Instant::now();
        let stopped = || {
            std::fs::read_to_string(format!("/proc/{id}/stat"))
                .unwrap()
                .contains(") T ")
        };
        while !stopped() || session.screen.screen().alternate_screen() {
            assert!(
                begun.elapsed() < PATIENCE,
                "it does not stop, or keeps the screen"
            );
            session.receive(Duration::from_millis(20));
        }
        session.is_restored();
        signal(&session, "CONT");
        while !session.screen.screen().alternate_screen() {
            assert!(begun.elapsed() < PATIENCE, "it does not come back");
            session.receive(Duration::from_millis(20));
        }
        session.see("scenarios 8");
    }
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}

#[test]
fn a_storm_of_sizes_ends_in_the_right_frame() {
    let mut session = Session::start(120, 40, &[]);
    session.see("The body of car 301 overlaps");
    for i in 0..200u16 {
        session.resize(20 + (i * 37) % 230, 5 + (i * 13) % 70);
        session.receive(Duration::from_millis(1));
    }
    session.resize(59, 20);
    session.see("this is 59×20, nearmiss needs 60×18");
    session.resize(120, 40);
    session.see("The body of car 301 overlaps");
    // What is seen may be half a frame.
    let before = session.settled();
    // A frame that is drawn from nothing is the same.
    session.press("\x1a");
    let begun = Instant::now();
    while session.screen.screen().alternate_screen() {
        assert!(begun.elapsed() < PATIENCE);
        session.receive(Duration::from_millis(20));
    }
    signal(&session, "CONT");
    session.see("The body of car 301 overlaps");
    assert_eq!(session.settled(), before);
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}

/// A paste as terminals send it.
fn paste(session: &mut Session, text: &str) {
    session.press("\x1b[200~");
    // The program reads while it is written.
    for piece in text.as_bytes().chunks(4096) {
        session.keys.write_all(piece).unwrap();
        session.receive(Duration::ZERO);
    }
    session.press("\x1b[201~");
}

#[test]
fn a_megabyte_is_pasted_into_the_editor_and_into_the_filter() {
    let mut session = Session::start(120, 40, &[]);
    session.see("The body of car 301 overlaps");
    session.press("e");
    session.see("template · collision-ego.md");
    let line = "a line of text that is as long as a line may be\n";
    paste(&mut session, &line.repeat(1_000_000 / line.len()));
    session.see("a line of text that is as long as a line may be");
    // What is too much is refused, and said.
    paste(&mut session, &line.repeat(1_000_000 / line.len()));
    session.see("1 MiB");
    session.press("\x03");
    session.see("draft");
    session.press("/");
    paste(&mut session, &"merge ".repeat(170_000));
    // No more than a line is looked for.
    session.see("scenarios 1/8");
    session.press("\x1b");
    session.see("scenarios 8");
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}

#[test]
fn terminals_of_few_colours_get_no_others() {
    for (term, variables) in [
        ("linux", &[][..]),
        ("xterm", &[]),
        ("vt100", &[]),
        ("xterm-256color", &[("NO_COLOR", "1")]),
    ] {
        let mut all = vec![("TERM", term), ("COLORTERM", "")];
        all.extend(variables);
        let mut session = Session::start(100, 30, &all);
        session.see("scenarios 8");
        session.press("?");
        session.see("Select the scenario above");
        session.press("\x1b");
        // Esc and a letter at once are another key.
        for _ in 0..10 {
            session.receive(Duration::from_millis(30));
        }
        session.press("q");
        assert_eq!(session.end(), 0, "{term}");
        session.is_restored();
        let raw = String::from_utf8_lossy(&session.raw).into_owned();
        let true_colour = raw.contains("\x1b[38;2") || raw.contains("\x1b[48;2");
        assert!(!true_colour, "{term}: colours that it has not");
        // Crossterm writes the sixteen colours as 38;5;0 to 38;5;15.
        let indices = raw.split("\x1b[").filter_map(|piece| {
            let codes = piece.split('m').next()?;
            let (_, index) = codes.split_once("8;5;")?;
            index.split(';').next()?.parse::<u16>().ok()
        });
        let most = indices.max();
        let none = term == "vt100" || !variables.is_empty();
        assert!(
            most.is_none_or(|index| index < 16 && !none),
            "{term}: {most:?}"
        );
        assert!(raw.contains("\x1b[7m"), "{term}: the selection is reversed");
    }
}

/// Starts the program in a terminal that is closed as soon as it shows something; waits for the end.
fn hang_up(data: &std::path::Path, keys: &str, environment: &[(&str, &str)]) -> u32 {
    let size = portable_pty::PtySize {
        rows: 30,
        cols: 100,
        pixel_width: 0,
        pixel_height: 0,
    };
    let pair = portable_pty::native_pty_system().openpty(size).unwrap();
    let mut command = portable_pty::CommandBuilder::new(env!("CARGO_BIN_EXE_nearmiss"));
    command.env("NEARMISS_CONFIG", data.join("config"));
    command.env("NEARMISS_DATA", data);
    command.env("TERM", "xterm-256color");
    for (name, value) in environment {
        command.env(name, value);
    }
    let mut child = pair.slave.spawn_command(command).unwrap();
    drop(pair.slave);
    let mut reader = pair.master.try_clone_reader().unwrap();
    let (mut seen, mut buffer) = (Vec::new(), [0; 4096]);
    while !String::from_utf8_lossy(&seen).contains("scenarios") {
        let count = std::io::Read::read(&mut reader, &mut buffer).unwrap();
        seen.extend_from_slice(&buffer[..count]);
    }
    let mut writer = pair.master.take_writer().unwrap();
    std::io::Write::write_all(&mut writer, keys.as_bytes()).unwrap();
    std::thread::sleep(Duration::from_millis(300 * keys.len() as u64));
    // The other side of the terminal is closed from here on.
    drop((writer, reader, pair.master));
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.exit_code();
        }
        assert!(begun.elapsed() < PATIENCE, "it goes on without a terminal");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn hanging_up_ends_it_and_what_was_done_is_kept() {
    for keys in ["", "", "", "", "", "", "x", " ", "e"] {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(hang_up(folder.path(), keys, &[]), 0, "{keys:?}");
        let sessions = std::fs::read_dir(folder.path().join("sessions"));
        let kept = sessions.map_or(0, Iterator::count);
        assert_eq!(kept, usize::from(!keys.is_empty()).max(kept), "{keys:?}");
    }
    // While an editor has the terminal that ends with it.
    let folder = tempfile::tempdir().unwrap();
    let status = hang_up(folder.path(), "\x05", &[("VISUAL", "sh -c 'read line'")]);
    assert_eq!(status, 0);
}
