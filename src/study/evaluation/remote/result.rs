//! Turns one batch result into the end of its run, parsed like an answer that arrived alone.

use jiff::Timestamp;
use jiff::tz::TimeZone;

use crate::evaluation::answer::{Answer, JudgeOutcome, MissingVerdict};
use crate::evaluation::answer_outcome::{read, stopped_short, unless_cut, weighed, word};
use crate::evaluation::judges::ModelJudge;
use nearmiss_ask::llm::batch::{Outcome, WholeAnswer};
use nearmiss_ask::llm::{Message, Secrets};
use nearmiss_ask::prompts::estimate_tokens;
use nearmiss_store::{AnswerPiece, Consumed, Ending, Run, RunState};

/// Why a question has no answer whose batch the provider did not finish in time.
pub const EXPIRED: &str = "the batch expired before the provider answered; ask again";

/// The texts of a result and the end of its run.
pub struct FinishedRun {
    pub reasoning: String,
    pub text: String,
    pub ending: Ending,
}

impl FinishedRun {
    pub fn pieces(&self) -> Vec<AnswerPiece<'_>> {
        let pieces = [
            AnswerPiece::Reasoning(&self.reasoning),
            AnswerPiece::Answer(&self.text),
        ];
        let some = |piece: &AnswerPiece<'_>| match piece {
            AnswerPiece::Reasoning(text) | AnswerPiece::Answer(text) => !text.is_empty(),
        };
        pieces.into_iter().filter(some).collect()
    }
}

/// The end of a question's run with this outcome.
pub fn settled(run: Run, outcome: Outcome, model: &ModelJudge) -> FinishedRun {
    match outcome {
        Outcome::Answered(answered) => answer(run, *answered, model),
        Outcome::Failed(why) => bare(RunState::Failed, Some(&why)),
        Outcome::Expired => bare(RunState::Failed, Some(EXPIRED)),
        Outcome::Cancelled => bare(RunState::Cancelled, None),
    }
}

fn bare(state: RunState, error: Option<&str>) -> FinishedRun {
    FinishedRun {
        reasoning: String::new(),
        text: String::new(),
        ending: Ending {
            error: error.map(str::to_string),
            ..Ending::bare(state)
        },
    }
}

fn answer(run: Run, answered: WholeAnswer, model: &ModelJudge) -> FinishedRun {
    let task = run.question.task;
    let sent = tokens_sent(&run.question.messages);
    let asked = Timestamp::from_millisecond(run.created_ms).unwrap_or(Timestamp::UNIX_EPOCH);
    let returned = answered.model.as_deref();
    let (cost_usd, price_source) = match cost(&answered, asked, returned, model) {
        Some((usd, source)) => (Some(usd), Some(source)),
        None => (None, None),
    };
    let usage = answered.usage.unwrap_or_default();
    let mut answer = Answer {
        text: answered.text,
        reasoning: answered.reasoning,
        model_returned: answered.model,
        finish: Some(word(&answered.finish)),
        consumed: Consumed {
            input_tokens: usage.input_tokens,
            output_tokens: usage.output_tokens,
            reasoning_tokens: usage.reasoning_tokens,
            cached_tokens: usage.cached_tokens,
            cost_usd,
            // Its time is the provider's queue, not the model's.
            first_chunk_ms: None,
            duration_ms: None,
        },
        price_source,
        judged: JudgeOutcome::Missing(MissingVerdict::Cancelled),
        ..Answer::from(run)
    };
    let secrets = Secrets::sent(&model.client, &model.endpoint);
    let read = read(task, &answer, stopped_short(&answered.finish)).without(&secrets);
    answer.judged = unless_cut(read, usage.input_tokens, sent);
    weighed(task, &answered.tokens, &mut answer.judged);
    let ending = answer.ending();
    FinishedRun {
        reasoning: answer.reasoning,
        text: answer.text,
        ending,
    }
}

/// Roughly how many tokens messages in words alone are; `None` of those with pictures.
fn tokens_sent(messages: &str) -> Option<usize> {
    let messages: Vec<Message> = serde_json::from_str(messages).ok()?;
    let in_words = messages.iter().all(|message| message.images.is_empty());
    let tokens = messages
        .iter()
        .map(|message| estimate_tokens(&message.content));
    in_words.then(|| tokens.sum())
}

/// Cost of an answer, US dollars, and its source.
fn cost(
    answered: &WholeAnswer,
    asked: Timestamp,
    returned: Option<&str>,
    model: &ModelJudge,
) -> Option<(f64, String)> {
    let usage = answered.usage.as_ref()?;
    if let Some(cost) = usage.cost {
        return Some((cost.usd, "stated by the server".into()));
    }
    let day = asked.to_zoned(TimeZone::UTC).date();
    let prices = &model.endpoint.prices;
    let pricing = prices.of_answer(&model.name, returned, day)?;
    let usd = pricing.batch_cost(usage, asked)?;
    let factor = pricing.batch_factor?;
    let origin = pricing
        .origin()
        .map(|o| format!(", {o}"))
        .unwrap_or_default();
    Some((
        usd,
        format!("tokens times {factor} of listed prices, as part of a batch{origin}"),
    ))
}
