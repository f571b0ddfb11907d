//! Batches: many questions submitted at once, answered within a day, at half the price.
//!
//! A submission has separate steps, so that a caller can record each of them: `Batches::prepare` uploads without asking
//! anything, `Batches::create` asks. If it is unknown whether a creation arrived, `Batches::look_up` finds out.

mod anthropic;
mod api;
mod call;
mod gemini;
mod openai;

use std::ops::Range;

use jiff::Timestamp;
use serde_json::{Value, json};

use super::chunk::{Chunk, Finish, Token, Usage};
use super::client::Client;
use super::decoder::Decoder;
use super::dialect::body;
use super::endpoint::Endpoint;
use super::error::Error;
use super::error_body::{ErrorBody, MAX_QUOTE_LENGTH, tidy};
use super::limits::Reservation;
use super::request::Request;
use api::{Match, Pages, Results, Submission};
use call::{Calls, RetryPolicy};

pub(super) use anthropic::AnthropicBatches;
pub(super) use api::BatchApi;
pub(super) use gemini::GeminiBatches;
pub(super) use openai::OpenAiBatches;

/// How many seconds the clocks here and there may differ.
const CLOCK_SKEW: i64 = 300;

/// A question of a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// Identifies its answer: at most 64 letters, digits, `-` and `_`, unique within the batch.
    pub id: String,
    /// The question.
    pub request: Request,
}

/// State of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BatchState {
    /// It is worked on, or waits for its turn.
    Working,
    /// It is being cancelled.
    Cancelling,
    /// Each question was answered or failed.
    Ended,
    /// It was cancelled; what was answered before can be had.
    Cancelled,
    /// The provider's time for it was over; what was answered before can be had.
    Expired,
    /// The provider could not use it at all.
    Failed,
}

impl BatchState {
    /// Whether nothing more comes, so that the results can be read.
    #[must_use]
    pub fn is_over(self) -> bool {
        !matches!(self, Self::Working | Self::Cancelling)
    }
}

/// A provider's report on a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Status {
    /// Where it stands.
    pub state: BatchState,
    /// Questions that were answered.
    pub answered: u64,
    /// Questions that failed, expired or were cancelled.
    pub failed: u64,
    /// Why all of it failed, in the provider's words.
    pub problem: Option<String>,
    /// The provider's whole document: it says where the results are.
    document: Value,
}

/// Outcome of one question.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// An answer.
    Answered(Box<WholeAnswer>),
    /// None, and why.
    Failed(String),
    /// The batch was cancelled before.
    Cancelled,
    /// The provider's time was over before.
    Expired,
}

/// A whole answer.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeAnswer {
    /// The answer's text.
    pub text: String,
    /// The reasoning's text, where it came apart from the answer.
    pub reasoning: String,
    /// Its usage, with the cost only if the server states it.
    pub usage: Option<Usage>,
    /// Its tokens with their log probabilities, where they were asked for and given.
    pub tokens: Vec<Token>,
    /// The model that the server says it used.
    pub model: Option<String>,
    /// Why the model stopped.
    pub finish: Finish,
}

/// Result of looking up a batch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Lookup {
    /// The batch with this id of the provider's.
    Batch(String),
    /// No such batch.
    Nothing,
    /// It may be one of these, which cannot be told before they have ended.
    Perhaps(Vec<String>),
}

/// The mark by which a submission is recognised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubmissionMark<'a> {
    /// A tag, sent along where the API supports one.
    pub tag: &'a str,
    /// The earliest time at which it can have arrived.
    pub since: Timestamp,
    /// The ids of its questions, for the API that has no such place.
    pub ids: &'a [String],
    /// Batches that are known to be others.
    pub others: &'a [String],
}

/// Input of `Batches::create`.
#[derive(Debug)]
pub struct PreparedBatch(Value);

/// Money of a budget that is set aside for a batch; free again when dropped, unless it is [`SetAside::spent`].
#[derive(Debug)]
pub struct SetAside(Option<Reservation>);

impl SetAside {
    /// The batch may have to be paid for.
    pub fn spent(mut self) {
        if let Some(reserved) = &mut self.0 {
            reserved.may_be_paid(true);
        }
    }
}

