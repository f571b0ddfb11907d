//! The context shared by all batches: configuration, templates, thresholds, store and models.

use std::num::NonZeroU32;
use std::path::Path;
use std::sync::Arc;

use super::options::Options;
use crate::open::{configuration, user_thresholds};
use crate::templates::templates;
use crate::{Failure, output};
use nearmiss_ask::llm::{Budget, Environment};
use nearmiss_ask::prompts::Library;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Judges;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_workflow::ExperimentContext;
use nearmiss_workflow::batch::BatchModels;

/// The shared context of a batch.
pub struct BatchContext {
    pub folders: Folders,
    pub config: Config,
    pub library: Library,
    pub thresholds: Arc<Thresholds>,
    pub store: Arc<Store>,
}

impl BatchContext {
    /// Opens everything, and reports errors of templates.
    pub fn new() -> Result<Self, Failure> {
        let (folders, config) = configuration()?;
        let library = templates(&folders)?;
        let thresholds = Arc::new(user_thresholds(&folders)?);
        let store = Store::open(&folders.store()).map_err(Failure::input)?;
        Ok(Self {
            folders,
            config,
            library,
            thresholds,
            store: Arc::new(store),
        })
    }

    /// The most that a run may cost, US dollars.
    pub fn budget(&self, options: &Options) -> Option<f64> {
        options.budget.or(self.config.budget)
    }

    /// Who is asked; they share one pool of connections, and the budget.
    pub fn judges(
        &self,
        models: &[String],
        spec: &Spec,
        options: &Options,
    ) -> Result<Judges, Failure> {
        let models_of_batch = BatchModels {
            providers: &self.config.providers,
            config_file: &self.folders.config_file(),
            environment: Environment::with_files(&[Path::new("."), &self.folders.config]),
            budget: self.budget(options).map(Budget::new),
            concurrency: options.concurrency,
            today: jiff::Zoned::now().date(),
        };
        let mut warn = |warning: String| output::say(&format!("nearmiss: {warning}"));
        let judges = models_of_batch.judges(models, spec, &mut warn);
        judges.map_err(Failure::input)
    }

    /// What an experiment is run with.
    pub fn of_experiment(&self) -> ExperimentContext<'_> {
        ExperimentContext {
            library: &self.library,
            thresholds: &self.thresholds,
            store: &self.store,
        }
    }

    /// How many requests to each provider are on their way at once.
    pub fn concurrency(&self, options: &Options) -> NonZeroU32 {
        options.concurrency.unwrap_or(self.config.concurrency)
    }
}
