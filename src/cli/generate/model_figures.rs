//! Figures of models over all scenarios: consumption, first tries, and how often both rankings agree.

use serde_json::{Value, json};

use super::line::Consumed;
use crate::output::counted;
use nearmiss_study::evaluation::generating::Tries;

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
    pub fn count(&mut self, consumed: &Consumed) {
        self.requests += consumed.requests;
        self.stored += consumed.from_store;
        self.tokens += consumed.input_tokens + consumed.output_tokens;
        self.usd += consumed.cost_usd;
        self.unpriced += consumed.unpriced;
        if let Some(tries) = consumed.tries {
            self.tries.conversations += tries.conversations;
            self.tries.first_admitted += tries.first_admitted;
            self.tries.first_effective += tries.first_effective;
            self.tries.effective += tries.effective;
        }
        if let Some(agreed) = consumed.agreement {
            self.compared += 1;
            self.agreed += usize::from(agreed.agrees);
            let even = 1.0 / agreed.of.max(1) as f64;
            self.by_chance += agreed.by_chance.unwrap_or(even);
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

    /// Adds the figures to the document of a report.
    pub fn add_to(&self, document: &mut Value) {
        document["requests"] = self.requests.into();
        document["from_store"] = self.stored.into();
        document["tokens"] = self.tokens.into();
        document["cost_usd"] = self.usd.into();
        document["unpriced"] = self.unpriced.into();
        document["tries"] = json!(self.tries);
        document["agreement"] = json!({
            "compared": self.compared,
            "agreed": self.agreed,
            "share": (self.compared > 0).then(|| self.agreed as f64 / self.compared as f64),
            "by_chance": self.by_chance,
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use serde::Deserialize;

    use super::*;

    fn consumed(tries: &Value, agreement: &Value) -> Consumed {
        let mut document = json!({
            "requests": 4, "from_store": 1, "input_tokens": 30, "output_tokens": 3, "cost_usd": 0.5, "unpriced": 0,
            "stopped": null,
        });
        document["tries"] = tries.clone();
        document["agreement"] = agreement.clone();
        Consumed::deserialize(&document).unwrap()
    }

    #[test]
    fn first_tries_and_agreement_are_summed_up() {
        let tries =
            json!({"conversations": 2, "first_admitted": 2, "first_effective": 1, "effective": 2});
        let mut figures = ModelFigures::default();
        assert_eq!(figures.words(), "");
        figures.count(&consumed(&tries, &json!({"agrees": true, "of": 2})));
        let twice = json!({"agrees": false, "of": 2, "by_chance": 0.25});
        figures.count(&consumed(&tries, &twice));
        // As versions before it wrote them.
        figures.count(&consumed(&Value::Null, &Value::Null));
        let mut document = json!({});
        figures.add_to(&mut document);
        assert_eq!(document["tries"]["first_effective"], 2);
        let agreement = json!({"compared": 2, "agreed": 1, "share": 0.5, "by_chance": 0.75});
        assert_eq!(document["agreement"], agreement);
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