/// The batches of one model at one endpoint.
#[derive(Debug)]
pub struct Batches {
    api: &'static dyn BatchApi,
    calls: Calls,
    model: String,
}

impl Batches {
    /// The batches of a model; runs the command that has the key, and sends nothing.
    ///
    /// # Errors
    /// [`Error::Setup`]: the endpoint cannot be used, or its API has no batches.
    pub async fn new(client: &Client, endpoint: &Endpoint, model: &str) -> Result<Self, Error> {
        let api = endpoint
            .dialect
            .protocol()
            .batches()
            .ok_or_else(|| Error::Setup {
                place: endpoint.place(),
                why: "its API has no batches; drop --batch".into(),
            })?;
        Ok(Self {
            api,
            calls: Calls::new(client, endpoint, model).await?,
            model: model.to_owned(),
        })
    }

    /// The most that a question can cost as part of a batch, US dollars, where price and limit of the answer are known.
    #[must_use]
    pub fn at_most(&self, request: &Request) -> Option<f64> {
        let endpoint = self.endpoint();
        let most = endpoint.at_most(request)?;
        let worst = endpoint.worst_case(&request.model, &request.parameters);
        let (pricing, _) = worst.ok()?;
        // Without a known batch price, a batch may cost the full price.
        Some(most * pricing.batch_factor.unwrap_or(1.0))
    }

    /// Reserves US dollars of the budget, if there is one.
    ///
    /// # Errors
    /// [`Error::Budget`]: too little is left, or the amount needed is unknown.
    pub fn set_aside(&self, usd: Option<f64>) -> Result<SetAside, Error> {
        let endpoint = self.endpoint();
        let no = |why: String| Error::Budget {
            place: endpoint.place(),
            why,
        };
        let Some(budget) = &endpoint.budget else {
            return Ok(SetAside(None));
        };
        let usd = usd.ok_or_else(|| {
            no("a budget needs a known cost, but that of the batch is unknown; set max_tokens and a price, or drop the budget".into())
        })?;
        let reserved = budget.reserve(usd).map_err(|over| no(over.to_string()))?;
        Ok(SetAside(Some(reserved)))
    }

    fn endpoint(&self) -> &Endpoint {
        self.calls.endpoint()
    }

    /// Hands over the questions; nothing is asked yet, and nothing paid for.
    ///
    /// # Errors
    /// The provider, or the way to it, failed.
    pub async fn prepare(&self, tag: &str, items: &[Item]) -> Result<PreparedBatch, Error> {
        let mut bodies = items.iter().map(|item| {
            let mut body = body(self.endpoint(), &item.request);
            if let Value::Object(fields) = &mut body {
                // Batches do not stream.
                fields.remove("stream");
                fields.remove("stream_options");
            }
            (item.id.as_str(), body)
        });
        let submission = self.api.submission(&self.calls, tag, &mut bodies)?;
        match submission {
            Submission::Document(document) => Ok(PreparedBatch(document)),
            Submission::File {
                url,
                content_type,
                body,
                mut document,
                field,
            } => {
                let file = self.calls.upload(url, content_type, body).await?;
                document[field] = self.calls.id(&file, "id")?.into();
                Ok(PreparedBatch(document))
            }
        }
    }

    /// Asks for everything that was prepared; the provider's id of the batch. What the server refuses for the moment is
    /// tried again; what may have arrived is not.
    ///
    /// # Errors
    /// As `Batches::prepare`. Where [`surely_not_created`] does not say otherwise, the batch may be there all the same.
    pub async fn create(&self, prepared: &PreparedBatch) -> Result<String, Error> {
        let url = self.api.create_url(&self.calls, &self.model)?;
        let document = self
            .calls
            .post(url, &prepared.0, RetryPolicy::Refused)
            .await?;
        self.calls.id(&document, self.api.id_field())
    }

