//! What every batch is made with: configuration, templates, thresholds, the store, and who is asked.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::batch::Options;
use crate::cli::open::{configuration, user_thresholds};
use crate::cli::{Failure, output};
use crate::evaluation::batch::{Desk, Judges, Matrix, Spec};
use crate::evaluation::{Judge, validate};
use crate::judge;
use crate::llm::{Budget, Client, Environment, Registry};
use crate::metrics::Thresholds;
use crate::prompts::Library;
use crate::settings::{Config, Folders};
use crate::store::Store;

/// What was opened.
pub struct Opened {
    pub folders: Folders,
    pub config: Config,
    pub library: Library,
    pub thresholds: Arc<Thresholds>,
    pub store: Arc<Store>,
}

impl Opened {
    /// Opens everything; what is wrong with templates is said.
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

    /// What makes the questions of a matrix.
    pub fn desk(&self, matrix: &Matrix) -> Arc<Desk> {
        Arc::new(Desk::new(
            self.library.clone(),
            Arc::clone(&self.thresholds),
            matrix.manner,
        ))
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
        let environment = Environment::with_files(&[Path::new("."), &self.folders.config]);
        let mut providers = self.config.providers.clone();
        if let Some(url) = &spec.base_url {
            for model in models.iter().filter(|model| *model != judge::MODEL) {
                let name = model.split('/').next().unwrap_or_default();
                let entry = providers.entry(name);
                let entry = entry.or_insert_with(|| toml::Table::new().into());
                if let Some(table) = entry.as_table_mut() {
                    table.insert("base_url".into(), url.clone().into());
                }
            }
        }
        let registry = Registry::lenient(&providers, &self.folders.config_file());
        let today = jiff::Zoned::now().date();
        let client = Client::new();
        let budget = self.budget(options).map(Budget::new);
        let mut judges = Judges::new();
        for id in models {
            if id.starts_with("reference/") && id != judge::MODEL {
                return Err(Failure::input(format!(
                    "--model {id}: it answers no questions; beside language models there is {}",
                    judge::MODEL
                )));
            }
            let end = registry.retirement(id);
            if let Some(warning) = end.and_then(|retirement| retirement.warning(today)) {
                output::say(&format!("nearmiss: {id}: {warning}"));
            }
            let parameters = spec.matrix.manner.parameters();
            let mut judge = Judge::resolve(id, &registry, &client, parameters, &environment)
                .map_err(Failure::input)?;
            if let Judge::Model(model) = &mut judge {
                model.endpoint.budget.clone_from(&budget);
                if options.concurrency.is_some() {
                    model.endpoint.limits.concurrency = options.concurrency;
                }
            }
            judges.insert(id.clone(), judge);
        }
        Ok(judges)
    }

    /// How many requests to each provider are on their way at once.
    pub fn at_once(&self, judges: &Judges, options: &Options) -> BTreeMap<String, usize> {
        let mut at_once = BTreeMap::new();
        for (id, judge) in judges {
            let usual = self.config.concurrency;
            let most = match judge {
                Judge::Reference => std::thread::available_parallelism().map_or(1, usize::from),
                Judge::Model(model) => {
                    let own = model.endpoint.limits.concurrency;
                    let own = own.map_or(usual, |own| own.min(usual));
                    options.concurrency.unwrap_or(own).get() as usize
                }
            };
            let provider = id.split('/').next().unwrap_or_default();
            at_once.insert(provider.to_string(), most);
        }
        at_once
    }
}
