//! Permits for requests: rate limits of a provider, and a budget that is reserved before sending and settled afterwards.

use std::collections::VecDeque;
use std::fmt;
use std::num::NonZeroU32;
use std::sync::{self, Arc, PoisonError};
use std::time::Duration;

use tokio::sync::{Mutex, OwnedSemaphorePermit, Semaphore};
use tokio::time::Instant;

/// Limits of one provider; `None` is without limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Limits {
    /// Requests begun within any 60 seconds, repetitions included.
    pub requests_per_minute: Option<NonZeroU32>,
    /// Tokens asked for within any 60 seconds: those of the question, estimated, and the limit of the answer, if one
    /// is set.
    pub tokens_per_minute: Option<NonZeroU32>,
    /// Requests on their way at once.
    pub concurrency: Option<NonZeroU32>,
}

impl Limits {
    /// Whether a request of this many tokens can ever begin.
    ///
    /// # Errors
    /// It alone is more than a minute allows.
    pub(super) fn allow(&self, tokens: u32) -> Result<(), String> {
        match self.tokens_per_minute.map(NonZeroU32::get) {
            Some(most) if tokens > most => Err(format!(
                "question and answer may take {tokens} tokens, but tokens_per_minute is {most}; raise it, or lower max_tokens"
            )),
            _ => Ok(()),
        }
    }
}

/// Enforces a provider's limits over all requests.
#[derive(Debug)]
pub(super) struct Gate {
    limits: Limits,
    span: Duration,
    slots: Option<Arc<Semaphore>>,
    // Held while waiting, so that requests go first come, first served.
    begun: Mutex<VecDeque<(Instant, u32)>>,
}

impl Gate {
    /// A gate without requests so far.
    pub fn new(limits: Limits) -> Self {
        let slots = limits.concurrency;
        Self {
            limits,
            span: Duration::from_secs(60),
            slots: slots.map(|n| Arc::new(Semaphore::new(n.get() as usize))),
            begun: Mutex::default(),
        }
    }

    /// Waits for one of the places for requests on their way; it is free again when the permit is dropped.
    pub async fn enter(&self) -> Option<OwnedSemaphorePermit> {
        let slots = Arc::clone(self.slots.as_ref()?);
        // The semaphore is never closed.
        slots.acquire_owned().await.ok()
    }

    /// Waits until a request of this many tokens may begin.
    ///
    /// The last 60 seconds are counted one by one. A bucket that fills steadily would be less to keep, but lets up to
    /// twice the limit through in its first minute.
    ///
    /// # Errors
    /// The request alone is more than a minute allows.
    pub async fn admit(&self, tokens: u32) -> Result<(), String> {
        let most_tokens = self
            .limits
            .tokens_per_minute
            .map_or(u32::MAX, NonZeroU32::get);
        let most_requests = self.limits.requests_per_minute.map(NonZeroU32::get);
        self.limits.allow(tokens)?;
        if self.limits.tokens_per_minute.is_none() && most_requests.is_none() {
            return Ok(());
        }
        let mut begun = self.begun.lock().await;
        loop {
            while begun
                .front()
                .is_some_and(|(at, _)| at.elapsed() >= self.span)
            {
                begun.pop_front();
            }
            let asked: u64 = begun.iter().map(|(_, n)| u64::from(*n)).sum();
            let many = most_requests.is_some_and(|most| begun.len() >= most as usize);
            let large = asked + u64::from(tokens) > u64::from(most_tokens);
            match begun.front() {
                Some((oldest, _)) if many || large => {
                    tokio::time::sleep_until(*oldest + self.span).await;
                }
                _ => break,
            }
        }
        begun.push_back((Instant::now(), tokens));
        Ok(())
    }
}

/// An amount of money in US dollars; clones share it.
#[derive(Clone)]
pub struct Budget(Arc<sync::Mutex<Ledger>>);

#[derive(Debug)]
struct Ledger {
    limit: f64,
    spent: f64,
    reserved: f64,
}

/// A request could cost more than is left.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "it may cost ${needed:.4}, but ${left:.4} of the budget of ${limit:.4} is left; raise the budget or lower max_tokens"
)]
pub struct OverBudget {
    /// Most that the request may cost, US dollars.
    pub needed: f64,
    /// Amount neither spent nor reserved.
    pub left: f64,
    /// The whole budget.
    pub limit: f64,
}

impl Budget {
    /// A budget in US dollars; an amount that is not a positive number counts as 0.
    #[must_use]
    pub fn new(usd: f64) -> Self {
        let limit = if usd.is_finite() { usd.max(0.0) } else { 0.0 };
        Self(Arc::new(sync::Mutex::new(Ledger {
            limit,
            spent: 0.0,
            reserved: 0.0,
        })))
    }

    /// Amount spent, US dollars; for a request of unknown cost, the most it could have cost.
    #[must_use]
    pub fn spent(&self) -> f64 {
        self.with(|ledger| ledger.spent)
    }

    /// Amount neither spent nor reserved, US dollars.
    #[must_use]
    pub fn left(&self) -> f64 {
        self.with(|ledger| ledger.left())
    }

