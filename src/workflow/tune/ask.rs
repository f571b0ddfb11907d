//! Asks with a template on a part of the questions, several at once, and grades the answers.

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss_ask::llm::ProviderOutage;
use nearmiss_store::{Store, StoreError};
use nearmiss_study::evaluation::batch::question_key;
use nearmiss_study::evaluation::statistics::SplitMix;
use nearmiss_study::evaluation::{
    Answer, AnswerStatus, AskError, Event, Judge, JudgeOutcome, MissingVerdict, Question,
    RunOptions, Scored,
};
use tokio::task::JoinSet;

use super::DevPart;
use super::candidate::{Candidate, rendered};
use super::outcome::{TuneEvent, Usage};
use super::prepare::{TunePlan, TuneQuestion};
use super::rounds::Tuning;
use crate::batch::BatchControl;
use crate::{AskOutcome, AskRequest, ask};

/// Why the work ends before its time.
#[derive(Debug)]
pub(super) enum TuneAbort {
    /// The budget is used up, or a server does not answer: why.
    Stopped(String),
    /// The user wants it to end.
    Interrupted,
    /// The store refused.
    Store(StoreError),
}

impl From<StoreError> for TuneAbort {
    fn from(error: StoreError) -> Self {
        Self::Store(error)
    }
}

