//! Estimates of a batch before it is asked: requests, tokens, and an upper bound on cost.

use jiff::Zoned;

use crate::evaluation::request::most_usd;
use crate::evaluation::{Judge, Question};

/// Estimated size of one question.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Tokens of the question, estimated.
    pub tokens: u64,
    /// Whether the store has a whole answer.
    pub stored: bool,
    /// Its price.
    pub price: Price,
}

/// Price of one question, US dollars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Price {
    /// Free: the built-in judge.
    Free,
    /// At most this, the answer included.
    AtMost(f64),
    /// The question alone, and a million tokens of the answer, which nothing bounds.
    Question {
        /// The question.
        usd: f64,
        /// A million tokens of the answer.
        million: f64,
    },
    /// No price is known.
    Unknown,
}

impl Size {
    /// Estimates a question.
    #[must_use]
    pub fn estimate(question: &Question, judge: &Judge) -> Self {
        let tokens = question.tokens();
        let price = match judge {
            Judge::Reference => Price::Free,
            Judge::Model(model) => most_usd(question, model).map_or_else(
                || {
                    let prices = &model.endpoint.prices;
                    let pricing = prices.pricing_for(&model.name, Zoned::now().date());
                    let tokens = u32::try_from(tokens).unwrap_or(u32::MAX);
                    let alone = pricing.and_then(|pricing| {
                        let usd = pricing.at_most(tokens, 0)?;
                        let million = pricing.at_most(tokens, 1_000_000)? - usd;
                        Some(Price::Question { usd, million })
                    });
                    alone.unwrap_or(Price::Unknown)
                },
                Price::AtMost,
            ),
        };
        Self {
            tokens: tokens as u64,
            stored: false,
            price,
        }
    }
}

/// Estimated total of all questions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Estimate {
    /// Requests that would be sent; those to the built-in judge are none.
    pub requests: u64,
    /// Questions that the built-in judge answers.
    pub free: u64,
    /// Questions whose answers the store has.
    pub stored: u64,
    /// Questions that cannot be asked.
    pub unaskable: u64,
    /// Why, each reason once, with how many questions it holds for.
    pub why: Vec<(String, u64)>,
    /// Tokens of the requests, estimated.
    pub tokens: u64,
    /// US dollars that are known: the most of requests with a bound, the question alone of those without.
    pub usd: f64,
    /// Requests whose answers nothing bounds.
    pub unbounded: u64,
    /// The most that a million tokens of these answers cost, US dollars.
    pub million: f64,
    /// Requests without a known price.
    pub unpriced: u64,
}

impl Estimate {
    /// Adds a question; `size` is missing where it cannot be asked, for this reason.
    pub fn add(&mut self, size: Option<Size>, why: Option<&str>) {
        let Some(size) = size else {
            self.unaskable += 1;
            let why = why.unwrap_or("no question can be made of it");
            match self.why.iter_mut().find(|(known, _)| known == why) {
                Some((_, count)) => *count += 1,
                None => self.why.push((why.to_string(), 1)),
            }
            return;
        };
        if size.price == Price::Free {
            self.free += 1;
            return;
        }
        if size.stored {
            self.stored += 1;
            return;
        }
        self.requests += 1;
        self.tokens += size.tokens;
        match size.price {
            Price::AtMost(usd) => self.usd += usd,
            Price::Question { usd, million } => {
                self.usd += usd;
                self.million = self.million.max(million);
                self.unbounded += 1;
            }
            Price::Unknown => self.unpriced += 1,
            Price::Free => {}
        }
    }

    /// Formats the price.
    #[must_use]
    pub fn price(&self) -> String {
        let all = self.requests;
        if all == 0 {
            return "nothing to pay".into();
        }
        if self.unpriced == all {
            return "no price known".into();
        }
        let mut words = match self.unbounded {
            0 => format!("at most {:.4} USD", self.usd),
            n => format!(
                "{:.4} USD and the answers of {n}, which nothing bounds (--max-tokens)",
                self.usd
            ),
        };
        if self.unpriced > 0 {
            words.push_str(&format!(
                ", without {} that have no known price",
                self.unpriced
            ));
        }
        words
    }
}
