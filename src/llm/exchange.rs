//! One question and its answer on the network: tries, waits, and the reading of the stream.

use std::collections::VecDeque;
use std::mem;
use std::pin::Pin;
use std::time::Duration;

use backon::ExponentialBackoff;
use eventsource_stream::{Event, EventStreamError, Eventsource};
use futures_util::stream::{Stream, StreamExt};
use reqwest::header::{AUTHORIZATION, CONTENT_TYPE, HeaderValue};
use reqwest::{Response, Url};

use super::chunk::Chunk;
use super::client::Client;
use super::endpoint::Endpoint;
use super::error::{Error, without_key};
use super::failure::Failure;
use super::openai_chat::{self, Decoder};
use super::patience::{Elapsed, Patience};
use super::problem::tidy;
use super::request::Request;
use super::retry::waits;
use super::text::{Fault, texts, whole};

/// Most of an unstreamed answer that is read, in bytes.
const LONGEST_DOCUMENT: usize = 16 << 20;

type Events = Pin<Box<dyn Stream<Item = Result<Event, EventStreamError<Fault>>> + Send>>;

/// The state machine behind [`super::stream`].
pub(super) struct Exchange {
    client: Client,
    endpoint: Endpoint,
    request: Request,
    queue: VecDeque<Result<Chunk, Error>>,
    state: State,
}

enum State {
    New,
    Sending(Box<Sending>),
    Waiting(Duration, Box<Sending>),
    Reading(Box<Reading>),
    Over,
}

/// A request ready to go, any number of times.
struct Sending {
    http: reqwest::Client,
    url: Url,
    key: Option<HeaderValue>,
    body: Vec<u8>,
    patience: Patience,
    waits: ExponentialBackoff,
    attempt: u32,
}

struct Reading {
    events: Events,
    decoder: Decoder,
}

impl Exchange {
    pub fn new(client: Client, endpoint: Endpoint, request: Request) -> Self {
        Self {
            client,
            endpoint,
            request,
            queue: VecDeque::new(),
            state: State::New,
        }
    }

    /// The next chunk, with the key taken out of what the server said; `None` after the last.
    pub async fn next(&mut self) -> Option<Result<Chunk, Error>> {
        loop {
            if let Some(item) = self.queue.pop_front() {
                if item.is_err() {
                    self.state = State::Over;
                    self.queue.clear();
                }
                return Some(item.map_err(|e| e.cleared_of(self.endpoint.usable_key())));
            }
            self.state = match mem::replace(&mut self.state, State::Over) {
                State::New => self.prepare(),
                State::Sending(sending) => self.send(sending).await,
                State::Waiting(wait, sending) => {
                    tokio::time::sleep(wait).await;
                    State::Sending(sending)
                }
                State::Reading(reading) => self.read(reading).await,
                State::Over => return None,
            };
        }
    }

    fn fail(&mut self, error: Error) -> State {
        self.queue.push_back(Err(error));
        State::Over
    }

    fn prepare(&mut self) -> State {
        match self.prepared() {
            Ok(sending) => State::Sending(Box::new(sending)),
            Err(error) => self.fail(error),
        }
    }

    fn prepared(&self) -> Result<Sending, Error> {
        let endpoint = &self.endpoint;
        let wrong = |why| Error::Setup {
            place: endpoint.place(),
            why,
        };
        let url = endpoint.chat_url()?;
        let key = endpoint.usable_key().map(|key| {
            let source = endpoint
                .key_source
                .as_deref()
                .unwrap_or("the configuration");
            let mut value = HeaderValue::from_str(&format!("Bearer {key}")).map_err(|_| {
                wrong(format!(
                    "the key from {source} holds characters that no key has; copy it again"
                ))
            })?;
            value.set_sensitive(true);
            Ok(value)
        });
        let http = self.client.http(endpoint.timeouts.connect).map_err(wrong)?;
        Ok(Sending {
            http,
            url,
            key: key.transpose()?,
            body: openai_chat::body(endpoint, &self.request)
                .to_string()
                .into_bytes(),
            patience: Patience::starting_now(endpoint.timeouts),
            waits: waits(endpoint.retry),
            attempt: 1,
        })
    }

