//! The program in a real pseudo-terminal: open, step, ask, see the verdict, resize, quit, and a panic.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod batch;
mod escape_sequences;
mod experiment;
mod idle;
mod signals;
#[path = "../support/mod.rs"]
mod support;
mod suspend;

use std::time::{Duration, Instant};

use support::session::{PATIENCE, Session};

#[test]
fn a_session_from_the_first_frame_to_the_shell() {
    let mut session = Session::start(120, 40, &[]);
    session.see("ZAM_HardBraking-1_1_T-1");
    session.see("The body of car 301 overlaps");
    assert!(session.screen.screen().alternate_screen());
    session.press("\x1b[H\x1b[C\x1b[C\x1b[C");
    session.see("step 3/60");
    session.press("x");
    session.see("X 301: contact");
    session.press("r");
    session.see("saved as run 1");
    session.press(" at");
    session.see("verdict · safety");
    session.press("/merge\r");
    session.see("ZAM_Merge-1_1_T-1 · 8 obstacles");
    session.resize(80, 24);
    session.see("1/8");
    session.resize(59, 20);
    session.see("Terminal too small");
    session.resize(160, 45);
    session.see("reasoning · built-in");
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}

#[test]
fn a_panic_gives_the_terminal_back_and_says_why() {
    let mut session = Session::start(100, 30, &[("NEARMISS_TEST_PANIC", "1")]);
    session.see("scenarios 8");
    // F12
    session.press("\x1b[24~");
    assert_eq!(session.end(), 101);
    session.is_restored();
    session.see("the report is in");
    let data = session.folders.path().join("data");
    let reports = std::fs::read_dir(data.join("crashes")).unwrap();
    let reports: Vec<_> = reports.flatten().map(|entry| entry.path()).collect();
    let report = std::fs::read_to_string(&reports[0]).unwrap();
    assert!(report.contains("a test asked for this panic"), "{report}");
    assert!(report.contains("ZAM_HardBraking"), "{report}");

    // What was open is not opened by itself at the next start, and all the same by hand.
    let environment = [("NEARMISS_DATA", data.to_str().unwrap())];
    let mut again = Session::start(160, 45, &environment);
    again.see("opens it anyway");
    again.press("\r");
    again.see("The body of car 301 overlaps");
    again.press("q");
    assert_eq!(again.end(), 0);
    let marks = std::fs::read_dir(data.join("marks")).unwrap();
    assert_eq!(marks.count(), 0, "nothing is held any longer");
}

#[test]
fn a_signal_ends_it_in_good_order() {
    let mut session = Session::start(100, 30, &[]);
    session.see("scenarios 8");
    let id = session.child.process_id().unwrap();
    let killed = std::process::Command::new("kill")
        .arg(id.to_string())
        .status()
        .unwrap();
    assert!(killed.success());
    assert_eq!(session.end(), 0);
    session.is_restored();
}

#[test]
fn without_colour_the_selection_is_still_seen() {
    let mut session = Session::start(100, 30, &[("NO_COLOR", "1")]);
    session.see("scenarios 8");
    session.press("q");
    session.end();
    let raw = String::from_utf8_lossy(&session.raw).into_owned();
    assert!(
        !raw.contains("\x1b[38;") && !raw.contains("\x1b[48;"),
        "no colours"
    );
    assert!(raw.contains("\x1b[7m"), "the selection is reversed");
}

#[test]
fn frames_are_synchronized_updates() {
    let mut session = Session::start(100, 30, &[("COLORTERM", "truecolor")]);
    session.see("scenarios 8");
    session.press("q");
    session.end();
    let raw = String::from_utf8_lossy(&session.raw).into_owned();
    let count = |sequence: &str| raw.matches(sequence).count();
    assert!(count("\x1b[?2026h") > 0 && count("\x1b[?2026h") <= count("\x1b[?2026l"));
    assert!(
        raw.contains("\x1b[38;2;"),
        "true colours where the terminal has them"
    );
}

#[test]
fn a_path_that_is_not_there_is_said_on_the_shell() {
    let mut session = Session::start_with(100, 30, &[], &["no/such/folder"]);
    assert_eq!(session.end(), 2);
    session.see("nearmiss: no/such/folder");
    assert!(
        !String::from_utf8_lossy(&session.raw).contains("?1049h"),
        "the workbench does not open"
    );
}

#[test]
fn a_chosen_ego_is_that_of_the_opened_scenario() {
    let name = "ZAM_CutIn-1_1_T-1";
    let bundled = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.csv");
    std::fs::copy(bundled.join(format!("{name}.ego_trajectory.csv")), &file).unwrap();
    let arguments = [name, "--ego", file.to_str().unwrap()];
    let mut session = Session::start_with(160, 45, &[], &arguments);
    session.see("ego recorded in mine.csv");
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
    let mut session = Session::start_with(100, 30, &[], &["--ego", "301"]);
    assert_eq!(session.end(), 2);
    session.see("needs one scenario");
}

