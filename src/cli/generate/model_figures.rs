//! Figures of models over all scenarios: consumption, first tries, and how often both rankings agree.

use schemars::JsonSchema;
use serde::Serialize;

use crate::output::counted;
use nearmiss_study::evaluation::generating::{AuthoredRecord, Tries};

/// Counts over all scenarios that a model wrote attacks for.
#[derive(Debug, Default)]
pub struct ModelFigures {
    /// Answers, and how many of them were in the store.
    requests: u32,
    stored: u32,
    tokens: u64,
    usd: f64,
    unpriced: u32,
    tries: Tries,
    /// Scenarios in which both rankings were compared, and those of them in which they agree.
    compared: usize,
    agreed: usize,
    /// Scenarios in which they would agree, on average, if one of the model's answers were drawn by lot.
    by_chance: f64,
}

impl ModelFigures {
    pub fn count(&mut self, consumed: &AuthoredRecord) {
        self.requests += consumed.requests;
        self.stored += consumed.from_store;
        self.tokens += consumed.input_tokens + consumed.output_tokens;
        self.usd += consumed.cost_usd;
        self.unpriced += consumed.unpriced;
        let tries = consumed.tries;
        self.tries.conversations += tries.conversations;
        self.tries.first_admitted += tries.first_admitted;
        self.tries.first_effective += tries.first_effective;
        self.tries.effective += tries.effective;
        if let Some(agreed) = consumed.agreement {
            self.compared += 1;
            self.agreed += usize::from(agreed.agrees);
            self.by_chance += agreed.by_chance;
        }
    }

    /// Describes the figures; nothing where no model was asked.
    pub fn words(&self) -> String {
        if self.requests == 0 {
            return String::new();
        }
        let mut text = String::new();
        let Tries {
            conversations,
            first_admitted,
            first_effective,
            effective,
        } = self.tries;
        if conversations > 0 {
            text.push_str(&format!(
                "{}: first answers that pass the gate {first_admitted}, effective and survivable {first_effective}; after retries {effective}\n",
                counted(conversations, "conversation"),
            ));
        }
        if self.compared > 0 {
            text.push_str(&format!(
                "the model's grades and the exact ranking prefer the same motion in {} of {} (by chance in {:.1})\n",
                self.agreed,
                counted(self.compared, "scenario"),
                self.by_chance
            ));
        }
        text + &self.consumed()
    }

    fn consumed(&self) -> String {
        let sent = self.requests.saturating_sub(self.stored);
        let cost = match self.unpriced {
            0 => format!("{:.4} USD", self.usd),
            n if n >= self.requests => "price unknown".into(),
            n => format!(
                "{:.4} USD, plus {} without a known price",
                self.usd,
                counted(n as usize, "answer")
            ),
        };
        let stored = match self.stored {
            0 => String::new(),
            n => format!(
                ", {} from the store (counted here, paid before)",
                counted(n as usize, "answer")
            ),
        };
        let sent = counted(sent as usize, "request");
        format!("{sent}{stored}; {} tokens, {cost}\n", self.tokens)
    }

    /// The figures for programs.
    pub fn report(&self) -> ModelsReport {
        ModelsReport {
            requests: self.requests,
            from_store: self.stored,
            tokens: self.tokens,
            cost_usd: self.usd,
            unpriced: self.unpriced,
            tries: self.tries,
            agreement: AgreementReport {
                compared: self.compared,
                agreed: self.agreed,
                share: (self.compared > 0).then(|| self.agreed as f64 / self.compared as f64),
                by_chance: self.by_chance,
            },
        }
    }
}

/// What models did in all scenarios.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ModelsReport {
    /// Answers of models.
    requests: u32,
    /// Of these, answers from the store.
    from_store: u32,
    /// Tokens of prompts and answers.
    tokens: u64,
    /// Cost of answers with a known price, US dollars.
    cost_usd: f64,
    /// Answers without a known price.
    unpriced: u32,
    /// Conversations with a model: how many of their first answers pass the gate, and have an effect that a good driver
    /// survives.
    tries: Tries,
    /// Scenarios in which the model's grades and the exact ranking were compared.
    agreement: AgreementReport,
}

/// In how many scenarios the model's grades and the exact ranking prefer the same motion.
#[derive(Debug, PartialEq, Serialize, JsonSchema)]
struct AgreementReport {
    compared: usize,
    agreed: usize,
    share: Option<f64>,
    /// In how many they would by chance.
    by_chance: f64,
}

#[cfg(test)]
mod tests {
    use nearmiss_study::evaluation::generating::AgreementRecord;

    use super::*;

    fn consumed(tries: Tries, agreement: Option<AgreementRecord>) -> AuthoredRecord {
        AuthoredRecord {
            requests: 4,
            from_store: 1,
            input_tokens: 30,
            output_tokens: 3,
            cost_usd: 0.5,
            tries,
            agreement,
            ..AuthoredRecord::default()
        }
    }

    #[test]
    fn first_tries_and_agreement_are_summed_up() {
        let tries = Tries {
            conversations: 2,
            first_admitted: 2,
            first_effective: 1,
            effective: 2,
        };
        let agreement = |agrees: bool, by_chance: f64| AgreementRecord {
            agrees,
            of: 2,
            by_chance,
            ..AgreementRecord::default()
        };
        let mut figures = ModelFigures::default();
        assert_eq!(figures.words(), "");
        figures.count(&consumed(tries, Some(agreement(true, 0.5))));
        figures.count(&consumed(tries, Some(agreement(false, 0.25))));
        // No motion of its own to compare.
        figures.count(&consumed(Tries::default(), None));
        let report = figures.report();
        assert_eq!(report.tries.first_effective, 2);
        let agreement = AgreementReport {
            compared: 2,
            agreed: 1,
            share: Some(0.5),
            by_chance: 0.75,
        };
        assert_eq!(report.agreement, agreement);
        let words = figures.words();
        assert!(
            words.contains("the same motion in 1 of 2 scenarios"),
            "{words}"
        );
        assert!(
            words.contains("4 conversations: first answers that pass the gate 4, "),
            "{words}"
        );
        assert!(words.ends_with("9 requests, 3 answers from the store (counted here, paid before); 99 tokens, 1.5000 USD\n"));
    }
}
