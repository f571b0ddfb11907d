//! How fast an index was made, on standard error.

use std::time::Instant;

use crate::output;
use crate::parts::PartsOutcome;

/// The time since the beginning.
pub struct Throughput {
    begun: Instant,
}

impl Throughput {
    /// Begins to count.
    pub fn begin() -> Self {
        Self {
            begun: Instant::now(),
        }
    }

    /// Says what was done in which time.
    pub fn say(&self, done: &PartsOutcome, pairs: u64) {
        let seconds = self.begun.elapsed().as_secs_f64();
        let rate = done.new_rows as f64 / seconds.max(1e-3);
        let kept = match done.kept_rows {
            0 => String::new(),
            kept => format!("; {kept} windows of an earlier run kept"),
        };
        output::say(&format!(
            "nearmiss: {} windows of {pairs} pairs in {seconds:.1} s: {rate:.0} windows a second{kept}",
            done.new_rows
        ));
    }
}