/// An answer, held against the truth.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Graded {
    /// Whether it counts as a yes; of an answer that cannot be read, what is wrong.
    pub yes: bool,
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
pub(super) struct BatchClient {
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

impl BatchClient {
    /// Asks the questions of a plan as they are given, each with its place, and calls `on_done` after each.
    ///
    /// # Errors
    /// See [`TuneAbort`]; what was answered until then is in the store.
    pub async fn ask(
        &self,
        plan: &TunePlan,
        questions: Vec<(usize, Question)>,
        usage: &mut Usage,
        mut on_done: impl FnMut(),
    ) -> Result<Replies, TuneAbort> {
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
                    halt.get_or_insert(TuneAbort::Stopped(format!("cannot be asked: {error}")));
                }
                Some(Ok((place, outcome, outage))) => {
                    let asked = &plan.questions[place];
                    match self.graded(plan, asked, outcome, usage) {
                        Ok(graded) => drop(replies.insert(place, graded)),
                        Err(why) => drop(halt.get_or_insert(why)),
                    }
                    if let Some((_, why)) = outage {
                        let model = self.judge.id();
                        halt.get_or_insert(TuneAbort::Stopped(format!("{model}: {why}")));
                    }
                    on_done();
                }
            }
        }
        match halt {
            Some(halt) => Err(halt),
            None if self.control.is_stopped() => Err(TuneAbort::Interrupted),
            None => Ok(replies),
        }
    }

    fn graded(
        &self,
        plan: &TunePlan,
        asked: &TuneQuestion,
        outcome: Result<AskOutcome, AskError>,
        usage: &mut Usage,
    ) -> Result<Result<Graded, String>, TuneAbort> {
        let answer = match outcome {
            Ok(AskOutcome {
                not_stored: Some(why),
                ..
            }) => return Err(TuneAbort::Store(StoreError::Unstored(why))),
            Ok(outcome) => outcome.answer,
            Err(AskError::Store(error)) => return Err(TuneAbort::Store(error)),
            Err(error) => return Err(TuneAbort::Stopped(error.to_string())),
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
        JudgeOutcome::Verdict(parsed) if answer.is_complete() && !cut => {
            let name = &plan.scenarios[asked.scenario];
            let (task, verdict) = (parsed.verdict.task, parsed.verdict.clone());
            let status = AnswerStatus::Verdict(verdict);
            let mut scored = Scored::built_in(name, &answer.model, task, Some(asked.truth), status);
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
        yes: *said.as_ref().unwrap_or(&!truth),
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

/// Wrong answers that are looked for before a template is reflected on; as many right ones are asked again with them.
pub(super) const WRONG_WANTED: usize = 6;

/// Feedback questions that are asked at a time until enough wrong answers are there.
const AT_A_TIME: usize = 8;

/// The feedback questions of a round.
pub(super) struct Minibatch {
    /// The candidate that answered them.
    pub parent: usize,
    /// All dev questions as it asks them.
    pub questions: Vec<Question>,
    /// Those it answered wrong.
    pub wrong: Vec<usize>,
    /// Some of those it answered right, so that what is spoilt is seen, too.
    pub right: Vec<usize>,
    /// Of all that were asked: how many it answered right, and how many not.
    pub asked: (usize, usize),
}

impl Minibatch {
    /// Tokens of all dev questions as the parent asks them.
    pub fn tokens(&self) -> usize {
        self.questions.iter().map(Question::tokens).sum()
    }

    /// All places.
    pub fn places(&self) -> Vec<usize> {
        [&self.wrong[..], &self.right].concat()
    }
}

impl<F: FnMut(TuneEvent<'_>)> Tuning<'_, F> {
    /// Asks these questions; `number` is what the template is called.
    pub(super) async fn ask(
        &mut self,
        number: usize,
        part: DevPart,
        questions: Vec<(usize, Question)>,
    ) -> Result<Replies, TuneAbort> {
        let of = questions.len();
        let (on_event, mut done) = (&mut self.on_event, 0);
        on_event(TuneEvent::Asking {
            candidate: number,
            part,
            done,
            of,
        });
        let asked = self.asker.ask(self.plan, questions, &mut self.usage, || {
            done += 1;
            on_event(TuneEvent::Asking {
                candidate: number,
                part,
                done,
                of,
            });
        });
        asked.await
    }

    /// The questions of a candidate that are shown in a round; `None` where it answers all feedback questions right.
    pub(super) async fn minibatch(
        &mut self,
        parent: usize,
        round: u32,
    ) -> Result<Option<Minibatch>, TuneAbort> {
        let questions = self.questions_of(parent)?;
        let seed = self.settings.seed ^ (u64::from(round) << 32);
        let mut order = self.plan.of_part(DevPart::Feedback);
        shuffle(&mut order, seed);
        let (mut wrong, mut right) = (Vec::new(), Vec::new());
        for some in order.chunks(AT_A_TIME) {
            let known = &self.replies[parent];
            let open: Vec<(usize, Question)> = some
                .iter()
                .filter(|at| !known.contains_key(at))
                .map(|at| (*at, questions[*at].clone()))
                .collect();
            if !open.is_empty() {
                let replies = self.ask(parent, DevPart::Feedback, open).await?;
                self.replies[parent].extend(replies);
            }
            for at in some {
                match self.replies[parent].get(at) {
                    Some(Ok(Graded { right: true, .. })) => right.push(*at),
                    Some(Ok(_)) => wrong.push(*at),
                    Some(Err(_)) | None => {}
                }
            }
            if wrong.len() >= WRONG_WANTED {
                break;
            }
        }
        let asked = (right.len(), wrong.len());
        wrong.truncate(WRONG_WANTED);
        right.truncate(wrong.len());
        Ok((!wrong.is_empty()).then_some(Minibatch {
            parent,
            questions,
            wrong,
            right,
            asked,
        }))
    }

    /// All dev questions as a candidate asks them.
    pub(super) fn questions_of(&self, number: usize) -> Result<Vec<Question>, TuneAbort> {
        let source = &self.candidates[number].source;
        rendered(self.plan, source).map_err(TuneAbort::Stopped)
    }

    /// The candidate that is changed in a round: in odd ones the best of the front, else another of it.
    pub(super) fn parents(&self, round: u32) -> Vec<usize> {
        let mut front: Vec<&Candidate> = self.candidates.iter().filter(|c| c.on_front).collect();
        let value = |one: &Candidate| one.score.value(self.measure).unwrap_or(0.0);
        front.sort_by(|a, b| value(b).total_cmp(&value(a)).then(a.number.cmp(&b.number)));
        let mut numbers: Vec<usize> = front.iter().map(|one| one.number).collect();
        if round.is_multiple_of(2) && numbers.len() > 1 {
            let mut random = SplitMix(self.settings.seed ^ u64::from(round));
            let other = 1 + random.below(numbers.len() - 1);
            let other = numbers.remove(other);
            numbers.insert(0, other);
        }
        numbers.retain(|number| !self.exhausted.contains(number));
        numbers
    }
}

/// Fisher and Yates.
fn shuffle(places: &mut [usize], seed: u64) {
    let mut random = SplitMix(seed);
    for last in (1..places.len()).rev() {
        places.swap(last, random.below(last + 1));
    }
}
