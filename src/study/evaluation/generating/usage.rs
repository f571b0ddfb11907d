//! Total consumption of an author's answers.

use super::super::answer::Answer;
use nearmiss_store::Consumed;

/// Requests, answers, tokens and cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AuthoringUsage {
    /// Questions, those that the store had an answer to among them.
    pub requests: u32,
    /// How many of them were answered.
    pub answers: u32,
    /// Answers that were in the store before; nothing was sent for them now.
    pub stored: u32,
    /// Tokens of all questions, as far as known.
    pub input_tokens: u64,
    /// Tokens of all answers, reasoning included, as far as known.
    pub output_tokens: u64,
    /// US dollars of all answers whose cost is known.
    pub usd: f64,
    /// Of these, dollars that had been paid before.
    pub usd_before: f64,
    /// Answers whose cost is not known.
    pub unpriced: u32,
}

impl AuthoringUsage {
    /// Adds an answer.
    pub fn add(&mut self, answer: &Answer) {
        let Consumed {
            input_tokens,
            output_tokens,
            cost_usd,
            ..
        } = answer.consumed;
        self.requests += 1;
        self.answers += u32::from(answer.arrived());
        self.stored += u32::from(answer.past.is_some());
        self.input_tokens = self.input_tokens.saturating_add(input_tokens.unwrap_or(0));
        self.output_tokens = self
            .output_tokens
            .saturating_add(output_tokens.unwrap_or(0));
        match cost_usd {
            Some(usd) => {
                self.usd += usd;
                if answer.past.is_some() {
                    self.usd_before += usd;
                }
            }
            None => self.unpriced += u32::from(answer.arrived()),
        }
    }

    /// Adds what others consumed.
    pub fn join(&mut self, other: &Self) {
        self.requests += other.requests;
        self.answers += other.answers;
        self.stored += other.stored;
        self.input_tokens = self.input_tokens.saturating_add(other.input_tokens);
        self.output_tokens = self.output_tokens.saturating_add(other.output_tokens);
        self.usd += other.usd;
        self.usd_before += other.usd_before;
        self.unpriced += other.unpriced;
    }
}
