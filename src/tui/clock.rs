//! The one clock: which time step is shown, and whether it runs.

use std::ops::Range;
use std::time::Duration;

/// The current time step. Every view asks it; only `update` moves it.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    first: i64,
    last: i64,
    step: i64,
    dt: f64,
    /// Time that has passed and is not a whole step yet, seconds of the scenario.
    pending: f64,
    /// Whether it runs.
    pub playing: bool,
    speed: f64,
}

const SPEEDS: (f64, f64) = (0.125, 16.0);

impl Clock {
    /// A clock over `steps` of `dt` seconds, at the first one.
    #[must_use]
    pub fn new(steps: Range<i64>, dt: f64) -> Self {
        Self {
            first: steps.start,
            last: (steps.end - 1).max(steps.start),
            step: steps.start,
            dt,
            pending: 0.0,
            playing: false,
            speed: 1.0,
        }
    }

    /// The same clock at another speed.
    #[must_use]
    pub fn at_speed(self, speed: f64) -> Self {
        Self { speed, ..self }
    }

    /// The current step.
    #[must_use]
    pub fn step(&self) -> i64 {
        self.step
    }

    /// First and last step.
    #[must_use]
    pub fn range(&self) -> (i64, i64) {
        (self.first, self.last)
    }

    /// Seconds since step 0.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.step as f64 * self.dt
    }

    /// How fast it runs, times real time.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Goes to a step, or as near to it as there is one.
    pub fn go(&mut self, step: i64) {
        self.step = step.clamp(self.first, self.last);
        self.pending = 0.0;
    }

    /// Goes some steps forward, or back.
    pub fn advance(&mut self, steps: i64) {
        self.go(self.step.saturating_add(steps));
    }

    /// Doubles or halves the speed.
    pub fn change_speed(&mut self, faster: bool) {
        let factor = if faster { 2.0 } else { 0.5 };
        self.speed = (self.speed * factor).clamp(SPEEDS.0, SPEEDS.1);
    }

    /// Starts or pauses; at the end it starts over.
    pub fn toggle(&mut self) {
        if !self.playing && self.step == self.last {
            self.go(self.first);
        }
        self.playing = !self.playing;
    }

    /// Lets real time pass; it stops at the end. Says whether the step changed.
    pub fn pass(&mut self, elapsed: Duration) -> bool {
        if !self.playing {
            return false;
        }
        self.pending += elapsed.as_secs_f64() * self.speed;
        let steps = (self.pending / self.dt).floor();
        self.pending -= steps * self.dt;
        let before = self.step;
        self.step = self.step.saturating_add(steps as i64).min(self.last);
        if self.step == self.last {
            self.playing = false;
            self.pending = 0.0;
        }
        self.step != before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_in_real_time_and_stops_at_the_end() {
        let mut clock = Clock::new(0..31, 0.1);
        clock.toggle();
        assert!(!clock.pass(Duration::from_millis(50)));
        assert!(clock.pass(Duration::from_millis(60)));
        assert_eq!(clock.step(), 1);
        clock.pass(Duration::from_secs(60));
        assert_eq!((clock.step(), clock.playing), (30, false));
        clock.toggle();
        assert_eq!(clock.step(), 0, "starts over");
    }

    #[test]
    fn stays_in_range() {
        let mut clock = Clock::new(5..10, 0.1);
        clock.advance(i64::MAX);
        assert_eq!(clock.step(), 9);
        clock.advance(-100);
        assert_eq!(clock.step(), 5);
    }
}
