//! Batches: many questions handed over at once, answered within a day, at half the price.
//!
//! The steps of a submission are apart, so that whoever keeps a record of it can write between them: `Batches::prepare`
//! hands over what can be handed over without anything being asked, `Batches::create` asks. Where nobody knows whether
//! a creation arrived, `Batches::look_up` finds out.

mod anthropic;
mod call;
mod gemini;
mod openai;
mod pages;
mod read;
mod split;

use jiff::Timestamp;
use serde_json::Value;

use super::budget::Reservation;
use super::chunk::{Finish, Usage};
use super::client::Client;
use super::dialect::{Dialect, body};
use super::endpoint::Endpoint;
use super::error::Error;
use super::request::Request;
use call::Calls;
pub use split::split;

/// How many seconds the clocks here and there may differ.
const SLACK: i64 = 300;

/// A question of a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// What its answer is known by: at most 64 letters, digits, `-` and `_`, different within the batch.
    pub id: String,
    /// The question.
    pub request: Request,
}

/// Where a batch stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
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

impl State {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Working => "working",
            Self::Cancelling => "cancelling",
            Self::Ended => "ended",
            Self::Cancelled => "cancelled",
            Self::Expired => "expired",
            Self::Failed => "failed",
        }
    }

    /// Whether nothing more comes, so that the results can be read.
    #[must_use]
    pub fn is_over(self) -> bool {
        !matches!(self, Self::Working | Self::Cancelling)
    }
}

/// What a provider says of a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Status {
    /// Where it stands.
    pub state: State,
    /// Questions that were answered.
    pub answered: u64,
    /// Questions that failed, expired or were cancelled.
    pub failed: u64,
    /// Why all of it failed, in the provider's words.
    pub problem: Option<String>,
    /// The provider's whole document: it says where the results are.
    document: Value,
}

/// What came of one question.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// An answer.
    Answered(Box<Answered>),
    /// None, and why.
    Failed(String),
    /// The batch was cancelled before.
    Cancelled,
    /// The provider's time was over before.
    Expired,
}

/// A whole answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Answered {
    /// The answer's text.
    pub text: String,
    /// The reasoning's text, where it came apart from the answer.
    pub reasoning: String,
    /// What it consumed, with the cost only where the server states it.
    pub usage: Option<Usage>,
    /// The model that the server says it used.
    pub model: Option<String>,
    /// Why the model stopped.
    pub finish: Finish,
}

/// What looking for a batch found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Found {
    /// The batch with this id of the provider's.
    Batch(String),
    /// No such batch.
    Nothing,
    /// It may be one of these, which cannot be told before they have ended.
    Perhaps(Vec<String>),
}

/// What a submission is recognised by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark<'a> {
    /// A word of its own, sent along where the API has a place for it.
    pub tag: &'a str,
    /// The earliest time at which it can have arrived.
    pub since: Timestamp,
    /// The ids of its questions, for the API that has no such place.
    pub ids: &'a [String],
    /// Batches that are known to be others.
    pub others: &'a [String],
}

/// What `Batches::create` needs.
#[derive(Debug)]
pub struct Prepared(Value);

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
    calls: Calls,
    model: String,
}

