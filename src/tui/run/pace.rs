//! Frame pacing: draws at once if the last frame is long enough ago, and never without a change.

use std::time::{Duration, Instant};

/// Least time between two frames.
pub const FRAME: Duration = Duration::from_micros(16_667);

/// Least time between a frame and the one that shows what a key did: who presses it waits for it.
pub const PROMPT: Duration = Duration::from_millis(8);

/// Paces the frames of the loop. The caller supplies the time.
#[derive(Debug)]
pub struct Pace {
    drawn: Instant,
    changed: bool,
    hurries: bool,
}

impl Pace {
    /// A frame was drawn just now, and there is news already.
    pub fn begin(now: Instant) -> Self {
        Self {
            drawn: now,
            changed: true,
            hurries: false,
        }
    }

    /// Something changed that the next frame shows.
    pub fn change(&mut self) {
        self.changed = true;
    }

    /// User input has arrived: its effect should show without delay.
    pub fn hurry(&mut self) {
        self.changed = true;
        self.hurries = true;
    }

    fn apart(&self) -> Duration {
        if self.hurries { PROMPT } else { FRAME }
    }

    /// How long the loop sleeps if nothing arrives; for ever where nothing changed and nothing `moves` by itself.
    pub fn wait(&self, now: Instant, moves: bool) -> Option<Duration> {
        match (self.changed, moves) {
            (true, _) => Some(
                self.apart()
                    .saturating_sub(now.saturating_duration_since(self.drawn)),
            ),
            (false, true) => Some(FRAME * 2),
            (false, false) => None,
        }
    }

    /// Whether a frame has to be drawn now.
    pub fn is_due(&self, now: Instant) -> bool {
        self.changed && now.saturating_duration_since(self.drawn) >= self.apart()
    }

    /// A frame was drawn, and this was the time afterwards.
    pub fn drawn(&mut self, now: Instant) {
        self.drawn = now;
        self.changed = false;
        self.hurries = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_of_chunks_costs_a_frame_in_sixteen_milliseconds() {
        let begun = Instant::now();
        let mut pace = Pace::begin(begun);
        let mut frames = Vec::new();
        // Ten thousand within a second, then silence.
        let mut now = begun;
        for _ in 0..10_000 {
            now += Duration::from_micros(100);
            pace.change();
            if pace.is_due(now) {
                frames.push(now);
                pace.drawn(now);
            }
        }
        assert!((50..=62).contains(&frames.len()), "{}", frames.len());
        let apart = frames.windows(2).map(|pair| pair[1] - pair[0]).min();
        assert!(apart.is_some_and(|apart| apart >= FRAME));
        // The last chunks are drawn too, and then nothing more.
        let rest = pace.wait(now, false).unwrap_or_default();
        assert!(rest <= FRAME);
        assert!(pace.is_due(now + rest));
        pace.drawn(now + rest);
        assert_eq!(pace.wait(now + rest, false), None);
        assert!(!pace.is_due(now + Duration::from_secs(60)));
    }

    #[test]
    fn a_key_does_not_wait_for_the_frame_of_the_chunks() {
        let begun = Instant::now();
        let mut pace = Pace::begin(begun);
        let soon = begun + PROMPT;
        assert!(!pace.is_due(soon), "chunks wait");
        pace.hurry();
        assert!(pace.is_due(soon), "keys do not");
        assert_eq!(pace.wait(begun, false), Some(PROMPT));
        // And they do not make it draw without end.
        pace.drawn(soon);
        pace.hurry();
        assert!(!pace.is_due(soon + PROMPT / 2));
        pace.drawn(soon + PROMPT);
        assert_eq!(pace.wait(soon + PROMPT, false), None);
    }
}
