//! Asks the reflecting model; its answers are in the store before they are used.

use std::sync::Arc;

use super::ask::Halt;
use super::outcome::Usage;
use super::proposal;
use crate::batch::BatchControl;
use crate::text_question::{TextError, TextQuestion};
use nearmiss_ask::llm::{Message, Request, Schema};
use nearmiss_store::Store;
use nearmiss_study::evaluation::ModelJudge;

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
        let question = TextQuestion::new(&self.model, self.request(messages), sample);
        if let Some(found) = question.stored(&self.store)? {
            usage.reflections_stored += 1;
            return Ok(found);
        }
        if self.control.is_stopped() {
            return Err(Halt::Interrupted);
        }
        match question.ask(&self.store).await {
            Ok(answer) => {
                usage.reflections += 1;
                Ok(answer)
            }
            Err(TextError::Failed(why)) => Ok(Err(why)),
            Err(TextError::Stopped(why)) => Err(Halt::Stopped(why)),
            Err(TextError::Store(error)) => Err(Halt::Store(error)),
        }
    }
}
