//! A failed attempt: why it brought no answer, and whether a retry may help.

use std::borrow::Cow;
use std::io;
use std::time::Duration;

use jiff::Timestamp;
use reqwest::Response;
use reqwest::header::LOCATION;

use super::body_text::whole;
use super::client::{deepest, has_io_kind, is_tls};
use super::deadlines::{Deadlines, Elapsed};
use super::endpoint::{Endpoint, plain};
use super::error::{Error, TimeoutKind};
use super::error_body::ErrorBody;
use super::retry::{asked_wait, may_pass};

/// Most of a failed answer's body that is read, in bytes.
const LONGEST_PROBLEM: usize = 64 << 10;

/// How long it is read at most.
const PROBLEM_PATIENCE: Duration = Duration::from_secs(10);

/// Whether and when to retry a request that the server refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RetryHint {
    /// Another try may go better, and this one cost nothing.
    pub may_pass: bool,
    /// How long the server asks to wait, milliseconds, if it said so; a `Duration` would make every error larger.
    after_ms: Option<u32>,
}

impl RetryHint {
    pub(super) fn new(may_pass: bool, after: Option<Duration>) -> Self {
        let milliseconds = |wait: Duration| u32::try_from(wait.as_millis()).unwrap_or(u32::MAX);
        Self {
            may_pass,
            after_ms: after.map(milliseconds),
        }
    }

    /// How long the server asks to wait, if it said so.
    #[must_use]
    pub fn after(self) -> Option<Duration> {
        self.after_ms.map(|wait| Duration::from_millis(wait.into()))
    }
}

impl Error {
    /// The HTTP status of the answer; `None` if there was no answer at all, or the error came later.
    pub(super) fn status(&self) -> Option<u16> {
        match self {
            Self::Unauthorized { status, .. }
            | Self::RateLimited { status, .. }
            | Self::BadRequest { status, .. }
            | Self::Redirected { status, .. }
            | Self::Server { status, .. } => Some(*status),
            Self::NotFound { .. } => Some(404),
            _ => None,
        }
    }

    /// Whether and when to try again.
    pub(super) fn retry(&self) -> RetryHint {
        match self {
            Self::Unauthorized { retry, .. }
            | Self::NotFound { retry, .. }
            | Self::RateLimited { retry, .. }
            | Self::BadRequest { retry, .. }
            | Self::Redirected { retry, .. }
            | Self::Server { retry, .. } => *retry,
            Self::Unreachable { .. } => RetryHint::new(true, None),
            Self::Timeout { which, .. } => RetryHint::new(*which == TimeoutKind::Connect, None),
            _ => RetryHint::default(),
        }
    }

    /// The cause in a few words, the server's if it said any.
    pub(super) fn cause(&self) -> Cow<'_, str> {
        match self {
            Self::Setup { why, .. }
            | Self::Refused { why, .. }
            | Self::Unreachable { why, .. }
            | Self::Tls { why, .. }
            | Self::Truncated { why, .. }
            | Self::Budget { why, .. } => why.into(),
            Self::Unauthorized { message, .. }
            | Self::NotFound { message, .. }
            | Self::RateLimited { message, .. }
            | Self::BadRequest { message, .. }
            | Self::Server { message, .. }
            | Self::Provider { message, .. } => message.into(),
            Self::Redirected { to, .. } => to.into(),
            Self::Malformed { what, .. } => what.into(),
            Self::Timeout { after, .. } => format!("no answer in {} s", after.as_secs_f64()).into(),
        }
    }

    /// No answer in time. The request may be worked on and paid for, so it is not repeated.
    pub(super) fn silence(elapsed: Elapsed, endpoint: &Endpoint) -> Self {
        let Elapsed { which, after } = elapsed;
        Self::Timeout {
            place: endpoint.place(),
            which,
            after,
        }
    }

    /// No answer because of the network. Only what failed before the request was sent may pass.
    pub(super) fn unanswered(error: &reqwest::Error, endpoint: &Endpoint) -> Self {
        let (place, why) = (endpoint.place(), deepest(error));
        if error.is_builder() {
            Self::Setup { place, why }
        } else if error.is_dns() || has_io_kind(error, io::ErrorKind::ConnectionRefused) {
            Self::Refused { place, why }
        } else if is_tls(error) {
            Self::Tls { place, why }
        } else if error.is_connect() && error.is_timeout() {
            Self::Timeout {
                place,
                which: TimeoutKind::Connect,
                after: endpoint.timeouts.connect,
            }
        } else if error.is_connect() {
            Self::Unreachable { place, why }
        } else {
            // The request may have arrived, and its answer may be paid for.
            Self::Truncated {
                place,
                received: 0,
                why,
            }
        }
    }

    /// An answer with an error status.
    pub(super) async fn answered(
        response: Response,
        endpoint: &Endpoint,
        model: &str,
        patience: Deadlines,
    ) -> Self {
        let status = response.status().as_u16();
        let headers = response.headers().clone();
        let here = response.url().clone();
        // Whatever part of the explanation arrives will do.
        let patience = patience.at_most(PROBLEM_PATIENCE);
        let body = whole(response, patience, LONGEST_PROBLEM)
            .await
            .unwrap_or_else(|(part, _)| part);
        let body = ErrorBody::in_body(&endpoint.secrets().redact_cut(&body));
        let retry = RetryHint::new(
            may_pass(status, &headers, &body),
            asked_wait(&headers, &body, Timestamp::now()),
        );
        let exhausted = status == 402 || body.is_exhausted();
        let (place, message) = (endpoint.place(), body.message);
        match status {
            300..=399 => {
                let to = headers
                    .get(LOCATION)
                    .and_then(|l| here.join(l.to_str().ok()?).ok())
                    .map_or_else(
                        || "an address it does not name".to_owned(),
                        |url| plain(&url),
                    );
                Self::Redirected {
                    place,
                    status,
                    to,
                    retry,
                }
            }
            401 | 403 => Self::Unauthorized {
                place,
                status,
                message,
                key_source: endpoint.key_source.clone(),
                key_sent: endpoint.usable_key().is_some(),
                retry,
            },
            404 => Self::NotFound {
                place,
                model: model.to_owned(),
                message,
                retry,
            },
            402 | 429 => Self::RateLimited {
                place,
                status,
                message,
                retry,
                exhausted,
            },
            408 | 409 | 500.. => Self::Server {
                place,
                status,
                message,
                retry,
            },
            _ => Self::BadRequest {
                place,
                status,
                message,
                retry,
            },
        }
    }
}
