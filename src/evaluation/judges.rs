//! Judges: the built-in one, or a language model behind an endpoint.

use std::collections::BTreeMap;

use crate::judge;
use crate::llm::{Client, Endpoint, Environment, Parameters, Registry, RegistryError};

/// Judges by model id.
pub type Judges = BTreeMap<String, Judge>;

/// A judge.
#[derive(Debug, Clone)]
pub enum Judge {
    /// The built-in reference judge.
    Reference,
    /// A language model.
    Model(Box<ModelJudge>),
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
        let (endpoint, name) = registry.resolve(id, environment)?;
        Ok(Self::Model(Box::new(ModelJudge {
            id: id.to_string(),
            name,
            endpoint,
            client: client.clone(),
            parameters,
        })))
    }

    /// The model id.
    #[must_use]
    pub fn id(&self) -> &str {
        match self {
            Self::Reference => judge::MODEL,
            Self::Model(model) => &model.id,
        }
    }
}
