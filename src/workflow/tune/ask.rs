//! Asks questions with a template, several at once, and grades the answers.

use std::collections::BTreeMap;
use std::sync::Arc;

use tokio::task::JoinSet;

use super::outcome::Usage;
use super::prepare::{TunePlan, TuneQuestion};
use crate::batch::BatchControl;
use crate::{AskOutcome, AskRequest, ask};
use nearmiss_ask::llm::ProviderOutage;
use nearmiss_store::{Store, StoreError};
use nearmiss_study::evaluation::batch::question_key;
use nearmiss_study::evaluation::{
    Answer, AskError, Event, Judge, JudgeOutcome, MissingVerdict, Question, RunOptions, Scored,
};

/// Why the work ends before its time.
#[derive(Debug)]
pub(super) enum Halt {
    /// The budget is used up, or a server does not answer: why.
    Stopped(String),
    /// The user wants it to end.
    Interrupted,
    /// The store refused.
    Store(StoreError),
}

impl From<StoreError> for Halt {
    fn from(error: StoreError) -> Self {
        Self::Store(error)
    }
}

/// An answer, held against the truth.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Graded {
    /// Whether it counts as a yes; of an answer that cannot be read, what is wrong.
    pub said: bool,
    /// Whether it is right.
    pub right: bool,
    /// Why no verdict could be read; `None` where one was.
    pub unreadable: Option<String>,
    /// US dollars, where they are known.
    pub usd: Option<f64>,
    /// Tokens of question and answer, where the server counted them.
    pub tokens: Option<u64>,
    /// The answer.
    pub text: String,
    /// The reasoning before it.
    pub reasoning: String,
}

/// Answers by the places of their questions, or why there is none.
pub(super) type Replies = BTreeMap<usize, Result<Graded, String>>;

/// Who is asked.
pub(super) struct Asker {
    pub judge: Arc<Judge>,
    pub store: Arc<Store>,
    /// Requests on their way at once.
    pub at_once: usize,
    pub control: BatchControl,
}

/// What came of one question.
type Asked = (
    usize,
    Result<AskOutcome, AskError>,
    Option<(ProviderOutage, String)>,
);

impl Asker {
    /// Asks the questions of a plan as they are given, each with its place, and calls `on_done` after each.
    ///
    /// # Errors
    /// See [`Halt`]; what was answered until then is in the store.
    pub async fn ask(
        &self,
        plan: &TunePlan,
        questions: Vec<(usize, Question)>,
        usage: &mut Usage,
        mut on_done: impl FnMut(),
    ) -> Result<Replies, Halt> {
        let mut replies = Replies::new();
        let mut halt = None;
        let mut waiting = questions.into_iter();
        let mut going: JoinSet<Asked> = JoinSet::new();
        loop {
            while going.len() < self.at_once.max(1) && halt.is_none() && !self.control.is_stopped()
            {
                let Some((place, question)) = waiting.next() else {
                    break;
                };
                let (judge, store) = (Arc::clone(&self.judge), Arc::clone(&self.store));
                going.spawn(async move { one(place, &question, &judge, store).await });
            }
            match going.join_next().await {
                None => break,
                Some(Err(error)) => {
                    halt.get_or_insert(Halt::Stopped(format!("cannot be asked: {error}")));
                }
                Some(Ok((place, outcome, outage))) => {
                    let asked = &plan.questions[place];
                    match self.graded(plan, asked, outcome, usage) {
                        Ok(graded) => drop(replies.insert(place, graded)),
                        Err(why) => drop(halt.get_or_insert(why)),
                    }
                    if let Some((_, why)) = outage {
                        let model = self.judge.id();
                        halt.get_or_insert(Halt::Stopped(format!("{model}: {why}")));
                    }
                    on_done();
                }
            }
        }
        match halt {
            Some(halt) => Err(halt),
            None if self.control.is_stopped() => Err(Halt::Interrupted),
            None => Ok(replies),
        }
    }

