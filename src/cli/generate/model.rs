//! Attacks written by a language model: which model, and what it consumed.

use std::path::Path;
use std::sync::Arc;

use serde_json::json;
use tokio::runtime::{Builder, Handle, Runtime};

use super::GenerateArguments;
use super::identity::WriterSettings;
use super::settings::AskSettings;
use crate::Failure;
use crate::open::{judge_of, user_thresholds};
use crate::templates::templates;
use nearmiss_ask::llm::{Effort, Environment, Parameters, Registry};
use nearmiss_scene::judge;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Settings;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_study::evaluation::generating::Author;
use nearmiss_workflow::{Models, Server};

/// The model, ready to ask.
pub struct Writer {
    author: Author,
    parameters: Parameters,
    runtime: Runtime,
}

impl Writer {
    /// The model that the arguments name.
    pub fn new(
        arguments: &GenerateArguments,
        asking: &AskSettings,
        folders: &Folders,
        config: &Config,
    ) -> Result<Self, Failure> {
        let model = &arguments.model;
        if model == judge::MODEL {
            return Err(Failure::input(format!(
                "{model} cannot answer attack questions; --model search needs no model"
            )));
        }
        let mut providers = config.provider.clone();
        if let Some(url) = &arguments.base_url {
            let server = Server {
                url,
                ..Server::default()
            };
            server.overlay(&mut providers, model.split('/').next().unwrap_or_default());
        }
        let parameters = Parameters {
            temperature: config.temperature,
            max_tokens: config.max_tokens,
            seed: None,
            effort: config.effort.as_deref().and_then(Effort::parse),
            log_probabilities: false,
            tools: None,
        };
        let models = Models::new(
            Registry::lenient(&providers, &folders.config_file()),
            Environment::with_files(&[Path::new("."), &folders.config]),
            parameters,
            arguments.budget.or(config.budget),
        );
        let judge = judge_of(&models, model)?;
        let library = templates(folders)?;
        let store = Store::open(&folders.store()).map_err(Failure::input)?;
        let author = Author {
            name: String::new(),
            judge,
            store: Some(Arc::new(store)),
            library,
            thresholds: Arc::new(user_thresholds(folders)?),
            settings: Settings::default(),
            frame: None,
            method: asking.method(config),
            at_once: config.concurrency as usize,
            attacker: arguments.attacker.first().copied(),
            obey: asking.obey,
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

    /// Who writes about the scenario of this name.
    pub fn author(&self, name: &str) -> Author {
        Author {
            name: name.into(),
            ..self.author.clone()
        }
    }

    /// What it is asked on.
    pub fn runtime(&self) -> Handle {
        self.runtime.handle().clone()
    }

    /// All that decides what it is asked, and how often.
    pub fn settings(&self) -> WriterSettings {
        let author = &self.author;
        WriterSettings {
            id: self.id().into(),
            method: author.method,
            obey: author.obey,
            parameters: json!(self.parameters),
            templates: author.templates(),
            thresholds: Spec::threshold_changes(&author.thresholds),
        }
    }

    /// Its id.
    pub fn id(&self) -> &str {
        self.author.judge.id()
    }
}
