//! Attacks that a language model writes: who is asked, and what it took.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::{Value, json};
use tokio::runtime::{Builder, Runtime};

use super::GenerateArguments;
use crate::cli::open::user_thresholds;
use crate::cli::{Failure, output};
use crate::config::{Config, Folders};
use crate::evaluation::batch::Spec;
use crate::evaluation::generating::{Author, AuthorError, Authored, write};
use crate::evaluation::{Judge, Settings, usable};
use crate::generation::{Made, Workshop, WorkshopError};
use crate::judge;
use crate::llm::{Budget, Client, Effort, Environment, Parameters, Registry};
use crate::prompts::Library;
use crate::scenario::Scene;
use crate::store::Store;

/// The model, ready to be asked.
pub struct Writer {
    author: Author,
    parameters: Parameters,
    runtime: Runtime,
}

/// Why a model made nothing.
#[derive(Debug, thiserror::Error)]
pub enum WriterError {
    /// Nothing can be attacked.
    #[error(transparent)]
    Workshop(#[from] WorkshopError),
    /// Nothing could be asked.
    #[error(transparent)]
    Author(#[from] AuthorError),
    /// It was not waited for; what was answered is in the store.
    #[error("interrupted")]
    Interrupted,
}

/// How soon an interrupt is noticed while a model answers.
const PATIENCE: Duration = Duration::from_millis(50);

/// Until the user wants no more.
async fn stopped(stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        tokio::time::sleep(PATIENCE).await;
    }
}

impl Writer {
    /// The model that the arguments name.
    pub fn new(
        arguments: &GenerateArguments,
        folders: &Folders,
        config: &Config,
    ) -> Result<Self, Failure> {
        let model = &arguments.model;
        if model == judge::MODEL {
            return Err(Failure::input(format!(
                "{model} answers no question about attacks; --model search works without any model"
            )));
        }
        let environment = Environment::with_files(&[Path::new("."), &folders.config]);
        let mut providers = config.providers.clone();
        if let Some(url) = &arguments.base_url {
            let name = model.split('/').next().unwrap_or_default();
            let entry = providers.entry(name);
            let entry = entry.or_insert_with(|| toml::Table::new().into());
            if let Some(table) = entry.as_table_mut() {
                table.insert("base_url".into(), url.clone().into());
            }
        }
        let registry = Registry::lenient(&providers, &folders.config_file());
        let parameters = Parameters {
            temperature: config.temperature,
            max_tokens: config.max_tokens,
            seed: None,
            effort: config.effort.as_deref().and_then(Effort::parse),
        };
        let client = Client::new();
        let mut judge = Judge::resolve(model, &registry, &client, parameters, &environment)
            .map_err(Failure::input)?;
        if let (Judge::Model(model), Some(usd)) = (&mut judge, arguments.budget.or(config.budget)) {
            model.endpoint.budget = Some(Budget::new(usd));
        }
        let library = usable(Library::load(Some(&folders.prompts())));
        for problem in &library.problems {
            output::say(&format!("nearmiss: {problem}"));
        }
        let store = Store::open(&folders.store()).map_err(Failure::input)?;
        let author = Author {
            name: String::new(),
            judge,
            store: Some(Arc::new(store)),
            library,
            thresholds: Arc::new(user_thresholds(folders)?),
            settings: Settings::default(),
            frame: None,
            samples: arguments.samples,
            retries: arguments.retries,
            at_once: config.concurrency.get() as usize,
            attacker: arguments.attacker,
            obey: arguments.obey,
            fresh: arguments.fresh,
            batch: None,
        };
        let runtime = Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .map_err(Failure::input)?;
        Ok(Self {
            author,
            parameters,
            runtime,
        })
    }

    /// Lets it write attacks on a scenario, drives the ego against those that pass the gate, and takes the most dangerous
    /// one that a good driver survives with a reaction time of `delay` seconds.
    pub fn write(
        &self,
        name: &str,
        workshop: &Workshop,
        delay: f64,
        stop: &AtomicBool,
    ) -> Result<(Made, Authored), WriterError> {
        let scenario = Arc::clone(workshop.closed.scenario());
        let scene = Arc::new(Scene::new(scenario, workshop.ego.clone()));
        let author = Author {
            name: name.into(),
            ..self.author.clone()
        };
        workshop.on(|ground| {
            let mut authored = self.runtime.block_on(async {
                tokio::select! {
                    written = write(&author, ground, &scene, &|_| {}) => Ok(written?),
                    () = stopped(stop) => Err(WriterError::Interrupted),
                }
            })?;
            let made = authored.made(ground, delay);
            Ok((made, authored))
        })?
    }

    /// All that decides what it is asked, and how often.
    pub fn settings(&self) -> Value {
        let author = &self.author;
        json!({
            "id": self.id(),
            "samples": author.samples,
            "retries": author.retries,
            "obey": author.obey,
            "parameters": self.parameters,
            "templates": author.templates(),
            "thresholds": Spec::thresholds_of(&author.thresholds),
        })
    }

    /// Its id.
    pub fn id(&self) -> &str {
        self.author.judge.id()
    }
}
