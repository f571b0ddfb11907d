//! Paused models: those whose server does not answer, or accepts none of their questions.

use std::collections::BTreeMap;

use nearmiss_ask::llm::ProviderOutage;

/// Questions in a row without an answer that pause a provider. Each had all its tries.
const IN_A_ROW: usize = 5;

/// A model whose questions are left open, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PausedModel {
    /// The model as `provider/model`; a provider alone where none of its models can be reached.
    pub who: String,
    /// Questions in a row that brought it about.
    pub after: usize,
    /// What the last of them met.
    pub why: String,
    /// Questions that were not asked because of it.
    pub open: usize,
}

impl PausedModel {
    /// Whether a model is meant, by itself or with its provider.
    #[must_use]
    pub fn holds(&self, model: &str) -> bool {
        let provider = model.split('/').next();
        self.who == model || provider == Some(self.who.as_str())
    }

    /// Who was not asked further, and why.
    #[must_use]
    pub fn words(&self) -> String {
        let after = match self.after {
            1 => "after one rejected question".to_string(),
            after => format!("after {after} questions in a row without an answer"),
        };
        let open = match self.open {
            1 => "1 question stays open".to_string(),
            open => format!("{open} questions stay open"),
        };
        format!(
            "{}: not asked further {after}: {}; {open}",
            self.who, self.why
        )
    }
}

/// Consecutive outages of one provider.
#[derive(Debug)]
pub(super) struct Watch {
    provider: String,
    silent: usize,
    forbidden: BTreeMap<String, usize>,
    paused: Vec<PausedModel>,
}

impl Watch {
    pub fn new(provider: String) -> Self {
        Self {
            provider,
            silent: 0,
            forbidden: BTreeMap::new(),
            paused: Vec::new(),
        }
    }

    /// Records the outcome of a question: the outage it met, if any, and its description.
    pub fn hear(&mut self, model: &str, met: Option<(ProviderOutage, String)>) {
        let Some((barrier, why)) = met else {
            self.silent = 0;
            self.forbidden.remove(model);
            return;
        };
        let (who, after) = match barrier {
            ProviderOutage::Silence => {
                self.silent += 1;
                (self.provider.clone(), self.silent)
            }
            ProviderOutage::Forbidden => {
                self.silent = 0;
                let times = self.forbidden.entry(model.to_string()).or_default();
                *times += 1;
                (model.to_string(), *times)
            }
            ProviderOutage::Refused => {
                self.silent = 0;
                (model.to_string(), 1)
            }
        };
        if after < IN_A_ROW && barrier != ProviderOutage::Refused {
            return;
        }
        match self.paused.iter_mut().find(|paused| paused.who == who) {
            // Questions that were on their way when it was paused.
            Some(known) => known.after = known.after.max(after),
            None => self.paused.push(PausedModel {
                who,
                after,
                why,
                open: 0,
            }),
        }
    }

    /// Whether a question to this model is left open; it is counted then.
    pub fn holds(&mut self, model: &str) -> bool {
        let provider = &self.provider;
        let mut paused = self.paused.iter_mut();
        let found = paused.find(|paused| paused.who == model || paused.who == *provider);
        found.is_some_and(|paused| {
            paused.open += 1;
            true
        })
    }

    /// Who is paused at the end.
    pub fn over(self) -> Vec<PausedModel> {
        self.paused
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn met(barrier: ProviderOutage) -> Option<(ProviderOutage, String)> {
        Some((barrier, "why".into()))
    }

    #[test]
    fn silence_pauses_a_provider_only_in_a_row() {
        let mut watch = Watch::new("lab".into());
        for _ in 1..IN_A_ROW {
            watch.hear("lab/a", met(ProviderOutage::Silence));
        }
        watch.hear("lab/b", None);
        for _ in 1..IN_A_ROW {
            watch.hear("lab/a", met(ProviderOutage::Silence));
            assert!(!watch.holds("lab/a"));
        }
        watch.hear("lab/b", met(ProviderOutage::Silence));
        assert!(watch.holds("lab/a") && watch.holds("lab/b"), "one server");
        // One that was on its way.
        watch.hear("lab/b", met(ProviderOutage::Silence));
        let paused = watch.over();
        assert_eq!((&*paused[0].who, paused[0].open), ("lab", 2));
        assert_eq!((paused.len(), paused[0].after), (1, IN_A_ROW + 1));
    }

    #[test]
    fn a_refusal_pauses_its_model_at_once_and_a_forbidden_question_alone_does_not() {
        let mut watch = Watch::new("lab".into());
        watch.hear("lab/a", met(ProviderOutage::Refused));
        assert!(watch.holds("lab/a") && !watch.holds("lab/b"));
        for times in 1..=IN_A_ROW {
            assert!(!watch.holds("lab/b"), "{times}");
            watch.hear("lab/b", met(ProviderOutage::Forbidden));
        }
        assert!(watch.holds("lab/b"));
        let who: Vec<_> = watch.over().into_iter().map(|paused| paused.who).collect();
        assert_eq!(who, ["lab/a", "lab/b"]);
    }
}
