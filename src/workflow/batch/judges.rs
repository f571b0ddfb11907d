//! Who answers the questions of a batch: its models, with its server, its parameters and a budget.

use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::path::Path;

use jiff::civil::Date;

use crate::{Models, Server};
use nearmiss_ask::llm::{Budget, Environment, Registry};
use nearmiss_scene::judge;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_study::evaluation::{Judge, Judges};

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