    /// Looks up a batch whose creation may or may not have arrived.
    ///
    /// # Errors
    /// As `Batches::prepare`.
    pub async fn look_up(&self, mark: SubmissionMark<'_>) -> Result<Lookup, Error> {
        let (api, calls) = (self.api, &self.calls);
        let mut after: Option<String> = None;
        let mut perhaps = Vec::new();
        let mut pages = Pages::new();
        'pages: loop {
            let page = calls.page(api.list_url(calls, after.as_deref())?).await?;
            let batches = api.batches(calls, &page)?;
            for batch in batches {
                match api.recognise(calls, batch, &mark)? {
                    Match::Yes(id) => return Ok(Lookup::Batch(id)),
                    Match::No => {}
                    Match::TooOld => break 'pages,
                    Match::Perhaps(id) => perhaps.push(id),
                    Match::ByResults(id) if self.is_ours(&id, batch, mark.ids).await? => {
                        return Ok(Lookup::Batch(id));
                    }
                    Match::ByResults(_) => {}
                }
            }
            after = api.next_page(calls, &page)?;
            pages.turn(calls, batches.len(), after.as_deref())?;
            if after.is_none() {
                break;
            }
        }
        Ok(if perhaps.is_empty() {
            Lookup::Nothing
        } else {
            Lookup::Perhaps(perhaps)
        })
    }

    /// Whether the results of a batch are those of these questions; ids are never used twice, so that one tells.
    async fn is_ours(&self, id: &str, document: &Value, ids: &[String]) -> Result<bool, Error> {
        let mut ours = false;
        self.each_result(id, document, |of: &str, _| {
            ours |= ids.iter().any(|id| id == of);
            Ok::<_, Error>(())
        })
        .await?;
        Ok(ours)
    }

    /// Where a batch stands.
    ///
    /// # Errors
    /// As `Batches::prepare`.
    pub async fn status(&self, id: &str) -> Result<Status, Error> {
        let url = self.api.status_url(&self.calls, id)?;
        let document = self.calls.get(url).await?;
        self.api.status(&self.calls, document)
    }

    /// Gives each result that there is to `each`, by the id of its question, as it arrives. Some questions may have
    /// none. Whether these are all for sure: a body that ends with its connection may have been cut.
    ///
    /// # Errors
    /// As `Batches::prepare`, with some results given perhaps; or what `each` says.
    pub async fn results<E: From<Error>>(
        &self,
        id: &str,
        status: &Status,
        each: impl FnMut(&str, Outcome) -> Result<(), E>,
    ) -> Result<bool, E> {
        self.each_result(id, &status.document, each).await
    }

    async fn each_result<E: From<Error>>(
        &self,
        id: &str,
        document: &Value,
        mut each: impl FnMut(&str, Outcome) -> Result<(), E>,
    ) -> Result<bool, E> {
        let mut take = |entry: &Value| {
            let (id, outcome) = self.api.result(&self.calls, entry)?;
            each(id, outcome)
        };
        let mut certain = true;
        for place in self.api.results(&self.calls, id, document) {
            match place? {
                Results::Inline(entries) => entries.iter().try_for_each(&mut take)?,
                Results::Lines(url) => {
                    certain &= self.calls.lines(url, |line| take(&line)).await?;
                }
            }
        }
        Ok(certain)
    }

    /// Asks the provider to stop working on a batch. What it has answered by then is paid for, and can be had later.
    ///
    /// # Errors
    /// As `Batches::prepare`.
    pub async fn cancel(&self, id: &str) -> Result<(), Error> {
        let url = self.api.cancel_url(&self.calls, id)?;
        let asked = self
            .calls
            .post(url, &json!({}), RetryPolicy::Harmless)
            .await;
        asked.map(drop)
    }
}

/// Whether it is certain that no batch was created when `Batches::create` failed in this way.
#[must_use]
pub fn surely_not_created(error: &Error) -> bool {
    error.before_sending()
        || matches!(
            error,
            Error::Unauthorized { .. }
                | Error::NotFound { .. }
                | Error::RateLimited { .. }
                | Error::BadRequest { .. }
                | Error::Redirected { .. }
        )
}

/// Most requests in a batch: all providers take more, but a batch is read back in one piece.
const MAX_REQUESTS: usize = 20_000;

/// Most bytes of a batch. OpenAI takes 200 MB, Anthropic 256 MB and Gemini 20 MB, sent in one request that must not
/// outlast the patience with a silent server.
const MOST_BYTES: usize = 16 << 20;

