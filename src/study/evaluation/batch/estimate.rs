//! Estimates of a batch before it is asked: requests, tokens, and an upper bound on cost.

use jiff::Zoned;

use crate::evaluation::request::most_usd;
use crate::evaluation::{Judge, Question};

/// Estimated size of one question.
#[derive(Debug, Clone, PartialEq)]
pub struct Size {
    /// Tokens of the question, estimated.
    pub tokens: u64,
    /// Whether the store has a whole answer.
    pub stored: bool,
    /// Its price.
    pub price: Price,
    /// What the bound counts beyond listed prices, in words.
    pub bound: Option<String>,
    /// Rounds of tools that it may take at most; 0 without tools.
    pub rounds: u32,
}

/// Price of one question, US dollars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Price {
    /// Free: the built-in judge, or recorded answers.
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
        let pricing = match judge {
            Judge::Reference | Judge::Recorded(_) => None,
            Judge::Model(model) => {
                let prices = &model.endpoint.prices;
                prices.pricing_for(&model.name, Zoned::now().date())
            }
        };
        let price = match judge {
            Judge::Reference | Judge::Recorded(_) => Price::Free,
            Judge::Model(model) => most_usd(question, model).map_or_else(
                || {
                    let tokens = u32::try_from(tokens).unwrap_or(u32::MAX);
                    let alone = pricing.as_ref().and_then(|pricing| {
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
            bound: pricing.and_then(|pricing| pricing.bound_words()),
            rounds: match judge {
                Judge::Model(model) => model.parameters.tools.map_or(0, |limits| limits.rounds),
                Judge::Reference | Judge::Recorded(_) => 0,
            },
        }
    }
}

/// Estimated total of all questions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Estimate {
    /// Requests that would be sent; those to the built-in judge, and for recorded answers, are none.
    pub requests: u64,
    /// Questions that the built-in judge answers.
    pub free: u64,
    /// Questions whose answers the store has.
    pub stored: u64,
    /// Questions whose request is that of another one of the batch: one answer is for both.
    pub repeated: u64,
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
    /// Rounds of tools that one of these may take at most, which the dollars do not count; 0 without tools.
    pub uncounted_rounds: u32,
    /// Requests without a known price.
    pub unpriced: u64,
    /// What the bounds count beyond listed prices, in words, each once.
    pub bounds: Vec<String>,
}

/// Tokens of an answer that the total is given for where nothing bounds answers.
const ASSUMED_ANSWER: u64 = 1000;

impl Estimate {
    /// All questions.
    #[must_use]
    pub fn questions(&self) -> u64 {
        self.requests + self.free + self.stored + self.repeated + self.unaskable
    }

    /// Adds a question; `size` is missing where it cannot be asked, for this reason.
    pub fn add(&mut self, size: Option<Size>, why: Option<&str>) {
        let Some(size) = size else {
            self.unaskable += 1;
            let why = why.unwrap_or("no question can be built from it");
            match self.why.iter_mut().find(|(known, _)| known == why) {
                Some((_, count)) => *count += 1,
                None => self.why.push((why.to_string(), 1)),
            }
            return;
        };
        if size.stored {
            self.stored += 1;
            return;
        }
        if size.price == Price::Free {
            self.free += 1;
            return;
        }
        self.requests += 1;
        self.tokens += size.tokens;
        let bound = size.bound.filter(|words| !self.bounds.contains(words));
        self.bounds.extend(bound);
        match size.price {
            Price::AtMost(usd) => self.usd += usd,
            Price::Question { usd, million } => {
                self.usd += usd;
                self.million = self.million.max(million);
                self.unbounded += 1;
                self.uncounted_rounds = self.uncounted_rounds.max(size.rounds);
            }
            Price::Unknown => self.unpriced += 1,
            Price::Free => {}
        }
    }

    /// The total cost in words: a bound, or where nothing bounds the answers an estimate for short ones.
    #[must_use]
    pub fn price(&self) -> String {
        let all = self.requests;
        if all == 0 {
            return "free".into();
        }
        if self.usd == 0.0 && self.unbounded == 0 && self.unpriced == 0 {
            return "free: nothing is paid for these models".into();
        }
        if self.unpriced == all {
            return "no price known; [[provider.NAME.prices]] in config.toml states one".into();
        }
        let mut words = match self.unbounded {
            0 => format!("at most ${:.4}", self.usd),
            n => {
                let answers = self.million * (n * ASSUMED_ANSWER) as f64 / 1e6;
                let rounds = match self.uncounted_rounds {
                    0 => String::new(),
                    n => format!(", without up to {n} rounds of tools each"),
                };
                format!(
                    "${:.4} for the questions, ${:.4} in all if answers take {ASSUMED_ANSWER} tokens each{rounds}; max_tokens sets a limit",
                    self.usd,
                    self.usd + answers
                )
            }
        };
        if self.unpriced > 0 {
            words.push_str(&format!(", without {} of unknown price", self.unpriced));
        }
        words
    }
}
