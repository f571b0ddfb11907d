//! The two clocks of an exchange: one restarts with every byte, one never.

use std::time::Duration;

use tokio::time::{Instant, timeout};

use super::endpoint::Timeouts;
use super::error::Which;

/// How long one exchange may still take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    idle: Duration,
    total: Duration,
    started: Instant,
}

/// The limit that was hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Elapsed {
    pub which: Which,
    pub after: Duration,
}

impl Patience {
    /// Both clocks start now.
    pub fn starting_now(timeouts: Timeouts) -> Self {
        Self {
            idle: timeouts.idle,
            total: timeouts.total,
            started: Instant::now(),
        }
    }

    /// What is left of the total time.
    pub fn left(&self) -> Duration {
        self.total.saturating_sub(self.started.elapsed())
    }

    /// Waits for one sign of life.
    pub async fn wait<F: Future>(&self, future: F) -> Result<F::Output, Elapsed> {
        let left = self.left();
        let elapsed = if left < self.idle {
            Elapsed {
                which: Which::Total,
                after: self.total,
            }
        } else {
            Elapsed {
                which: Which::Idle,
                after: self.idle,
            }
        };
        timeout(left.min(self.idle), future)
            .await
            .map_err(|_| elapsed)
    }
}
