//! The program in a real pseudo-terminal: its keys, its screen, its end.
#![cfg(unix)]

use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, native_pty_system};

/// Longer than any machine takes for one step.
pub const PATIENCE: Duration = Duration::from_secs(30);

fn cells(count: u16) -> std::num::NonZero<u16> {
    std::num::NonZero::new(count).unwrap()
}

/// A workbench that runs in a terminal of its own.
pub struct Session {
    pub child: Box<dyn Child + Send + Sync>,
    pub master: Box<dyn MasterPty + Send>,
    pub keys: Box<dyn Write + Send>,
    pub output: Receiver<Vec<u8>>,
    pub screen: vt100::Parser,
    pub raw: Vec<u8>,
    pub folders: tempfile::TempDir,
}

impl Session {
    pub fn start(columns: u16, rows: u16, environment: &[(&str, &str)]) -> Self {
        Self::start_with(columns, rows, environment, &[])
    }

    pub fn start_with(
        columns: u16,
        rows: u16,
        environment: &[(&str, &str)],
        arguments: &[&str],
    ) -> Self {
        let size = PtySize {
            rows,
            cols: columns,
            pixel_width: 0,
            pixel_height: 0,
        };
        let pair = native_pty_system().openpty(size).unwrap();
        let folders = tempfile::tempdir().unwrap();
        let mut command = CommandBuilder::new(env!("CARGO_BIN_EXE_nearmiss"));
        command.args(arguments);
        command.env("NEARMISS_CONFIG", folders.path().join("config"));
        command.env("NEARMISS_DATA", folders.path().join("data"));
        command.env("TERM", "xterm-256color");
        command.env_remove("NO_COLOR");
        // A panic's message shall not be scrolled away by where it came from.
        command.env("RUST_BACKTRACE", "0");
        // The program works from any folder.
        command.cwd(folders.path());
        for (name, value) in environment {
            command.env(name, value);
        }
        let child = pair.slave.spawn_command(command).unwrap();
        drop(pair.slave);
        let mut reader = pair.master.try_clone_reader().unwrap();
        let (sender, output) = channel();
        std::thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(count) = reader.read(&mut buffer) {
                if count == 0 || sender.send(buffer[..count].to_vec()).is_err() {
                    break;
                }
            }
        });
        Self {
            child,
            keys: pair.master.take_writer().unwrap(),
            master: pair.master,
            output,
            screen: vt100::Parser::new(cells(rows), cells(columns), 0),
            raw: Vec::new(),
            folders,
        }
    }

    pub fn press(&mut self, keys: &str) {
        self.keys.write_all(keys.as_bytes()).unwrap();
        self.keys.flush().unwrap();
    }

    /// Takes a piece of what comes; says whether one came.
    pub fn receive(&mut self, wait: Duration) -> bool {
        let Ok(bytes) = self.output.recv_timeout(wait) else {
            return false;
        };
        self.screen.process(&bytes);
        self.raw.extend(bytes);
        true
    }

    pub fn see(&mut self, what: &str) {
        let end = Instant::now() + PATIENCE;
        while !self.screen.screen().contents().contains(what) {
            let left = end.saturating_duration_since(Instant::now());
            assert!(
                !left.is_zero(),
                "`{what}` is not on the screen:\n{}",
                self.screen.screen().contents()
            );
            self.receive(left.min(Duration::from_millis(200)));
        }
    }

    /// What is on the screen when the scenarios are read and nothing changes any more.
    pub fn settled(&mut self) -> String {
        let end = Instant::now() + PATIENCE;
        loop {
            let before = self.screen.screen().contents();
            for _ in 0..10 {
                self.receive(Duration::from_millis(30));
            }
            let now = self.screen.screen().contents();
            // `scenarios 8 · 7 read` while they are.
            if now == before && !now.contains(" read ━") {
                return now;
            }
            assert!(Instant::now() < end, "it does not come to rest:\n{now}");
        }
    }

    pub fn resize(&mut self, columns: u16, rows: u16) {
        let size = PtySize {
            rows,
            cols: columns,
            pixel_width: 0,
            pixel_height: 0,
        };
        self.screen
            .screen_mut()
            .set_size(cells(rows), cells(columns));
        self.master.resize(size).unwrap();
    }

    /// Waits for the end; gives the exit status.
    pub fn end(&mut self) -> u32 {
        let end = Instant::now() + PATIENCE;
        loop {
            self.receive(Duration::from_millis(50));
            if let Some(status) = self.child.try_wait().unwrap() {
                // All of what it wrote, however much lies before it.
                while self.receive(Duration::from_millis(400)) {}
                return status.exit_code();
            }
            assert!(
                Instant::now() < end,
                "it does not end:\n{}",
                self.screen.screen().contents()
            );
        }
    }

    pub fn is_restored(&self) {
        let screen = self.screen.screen();
        assert!(!screen.alternate_screen(), "the main screen is back");
        assert!(!screen.hide_cursor(), "the cursor is back");
        assert!(!screen.bracketed_paste(), "pasting is plain again");
        let mouse = screen.mouse_protocol_mode();
        assert!(
            matches!(mouse, vt100::MouseProtocolMode::None),
            "the mouse is given back"
        );
        // The terminal reads lines and echoes them, as the shell had it.
        let Some(name) = self.master.tty_name() else {
            return;
        };
        let said = std::process::Command::new("stty")
            .arg("-a")
            .arg("-F")
            .arg(name)
            .output();
        let said = String::from_utf8(said.unwrap().stdout).unwrap();
        let on = |flag: &str| said.split([' ', ';', '\n']).any(|word| word == flag);
        assert!(
            on("icanon") && on("echo") && on("isig"),
            "raw mode is left: {said}"
        );
    }
}