    fn graded(
        &self,
        plan: &TunePlan,
        asked: &TuneQuestion,
        outcome: Result<AskOutcome, AskError>,
        usage: &mut Usage,
    ) -> Result<Result<Graded, String>, Halt> {
        let answer = match outcome {
            Ok(AskOutcome {
                not_stored: Some(why),
                ..
            }) => return Err(Halt::Store(StoreError::Unstored(why))),
            Ok(outcome) => outcome.answer,
            Err(AskError::Store(error)) => return Err(Halt::Store(error)),
            Err(error) => return Err(Halt::Stopped(error.to_string())),
        };
        match answer.past {
            Some(_) => usage.answers_stored += 1,
            None => usage.answers += 1,
        }
        Ok(grade(plan, asked, &answer))
    }
}

/// Asks one question; with it, what was met of its server where nothing more is to be hoped from it.
async fn one(place: usize, question: &Question, judge: &Judge, store: Arc<Store>) -> Asked {
    let mut barred = None;
    match at_limit(question, judge, &store) {
        Ok(None) => {}
        Ok(Some(answer)) => {
            let outcome = AskOutcome {
                answer,
                not_stored: None,
            };
            return (place, Ok(outcome), None);
        }
        Err(error) => return (place, Err(error.into()), None),
    }
    let request = AskRequest {
        question,
        judge,
        store: Some(store),
        options: RunOptions::default(),
    };
    let outcome = ask(request, |event| {
        if let Event::Barred(outage) = event {
            barred = Some(outage);
        }
    })
    .await;
    let why = match &outcome {
        Ok(outcome) => match &outcome.answer.judged {
            JudgeOutcome::Missing(missing) => missing.to_string(),
            _ => String::new(),
        },
        Err(error) => error.to_string(),
    };
    (place, outcome, barred.map(|outage| (outage, why)))
}

/// The stored answer that ran into the limit of tokens, where there is no whole one: it is paid, and counts.
fn at_limit(
    question: &Question,
    judge: &Judge,
    store: &Store,
) -> Result<Option<Answer>, StoreError> {
    let Some(key) = question_key(question, judge)? else {
        return Ok(None);
    };
    Ok(store.answer_at_limit(&key, 0)?.map(Answer::from))
}

/// The word of servers for an answer at the limit of tokens: that is the template's doing, too.
const AT_THE_LIMIT: &str = "length";

/// Holds an answer against the truth. One without a readable verdict is wrong: a template that spoils the form of answers
/// must not gain by it.
fn grade(plan: &TunePlan, asked: &TuneQuestion, answer: &Answer) -> Result<Graded, String> {
    let truth = asked.truth.collides();
    let cut = answer.finish.as_deref() == Some(AT_THE_LIMIT);
    let said = match &answer.judged {
        JudgeOutcome::Verdict(parsed) if answer.is_whole() && !cut => {
            let (name, verdict) = (&plan.scenarios[asked.scenario], parsed.verdict.clone());
            let mut scored = Scored::built_in(name, &answer.model, Some(asked.truth), verdict);
            scored.critical.clone_from(&asked.critical);
            plan.protocol.count(&mut scored);
            scored.positive().ok_or_else(|| "no verdict".to_string())
        }
        JudgeOutcome::Missing(MissingVerdict::NotInAnswer(why)) => Err(why.clone()),
        _ if cut => Err("the answer ran into the token limit".to_string()),
        JudgeOutcome::Missing(missing) => return Err(missing.to_string()),
        _ => {
            let cut = answer.cut_off();
            return Err(cut.unwrap_or_else(|| "the server ended the answer early".to_string()));
        }
    };
    let consumed = &answer.consumed;
    Ok(Graded {
        said: *said.as_ref().unwrap_or(&!truth),
        right: said == Ok(truth),
        unreadable: said.err(),
        usd: consumed.cost_usd,
        tokens: consumed
            .input_tokens
            .zip(consumed.output_tokens)
            .map(|(question, answer)| question.saturating_add(answer)),
        text: answer.text.clone(),
        reasoning: answer.reasoning.clone(),
    })
}
