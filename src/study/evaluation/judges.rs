//! Judges: the built-in one, a language model behind an endpoint, or answers that were recorded elsewhere.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::AxisValues;
use nearmiss_ask::llm::{
    Client, Endpoint, Environment, Parameters, Registry, RegistryError, ToolLimits,
};
use nearmiss_scene::judge;

/// Judges by model id.
pub type Judges = BTreeMap<String, Judge>;

/// How the ids of models begin whose answers were recorded elsewhere and imported.
pub const RECORDED: &str = "recorded/";

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
        if id.starts_with(RECORDED) {
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
