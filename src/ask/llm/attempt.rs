//! A failed attempt: why it brought no answer, whether and when to retry, and whether the next question would fail too.

use std::borrow::Cow;
use std::io;
use std::time::Duration;

use backon::{BackoffBuilder, ExponentialBackoff, ExponentialBuilder};
use jiff::Timestamp;
use jiff::fmt::rfc2822::DateTimeParser;
use reqwest::Response;
use reqwest::header::{HeaderMap, LOCATION, RETRY_AFTER};

use super::body_text::{Deadlines, Elapsed, read_to_end};
use super::client::{deepest, has_io_kind, is_tls};
use super::endpoint::{Endpoint, Retry, plain};
use super::error::{Error, TimeoutKind};
use super::error_body::ErrorBody;

/// Most of a failed answer's body that is read, in bytes.
const MAX_PROBLEM_BYTES: usize = 64 << 10;

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
        let body = read_to_end(response, patience, MAX_PROBLEM_BYTES)
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

/// The waits between tries; ends when the tries are used up. Random parts keep a batch from asking in step.
pub(super) fn waits(retry: Retry) -> ExponentialBackoff {
    ExponentialBuilder::new()
        .with_min_delay(retry.first_wait)
        .with_factor(2.0)
        .with_max_delay(retry.longest_wait)
        .with_max_times(retry.attempts.max(1) as usize - 1)
        .with_jitter()
        .build()
}

/// Whether an answer of this status may be followed by a better one. 409 is a lock timeout, 529 "overloaded".
pub(super) fn may_pass(status: u16, headers: &HeaderMap, body: &ErrorBody) -> bool {
    let says = headers.get("x-should-retry");
    let says = |word: &[u8]| says.is_some_and(|v| v.as_bytes().eq_ignore_ascii_case(word));
    let passing = matches!(status, 408 | 409 | 429 | 500 | 502 | 503 | 504 | 529);
    (passing || says(b"true")) && !says(b"false") && !body.is_exhausted()
}

/// The wait the server asks for: `retry-after-ms`, `retry-after` in seconds or as a date, or a word in the body.
pub(super) fn asked_wait(
    headers: &HeaderMap,
    body: &ErrorBody,
    now: Timestamp,
) -> Option<Duration> {
    let header = |name: &str| headers.get(name)?.to_str().ok().map(str::trim);
    let milliseconds = header("retry-after-ms")
        .and_then(|v| v.parse().ok())
        .map(|ms: f64| ms / 1000.0);
    let seconds =
        || header(RETRY_AFTER.as_str()).and_then(|v| v.parse().ok().or_else(|| until(v, now)));
    milliseconds
        .or_else(seconds)
        .and_then(|s: f64| Duration::try_from_secs_f64(s.max(0.0)).ok())
        .or(body.retry_delay)
}

fn until(date: &str, now: Timestamp) -> Option<f64> {
    // Servers get the weekday wrong more often than the day.
    let parser = DateTimeParser::new().relaxed_weekday(true);
    let then = parser.parse_timestamp(date).ok()?;
    Some(then.duration_since(now).as_secs_f64())
}

/// An obstacle between a server and every question to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProviderOutage {
    /// No response: no connection, or one on which nothing ever came. It may pass.
    Silence,
    /// The server forbids it (403): mostly the key may not do this, with some servers the question was blocked.
    Forbidden,
    /// The server takes no question to this model as things stand: wrong key, unknown model, used-up quota, another
    /// address.
    Refused,
}