impl Batches {
    /// The batches of a model; runs the command that has the key, and sends nothing.
    ///
    /// # Errors
    /// [`Error::Setup`]: the endpoint cannot be used, or its API has no batches.
    pub async fn new(client: &Client, endpoint: &Endpoint, model: &str) -> Result<Self, Error> {
        if endpoint.dialect == Dialect::Ollama {
            return Err(Error::Setup {
                place: endpoint.place(),
                why: "Ollama has no batches; ask without a batch".into(),
            });
        }
        Ok(Self {
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
        // Where nobody says what batches cost, they may cost as much.
        Some(most * pricing.batch_factor.unwrap_or(1.0))
    }

    /// Sets money of the budget aside, US dollars, if there is one.
    ///
    /// # Errors
    /// [`Error::Budget`]: so much is not left, or nobody knows how much is needed.
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
            no("there is a budget, and nobody knows what the batch can cost; set max_tokens and state a price, or leave the budget out".into())
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
    pub async fn prepare(&self, tag: &str, items: &[Item]) -> Result<Prepared, Error> {
        let bodies = items.iter().map(|item| {
            let mut body = body(self.endpoint(), &item.request);
            if let Value::Object(fields) = &mut body {
                // Nothing streams out of a batch.
                fields.remove("stream");
                fields.remove("stream_options");
            }
            (item.id.as_str(), body)
        });
        match self.endpoint().dialect {
            Dialect::Anthropic => Ok(Prepared(anthropic::prepared(bodies))),
            Dialect::Gemini => Ok(Prepared(gemini::prepared(tag, bodies))),
            _ => openai::prepare(&self.calls, tag, bodies)
                .await
                .map(Prepared),
        }
    }

    /// Asks for everything that was prepared; the provider's id of the batch. What the server refuses for the moment is
    /// tried again; what may have arrived is not.
    ///
    /// # Errors
    /// As `Batches::prepare`. Where [`surely_not_created`] does not say otherwise, the batch may be there all the same.
    pub async fn create(&self, prepared: &Prepared) -> Result<String, Error> {
        let document = match self.endpoint().dialect {
            Dialect::Anthropic => anthropic::create(&self.calls, &prepared.0).await?,
            Dialect::Gemini => gemini::create(&self.calls, &self.model, &prepared.0).await?,
            _ => openai::create(&self.calls, &prepared.0).await?,
        };
        let field = match self.endpoint().dialect {
            Dialect::Gemini => "name",
            _ => "id",
        };
        self.calls.id(&document, field)
    }

    /// Looks for a batch of which nobody knows whether its creation arrived.
    ///
    /// # Errors
    /// As `Batches::prepare`.
    pub async fn look_up(&self, mark: Mark<'_>) -> Result<Found, Error> {
        match self.endpoint().dialect {
            Dialect::Anthropic => anthropic::look_up(&self.calls, mark).await,
            Dialect::Gemini => gemini::look_up(&self.calls, mark).await,
            _ => openai::look_up(&self.calls, mark).await,
        }
    }

    /// Where a batch stands.
    ///
    /// # Errors
    /// As `Batches::prepare`.
    pub async fn status(&self, id: &str) -> Result<Status, Error> {
        match self.endpoint().dialect {
            Dialect::Anthropic => anthropic::status(&self.calls, id).await,
            Dialect::Gemini => gemini::status(&self.calls, id).await,
            _ => openai::status(&self.calls, id).await,
        }
    }

    /// Gives each result that there is to `each`, by the id of its question, as it arrives. Some questions may have none.
    /// Whether these are all for sure: a body that ends with its connection may have been cut.
    ///
    /// # Errors
    /// As `Batches::prepare`, with some results given perhaps; or what `each` says.
    pub async fn results<E: From<Error>>(
        &self,
        id: &str,
        status: &Status,
        mut each: impl FnMut(&str, Outcome) -> Result<(), E>,
    ) -> Result<bool, E> {
        match self.endpoint().dialect {
            Dialect::Anthropic => anthropic::results(&self.calls, id, &mut each).await,
            Dialect::Gemini => gemini::results(&self.calls, &status.document, &mut each).await,
            _ => openai::results(&self.calls, &status.document, &mut each).await,
        }
    }

    /// Asks the provider to stop working on a batch. What it has answered by then is paid for, and can be had later.
    ///
    /// # Errors
    /// As `Batches::prepare`.
    pub async fn cancel(&self, id: &str) -> Result<(), Error> {
        match self.endpoint().dialect {
            Dialect::Anthropic => anthropic::cancel(&self.calls, id).await,
            Dialect::Gemini => gemini::cancel(&self.calls, id).await,
            _ => openai::cancel(&self.calls, id).await,
        }
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