    /// Sets aside what a request may cost at most.
    ///
    /// # Errors
    /// So much is not left.
    pub(super) fn reserve(&self, usd: f64) -> Result<Reservation, OverBudget> {
        self.with(|ledger| {
            let left = ledger.left();
            if usd > left {
                return Err(OverBudget {
                    needed: usd,
                    left,
                    limit: ledger.limit,
                });
            }
            ledger.reserved += usd;
            Ok(())
        })?;
        Ok(Reservation {
            budget: self.clone(),
            usd,
            may_be_paid: false,
        })
    }

    fn with<T>(&self, work: impl FnOnce(&mut Ledger) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Ledger {
    fn left(&self) -> f64 {
        (self.limit - self.spent - self.reserved).max(0.0)
    }
}

impl fmt::Debug for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.with(|ledger| ledger.fmt(f))
    }
}

/// Money set aside for one request. Dropped without being settled it is spent, if the request may have to be paid for.
#[derive(Debug)]
pub(super) struct Reservation {
    budget: Budget,
    usd: f64,
    may_be_paid: bool,
}

impl Reservation {
    /// Whether the request, as it stands, may have to be paid for.
    pub fn may_be_paid(&mut self, yes: bool) {
        self.may_be_paid = yes;
    }

    /// The request cost this; what is no amount of money counts as the most it could have cost.
    pub fn settle(mut self, usd: f64) {
        let stated = usd.is_finite() && usd >= 0.0;
        self.close(if stated { usd } else { self.usd });
    }

    fn close(&mut self, usd: f64) {
        let reserved = std::mem::take(&mut self.usd);
        self.may_be_paid = false;
        self.budget.with(|ledger| {
            ledger.reserved -= reserved;
            ledger.spent += usd;
        });
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        let spent = if self.may_be_paid { self.usd } else { 0.0 };
        self.close(spent);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn gate(requests: u32, tokens: u32, span: Duration) -> Gate {
        Gate {
            span,
            ..Gate::new(Limits {
                requests_per_minute: NonZeroU32::new(requests),
                tokens_per_minute: NonZeroU32::new(tokens),
                concurrency: NonZeroU32::new(1),
            })
        }
    }

    /// When requests of these sizes were let through, in spans.
    async fn times(gate: &Gate, sizes: &[u32]) -> Vec<f64> {
        let begun = Instant::now();
        let mut times = Vec::new();
        for size in sizes {
            gate.admit(*size).await.unwrap();
            times.push(begun.elapsed().as_secs_f64() / gate.span.as_secs_f64());
        }
        times
    }

    #[tokio::test]
    async fn no_span_holds_more_than_the_limit() {
        let span = Duration::from_millis(120);
        let times = times(&gate(2, 0, span), &[1, 1, 1, 1, 1]).await;
        for pair in times.windows(3) {
            assert!(pair[2] - pair[0] >= 1.0, "{times:?}");
        }
        assert!(times[1] < 0.5 && times[4] < 3.5, "{times:?}");
    }

    #[tokio::test]
    async fn tokens_are_counted_too() {
        let span = Duration::from_millis(120);
        let gate = gate(0, 100, span);
        let times = times(&gate, &[60, 40, 50]).await;
        assert!(times[1] < 0.5 && times[2] >= 1.0, "{times:?}");
        let why = gate.admit(101).await.unwrap_err();
        assert!(
            why.contains("101") && why.contains("tokens_per_minute is 100"),
            "{why}"
        );
    }

    #[tokio::test]
    async fn places_are_given_back() {
        let gate = gate(0, 0, Duration::from_secs(60));
        let first = gate.enter().await;
        let second = tokio::time::timeout(Duration::from_millis(30), gate.enter()).await;
        assert!(first.is_some() && second.is_err());
        drop(first);
        assert!(gate.enter().await.is_some());
    }

    #[test]
    fn nothing_is_spent_twice() {
        let budget = Budget::new(1.0);
        let mut first = budget.reserve(0.5).unwrap();
        let refused = budget.clone().reserve(0.75).unwrap_err();
        assert_eq!(
            (refused.needed, refused.left, refused.limit),
            (0.75, 0.5, 1.0)
        );
        let text = refused.to_string();
        assert!(
            text.contains("$0.7500") && text.contains("raise the budget"),
            "{text}"
        );
        first.may_be_paid(true);
        first.settle(0.125);
        assert_eq!((budget.spent(), budget.left()), (0.125, 0.875));
        drop(budget.reserve(0.5).unwrap());
        assert_eq!(budget.spent(), 0.125, "what was never sent costs nothing");
        let mut lost = budget.reserve(0.5).unwrap();
        lost.may_be_paid(true);
        drop(lost);
        assert_eq!(
            budget.spent(),
            0.625,
            "what is not known is counted in full"
        );
        assert!(Budget::new(f64::NAN).reserve(0.01).is_err());
        let budget = Budget::new(1.0);
        for (nonsense, spent) in [(f64::NAN, 0.25), (f64::INFINITY, 0.5), (-3.0, 0.75)] {
            budget.reserve(0.25).unwrap().settle(nonsense);
            assert_eq!(budget.spent(), spent, "{nonsense}");
        }
    }
}
