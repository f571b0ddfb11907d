//! One question over the network: attempts, waits, and reading the stream.

use std::collections::VecDeque;
use std::mem;
use std::time::Duration;

use futures_util::stream::{self, StreamExt};
use jiff::Timestamp;
use jiff::tz::TimeZone;
use reqwest::Response;
use tokio::sync::OwnedSemaphorePermit;
use tokio::task::yield_now;

use super::body_text::{Deadlines, beginning, join_to_end, response_texts};
use super::chunk::{Chunk, Cost, CostSource, Finish, Usage};
use super::client::{Client, Dispensable};
use super::decoder::Decoder;
use super::dialect::Framing;
use super::endpoint::{Endpoint, ResponseFormat};
use super::error::Error;
use super::error_body::tidy;
use super::events::{Frames, ended, frames, step};
use super::limits::Reservation;
use super::redaction::Secrets;
use super::redaction::redactor::Redactors;
use super::request::Request;
use super::sending::{Ready, Sending};

/// Most of an unstreamed answer that is read, in bytes.
const LONGEST_DOCUMENT: usize = 16 << 20;

/// Events that are read before everything else gets its turn.
const EVENTS_PER_TURN: u64 = 64;

/// The state machine behind [`super::stream`].
pub(super) struct StreamingRequest {
    client: Client,
    endpoint: Endpoint,
    request: Request,
    queue: VecDeque<Result<Chunk, Error>>,
    state: State,
    /// Secrets sent, which must not appear in the answer; known once the key is.
    secrets: Secrets,
    redactors: Redactors,
    /// Money set aside for this request.
    reserved: Option<Reservation>,
    /// The place among the requests on their way.
    place: Option<OwnedSemaphorePermit>,
    returned: Option<String>,
    asked: Timestamp,
}

enum State {
    New,
    Sending(Box<Sending>),
    Waiting(Duration, Box<Sending>),
    Reading(Box<Reading>),
    Over,
}

struct Reading {
    frames: Frames,
    decoder: Decoder,
    /// How many events were read.
    events: u64,
}

impl StreamingRequest {
    pub fn new(client: Client, endpoint: Endpoint, request: Request) -> Self {
        Self {
            client,
            endpoint,
            request,
            queue: VecDeque::new(),
            state: State::New,
            secrets: Secrets::default(),
            redactors: Redactors::default(),
            reserved: None,
            place: None,
            returned: None,
            asked: Timestamp::now(),
        }
    }

    /// The next chunk, with secrets taken out of what the server said; `None` after the last.
    pub async fn next(&mut self) -> Option<Result<Chunk, Error>> {
        loop {
            if let Some(item) = self.queue.pop_front() {
                if item.is_err() {
                    self.state = State::Over;
                    self.queue.clear();
                }
                match self.cleared(item) {
                    Some(item) => return Some(item),
                    None => continue,
                }
            }
            self.state = match mem::replace(&mut self.state, State::Over) {
                State::New => self.prepare().await,
                State::Sending(sending) => self.send(sending).await,
                State::Waiting(wait, sending) => {
                    tokio::time::sleep(wait).await;
                    State::Sending(sending)
                }
                State::Reading(reading) => self.read(reading).await,
                State::Over => {
                    self.reserved = None;
                    self.place = None;
                    return None;
                }
            };
        }
    }

    /// A chunk as it leaves: without secrets, and with its cost. `None` if all of it is held back, since it may
    /// become one.
    fn cleared(&mut self, item: Result<Chunk, Error>) -> Option<Result<Chunk, Error>> {
        let clear = |text: String| self.secrets.redact(&text);
        let chunk = match item {
            Ok(Chunk::Reasoning(_) | Chunk::Text(_) | Chunk::Note(_) | Chunk::Retrying { .. }) => {
                item.ok()?
            }
            Ok(Chunk::Started { model }) => {
                let model = model.map(clear);
                self.returned.clone_from(&model);
                return Some(Ok(Chunk::Started { model }));
            }
            // At the end, held text was no secret, or a truncated one.
            last => match self.redactors.held() {
                Some(held) => {
                    self.queue.push_front(last);
                    return Some(Ok(held));
                }
                None => match last {
                    Ok(chunk) => chunk,
                    Err(error) => return Some(Err(error.redacted(&self.secrets))),
                },
            },
        };
        Some(Ok(match chunk {
            Chunk::Reasoning(_) | Chunk::Text(_) => self.redactors.piece(chunk)?,
            Chunk::Usage(usage) => Chunk::Usage(self.priced(usage)),
            Chunk::ToolCalls(turn) => Chunk::ToolCalls(turn.cleared(clear)),
            Chunk::Finished(finish) => Chunk::Finished(match finish {
                Finish::Refusal(text) => Finish::Refusal(clear(text)),
                Finish::Blocked(text) => Finish::Blocked(clear(text)),
                Finish::Other(text) => Finish::Other(clear(text)),
                other => other,
            }),
            other => other,
        }))
    }

