//! Judges: the built-in one, a language model behind an endpoint, or answers that were recorded elsewhere.

use std::borrow::Cow;
use std::collections::BTreeMap;

use nearmiss_ask::llm::{
    Client, Endpoint, Environment, Parameters, Registry, RegistryError, ToolLimits,
};
use nearmiss_scene::judge;
use nearmiss_store::{Key, Store, StoreError};

use super::AxisValues;
use super::ask_model::record;
use super::question::Question;
use super::run_case::RunOptions;

/// Judges by model id.
pub type Judges = BTreeMap<String, Judge>;

/// How the ids of models begin whose answers were recorded elsewhere and imported, and of those that are examples of this
/// program.
const STORED: [&str; 2] = ["recorded/", "example/"];

/// Whether a model is known by stored answers alone, and cannot be asked.
#[must_use]
pub fn is_stored_alone(model: &str) -> bool {
    STORED.iter().any(|begin| model.starts_with(begin))
}

/// A judge.
#[derive(Debug, Clone)]
pub enum Judge {
    /// The built-in reference judge.
    Reference,
    /// A language model.
    Model(Box<ModelJudge>),
    /// The imported answers of a model, `recorded/NAME`: nothing is sent.
    Recorded(String),
}

/// A language model and how it is asked.
#[derive(Debug, Clone)]
pub struct ModelJudge {
    /// `provider/model`.
    pub id: String,
    /// The name the server knows it by.
    pub name: String,
    /// The server.
    pub endpoint: Endpoint,
    /// The HTTP client.
    pub client: Client,
    /// Sampling parameters.
    pub parameters: Parameters,
}

impl Judge {
    /// The judge with a model id; its key is looked for in `environment`, and missed only when it is asked.
    ///
    /// # Errors
    /// The id or its provider is not known.
    pub fn resolve(
        id: &str,
        registry: &Registry,
        client: &Client,
        parameters: Parameters,
        environment: &Environment,
    ) -> Result<Self, RegistryError> {
        if id == judge::MODEL {
            return Ok(Self::Reference);
        }
        if is_stored_alone(id) {
            return Ok(Self::Recorded(id.to_string()));
        }
        let (endpoint, name) = registry.resolve(id, environment)?;
        Ok(Self::Model(Box::new(ModelJudge {
            id: id.to_string(),
            name,
            endpoint,
            client: client.clone(),
            parameters,
        })))
    }

    /// The same judge, asked with these values of axes.
    #[must_use]
    pub fn under(&self, values: &AxisValues) -> Cow<'_, Self> {
        match self {
            Self::Model(model) if !values.is_empty() => {
                let mut model = model.clone();
                model.parameters = values.parameters(model.parameters);
                Cow::Owned(Self::Model(model))
            }
            _ => Cow::Borrowed(self),
        }
    }

    /// The same judge, which may call tools as often; `None` without any.
    #[must_use]
    pub fn with_tools(mut self, tools: Option<ToolLimits>) -> Self {
        if let Self::Model(model) = &mut self {
            model.parameters.tools = tools;
        }
        self
    }

    /// Whether it may call tools.
    #[must_use]
    pub fn calls_tools(&self) -> bool {
        matches!(self, Self::Model(model) if model.parameters.tools.is_some())
    }

    /// The model id.
    #[must_use]
    pub fn id(&self) -> &str {
        match self {
            Self::Reference => judge::MODEL,
            Self::Model(model) => &model.id,
            Self::Recorded(id) => id,
        }
    }
}

/// Whether the store has the answer of `judge` to a question, whose request has this key; of a recorded model that has
/// none, why it cannot be asked.
///
/// # Errors
/// The store cannot be read.
pub fn has_answer(
    question: &Question,
    (judge, key): (&Judge, Option<&Key>),
    sample: u32,
    store: &Store,
) -> Result<Result<bool, String>, StoreError> {
    if let Some(key) = key {
        return Ok(Ok(store.has_answer(key, sample)?));
    }
    if !matches!(judge, Judge::Recorded(_)) {
        return Ok(Ok(false));
    }
    let wanted = RunOptions {
        sample,
        ..RunOptions::default()
    };
    let found = store.recorded_answer(&record(question, judge, &wanted)?)?;
    Ok(match found {
        Some(_) => Ok(true),
        None => Err(not_recorded(question)),
    })
}

/// Why a recorded model has no answer to a question.
pub fn not_recorded(question: &Question) -> String {
    let case = &question.case;
    format!(
        "no recorded answer ({}, {} frame, {}); see `nearmiss runs import` and --set protocol=paper",
        case.task.name(),
        case.frame.name(),
        case.techniques,
    )
}
