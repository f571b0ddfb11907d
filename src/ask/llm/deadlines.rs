//! The two deadlines of an exchange: one restarts with every byte, one never does.

use std::time::Duration;

use tokio::task::yield_now;
use tokio::time::{Instant, timeout};

use super::endpoint::Timeouts;
use super::error::TimeoutKind;

/// Remaining time of one exchange.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deadlines {
    idle: Duration,
    total: Duration,
    started: Instant,
}

/// The limit that was hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Elapsed {
    pub which: TimeoutKind,
    pub after: Duration,
}

impl Deadlines {
    /// Both clocks start now.
    pub fn starting_now(timeouts: Timeouts) -> Self {
        Self {
            idle: timeouts.idle,
            total: timeouts.total,
            started: Instant::now(),
        }
    }

    /// Remaining total time.
    pub fn left(&self) -> Duration {
        self.total.saturating_sub(self.started.elapsed())
    }

    /// Waits for one sign of life.
    pub async fn wait<F: Future>(&self, future: F) -> Result<F::Output, Elapsed> {
        let left = self.left();
        let elapsed = if left < self.idle {
            Elapsed {
                which: TimeoutKind::Total,
                after: self.total,
            }
        } else {
            Elapsed {
                which: TimeoutKind::Idle,
                after: self.idle,
            }
        };
        // A timeout looks at the clock only where the future has to wait: what is always ready would never be late.
        if left.is_zero() {
            return Err(elapsed);
        }
        // For the same reason everything else gets its turn, Ctrl-C among it. Not by tokio's budget: who uses it up
        // leaves none to those beside it in a `select`.
        yield_now().await;
        timeout(left.min(self.idle), future)
            .await
            .map_err(|_| elapsed)
    }

    /// The same patience, but from now on for no longer than this in all.
    pub fn at_most(self, longest: Duration) -> Self {
        let total = self.started.elapsed().saturating_add(longest);
        Self {
            total: total.min(self.total),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    fn patience(total: Duration) -> Deadlines {
        Deadlines::starting_now(Timeouts {
            connect: MS,
            idle: 60_000 * MS,
            total,
        })
    }

    #[tokio::test]
    async fn what_is_always_ready_runs_out_of_time_too() {
        let patience = patience(50 * MS);
        let begun = Instant::now();
        let elapsed = loop {
            if let Err(elapsed) = patience.wait(std::future::ready(())).await {
                break elapsed;
            }
            assert!(begun.elapsed() < 10_000 * MS, "the total time is not kept");
        };
        assert_eq!(
            (elapsed.which, elapsed.after),
            (TimeoutKind::Total, 50 * MS)
        );
    }

    #[tokio::test]
    async fn what_is_always_ready_lets_others_have_their_turn() {
        let patience = patience(60_000 * MS);
        let endless = async {
            loop {
                let _ = patience.wait(std::future::ready(())).await;
            }
        };
        tokio::select! {
            biased;
            () = endless => {}
            () = tokio::time::sleep(20 * MS) => {}
        }
    }

    #[tokio::test]
    async fn patience_for_a_part_ends_before_the_whole() {
        let whole = patience(60_000 * MS);
        let part = whole.at_most(30 * MS);
        let late = part.wait(std::future::pending::<()>()).await;
        assert_eq!(
            late.map_err(|elapsed| elapsed.which),
            Err(TimeoutKind::Total)
        );
        assert!(whole.left() > 30_000 * MS);
        assert!(patience(10 * MS).at_most(60_000 * MS).left() <= 10 * MS);
    }
}
