//! Cost estimates from the providers' prices.

use jiff::civil::Date;

use crate::judge;
use crate::llm::{Pricing, Registry};

/// Prices of all models on a day.
#[derive(Debug, Clone, Default)]
pub struct Prices(Option<(Registry, Date)>);

impl Prices {
    /// The prices that a registry knows, on a day.
    #[must_use]
    pub fn new(registry: Registry, day: Date) -> Self {
        Self(Some((registry, day)))
    }

    fn pricing_for(&self, model: &str) -> Option<Pricing> {
        let (registry, day) = self.0.as_ref()?;
        registry.pricing(model, *day)
    }

    /// The cost of asking a model this many tokens, in words; includes the answer if its length has a limit.
    #[must_use]
    pub fn words(&self, model: &str, tokens: usize, most: Option<u32>) -> String {
        if model == judge::MODEL {
            return "built in: free".into();
        }
        let Some(pricing) = self.pricing_for(model) else {
            return "price unknown".into();
        };
        let tokens = u32::try_from(tokens).unwrap_or(u32::MAX);
        match (most, pricing.at_most(tokens, most.unwrap_or(0))) {
            (_, None) => "price unknown".into(),
            (Some(_), Some(usd)) => format!("${usd:.4} at most"),
            (None, Some(usd)) => format!("${usd:.4} + answer"),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_price_only_where_one_is_known() {
        let users = "[lab]\nbase_url = \"http://localhost:1\"\n[[lab.prices]]\nmodel = \"big\"\ninput = 2.0\noutput = 10.0\n";
        let registry = Registry::new(&toml::from_str(users).unwrap()).unwrap();
        let prices = Prices::new(registry, jiff::civil::date(2026, 1, 1));
        let words = |model, most| prices.words(model, 1000, most);
        assert_eq!(words("lab/big", None), "$0.0020 + answer");
        assert_eq!(words("lab/big", Some(100)), "$0.0030 at most");
        assert_eq!(words("lab/small", None), "price unknown");
        assert_eq!(words("nobody/x", None), "price unknown");
        assert_eq!(words(judge::MODEL, None), "built in: free");
    }
}
