//! Who answers the questions of a batch: its models, with server, parameters and budget, and which of them are paused.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU32;
use std::path::Path;

use jiff::civil::Date;
use nearmiss_ask::llm::{Budget, Environment, ProviderOutage, Registry};
use nearmiss_scene::judge;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_study::evaluation::{Judge, Judges};

use crate::{Models, Server};

/// How the models of a batch are reached.
#[derive(Debug)]
pub struct BatchModels<'a> {
    /// The user's providers, as config.toml has them.
    pub providers: &'a toml::Table,
    /// That file, for messages.
    pub config_file: &'a Path,
    /// Keys.
    pub environment: Environment,
    /// What all requests together may cost; `None` without a bound.
    pub budget: Option<Budget>,
    /// Requests to each provider at once, in the place of the providers' own numbers.
    pub concurrency: Option<NonZeroU32>,
    /// The day, for warnings about retired models.
    pub today: Date,
}

impl BatchModels<'_> {
    /// The judges of these models, for what a batch asks; they share one pool of connections, and the budget.
    ///
    /// # Errors
    /// A model or its provider is not known, or cannot be asked in a batch: in words.
    pub fn judges(
        self,
        models: &[String],
        spec: &Spec,
        on_warning: &mut dyn FnMut(String),
    ) -> Result<Judges, String> {
        let mut providers = self.providers.clone();
        let experiment = &spec.experiment;
        if let Some(url) = &experiment.base_url {
            let server = Server {
                url,
                dialect: experiment.dialect.as_deref(),
                key_env: experiment.key_env.as_deref(),
            };
            for model in models.iter().filter(|model| *model != judge::MODEL) {
                server.overlay(&mut providers, model.split('/').next().unwrap_or_default());
            }
        }
        let known = Models::within(
            Registry::lenient(&providers, self.config_file),
            self.environment,
            spec.experiment.parameters(),
            self.budget,
        );
        // A provider that is asked reports its own mistake.
        let asked = |name: &str| models.iter().any(|id| id.split('/').next() == Some(name));
        let broken = known.registry().broken().filter(|(name, _)| !asked(name));
        broken.for_each(|(_, why)| on_warning(why.to_string()));
        let keys = models.iter().filter_map(|id| known.key_of_folder(id));
        keys.collect::<BTreeSet<_>>()
            .into_iter()
            .for_each(&mut *on_warning);
        let mut judges = Judges::new();
        for id in models {
            if id.starts_with("reference/") && id != judge::MODEL {
                return Err(format!(
                    "--model {id}: not available in a batch; of the built-in models only {} is",
                    judge::MODEL
                ));
            }
            if let Some(warning) = known.warning(id, self.today) {
                on_warning(format!("{id}: {warning}"));
            }
            let mut judge = known.judge(id).map_err(|error| error.to_string())?;
            if let (Judge::Model(model), Some(_)) = (&mut judge, self.concurrency) {
                model.endpoint.limits.concurrency = self.concurrency;
            }
            judges.insert(id.clone(), judge);
        }
        Ok(judges)
    }
}

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
    pub fn summary(&self) -> String {
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
    pub fn record_outcome(&mut self, model: &str, met: Option<(ProviderOutage, String)>) {
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
            watch.record_outcome("lab/a", met(ProviderOutage::Silence));
        }
        watch.record_outcome("lab/b", None);
        for _ in 1..IN_A_ROW {
            watch.record_outcome("lab/a", met(ProviderOutage::Silence));
            assert!(!watch.holds("lab/a"));
        }
        watch.record_outcome("lab/b", met(ProviderOutage::Silence));
        assert!(watch.holds("lab/a") && watch.holds("lab/b"), "one server");
        // One that was on its way.
        watch.record_outcome("lab/b", met(ProviderOutage::Silence));
        let paused = watch.over();
        assert_eq!((&*paused[0].who, paused[0].open), ("lab", 2));
        assert_eq!((paused.len(), paused[0].after), (1, IN_A_ROW + 1));
    }

    #[test]
    fn a_refusal_pauses_its_model_at_once_and_a_forbidden_question_alone_does_not() {
        let mut watch = Watch::new("lab".into());
        watch.record_outcome("lab/a", met(ProviderOutage::Refused));
        assert!(watch.holds("lab/a") && !watch.holds("lab/b"));
        for times in 1..=IN_A_ROW {
            assert!(!watch.holds("lab/b"), "{times}");
            watch.record_outcome("lab/b", met(ProviderOutage::Forbidden));
        }
        assert!(watch.holds("lab/b"));
        let who: Vec<_> = watch.over().into_iter().map(|paused| paused.who).collect();
        assert_eq!(who, ["lab/a", "lab/b"]);
    }
}
