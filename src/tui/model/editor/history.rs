//! Undo and redo: typed words are grouped, every other change is its own step.

use edtui::Index2;

type Before = (String, Index2);

/// Texts before and after.
#[derive(Debug, Default)]
pub struct History {
    back: Vec<Before>,
    forward: Vec<Before>,
    /// Where the cursor was after the last typed character; the next one there belongs to it.
    typing: Option<Index2>,
}

/// Bytes of texts that are kept.
const MOST: usize = 16 << 20;

impl History {
    /// Remembers the text before a change: `old` with the cursor `before` it, which is `after` now.
    pub fn record(&mut self, old: String, before: Index2, after: Index2, typed: bool) {
        self.forward.clear();
        let goes_on = typed && self.typing == Some(before);
        self.typing = typed.then_some(after);
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

    /// The cursor moved elsewhere: further typing starts a new undo step.
    pub fn rest(&mut self) {
        self.typing = None;
    }

    /// A change back or forward from `now`.
    pub fn step(&mut self, back: bool, now: Before) -> Option<Before> {
        self.typing = None;
        let (from, to) = match back {
            true => (&mut self.back, &mut self.forward),
            false => (&mut self.forward, &mut self.back),
        };
        let before = from.pop()?;
        to.push(now);
        Some(before)
    }
}