/// How many of these go into one batch, and then into the next: ranges of positions, none of them empty.
#[must_use]
pub fn split(endpoint: &Endpoint, requests: &[Request]) -> Vec<Range<usize>> {
    let size = |request: &Request| body(endpoint, request).to_string().len() + 200;
    parts(requests.iter().map(size))
}

fn parts(sizes: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    let mut bytes = 0;
    for (at, size) in sizes.enumerate() {
        match parts.last_mut() {
            Some(part) if part.len() < MAX_REQUESTS && bytes + size <= MOST_BYTES => {
                part.end = at + 1;
                bytes += size;
            }
            _ => {
                parts.push(at..at + 1);
                bytes = size;
            }
        }
    }
    parts
}

/// The answer in a document that was not streamed, with secrets taken out of what the server said.
fn answer(calls: &Calls, document: &Value) -> Outcome {
    let (endpoint, secrets) = (calls.endpoint(), calls.secrets());
    let clear = |text: String| secrets.redact(&text);
    let mut decoder = Decoder::new(endpoint.dialect, endpoint.place());
    let chunks = match decoder.document(&document.to_string()) {
        Ok(chunks) => chunks,
        Err(error) => return Outcome::Failed(error.redacted(secrets).to_string()),
    };
    let mut answer = WholeAnswer {
        text: String::new(),
        reasoning: String::new(),
        usage: None,
        tokens: Vec::new(),
        model: None,
        finish: Finish::Other("unstated".into()),
    };
    for chunk in chunks {
        match chunk {
            Chunk::Started { model } => answer.model = model.map(clear),
            Chunk::Reasoning(text) => answer.reasoning.push_str(&text),
            Chunk::Text(text) => answer.text.push_str(&text),
            Chunk::Usage(usage) => answer.usage = Some(usage),
            Chunk::LogProbabilities(tokens) => answer.tokens = tokens,
            Chunk::Finished(finish) => {
                answer.finish = match finish {
                    Finish::Refusal(text) => Finish::Refusal(clear(text)),
                    Finish::Blocked(text) => Finish::Blocked(clear(text)),
                    Finish::Other(text) => Finish::Other(clear(text)),
                    other => other,
                };
            }
            Chunk::Note(_) | Chunk::Retrying { .. } | Chunk::ToolCalls(_) => {}
        }
    }
    answer.text = secrets.redact_cut(&answer.text);
    answer.reasoning = secrets.redact_cut(&answer.reasoning);
    Outcome::Answered(Box::new(answer))
}

/// A failure in the provider's words: one line without secrets.
fn failed(calls: &Calls, document: &Value, status: Option<u64>) -> Outcome {
    let body = ErrorBody::in_body(&calls.secrets().redact(&document.to_string()));
    let status = status.map(|s| format!("{s}: ")).unwrap_or_default();
    let code = body
        .code
        .or(body.kind)
        .map(|c| format!(" ({c})"))
        .unwrap_or_default();
    let words = format!("{status}{}{code}", body.message);
    Outcome::Failed(line(calls, &words))
}

/// The id of a question that an entry of results names.
fn custom_id<'a>(calls: &Calls, entry: &'a Value) -> Result<&'a str, Error> {
    let id = entry.get("custom_id").and_then(Value::as_str);
    id.ok_or_else(|| calls.malformed(&format!("no custom_id: {entry}")))
}

/// Words of the provider's on one line, without secrets.
fn line(calls: &Calls, words: &str) -> String {
    tidy(&calls.secrets().redact_cut(words), MAX_QUOTE_LENGTH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_split_at_both_limits() {
        assert!(parts(std::iter::empty()).is_empty());
        assert_eq!(parts([10; 3].into_iter()), vec![0..3; 1]);
        let half = MOST_BYTES / 2;
        assert_eq!(parts([half, half, 1].into_iter()), [0..2, 2..3]);
        assert_eq!(parts([1, MOST_BYTES, 1].into_iter()), [0..1, 1..2, 2..3]);
        // One that is too large alone is the provider's to refuse.
        assert_eq!(parts([2 * MOST_BYTES, 1].into_iter()), [0..1, 1..2]);
        let many = vec![1; MAX_REQUESTS + 1];
        let split = parts(many.into_iter());
        assert_eq!(split, [0..MAX_REQUESTS, MAX_REQUESTS..MAX_REQUESTS + 1]);
    }
}
