//! Steps of a scenario: the sweeps of the lidar.

use super::log::Log;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::Report;

/// Sweeps with the steps that they are at.
pub struct Clock<'l> {
    pub log: &'l Log,
    /// Places in the log, and steps; each step once.
    pub sweeps: Vec<(usize, i64)>,
    /// Sweeps of which the step had one already.
    pub twice: usize,
    /// Sweeps that are more than a quarter of a step off.
    pub off: usize,
}

impl<'l> Clock<'l> {
    /// Of sweeps in order; the first one is at step 0, and one takes so many seconds.
    pub fn new(log: &'l Log, sweeps: &[usize], time_step: f64) -> Self {
        let start = sweeps.first().map_or(0.0, |first| log.seconds(*first));
        let mut clock = Self {
            log,
            sweeps: Vec::with_capacity(sweeps.len()),
            twice: 0,
            off: 0,
        };
        for sweep in sweeps {
            let at = (log.seconds(*sweep) - start) / time_step;
            let step = at.round();
            if clock
                .sweeps
                .last()
                .is_some_and(|(_, last)| step as i64 <= *last)
            {
                clock.twice += 1;
                continue;
            }
            clock.off += usize::from((at - step).abs() > 0.25);
            clock.sweeps.push((*sweep, step as i64));
        }
        clock
    }

    /// The last step.
    pub fn last(&self) -> i64 {
        self.sweeps.last().map_or(0, |(_, step)| *step)
    }

    /// Says what is odd about it.
    pub fn tell(&self, report: &Report) {
        let missing = usize::try_from(self.last() + 1)
            .unwrap_or(0)
            .saturating_sub(self.sweeps.len());
        let at = report.at("table lidar_pc");
        if self.off > 0 {
            at.warn(format!(
                "{} sweeps are not on a grid of {} s; taken as at the nearest step",
                self.off, self.log.time_step
            ));
        }
        if self.twice + missing > 0 {
            at.warn(format!(
                "{missing} steps of {} s have no sweep, and {} have two, of which the first is used",
                self.log.time_step, self.twice
            ));
        }
    }
}