impl Error {
    /// The obstacle to every other question, too; `None` if the error concerns this one alone. Silence counts only if
    /// nothing of an answer had arrived.
    #[must_use]
    pub fn barrier(&self) -> Option<ProviderOutage> {
        match self {
            Self::Refused { .. } | Self::Unreachable { .. } | Self::Tls { .. } => {
                Some(ProviderOutage::Silence)
            }
            Self::Timeout { which, .. } => match which {
                TimeoutKind::Connect | TimeoutKind::Idle => Some(ProviderOutage::Silence),
                // A model may need longer for one question than for another.
                TimeoutKind::Total => None,
            },
            Self::Truncated { received: 0, .. } => Some(ProviderOutage::Silence),
            Self::Unauthorized { status: 403, .. } => Some(ProviderOutage::Forbidden),
            Self::Unauthorized { .. } | Self::NotFound { .. } | Self::Redirected { .. } => {
                Some(ProviderOutage::Refused)
            }
            Self::RateLimited { exhausted, .. } => exhausted.then_some(ProviderOutage::Refused),
            Self::Setup { .. }
            | Self::BadRequest { .. }
            | Self::Server { .. }
            | Self::Truncated { .. }
            | Self::Malformed { .. }
            | Self::Budget { .. }
            | Self::Provider { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn asked(name: &'static str, value: &'static str) -> Option<Duration> {
        let now = "2015-10-21T07:28:00Z".parse().unwrap();
        let headers = HeaderMap::from_iter([(name.parse().unwrap(), value.parse().unwrap())]);
        asked_wait(&headers, &ErrorBody::default(), now)
    }

    #[test]
    fn the_server_may_say_how_long() {
        assert_eq!(
            asked("retry-after-ms", "1500"),
            Some(Duration::from_millis(1500))
        );
        assert_eq!(asked("retry-after", " 7 "), Some(Duration::from_secs(7)));
        assert_eq!(
            asked("retry-after", "0.25"),
            Some(Duration::from_millis(250))
        );
        assert_eq!(
            asked("retry-after", "Wed, 21 Oct 2015 07:28:30 GMT"),
            Some(Duration::from_secs(30))
        );
        assert_eq!(
            asked("retry-after", "Wed, 21 Oct 2015 07:00:00 GMT"),
            Some(Duration::ZERO)
        );
        assert_eq!(asked("retry-after", "-3"), Some(Duration::ZERO));
        for nonsense in ["soon", "", "NaN", "inf", "1e300"] {
            let wait = asked("retry-after", nonsense);
            assert!(wait.is_none_or(|w| w.is_zero()), "{nonsense}: {wait:?}");
        }
    }

    #[test]
    fn tries_are_counted_and_waits_grow() {
        let retry = Retry {
            attempts: 4,
            first_wait: Duration::from_secs(1),
            longest_wait: Duration::from_secs(3),
        };
        let waits: Vec<f64> = waits(retry).map(|w| w.as_secs_f64()).collect();
        assert_eq!(waits.len(), 3);
        assert!(
            (1.0..=2.0).contains(&waits[0])
                && (2.0..=4.0).contains(&waits[1])
                && (3.0..=6.0).contains(&waits[2]),
            "{waits:?}"
        );
        assert_eq!(
            super::waits(Retry {
                attempts: 0,
                ..retry
            })
            .count(),
            0
        );
    }

    #[test]
    fn what_may_pass() {
        let none = HeaderMap::new();
        let ok = ErrorBody::default();
        for status in [408, 409, 429, 500, 502, 503, 504, 529] {
            assert!(may_pass(status, &none, &ok));
        }
        for status in [400, 401, 402, 403, 404, 413, 422, 501] {
            assert!(!may_pass(status, &none, &ok));
        }
        let no =
            HeaderMap::from_iter([("x-should-retry".parse().unwrap(), "false".parse().unwrap())]);
        assert!(!may_pass(500, &no, &ok));
        let yes =
            HeaderMap::from_iter([("x-should-retry".parse().unwrap(), "true".parse().unwrap())]);
        assert!(may_pass(501, &yes, &ok));
        let empty = ErrorBody {
            kind: Some("insufficient_quota".into()),
            ..ErrorBody::default()
        };
        assert!(!may_pass(429, &none, &empty));
    }
}
