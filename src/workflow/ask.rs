//! Asks one question of one model, and lists the models available; requests for a text, stored before they are used.

use std::sync::Arc;

use futures_util::StreamExt;
use jiff::civil::Date;
use nearmiss_ask::llm::{
    self, Budget, Chunk, Client, Effort, Environment, Finish, Parameters, Registry, RegistryError,
    Request,
};
use nearmiss_settings::Config;
use nearmiss_store::{Consumed, Key, NewReflection, Reflection, Store, StoreError};
use nearmiss_study::evaluation::{
    self, Answer, AskError, Event, Judge, ModelJudge, Question, RunOptions,
};
use serde_json::{Value, json};

/// The models that can be asked, with a shared connection pool and budget.
#[derive(Debug)]
pub struct Models {
    registry: Registry,
    environment: Environment,
    client: Client,
    parameters: Parameters,
    budget: Option<Budget>,
}

/// Request parameters beside the messages, as config.toml has them.
#[must_use]
pub fn parameters(config: &Config) -> Parameters {
    Parameters {
        temperature: config.temperature,
        max_tokens: config.max_tokens,
        seed: None,
        effort: config.effort.as_deref().and_then(Effort::parse),
        log_probabilities: config.log_probabilities,
        tools: None,
    }
}

/// A server that replaces the provider's own.
#[derive(Debug, Clone, Copy, Default)]
pub struct Server<'a> {
    /// Its address.
    pub url: &'a str,
    /// Its dialect; the provider's if none is named.
    pub dialect: Option<&'a str>,
    /// Environment variable with its key; the provider's if none is named.
    pub key_env: Option<&'a str>,
}

impl Models {
    /// Models of these providers, asked with these parameters; together, requests cost at most `budget` US dollars.
    #[must_use]
    pub fn new(
        registry: Registry,
        environment: Environment,
        parameters: Parameters,
        budget: Option<f64>,
    ) -> Self {
        Self::within(registry, environment, parameters, budget.map(Budget::new))
    }

    /// The same within a budget that others may share.
    #[must_use]
    pub fn within(
        registry: Registry,
        environment: Environment,
        parameters: Parameters,
        budget: Option<Budget>,
    ) -> Self {
        Self {
            registry,
            environment,
            client: Client::new(),
            parameters,
            budget,
        }
    }

    /// The budget, which its clones share; `None` if there is none.
    #[must_use]
    pub fn budget(&self) -> Option<Budget> {
        self.budget.clone()
    }

    /// The judge with a model id, or the built-in one. A missing key is an error only once the model is asked.
    ///
    /// # Errors
    /// The id or its provider is not known.
    pub fn judge(&self, id: &str) -> Result<Judge, RegistryError> {
        let (registry, environment) = (&self.registry, &self.environment);
        let mut judge = Judge::resolve(id, registry, &self.client, self.parameters, environment)?;
        if let Judge::Model(model) = &mut judge {
            model.endpoint.budget.clone_from(&self.budget);
        }
        Ok(judge)
    }

    /// A warning that a model is retired or will be, or is probably mistyped.
    #[must_use]
    pub fn warning(&self, id: &str, today: Date) -> Option<String> {
        let retirement = self.registry.retirement(id);
        let retired = retirement.and_then(|end| end.warning(today));
        retired.or_else(|| self.registry.unlisted(id))
    }

    /// Where a model's key is from, if that is a file of the current folder ([`Registry::key_of_folder`]).
    #[must_use]
    pub fn key_of_folder(&self, id: &str) -> Option<String> {
        self.registry.key_of_folder(id, &self.environment)
    }

    /// The providers.
    #[must_use]
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Keys and other settings from the environment.
    #[must_use]
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Remaining budget, US dollars; `None` if there is none.
    #[must_use]
    pub fn budget_left(&self) -> Option<f64> {
        self.budget.as_ref().map(Budget::left)
    }
}

impl Server<'_> {
    /// Replaces a provider's own server by this one.
    pub fn overlay(&self, providers: &mut toml::Table, provider: &str) {
        let entry = providers
            .entry(provider)
            .or_insert_with(|| toml::Table::new().into());
        let Some(table) = entry.as_table_mut() else {
            return;
        };
        table.insert("base_url".into(), self.url.into());
        if let Some(dialect) = self.dialect {
            table.insert("dialect".into(), dialect.into());
        }
        if let Some(variable) = self.key_env {
            // This key and no other.
            table.remove("key_command");
            table.insert("key_env".into(), variable.into());
        }
    }
}

/// One question to one model.
#[derive(Debug)]
pub struct AskRequest<'a> {
    /// The rendered question.
    pub question: &'a Question,
    /// The model, or the built-in judge.
    pub judge: &'a Judge,
    /// The store for the answer, also searched for an existing one; `None` to store nothing.
    pub store: Option<Arc<Store>>,
    /// Which answer to use.
    pub options: RunOptions,
}

