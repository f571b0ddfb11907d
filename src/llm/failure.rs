//! A try that brought no answer: what it means, and whether another try may help.

use std::io;
use std::time::Duration;

use jiff::Timestamp;
use reqwest::Response;
use reqwest::header::LOCATION;

use super::client::{deepest, has_io_kind, is_tls};
use super::deadlines::{Deadlines, Elapsed};
use super::endpoint::{Endpoint, plain};
use super::error::{Error, Which};
use super::problem::Problem;
use super::retry::{asked_wait, may_pass};
use super::text::whole;

/// Most of a failed answer's body that is read, in bytes.
const LONGEST_PROBLEM: usize = 64 << 10;

/// How long it is read at most.
const PROBLEM_PATIENCE: Duration = Duration::from_secs(10);

/// What one try came to.
pub(super) struct Failure {
    /// The error, if there is no further try.
    pub error: Error,
    /// Another try may go better, and this one cost nothing.
    pub may_pass: bool,
    /// The wait the server asks for.
    pub asked: Option<Duration>,
    /// The HTTP status; `None` if there was no answer at all.
    pub status: Option<u16>,
    /// The cause in a few words, the server's if it said any.
    pub message: String,
}

impl Failure {
    /// No answer in time. The request may be worked on and paid for, so it is not repeated.
    pub fn silence(elapsed: Elapsed, endpoint: &Endpoint) -> Self {
        let Elapsed { which, after } = elapsed;
        Self::without_status(
            Error::Timeout {
                place: endpoint.place(),
                which,
                after,
            },
            false,
            "no answer".to_owned(),
        )
    }

    /// No answer because of the network. Only what failed before the request was sent may pass.
    pub fn unanswered(error: &reqwest::Error, endpoint: &Endpoint) -> Self {
        let (place, why) = (endpoint.place(), deepest(error));
        let message = why.clone();
        let (error, may_pass) = if error.is_builder() {
            (Error::Setup { place, why }, false)
        } else if error.is_dns() || has_io_kind(error, io::ErrorKind::ConnectionRefused) {
            (Error::Refused { place, why }, false)
        } else if is_tls(error) {
            (Error::Tls { place, why }, false)
        } else if error.is_connect() && error.is_timeout() {
            (
                Error::Timeout {
                    place,
                    which: Which::Connect,
                    after: endpoint.timeouts.connect,
                },
                true,
            )
        } else if error.is_connect() {
            (Error::Unreachable { place, why }, true)
        } else {
            // The request may have arrived, and its answer may be paid for.
            (
                Error::Truncated {
                    place,
                    received: 0,
                    why,
                },
                false,
            )
        };
        Self::without_status(error, may_pass, message)
    }

    /// An answer with an error status.
    pub async fn answered(
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
        let problem = Problem::in_body(&endpoint.secrets().redact_cut(&body));
        let asked = asked_wait(&headers, &problem, Timestamp::now());
        let may_pass = may_pass(status, &headers, &problem);
        let exhausted = status == 402 || problem.is_exhausted();
        let message = problem.message.clone();
        let place = endpoint.place();
        let error = match status {
            300..=399 => {
                let to = headers
                    .get(LOCATION)
                    .and_then(|l| here.join(l.to_str().ok()?).ok());
                let to = to.map_or_else(
                    || "an address it does not name".to_owned(),
                    |url| plain(&url),
                );
                Error::Redirected { place, status, to }
            }
            401 | 403 => Error::Unauthorized {
                place,
                status,
                message,
                key_source: endpoint.key_source.clone(),
                key_sent: endpoint.usable_key().is_some(),
            },
            404 => Error::NotFound {
                place,
                model: model.to_owned(),
                message,
            },
            402 | 429 => Error::RateLimited {
                place,
                status,
                message,
                retry_after: asked,
                exhausted,
            },
            408 | 409 | 500.. => Error::Server {
                place,
                status,
                message,
            },
            _ => Error::BadRequest {
                place,
                status,
                message,
            },
        };
        Self {
            error,
            may_pass,
            asked,
            status: Some(status),
            message: problem.message,
        }
    }

    fn without_status(error: Error, may_pass: bool, message: String) -> Self {
        Self {
            error,
            may_pass,
            asked: None,
            status: None,
            message,
        }
    }
}
