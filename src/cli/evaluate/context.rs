//! The context shared by all batches: configuration, templates, thresholds, store and models.

use std::num::NonZeroU32;
use std::path::Path;
use std::sync::Arc;

use super::batch::Options;
use crate::cli::open::{configuration, user_thresholds};
use crate::cli::{Failure, output};
use crate::evaluation::batch::Spec;
use crate::evaluation::{Judge, Judges, validate};
use crate::judge;
use crate::llm::{Environment, Registry};
use crate::metrics::Thresholds;
use crate::prompts::Library;
use crate::settings::{Config, Folders};
use crate::store::Store;
use crate::workflow::{Models, Server};

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
        let library = validate(Library::load(Some(&folders.prompts())));
        for problem in &library.problems {
            output::say(&format!("nearmiss: {problem}"));
        }
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
        let mut providers = self.config.providers.clone();
        if let Some(url) = &spec.base_url {
            let server = Server {
                url,
                ..Server::default()
            };
            for model in models.iter().filter(|model| *model != judge::MODEL) {
                server.overlay(&mut providers, model.split('/').next().unwrap_or_default());
            }
        }
        let known = Models::new(
            Registry::lenient(&providers, &self.folders.config_file()),
            Environment::with_files(&[Path::new("."), &self.folders.config]),
            spec.matrix.request.parameters(),
            self.budget(options),
        );
        let today = jiff::Zoned::now().date();
        let mut judges = Judges::new();
        for id in models {
            if id.starts_with("reference/") && id != judge::MODEL {
                return Err(Failure::input(format!(
                    "--model {id}: not available in a batch; of the built-in models only {} is",
                    judge::MODEL
                )));
            }
            if let Some(warning) = known.warning(id, today) {
                output::say(&format!("nearmiss: {id}: {warning}"));
            }
            let mut judge = known.judge(id).map_err(Failure::input)?;
            if let (Judge::Model(model), Some(_)) = (&mut judge, options.concurrency) {
                model.endpoint.limits.concurrency = options.concurrency;
            }
            judges.insert(id.clone(), judge);
        }
        Ok(judges)
    }

    /// How many requests to each provider are on their way at once.
    pub fn concurrency(&self, options: &Options) -> NonZeroU32 {
        options.concurrency.unwrap_or(self.config.concurrency)
    }
}
