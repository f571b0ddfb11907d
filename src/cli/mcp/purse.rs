//! What clients may spend on language models in one session.

use std::sync::{Mutex, PoisonError};

use serde_json::Value;

/// The option and argument that limit the cost of one answer.
pub const BUDGET: &str = "budget";

/// Money that is left for a session, US dollars.
#[derive(Debug)]
pub struct Purse(Mutex<f64>);

impl Purse {
    /// One with so many US dollars.
    pub fn new(usd: f64) -> Self {
        Self(Mutex::new(usd))
    }

    /// Takes out what an answer may cost, US dollars: what its arguments say, or all that is left.
    ///
    /// # Errors
    /// In words: nothing is left, or less than the arguments ask for.
    pub fn reserve(&self, arguments: &Value) -> Result<f64, String> {
        let mut left = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let asked = arguments[BUDGET].as_f64().unwrap_or(*left);
        if asked < 0.0 {
            return Err(format!(
                "argument `{BUDGET}` is {asked}; it must not be negative"
            ));
        }
        if *left <= 0.0 || asked > *left {
            return Err(format!(
                "the session has {:.4} USD left of its --budget, and this answer may cost {asked:.4}",
                left.max(0.0)
            ));
        }
        *left -= asked;
        Ok(asked)
    }

    /// Puts back what an answer did not cost; nothing where the cost is not known.
    pub fn settle(&self, reserved: f64, given: &[u8]) {
        let line = given
            .split(|byte| *byte == b'\n')
            .next()
            .unwrap_or_default();
        let document: Value = serde_json::from_slice(line).unwrap_or_default();
        if let Some(cost) = document["cost_usd"].as_f64() {
            self.put_back((reserved - cost).max(0.0));
        }
    }

    /// Puts back what nothing was paid of.
    pub fn put_back(&self, usd: f64) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) += usd;
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_session_spends_no_more_than_it_has() {
        let purse = Purse::new(1.0);
        let taken = |asked: Value| purse.reserve(&asked);
        assert_eq!(taken(json!({"budget": 0.6})), Ok(0.6));
        assert!(taken(json!({"budget": 0.6})).is_err());
        // Less than nothing would add to what is left.
        assert!(taken(json!({"budget": -5.0})).is_err());
        assert!(taken(json!({"budget": 0.6})).is_err());
        purse.settle(0.6, br#"{"cost_usd": 0.1}"#);
        assert_eq!(taken(json!({"budget": 0.6})), Ok(0.6));
        // An unknown cost may have been all of it.
        purse.settle(0.6, b"interrupted");
        let left = taken(json!({})).unwrap_or_default();
        assert!((left - 0.3).abs() < 1e-9, "{left}");
        assert!(taken(json!({})).is_err());
    }
}
