//! Undo and redo in steps of words: a run of typing ends after a word, with a line, a cursor move or a pause.

use std::time::Duration;

use edtui::Index2;

type Before = (String, Index2);

/// What changed a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// A typed character.
    Typed(char),
    /// A character that was taken away beside the cursor.
    Erased,
    /// Anything else, such as pasting or cutting: always a step of its own.
    Whole,
}

/// Changes that are undone together.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// The last change of it.
    last: Change,
    /// Where the cursor was then; what follows there may belong to it.
    cursor: Index2,
    /// When that was.
    time: Duration,
}

/// Texts before and after.
#[derive(Debug, Default)]
pub struct History {
    back: Vec<Before>,
    forward: Vec<Before>,
    /// The run that may go on.
    run: Option<Run>,
}

/// Bytes of texts that are kept.
const MOST: usize = 16 << 20;

/// A pause of this length ends a run.
const PAUSE: Duration = Duration::from_secs(1);

impl Run {
    /// Whether a change with the cursor at a place belongs to it.
    fn takes(&self, change: Change, cursor: Index2, now: Duration) -> bool {
        if self.cursor != cursor || now.saturating_sub(self.time) >= PAUSE {
            return false;
        }
        match (self.last, change) {
            // The space after a word belongs to the word; the next word is the next step.
            (Change::Typed(last), Change::Typed(next)) => {
                next != '\n' && last != '\n' && (!last.is_whitespace() || next.is_whitespace())
            }
            (Change::Erased, Change::Erased) => true,
            _ => false,
        }
    }
}

impl History {
    /// Remembers the text before a change: `old` with the cursor at `before`, which is at `after` now.
    pub fn record(
        &mut self,
        old: String,
        (before, after): (Index2, Index2),
        change: Change,
        now: Duration,
    ) {
        self.forward.clear();
        let goes_on = self
            .run
            .take()
            .is_some_and(|run| run.takes(change, before, now));
        if change != Change::Whole {
            self.run = Some(Run {
                last: change,
                cursor: after,
                time: now,
            });
        }
        if goes_on && !self.back.is_empty() {
            return;
        }
        self.back.push((old, before));
        let mut bytes: usize = self.back.iter().map(|(text, _)| text.len()).sum();
        let mut dropped = 0;
        while bytes > MOST && dropped + 1 < self.back.len() {
            bytes -= self.back[dropped].0.len();
            dropped += 1;
        }
        self.back.drain(..dropped);
    }

    /// The cursor moved elsewhere: further typing starts a new step.
    pub fn rest(&mut self) {
        self.run = None;
    }

    /// A step back or forward from `now`.
    pub fn step(&mut self, back: bool, now: Before) -> Option<Before> {
        self.run = None;
        let (from, to) = if back {
            (&mut self.back, &mut self.forward)
        } else {
            (&mut self.forward, &mut self.back)
        };
        let before = from.pop()?;
        to.push(now);
        Some(before)
    }
}
