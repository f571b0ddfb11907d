//! Asks the reflecting model; its answers are in the store before they are used.

use std::sync::Arc;

use futures_util::StreamExt;
use serde_json::json;

use super::ask::Halt;
use super::outcome::Usage;
use super::proposal;
use crate::batch::BatchControl;
use nearmiss_ask::llm::{self, Chunk, Finish, Message, Request, Schema};
use nearmiss_store::{Consumed, Key, NewReflection, Reflection, Store};
use nearmiss_study::evaluation::ModelJudge;

/// The word of the store for an answer that was cut off.
const CUT_OFF: &str = "length";

/// Who proposes templates.
pub(super) struct Reflector {
    pub model: Box<ModelJudge>,
    pub store: Arc<Store>,
    pub control: BatchControl,
}

impl Reflector {
    /// The request that is sent.
    pub fn request(&self, messages: Vec<Message>) -> Request {
        Request {
            model: self.model.name.clone(),
            messages,
            parameters: self.model.parameters,
            schema: Some(Schema {
                is_bounded: false,
                name: "template_proposal".into(),
                schema: proposal::schema(),
            }),
            tools: None,
        }
    }

    /// The answer to these messages: that of the store, or a new one; or why none came.
    ///
    /// # Errors
    /// See [`Halt`].
    pub async fn ask(
        &self,
        messages: Vec<Message>,
        sample: u32,
        usage: &mut Usage,
    ) -> Result<Result<String, String>, Halt> {
        let request = self.request(messages);
        let sent = json!({
            "model": self.model.id,
            "messages": request.messages,
            "parameters": request.parameters,
            "schema": proposal::schema(),
        });
        let key = Key::digest(&sent);
        if let Some(found) = self.store.reflection(&key, sample)? {
            usage.reflections_stored += 1;
            return Ok(read(found));
        }
        if self.control.is_stopped() {
            return Err(Halt::Interrupted);
        }
        let (client, endpoint) = (&self.model.client, &self.model.endpoint);
        let stopped = |error: &llm::Error| Halt::Stopped(format!("{}: {error}", self.model.id));
        if let Err(error) = llm::check(client, endpoint, &request).await {
            return Err(stopped(&error));
        }
        let id = self.store.begin_reflection(&NewReflection {
            key,
            sample,
            model: self.model.id.clone(),
            request: sent.to_string(),
            most_usd: endpoint.at_most(&request),
        })?;
        let mut chunks = llm::stream(client, endpoint.clone(), request);
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
                    self.store
                        .fail_reflection(id, &error.to_string(), was_sent)?;
                    let nothing_more = error.barrier().is_some() && !begun;
                    return match error {
                        llm::Error::Budget { .. } => Err(stopped(&error)),
                        _ if nothing_more => Err(stopped(&error)),
                        _ => Ok(Err(format!("no answer: {error}"))),
                    };
                }
            }
        }
        usage.reflections += 1;
        let found = Reflection {
            answer,
            finish: match finish {
                Some(Finish::Length | Finish::TooLong) => CUT_OFF.into(),
                _ => "stop".into(),
            },
            consumed,
        };
        self.store.finish_reflection(id, &found)?;
        Ok(read(found))
    }
}

/// What an answer says; one that was cut off says no whole template.
fn read(found: Reflection) -> Result<String, String> {
    if found.finish == CUT_OFF {
        Err("the answer ran into the token limit".into())
    } else {
        Ok(found.answer)
    }
}
