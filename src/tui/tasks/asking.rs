//! One question to one model, and the models that servers on this machine serve.

use crate::message::Effect;
use crate::model::{Job, JobId, JobKind, JobState, Model, Update};
use crate::request::{Replies, Request};
use crate::services::{Canceller, Services};
use crate::update::{answers, jobs};
use nearmiss_ask::llm::{Discovered, ToolLimits, probe};
use nearmiss_study::evaluation::{Answer, Event, Question, RunOptions};
use nearmiss_workflow::{AskRequest, ask};

/// Asks a model.
#[derive(Debug)]
pub struct Ask {
    /// Its number.
    pub id: JobId,
    /// The question.
    pub question: Box<Question>,
    /// The model, `provider/model`.
    pub model: String,
    /// How often it may call tools; `None` where it may not.
    pub tools: Option<ToolLimits>,
    /// Whether it is asked anew where the store has its answer.
    pub fresh: bool,
}

impl Request for Ask {
    /// Pieces of an answer; then the whole answer, or why the store refused.
    type Reply = (JobId, Update<Event, Box<Answer>>);

    fn sent(&self, model: &mut Model) {
        let title = format!("{} on {}", self.model, self.question.case.name);
        let mut job = Job::new(self.id, JobKind::Question, title, 1, model.uptime);
        job.state = JobState::Waiting(String::new());
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self {
            id,
            question,
            model,
            tools,
            fresh,
        } = self;
        let reply = move |update| {
            replies.send((id, update));
        };
        let judge = match services.judge(&model, tools) {
            Ok(judge) => judge,
            Err(error) => return reply(Update::Ended(Err(error))),
        };
        let store = services.store.clone();
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
            let outcome = ask(request, |event| reply(Update::Progress(event))).await;
            let outcome = outcome.map(|outcome| Box::new(outcome.answer));
            reply(Update::Ended(outcome.map_err(|error| error.to_string())));
        });
        // Aborting the task closes the connection and writes the run down as cancelled.
        let task = task.abort_handle();
        services.jobs.insert(id, Canceller::Abort, task);
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        if let Update::Ended(Ok(answer)) = &update
            && answer.verdict().is_some()
        {
            model.recall.hint = false;
        }
        let is_current = jobs::note(model, id, |job, now| jobs::note_question(job, &update, now));
        if is_current {
            answers::on_update(model, id, update)
        } else {
            Vec::new()
        }
    }
}

/// Looks which model servers run on this machine.
#[derive(Debug)]
pub struct Probe;

impl Request for Probe {
    type Reply = Vec<Discovered>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let registry = services.models.registry().clone();
        let environment = services.models.environment().clone();
        tokio::spawn(async move {
            let mut found = probe(&registry, &environment).await;
            found.models.retain(|model| !model.is_no_chat());
            replies.send(found.models);
            for note in found.notes {
                replies.complain(note);
            }
        });
    }

    fn reply(model: &mut Model, found: Self::Reply) -> Vec<Effect> {
        answers::offer(model, found);
        Vec::new()
    }
}