    /// The usage with what it cost, which is taken from the budget.
    fn priced(&mut self, mut usage: Usage) -> Usage {
        if usage.cost.is_none() {
            let day = self.asked.to_zoned(TimeZone::UTC).date();
            let prices = &self.endpoint.prices;
            let pricing = prices.of_answer(&self.request.model, self.returned.as_deref(), day);
            usage.cost = pricing
                .and_then(|pricing| pricing.cost(&usage, self.asked))
                .map(|usd| Cost {
                    usd,
                    source: CostSource::Prices,
                });
        }
        if let Some(cost) = usage.cost
            && let Some(reserved) = self.reserved.take()
        {
            reserved.settle(cost.usd);
        }
        usage
    }

    fn fail(&mut self, error: Error) -> State {
        self.queue.push_back(Err(error));
        State::Over
    }

    async fn prepare(&mut self) -> State {
        let (name, model) = (&self.endpoint.name, &self.request.model);
        let refused = |part| self.client.has_refused(name, model, part);
        let bounds = self.endpoint.is_here() && !refused(Dispensable::Bounds);
        let (form, options) = (
            refused(Dispensable::Form),
            refused(Dispensable::StreamOptions),
        );
        if form {
            self.endpoint.response_format = ResponseFormat::Off;
        }
        if let Some(schema) = &mut self.request.schema {
            schema.is_bounded = bounds;
        }
        self.endpoint.quirks.stream_options &= !options;
        match Ready::new(&self.client, &mut self.endpoint, &self.request).await {
            Ok(ready) => {
                self.secrets = self.endpoint.secrets();
                self.redactors = Redactors::new(&self.secrets);
                let notes = ready.notes.into_iter().map(|note| Ok(Chunk::Note(note)));
                self.queue.extend(notes);
                self.place = ready.place;
                self.reserved = ready.reserved;
                State::Sending(Box::new(ready.sending))
            }
            Err(error) => self.fail(error),
        }
    }

    fn may_be_paid(&mut self, yes: bool) {
        if let Some(reserved) = &mut self.reserved {
            reserved.may_be_paid(yes);
        }
    }

    async fn send(&mut self, mut sending: Box<Sending>) -> State {
        if let Err(why) = sending.gate.admit(sending.tokens).await {
            let place = self.endpoint.place();
            return self.fail(Error::Setup { place, why });
        }
        if sending.attempt == 1 {
            // Waiting for a turn does not count against the server's deadlines.
            sending.patience = Deadlines::starting_now(self.endpoint.timeouts);
        }
        self.asked = Timestamp::now();
        self.may_be_paid(true);
        let error = match self.answer(&mut sending).await {
            Ok(response) => return self.begin(response, sending.patience).await,
            Err(error) => error,
        };
        if let Some(part) = self.refused_part(&error) {
            return self.again_without(part, &error);
        }
        let (retry, status) = (error.retry(), error.status());
        // A refused request is not paid for; one that may be in progress may be.
        self.may_be_paid(status.is_none() && !retry.may_pass);
        if let (Some(401 | 403), Some(command)) = (status, &self.endpoint.key_command) {
            self.client.forget_key(command);
        }
        if !retry.may_pass {
            return self.fail(error);
        }
        let longest = self.endpoint.retry.longest_wait;
        if let Some(status) = status
            && retry.after().is_some_and(|asked| asked > longest)
        {
            return self.fail(Error::RateLimited {
                place: self.endpoint.place(),
                status,
                message: error.cause().into_owned(),
                retry,
                exhausted: false,
            });
        }
        let waits = sending.waits.next();
        let Some(wait) = waits.map(|wait| retry.after().unwrap_or(wait.min(longest))) else {
            return self.fail(error);
        };
        // The total time would run out during the wait; what went wrong says more than a timeout then.
        if wait >= sending.patience.left() {
            return self.fail(error);
        }
        sending.attempt += 1;
        let status = status.map(|s| format!("{s}: ")).unwrap_or_default();
        let message = self.secrets.redact_cut(&error.cause());
        let why = tidy(&format!("{status}{message}"), 200);
        self.queue.push_back(Ok(Chunk::Retrying {
            attempt: sending.attempt,
            wait,
            why,
        }));
        State::Waiting(wait, sending)
    }