/// The answer.
#[derive(Debug)]
pub struct AskOutcome {
    /// The answer, whatever it says.
    pub answer: Answer,
    /// Why the answer is not stored, and where it is instead; `None` if it is stored or was not to be.
    pub not_stored: Option<String>,
}

/// Asks the question. Every chunk of the answer is stored before `on_event` receives it. Dropping the future cancels
/// the request and records that in the store.
///
/// # Errors
/// See [`AskError`]: nothing was sent, or the store failed before anything was.
pub async fn ask(
    request: AskRequest<'_>,
    mut on_event: impl FnMut(Event),
) -> Result<AskOutcome, AskError> {
    let AskRequest {
        question,
        judge,
        store,
        options,
    } = request;
    let mut not_stored = None;
    let answer = evaluation::run(question, judge, store, &options, |event| {
        if let Event::NotStored(why) = &event {
            not_stored = Some(why.clone());
        }
        on_event(event);
    })
    .await?;
    Ok(AskOutcome { answer, not_stored })
}

/// The word of the store for an answer that was cut off.
const CUT_OFF: &str = "length";

/// The text of an answer, or why it is of no use.
pub(crate) type Text = Result<String, String>;

/// Why there is no answer.
#[derive(Debug)]
pub(crate) enum TextError {
    /// Nothing more can be asked of this model: the budget, the key, or the server.
    Stopped(String),
    /// This request failed.
    Failed(String),
    /// The store refused.
    Store(StoreError),
}

impl From<StoreError> for TextError {
    fn from(error: StoreError) -> Self {
        Self::Store(error)
    }
}

/// A request for a text.
pub(crate) struct TextQuestion<'a> {
    model: &'a ModelJudge,
    request: Request,
    /// Which of several answers to it, from 0.
    sample: u32,
    sent: Value,
    key: Key,
}

impl<'a> TextQuestion<'a> {
    pub fn new(model: &'a ModelJudge, request: Request, sample: u32) -> Self {
        let sent = json!({
            "model": model.id,
            "messages": request.messages,
            "parameters": request.parameters,
            "schema": request.schema.as_ref().map(|schema| &schema.schema),
        });
        Self {
            model,
            request,
            sample,
            key: Key::digest(&sent),
            sent,
        }
    }

    /// The answer of the store.
    pub fn stored(&self, store: &Store) -> Result<Option<Text>, StoreError> {
        Ok(store.reflection(&self.key, self.sample)?.map(complete_text))
    }

    /// A new answer.
    pub async fn ask(self, store: &Store) -> Result<(Text, Consumed), TextError> {
        let (client, endpoint) = (&self.model.client, &self.model.endpoint);
        let stopped =
            |error: &llm::Error| TextError::Stopped(format!("{}: {error}", self.model.id));
        if let Err(error) = llm::check(client, endpoint, &self.request).await {
            return Err(stopped(&error));
        }
        let id = store.begin_reflection(&NewReflection {
            key: self.key,
            sample: self.sample,
            model: self.model.id.clone(),
            request: self.sent.to_string(),
            most_usd: endpoint.at_most(&self.request),
        })?;
        let mut chunks = llm::stream(client, endpoint.clone(), self.request);
        let (mut answer, mut consumed, mut begun) = (String::new(), Consumed::default(), false);
        let mut finish = None;
        while let Some(chunk) = chunks.next().await {
            match chunk {
                Ok(Chunk::Started { .. }) => begun = true,
                Ok(Chunk::Text(text)) => answer.push_str(&text),
                Ok(Chunk::Usage(usage)) => {
                    consumed.input_tokens = usage.input_tokens;
                    consumed.output_tokens = usage.output_tokens;
                    consumed.cost_usd = usage.cost.map(|cost| cost.usd);
                }
                Ok(Chunk::Finished(end)) => finish = Some(end),
                Ok(_) => {}
                Err(error) => {
                    let was_sent = begun || !error.before_sending();
                    store.fail_reflection(id, &error.to_string(), was_sent)?;
                    let nothing_more = error.barrier().is_some() && !begun;
                    return Err(match error {
                        llm::Error::Budget { .. } => stopped(&error),
                        _ if nothing_more => stopped(&error),
                        _ => TextError::Failed(format!("no answer: {error}")),
                    });
                }
            }
        }
        let found = Reflection {
            answer,
            finish: match finish {
                Some(Finish::Length | Finish::TooLong) => CUT_OFF.into(),
                _ => "stop".into(),
            },
            consumed,
        };
        store.finish_reflection(id, &found)?;
        let consumed = found.consumed;
        Ok((complete_text(found), consumed))
    }
}

/// The text of an answer; one that was cut off is not whole.
fn complete_text(found: Reflection) -> Text {
    if found.finish == CUT_OFF {
        Err("the answer ran into the token limit".into())
    } else {
        Ok(found.answer)
    }
}
