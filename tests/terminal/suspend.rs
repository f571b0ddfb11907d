//! Stopped and continued, at once and many times, by the shell and past it: the program goes on and its screen is
//! whole.
#![cfg(target_os = "linux")]

use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{PATIENCE, Session};

/// Stops and continuations; `NEARMISS_STOPS` raises their number.
fn times() -> u32 {
    let said = std::env::var("NEARMISS_STOPS").ok();
    said.map_or(60, |n| n.parse().unwrap())
}

impl Session {
    /// Sends signals one after another from one process, `apart` turns of a loop between them.
    fn signals(&self, names: &[&str], apart: u32) {
        let id = self.child.process_id().unwrap();
        let pause = format!("i=0; while [ $i -lt {apart} ]; do i=$((i+1)); done; ");
        let all: Vec<String> = names.iter().map(|n| format!("kill -{n} {id}; ")).collect();
        let sent = Command::new("sh").args(["-c", &all.join(&pause)]).status();
        assert!(sent.unwrap().success());
    }

    fn is_stopped(&self) -> bool {
        let id = self.child.process_id().unwrap();
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
        stat.contains(") T ")
    }

    fn until(&mut self, what: &str, mut holds: impl FnMut(&mut Self) -> bool) {
        let begun = Instant::now();
        while !holds(self) {
            assert!(
                begun.elapsed() < PATIENCE,
                "{what}:\n{}",
                self.screen.screen().contents()
            );
            self.receive(Duration::from_millis(10));
        }
    }

    /// Whether the terminal is as the workbench has it, and shows this.
    fn is_whole(&self, contents: &str) -> bool {
        let screen = self.screen.screen();
        screen.alternate_screen()
            && screen.bracketed_paste()
            && screen.contents() == contents
            && self.is_raw()
    }

    fn is_raw(&self) -> bool {
        let name = self.master.tty_name().unwrap();
        let said = Command::new("stty").arg("-a").arg("-F").arg(name).output();
        let said = String::from_utf8(said.unwrap().stdout).unwrap();
        let off = |flag: &str| said.split([' ', ';', '\n']).any(|word| word == flag);
        off("-icanon") && off("-echo") && off("-isig")
    }

    /// Opens the help and closes it: the keys are its own, and all of the screen is there again.
    fn answers_keys(&mut self, whole: &str) {
        let begun = Instant::now();
        let has_help = |s: &Self| s.screen.screen().contents().contains("signs in the list");
        while !has_help(self) {
            assert!(
                begun.elapsed() < PATIENCE,
                "the help does not come:\n{}",
                self.screen.screen().contents()
            );
            // Keys that come while the terminal is the shell's are the shell's; a second one would be searched for.
            self.press("?");
            let pressed = Instant::now();
            while !has_help(self) && pressed.elapsed() < Duration::from_secs(5) {
                self.receive(Duration::from_millis(20));
            }
        }
        self.press("\x1b");
        self.until("the help stays", |s| s.is_whole(whole));
    }
}

/// Keeps all processors busy until it is dropped.
struct Load(std::sync::Arc<AtomicBool>);

impl Load {
    fn begin() -> Self {
        let ends = std::sync::Arc::new(AtomicBool::new(false));
        for _ in 0..2 * std::thread::available_parallelism().map_or(2, usize::from) {
            let ends = ends.clone();
            std::thread::spawn(move || while !ends.load(Ordering::Relaxed) {});
        }
        Self(ends)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn who_is_continued_at_once_goes_on_with_a_whole_screen() {
    let mut session = Session::start(100, 30, &[]);
    session.see("collision yes");
    let whole = session.settled();
    for loaded in [false, true] {
        let _load = loaded.then(Load::begin);
        for i in 0..times() {
            // At once, and at every moment of the way to the stop.
            session.signals(&["TSTP", "CONT"], (i % 20) * 50 * u32::from(i % 3 != 0));
            session.until("it stopped for good", |s| {
                !s.is_stopped() && s.is_whole(&whole)
            });
        }
    }
    session.signals(&["TSTP", "CONT", "TSTP", "CONT"], 0);
    session.until("it stopped for good", |s| {
        !s.is_stopped() && s.is_whole(&whole)
    });
    session.answers_keys(&whole);
    session.signals(&["TSTP"], 0);
    session.until("it does not stop", |s| {
        s.is_stopped() && !s.screen.screen().alternate_screen()
    });
    session.signals(&["CONT"], 0);
    session.until("its screen is not whole", |s| s.is_whole(&whole));
    session.answers_keys(&whole);
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}

#[test]
fn a_stop_that_cannot_be_heard_is_made_good_when_it_is_continued() {
    let mut session = Session::start(100, 30, &[]);
    session.see("collision yes");
    let whole = session.settled();
    for _ in 0..10 {
        session.signals(&["STOP"], 0);
        session.until("it does not stop", |s| s.is_stopped());
        // What a shell does then: its own modes, and its own words on the screen.
        let terminal = session.master.tty_name().unwrap();
        let sane = Command::new("stty")
            .arg("sane")
            .arg("-F")
            .arg(&terminal)
            .status();
        assert!(sane.unwrap().success());
        std::fs::write(&terminal, "\r\n[1]+  Stopped   nearmiss\r\n$ fg\r\n").unwrap();
        session.until("the shell says nothing", |s| {
            s.screen.screen().contents().contains("$ fg")
        });
        session.signals(&["CONT"], 0);
        session.until("its screen is not whole", |s| s.is_whole(&whole));
    }
    session.answers_keys(&whole);
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}

#[test]
fn a_stop_while_an_editor_has_the_terminal_is_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let (begun, go_on) = (folder.path().join("begun"), folder.path().join("go on"));
    let editor = format!(
        "sh -c 'touch \"{}\"; until [ -e \"{}\" ]; do sleep 0.05; done'",
        begun.display(),
        go_on.display()
    );
    let mut session = Session::start(120, 40, &[("VISUAL", &editor)]);
    session.see("collision yes");
    let whole = session.settled();
    session.press("\x05");
    session.until("no editor", |_| begun.exists());
    for loaded in [false, true] {
        let _load = loaded.then(Load::begin);
        for i in 0..times() {
            session.signals(&["TSTP", "CONT"], (i % 20) * 50);
            session.until("it stopped for good", |s| !s.is_stopped());
        }
    }
    session.signals(&["TSTP"], 0);
    session.until("it does not stop", |s| s.is_stopped());
    assert!(
        !session.screen.screen().alternate_screen(),
        "the editor has the terminal"
    );
    session.signals(&["CONT"], 0);
    session.until("it does not go on", |s| !s.is_stopped());
    assert!(
        !session.screen.screen().alternate_screen(),
        "the editor has the terminal"
    );
    std::fs::write(&go_on, "").unwrap();
    session.see("collision yes");
    session.until("not whole", |s| s.is_whole(&whole));
    session.answers_keys(&whole);
    session.press("q");
    assert_eq!(session.end(), 0);
    session.is_restored();
}