    /// The part that a server refuses and that requests can do without: the form of the answer, which servers on this machine
    /// are asked for by default, and the usage in the stream.
    fn refused_part(&self, error: &Error) -> Option<Dispensable> {
        const FORM: [&str; 5] = [
            "response_format",
            "json_schema",
            "schema",
            "grammar",
            "structured",
        ];
        if !matches!(error, Error::BadRequest { .. } | Error::Server { .. }) {
            return None;
        }
        let cause = error.cause().to_lowercase();
        let has_form = self.request.schema.is_some()
            && self.endpoint.response_format != ResponseFormat::Off
            && self.endpoint.is_here();
        if has_form && FORM.iter().any(|word| cause.contains(word)) {
            let schema = self.request.schema.as_ref();
            let is_bounded = self.endpoint.response_format == ResponseFormat::JsonSchema
                && schema.is_some_and(|schema| schema.is_bounded);
            return Some(if is_bounded {
                Dispensable::Bounds
            } else {
                Dispensable::Form
            });
        }
        let has_options = self.endpoint.quirks.stream_options;
        (has_options && cause.contains("stream_options")).then_some(Dispensable::StreamOptions)
    }

    /// Asks once more, and from now on, without it.
    fn again_without(&mut self, part: Dispensable, error: &Error) -> State {
        let (provider, model) = (&self.endpoint.name, &self.request.model);
        self.client.refuses(provider, model, part);
        let cause = tidy(&self.secrets.redact_cut(&error.cause()), 200);
        let what = match part {
            Dispensable::Bounds => "bounds in the form of the answer",
            Dispensable::Form => "form of the answer",
            Dispensable::StreamOptions => "stream_options, and may not tell the tokens",
        };
        let note = format!("the server takes no {what} ({cause}); asked without");
        self.queue.push_back(Ok(Chunk::Note(note)));
        // A refused request is not paid for, and its place is free.
        self.may_be_paid(false);
        (self.reserved, self.place) = (None, None);
        State::New
    }

    // Exclusive borrows, because shared ones of what is not `Sync` would tie the stream to one thread.
    async fn answer(&mut self, sending: &mut Sending) -> Result<Response, Error> {
        let request = sending
            .http
            .post(sending.url.clone())
            .headers(sending.headers.clone());
        let sent = sending
            .patience
            .wait(request.body(sending.body.clone()).send())
            .await;
        match sent {
            Ok(Ok(response)) if response.status().is_success() => Ok(response),
            Ok(Ok(response)) => Err(Error::answered(
                response,
                &self.endpoint,
                &self.request.model,
                sending.patience,
            )
            .await),
            Ok(Err(error)) => Err(Error::unanswered(&error, &self.endpoint)),
            Err(elapsed) => Err(Error::silence(elapsed, &self.endpoint)),
        }
    }

    async fn begin(&mut self, response: Response, patience: Deadlines) -> State {
        let framing = self.endpoint.dialect.protocol().framing();
        let mut decoder = Decoder::new(self.endpoint.dialect, self.endpoint.place());
        let mut pieces = response_texts(response, patience);
        // A body is what it begins with: proxies and servers name its kind as they like.
        let begun = beginning(&mut pieces).await;
        let first = begun
            .as_ref()
            .ok()
            .and_then(|text| text.trim_start().chars().next());
        if first == Some('<') {
            let what = "a web page; is the address that of a website?".to_owned();
            return self.fail(Error::Malformed {
                place: self.endpoint.place(),
                what,
            });
        }
        let pieces = stream::iter([begun]).chain(pieces);
        // Where a line is an object, one object alone is a line too.
        if matches!(first, Some('{' | '[')) && framing == Framing::Events {
            let items = match join_to_end(pieces, LONGEST_DOCUMENT).await {
                Ok(body) => match decoder.document(&body) {
                    Ok(chunks) => chunks.into_iter().map(Ok).collect(),
                    Err(error) => decoder.failed(error),
                },
                Err((_, fault)) => ended(&mut decoder, fault),
            };
            self.queue.extend(items);
            return State::Over;
        }
        let frames = frames(pieces, framing);
        State::Reading(Box::new(Reading {
            frames,
            decoder,
            events: 0,
        }))
    }

    async fn read(&mut self, mut reading: Box<Reading>) -> State {
        // One piece of the body may hold thousands of events; between them everything else gets its turn.
        reading.events += 1;
        if reading.events.is_multiple_of(EVENTS_PER_TURN) {
            yield_now().await;
        }
        let items = step(&mut reading.frames, &mut reading.decoder).await;
        self.queue.extend(items);
        // The connection is dropped with the frames: some servers keep it open after the end.
        if reading.decoder.is_done() {
            State::Over
        } else {
            State::Reading(reading)
        }
    }
}
