//! Why one try brought no answer, and whether another may help.

use std::io;
use std::time::Duration;

use jiff::Timestamp;
use reqwest::Response;
use reqwest::header::LOCATION;

use super::client::{deepest, has_io_kind, is_tls};
use super::deadlines::{Deadlines, Elapsed};
use super::endpoint::{Endpoint, plain};
use super::error::{Error, RetryHint, Which};
use super::error_body::ErrorBody;
use super::retry::{asked_wait, may_pass};
use super::text::whole;

/// Most of a failed answer's body that is read, in bytes.
const LONGEST_PROBLEM: usize = 64 << 10;

/// How long it is read at most.
const PROBLEM_PATIENCE: Duration = Duration::from_secs(10);

impl Error {
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
                which: Which::Connect,
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
        let retry = RetryHint {
            may_pass: may_pass(status, &headers, &body),
            after: asked_wait(&headers, &body, Timestamp::now()),
        };
        let exhausted = status == 402 || body.is_exhausted();
        let (place, message) = (endpoint.place(), body.message);
        match status {
            300..=399 => {
                let to = headers
                    .get(LOCATION)
                    .and_then(|l| here.join(l.to_str().ok()?).ok());
                let to = to.map_or_else(
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
