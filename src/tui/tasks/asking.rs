//! One question to one model, and the judges that can be asked.

use super::Tasks;
use super::job::Canceller;
use crate::message::{JobEvent, JobId, Msg, Update};
use nearmiss_ask::llm::ToolLimits;
use nearmiss_study::evaluation::{Judge, Question, RunOptions};
use nearmiss_workflow::{AskRequest, ask};

impl Tasks {
    /// The judge with a model id, which may call tools as often; all share the budget of the session.
    pub(super) fn judge(&self, model: &str, tools: Option<ToolLimits>) -> Result<Judge, String> {
        let judge = self
            .models
            .judge(model)
            .map_err(|error| error.to_string())?;
        Ok(judge.with_tools(tools))
    }

    /// Asks a question; its pieces and its end are told under this id.
    pub(super) fn ask(
        &mut self,
        id: JobId,
        question: Box<Question>,
        judge: Result<Judge, String>,
        fresh: bool,
    ) {
        let sender = self.sender.clone();
        let tell = move |update| drop(sender.send(Msg::Job(id, JobEvent::Question(update))));
        let judge = match judge {
            Ok(judge) => judge,
            Err(error) => {
                tell(Update::Ended(Err(error)));
                return;
            }
        };
        let store = self.store.clone();
        let task = tokio::spawn(async move {
            let request = AskRequest {
                question: &question,
                judge: &judge,
                store,
                options: RunOptions {
                    fresh,
                    ..RunOptions::default()
                },
            };
            let outcome = ask(request, |event| tell(Update::Progress(event)));
            let outcome = outcome
                .await
                .map(|outcome| Box::new(outcome.answer))
                .map_err(|error| error.to_string());
            tell(Update::Ended(outcome));
        });
        // Aborting the task closes the connection and writes the run down as cancelled.
        self.jobs.insert(id, Canceller::Abort, task.abort_handle());
    }
}
