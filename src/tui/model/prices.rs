//! What asking costs, from the providers' prices: known before anything is sent.

use std::collections::BTreeSet;

use jiff::civil::Date;

use nearmiss_ask::llm::{Pricing, Registry};
use nearmiss_scene::judge;

/// Prices of all models on a day.
#[derive(Debug, Clone, Default)]
pub struct Prices(Option<PriceTable>);

#[derive(Debug, Clone)]
struct PriceTable {
    registry: Registry,
    /// Providers that cost nothing, as [`Registry::free`] has them.
    free: BTreeSet<String>,
    day: Date,
}

/// Price of a model where none is known.
const UNKNOWN: &str = "price unknown";

/// Price of the built-in judge, and of models on this machine.
const FREE: &str = "free";

/// Tokens of one request.
#[derive(Debug, Clone, Copy)]
pub struct RequestTokens {
    /// Of the question.
    pub question: usize,
    /// Of the answer at most, where that has a limit.
    pub answer: Option<u32>,
}

impl Prices {
    /// The prices that a registry knows, on a day; `free` names the providers that cost nothing.
    #[must_use]
    pub fn new(registry: Registry, free: BTreeSet<String>, day: Date) -> Self {
        Self(Some(PriceTable {
            registry,
            free,
            day,
        }))
    }

    fn pricing_for(&self, model: &str) -> Option<Pricing> {
        let table = self.0.as_ref()?;
        table.registry.pricing(model, table.day)
    }

    /// Whether nothing is paid: the built-in judge, or a server on this machine for which no price is stated.
    #[must_use]
    pub fn is_free(&self, model: &str) -> bool {
        let provider = model.split('/').next().unwrap_or_default();
        let free = self.0.as_ref().is_some_and(|t| t.free.contains(provider));
        model == judge::MODEL || free
    }

    /// The most that requests to a model can cost, in words; includes the answers if their length has a limit.
    #[must_use]
    pub fn of_requests(&self, model: &str, requests: &[RequestTokens]) -> String {
        if self.is_free(model) {
            return FREE.into();
        }
        let Some(pricing) = self.pricing_for(model) else {
            return UNKNOWN.into();
        };
        let most = |one: &RequestTokens| {
            let question = u32::try_from(one.question).unwrap_or(u32::MAX);
            pricing.at_most(question, one.answer.unwrap_or(0))
        };
        let Some(usd) = requests.iter().map(most).sum::<Option<f64>>() else {
            return UNKNOWN.into();
        };
        match (requests.iter().all(|one| one.answer.is_some()), requests) {
            (true, _) => format!("at most ${usd:.4}"),
            (false, [_]) => format!("${usd:.4} + answer"),
            (false, _) => format!("${usd:.4} + answers"),
        }
    }

    /// The price of a million tokens, in words: `$2 in, $10 out per 1M tokens`.
    #[must_use]
    pub fn per_million(&self, model: &str) -> String {
        if self.is_free(model) {
            return FREE.into();
        }
        match self.pricing_for(model) {
            Some(Pricing { price, .. }) => {
                format!("${} in, ${} out per 1M", price.input, price.output)
            }
            None => UNKNOWN.into(),
        }
    }

    /// What the bound on a model's cost counts beyond listed prices, in words.
    #[must_use]
    pub fn bound(&self, model: &str) -> Option<String> {
        self.pricing_for(model)?.bound_note()
    }

    /// Where the price of a model is from, or how to state one.
    #[must_use]
    pub fn origin(&self, model: &str) -> String {
        if model == judge::MODEL {
            return "built in: runs here, costs nothing".into();
        }
        if self.is_free(model) {
            return "a server on this machine: costs nothing".into();
        }
        let provider = model.split('/').next().unwrap_or_default();
        match self.pricing_for(model) {
            Some(pricing) => match pricing.origin() {
                Some(origin) => format!("price {origin}"),
                None => "price from your config.toml".into(),
            },
            None => format!(
                "no price known; [[provider.{provider}.prices]] in config.toml sets one, in US dollars per 1M tokens"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_ask::llm::Environment;

    #[test]
    fn a_price_only_where_one_is_known_and_free_only_what_runs_here() {
        let users = "[lab]\nbase_url = \"http://lab.example\"\n[[lab.prices]]\nmodel = \"big\"\ninput = 2.0\noutput = 10.0\n\
            [desk]\nbase_url = \"http://localhost:1\"\n[shop]\nbase_url = \"http://localhost:2\"\n[[shop.prices]]\nmodel = \"sold\"\ninput = 1.0\noutput = 1.0\n";
        let registry = Registry::new(&toml::from_str(users).unwrap()).unwrap();
        let free = registry.free(&Environment::from_lookup(|_| None));
        assert!(free.contains("desk"), "{free:?}");
        assert!(!free.contains("lab") && !free.contains("shop"));
        let prices = Prices::new(registry, free, jiff::civil::date(2026, 1, 1));
        let words = |model, answer| {
            let question = 1000;
            prices.of_requests(model, &[RequestTokens { question, answer }])
        };
        assert_eq!(words("lab/big", None), "$0.0020 + answer");
        assert_eq!(words("lab/big", Some(100)), "at most $0.0030");
        assert_eq!(words("lab/small", None), UNKNOWN);
        assert_eq!(words("nobody/x", None), UNKNOWN);
        assert_eq!(words(judge::MODEL, None), FREE);
        assert_eq!(words("desk/any", None), FREE);
        assert_eq!(words("shop/any", None), UNKNOWN);
        assert_eq!(words("shop/sold", Some(0)), "at most $0.0010");
        assert_eq!(prices.per_million("lab/big"), "$2 in, $10 out per 1M");
        assert!(
            prices
                .origin("lab/small")
                .contains("[[provider.lab.prices]]")
        );
        let two = [(1000, Some(100)), (500, Some(0))]
            .map(|(question, answer)| RequestTokens { question, answer });
        assert_eq!(prices.of_requests("lab/big", &two), "at most $0.0040");
    }
}
