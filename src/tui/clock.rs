//! The playback clock: the time step shown, and whether it plays.

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
    lap: PlayRange,
}

/// The range played, and whether it repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlayRange {
    /// Everything, once.
    #[default]
    Once,
    /// Everything, over and over.
    Whole,
    /// The steps from one to another, over and over.
    Part(i64, i64),
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
            lap: PlayRange::Once,
        }
    }

    /// The same clock, as fast as another one, and over and over where that is; a part of another scenario is none of
    /// this one.
    #[must_use]
    pub fn like(self, other: &Self) -> Self {
        let lap = match other.lap {
            PlayRange::Once => PlayRange::Once,
            PlayRange::Whole | PlayRange::Part(..) => PlayRange::Whole,
        };
        Self {
            speed: other.speed,
            lap,
            ..self
        }
    }

    /// The range played.
    #[must_use]
    pub fn lap(&self) -> PlayRange {
        self.lap
    }

    /// Plays this from now on.
    pub fn go_round(&mut self, lap: PlayRange) {
        self.lap = lap;
    }

    /// First and last step of what is played.
    #[must_use]
    pub fn played(&self) -> (i64, i64) {
        match self.lap {
            PlayRange::Part(first, last) => (
                first.clamp(self.first, self.last),
                last.clamp(self.first, self.last),
            ),
            PlayRange::Once | PlayRange::Whole => (self.first, self.last),
        }
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

    /// Goes back so many seconds, or to the first step.
    pub fn rewind(&mut self, seconds: f64) {
        self.advance(-((seconds / self.dt).round() as i64));
    }

    /// Doubles or halves the speed.
    pub fn change_speed(&mut self, faster: bool) {
        let factor = if faster { 2.0 } else { 0.5 };
        self.speed = (self.speed * factor).clamp(SPEEDS.0, SPEEDS.1);
    }

    /// Starts or pauses; at the end, and outside what is played, it starts over.
    pub fn toggle(&mut self) {
        let (first, last) = self.played();
        if !self.playing && (self.step == self.last || !(first..=last).contains(&self.step)) {
            self.go(first);
        }
        self.playing = !self.playing;
    }

    /// Lets real time pass; at the end it stops, or starts over. Says whether the step changed.
    pub fn pass(&mut self, elapsed: Duration) -> bool {
        if !self.playing {
            return false;
        }
        self.pending += elapsed.as_secs_f64() * self.speed;
        let steps = (self.pending / self.dt).floor();
        self.pending -= steps * self.dt;
        let before = self.step;
        let (first, last) = self.played();
        let next = self.step.saturating_add(steps as i64);
        if self.lap != PlayRange::Once && first < last {
            // The last step is shown as long as every other one.
            self.step = match next {
                inside if inside <= last => inside,
                beyond => first + (beyond - first).rem_euclid(last - first + 1),
            };
            return self.step != before;
        }
        self.step = next.min(self.last);
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
    fn goes_round_the_whole_or_a_part_and_another_scenario_has_no_part() {
        let mut clock = Clock::new(0..31, 0.1);
        clock.go_round(PlayRange::Part(10, 14));
        clock.toggle();
        assert_eq!(clock.step(), 10, "from outside to the beginning");
        clock.pass(Duration::from_millis(410));
        assert_eq!(clock.step(), 14);
        assert!(clock.pass(Duration::from_millis(110)) && clock.playing);
        assert_eq!(clock.step(), 10);
        clock.go_round(PlayRange::Whole);
        clock.pass(Duration::from_secs(60));
        assert!(clock.playing && (0..=30).contains(&clock.step()));
        clock.change_speed(true);
        clock.go_round(PlayRange::Part(10, 14));
        let other = Clock::new(0..5, 0.1).like(&clock);
        assert_eq!((other.lap(), other.speed()), (PlayRange::Whole, 2.0));
        assert!(!other.playing);
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