    async fn send(&mut self, mut sending: Box<Sending>) -> State {
        let failure = match self.answer(&mut sending).await {
            Ok(response) => return self.begin(response, sending.patience).await,
            Err(failure) => failure,
        };
        let longest = self.endpoint.retry.longest_wait;
        let too_long = failure
            .asked
            .filter(|asked| failure.may_pass && *asked > longest);
        if let (Some(asked), Some(status)) = (too_long, failure.status) {
            return self.fail(Error::RateLimited {
                place: self.endpoint.place(),
                status,
                message: failure.message,
                retry_after: Some(asked),
                exhausted: false,
            });
        }
        if !failure.may_pass {
            return self.fail(failure.error);
        }
        let Some(wait) = sending
            .waits
            .next()
            .map(|w| failure.asked.unwrap_or(w.min(longest)))
        else {
            return self.fail(failure.error);
        };
        // The total time would run out during the wait; what went wrong says more than a timeout then.
        if wait >= sending.patience.left() {
            return self.fail(failure.error);
        }
        sending.attempt += 1;
        let status = failure.status.map(|s| format!("{s}: ")).unwrap_or_default();
        let message = without_key(&failure.message, self.endpoint.usable_key());
        let why = tidy(&format!("{status}{message}"), 200);
        self.queue.push_back(Ok(Chunk::Retrying {
            attempt: sending.attempt,
            wait,
            why,
        }));
        State::Waiting(wait, sending)
    }

    // Exclusive borrows, because shared ones of what is not `Sync` would tie the stream to one thread.
    async fn answer(&mut self, sending: &mut Sending) -> Result<Response, Failure> {
        let mut request = sending
            .http
            .post(sending.url.clone())
            .header(CONTENT_TYPE, "application/json");
        if let Some(key) = &sending.key {
            request = request.header(AUTHORIZATION, key.clone());
        }
        let sent = sending
            .patience
            .wait(request.body(sending.body.clone()).send())
            .await;
        match sent {
            Ok(Ok(response)) if response.status().is_success() => Ok(response),
            Ok(Ok(response)) => Err(Failure::answered(
                response,
                &self.endpoint,
                &self.request.model,
                sending.patience,
            )
            .await),
            Ok(Err(error)) => Err(Failure::unanswered(&error, &self.endpoint)),
            Err(elapsed) => Err(Failure::silence(elapsed, &self.endpoint)),
        }
    }

    async fn begin(&mut self, response: Response, patience: Patience) -> State {
        let kind = response
            .headers()
            .get(CONTENT_TYPE)
            .and_then(|v| v.to_str().ok())
            .unwrap_or_default();
        let kind = kind
            .split(';')
            .next()
            .unwrap_or_default()
            .trim()
            .to_ascii_lowercase();
        let mut decoder = Decoder::new(self.endpoint.place());
        if kind == "text/html" {
            let what = "a web page; the address may be that of a page for people".to_owned();
            return self.fail(Error::Malformed {
                place: self.endpoint.place(),
                what,
            });
        }
        if kind == "application/json" {
            let items = match whole(response, patience, LONGEST_DOCUMENT).await {
                Ok(body) => match decoder.document(&body) {
                    Ok(chunks) => chunks.into_iter().map(Ok).collect(),
                    Err(error) => decoder.failed(error),
                },
                Err((_, fault)) => self.ended(&mut decoder, fault),
            };
            self.queue.extend(items);
            return State::Over;
        }
        let events = Box::pin(texts(response.bytes_stream(), patience).eventsource());
        State::Reading(Box::new(Reading { events, decoder }))
    }

    async fn read(&mut self, mut reading: Box<Reading>) -> State {
        let decoder = &mut reading.decoder;
        let items = match reading.events.next().await {
            Some(Ok(event)) if event.event == "error" => {
                let error = decoder.error_event(&event.data);
                decoder.failed(error)
            }
            Some(Ok(event)) => match decoder.event(&event.data) {
                Ok(chunks) => {
                    self.queue.extend(chunks.into_iter().map(Ok));
                    // The connection is dropped with the events: some servers keep it open after the end.
                    return if decoder.is_done() {
                        State::Over
                    } else {
                        State::Reading(reading)
                    };
                }
                Err(error) => decoder.failed(error),
            },
            Some(Err(EventStreamError::Transport(fault))) => self.ended(decoder, fault),
            Some(Err(EventStreamError::Utf8(_) | EventStreamError::Parser(_))) => {
                self.ended(decoder, Fault::NotText)
            }
            // An event begun but not ended by an empty line has been dropped by the parser, as the standard wants.
            None => self.ended(decoder, Fault::Cut("the stream ended early".to_owned())),
        };
        self.queue.extend(items);
        State::Over
    }

    fn ended(&self, decoder: &mut Decoder, fault: Fault) -> Vec<Result<Chunk, Error>> {
        decoder.ended(|place, received| match fault {
            Fault::Elapsed(Elapsed { which, after }) => Error::Timeout {
                place,
                which,
                after,
            },
            Fault::Cut(why) => Error::Truncated {
                place,
                received,
                why,
            },
            Fault::NotText => Error::Malformed {
                place,
                what: "bytes that are no UTF-8 text".to_owned(),
            },
            Fault::TooLong => Error::Malformed {
                place,
                what: "more than any answer can be".to_owned(),
            },
        })
    }
}
