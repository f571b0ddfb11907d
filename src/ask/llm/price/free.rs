//! What costs nothing: a server on this machine whose provider states no price.

use super::{Price, PriceEntry, Prices, Pricing};

/// Where the price of such a server is from, for display.
const HERE: &str = "a server on this machine";

impl Prices {
    /// The prices of a server on this machine: nothing, whatever the model.
    #[must_use]
    pub fn free() -> Self {
        Self {
            entries: vec![PriceEntry {
                model: "*".into(),
                from: None,
                to: None,
                up_to: None,
                price: Price {
                    input: 0.0,
                    output: 0.0,
                    cached: None,
                    cache_write: None,
                },
                as_of: None,
                source: Some(HERE.into()),
            }],
            peak: None,
            batch_factor: Some(1.0),
        }
    }

    /// Whether these are the prices of [`Prices::free`].
    #[must_use]
    pub fn are_free(&self) -> bool {
        *self == Self::free()
    }
}

impl Pricing {
    /// Whether it is a price of [`Prices::free`].
    #[must_use]
    pub fn is_free(&self) -> bool {
        let nothing = self.price.input == 0.0 && self.price.output == 0.0;
        nothing && self.source.as_deref() == Some(HERE)
    }

    /// The same in words; `None` for all others.
    #[must_use]
    pub fn free_words(&self) -> Option<String> {
        self.is_free().then(|| format!("free: {HERE}"))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::llm::Usage;

    #[test]
    fn what_runs_here_costs_nothing_even_where_no_tokens_are_counted() {
        let prices = Prices::free();
        let day = "2026-11-20".parse().unwrap();
        let pricing = prices.of_answer("any", Some("other"), day).unwrap();
        let asked = "2026-11-20T12:00:00Z".parse().unwrap();
        assert_eq!(pricing.cost(&Usage::default(), asked), Some(0.0));
        assert_eq!(pricing.batch_cost(&Usage::default(), asked), Some(0.0));
        assert_eq!(pricing.at_most(1000, 1000), Some(0.0));
        assert!(prices.are_free() && !Prices::default().are_free());
        assert_eq!(
            pricing.free_words().unwrap(),
            "free: a server on this machine"
        );
    }
}