#[test]
#[cfg(target_os = "linux")]
fn ctrl_z_gives_the_terminal_back_until_it_is_continued() {
    let mut session = Session::start(100, 30, &[]);
    session.see("scenarios 8");
    let id = session.child.process_id().unwrap();
    session.press("\x1a");
    let end = Instant::now() + PATIENCE;
    let stopped = || {
        std::fs::read_to_string(format!("/proc/{id}/stat"))
            .unwrap()
            .contains(") T ")
    };
    while !stopped() {
        assert!(Instant::now() < end, "it does not stop");
        session.receive(Duration::from_millis(20));
    }
    while session.screen.screen().alternate_screen() {
        assert!(Instant::now() < end, "the main screen does not come back");
        session.receive(Duration::from_millis(20));
    }
    session.is_restored();
    let continued = std::process::Command::new("kill")
        .args(["-CONT", &id.to_string()])
        .status();
    assert!(continued.unwrap().success());
    // Keys pressed before the terminal is taken again belong to the shell.
    while !session.screen.screen().contents().contains("step 59/60") {
        assert!(Instant::now() < end, "it does not come back");
        session.press("x");
        session.receive(Duration::from_millis(200));
    }
    assert!(session.screen.screen().alternate_screen());
    session.press("q");
    assert_eq!(session.end(), 0);
}

#[test]
fn the_users_editor_has_the_terminal_and_gives_the_template_back() {
    // It looks at its terminal before it writes: cooked, and on the main screen.
    let script = "sh -c 'stty -a | grep -q \" icanon\" && sed -i s/expert/poet/ \"$0\"'";
    let mut session = Session::start(120, 40, &[("EDITOR", "false"), ("VISUAL", script)]);
    session.see("The body of car 301 overlaps");
    session.press("\x05");
    session.see("changes are a draft now");
    assert!(session.screen.screen().alternate_screen());
    assert!(
        session.screen.screen().bracketed_paste(),
        "all modes are back"
    );
    let mouse = session.screen.screen().mouse_protocol_mode();
    assert!(!matches!(mouse, vt100::MouseProtocolMode::None));
    let raw = String::from_utf8_lossy(&session.raw).into_owned();
    assert_eq!(raw.matches("\x1b[?1049h").count(), 2);
    session.see("You are an poet in the");
    // Keys reach the workbench again.
    session.press("x");
    session.see("X 301: contact");
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}

#[test]
fn an_editor_that_is_missing_or_fails_is_named_and_nothing_is_lost() {
    for (editor, said) in [
        ("no-such-editor -w", "`no-such-editor -w` cannot be started"),
        ("sh -c 'exit 3'", "ended with status 3"),
        ("", "neither VISUAL nor EDITOR is set"),
    ] {
        let mut session = Session::start(120, 40, &[("EDITOR", ""), ("VISUAL", editor)]);
        session.see("The body of car 301 overlaps");
        session.press("\x05");
        session.see(said);
        session.press("e");
        session.see("template · collision-ego.md ");
        session.press("\x03");
        session.press("q");
        assert_eq!(session.end(), 0, "{editor}");
        session.is_restored();
    }
}

#[test]
fn a_draft_survives_a_kill() {
    let folders = tempfile::tempdir().unwrap();
    let path = |name: &str| folders.path().join(name).to_str().unwrap().to_string();
    let (config, data) = (path("config"), path("data"));
    let environment = [
        ("NEARMISS_CONFIG", config.as_str()),
        ("NEARMISS_DATA", data.as_str()),
    ];
    let mut session = Session::start(120, 40, &environment);
    session.see("The body of car 301 overlaps");
    session.press("e");
    session.see("template · collision-ego.md");
    session.press("Written before the end. ");
    session.see("before the end. You are");
    let draft = folders.path().join("data/drafts/collision-ego.md");
    let begun = Instant::now();
    let kept = || std::fs::read_to_string(&draft).is_ok_and(|t| t.contains("before the end. You"));
    while !kept() {
        assert!(begun.elapsed() < PATIENCE, "the draft is not kept");
        session.receive(Duration::from_millis(20));
    }
    let id = session.child.process_id().unwrap().to_string();
    let killed = std::process::Command::new("kill")
        .args(["-KILL", &id])
        .status();
    assert!(killed.unwrap().success());
    session.end();
    let mut session = Session::start(120, 40, &environment);
    session.see("unsaved drafts restored: collision-ego.md");
    session.see("The body of car 301 overlaps");
    session.press("e");
    session.see("before the end. You are");
    session.press("\x03");
    session.press("q");
    assert_eq!(session.end(), 0);
}
