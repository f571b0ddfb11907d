//! A request for a text: its answer is in the store before it is used, and the same request is paid for once.

use futures_util::StreamExt;
use serde_json::{Value, json};

use nearmiss_ask::llm::{self, Chunk, Finish, Request};
use nearmiss_store::{Consumed, Key, NewReflection, Reflection, Store, StoreError};
use nearmiss_study::evaluation::ModelJudge;

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
        Ok(store.reflection(&self.key, self.sample)?.map(text_of))
    }

    /// A new answer.
    pub async fn ask(self, store: &Store) -> Result<Text, TextError> {
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
        Ok(text_of(found))
    }
}

/// The text of an answer; one that was cut off is not whole.
fn text_of(found: Reflection) -> Text {
    if found.finish == CUT_OFF {
        Err("the answer ran into the token limit".into())
    } else {
        Ok(found.answer)
    }
}
