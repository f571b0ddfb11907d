//! A budget shared by requests: reserved before sending, settled once the cost is known.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// An amount of money in US dollars; clones share it.
#[derive(Clone)]
pub struct Budget(Arc<Mutex<Ledger>>);

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
        Self(Arc::new(Mutex::new(Ledger {
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
