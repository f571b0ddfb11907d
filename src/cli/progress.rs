//! Progress of long jobs: a bar on standard error in a terminal, nothing in a pipe.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar, or nothing.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar over `count` things, called `what`; `to_file` says that standard output stays empty.
    ///
    /// It is not shown where standard error is no terminal, nor where data runs over the same terminal.
    pub fn new(count: usize, what: &str, to_file: bool) -> Self {
        let shown = count > 1 && (to_file || !std::io::stdout().is_terminal());
        let bar = if shown {
            ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::stderr())
        } else {
            ProgressBar::hidden()
        };
        let template = format!("{{wide_bar}} {{pos}}/{{len}} {what}, {{eta}} left");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        Self { bar }
    }

    /// The same with its own words, see [`Progress::say`].
    pub fn with_words(count: usize, what: &str) -> Self {
        let progress = Self::new(count, what, true);
        let template = format!("{{wide_bar}} {{pos}}/{{len}} {what}, {{msg}}, {{eta}} left");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            progress.bar.set_style(style);
        }
        progress
    }

    /// How it goes.
    pub fn say(&self, words: String) {
        self.bar.set_message(words);
    }

    /// One more is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// Prints a message without disturbing the bar.
    pub fn suspend(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }
}

/// A bar over things that are counted when the first of them is done, on any thread.
pub struct LateProgress {
    what: &'static str,
    bar: Mutex<Option<Progress>>,
}

impl LateProgress {
    /// A bar over things that are called `what`.
    pub fn new(what: &'static str) -> Self {
        Self {
            what,
            bar: Mutex::default(),
        }
    }

    /// One more of so many is done.
    pub fn step(&self, of: usize) {
        let mut bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        bar.get_or_insert_with(|| Progress::new(of, self.what, true))
            .step();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
