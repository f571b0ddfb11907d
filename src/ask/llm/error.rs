//! Errors between a question and its answer, worded so that users know what to do.

use std::fmt;
use std::time::Duration;

use super::attempt::RetryHint;
use super::error_body::{MAX_QUOTE_LENGTH, tidy};
use super::redaction::Secrets;

/// Place of an error: the provider and the address without its secrets.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProviderAddress {
    /// The provider's name as people know it.
    pub provider: String,
    /// Scheme, host, port and path.
    pub url: String,
}

impl fmt::Display for ProviderAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.provider, self.url)
    }
}

/// The deadline that passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeoutKind {
    /// No connection.
    Connect,
    /// Nothing was received for a while.
    Idle,
    /// The whole exchange took too long.
    Total,
}

/// A failed exchange. No variant ever holds a secret; texts of the server are tidied to one line of at most 1,000
/// characters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The endpoint cannot be used as configured: address, key or the machine's certificates.
    #[error("cannot use {place}: {why}")]
    Setup {
        /// Where.
        place: ProviderAddress,
        /// The problem and its remedy.
        why: String,
    },
    /// Nothing listens there, or the name is unknown.
    #[error(
        "cannot reach {place}: {why}; check that the server is running and the address is right"
    )]
    Refused {
        /// Where.
        place: ProviderAddress,
        /// The system's reason.
        why: String,
    },
    /// The network failed before the request was sent, and kept failing.
    #[error("cannot reach {place}: {why}; check the network, then try again")]
    Unreachable {
        /// Where.
        place: ProviderAddress,
        /// The system's reason.
        why: String,
    },
    /// No encrypted connection.
    #[error(
        "no secure connection to {place}: {why}; check the address, the clock and the certificates of this machine"
    )]
    Tls {
        /// Where.
        place: ProviderAddress,
        /// The reason.
        why: String,
    },
    /// Patience ran out.
    #[error("{}", timeout_text(place, *which, *after))]
    Timeout {
        /// Where.
        place: ProviderAddress,
        /// Which limit was hit.
        which: TimeoutKind,
        /// The limit.
        after: Duration,
    },
    /// 401 or 403: the key is missing, wrong, or not allowed to do this.
    #[error("{}", unauthorized_text(place, *status, message, key_source.as_deref(), *key_sent))]
    Unauthorized {
        /// Where.
        place: ProviderAddress,
        /// The HTTP status.
        status: u16,
        /// The server's words.
        message: String,
        /// Where the key comes from.
        key_source: Option<String>,
        /// Whether a key was sent at all.
        key_sent: bool,
        /// Whether and when to try again.
        retry: RetryHint,
    },
    /// 404: no such model, or no such address.
    #[error(
        "{place} does not know model `{model}` or this address (404: {message}); check the model's name, then the address"
    )]
    NotFound {
        /// Where.
        place: ProviderAddress,
        /// The model asked for.
        model: String,
        /// The server's words.
        message: String,
        /// Whether and when to try again.
        retry: RetryHint,
    },
    /// Too many requests, or the account is used up.
    #[error("{}", limited_text(place, *status, message, retry.after(), *exhausted))]
    RateLimited {
        /// Where.
        place: ProviderAddress,
        /// The HTTP status, usually 429.
        status: u16,
        /// The server's words.
        message: String,
        /// Whether and when to try again.
        retry: RetryHint,
        /// The quota or the credit is used up: waiting does not help.
        exhausted: bool,
    },
    /// 400, 422 and their like: the server does not accept the request as it is.
    #[error(
        "{place} did not accept the request ({status}: {message}); {}",
        refusal_hint(message)
    )]
    BadRequest {
        /// Where.
        place: ProviderAddress,
        /// The HTTP status.
        status: u16,
        /// The server's words.
        message: String,
        /// Whether and when to try again.
        retry: RetryHint,
    },
    /// The server points elsewhere; not followed, because the key would go along.
    #[error("{place} redirects to {to} ({status}); if that is right, set it as the address of {}", place.provider)]
    Redirected {
        /// Where.
        place: ProviderAddress,
        /// The HTTP status.
        status: u16,
        /// The other address, without its query.
        to: String,
        /// Whether and when to try again.
        retry: RetryHint,
    },
    /// The server failed, and kept failing.
    #[error("{place} failed ({status}: {message}); try again later")]
    Server {
        /// Where.
        place: ProviderAddress,
        /// The HTTP status.
        status: u16,
        /// The server's words.
        message: String,
        /// Whether and when to try again.
        retry: RetryHint,
    },
    /// The answer broke off; it may have been paid for, so it is not asked for again.
    #[error("the answer of {place} broke off after {received} characters ({why}); ask again")]
    Truncated {
        /// Where.
        place: ProviderAddress,
        /// Characters of reasoning and text received until then.
        received: usize,
        /// How it broke off.
        why: String,
    },
    /// The response does not follow the protocol.
    #[error(
        "{place} sent an unexpected response: {what}; check the address and the provider's dialect"
    )]
    Malformed {
        /// Where.
        place: ProviderAddress,
        /// The unexpected response.
        what: String,
    },
    /// The request was not sent, because of money.
    #[error("{place} was not asked: {why}")]
    Budget {
        /// Where.
        place: ProviderAddress,
        /// The missing setting and its remedy.
        why: String,
    },
    /// The server reported an error inside an answer that had begun well.
    #[error("{place} reported an error while answering: {message}{}; try again, or choose another model", code.as_ref().map(|c| format!(" ({c})")).unwrap_or_default())]
    Provider {
        /// Where.
        place: ProviderAddress,
        /// The server's code, if any.
        code: Option<String>,
        /// The server's words.
        message: String,
    },
}

impl Error {
    /// Whether it is certain that nothing of the question had left this machine when this happened.
    #[must_use]
    pub fn before_sending(&self) -> bool {
        match self {
            Self::Setup { .. }
            | Self::Refused { .. }
            | Self::Unreachable { .. }
            | Self::Tls { .. }
            | Self::Budget { .. } => true,
            Self::Timeout { which, .. } => *which == TimeoutKind::Connect,
            _ => false,
        }
    }
}

fn timeout_text(place: &ProviderAddress, which: TimeoutKind, after: Duration) -> String {
    match which {
        TimeoutKind::Connect => {
            format!("no connection to {place} within {after:?}; check the network and the address")
        }
        TimeoutKind::Idle => {
            format!("{place} sent nothing for {after:?}; try again, or raise the idle timeout")
        }
        TimeoutKind::Total => format!(
            "{place} did not finish within {after:?}; ask for less, or raise the total timeout"
        ),
    }
}

fn unauthorized_text(
    place: &ProviderAddress,
    status: u16,
    message: &str,
    key_source: Option<&str>,
    key_sent: bool,
) -> String {
    match (key_sent, key_source) {
        (true, Some(source)) => format!(
            "{place} rejected the key from {source} ({status}: {message}); check the key and its permissions"
        ),
        (true, None) => format!(
            "{place} rejected the key ({status}: {message}); check the configured key and its permissions"
        ),
        (false, Some(source)) => {
            format!("{place} requires a key ({status}: {message}); set {source}")
        }
        (false, None) => {
            format!("{place} requires a key ({status}: {message}); configure one for this provider")
        }
    }
}

/// What to change about a request that a server refuses: the quirk that its words are about, else what is asked.
fn refusal_hint(message: &str) -> String {
    let quirk = [
        ("max_completion_tokens", "max_completion_tokens = true"),
        ("stream_options", "stream_options = false"),
        ("temperature", "temperature = \"fixed\""),
        ("seed", "seed = false"),
        ("logprobs", "log_probabilities = \"withheld\""),
        ("image", "images = false"),
        ("tool", "tools = false"),
    ];
    let words = message.to_lowercase();
    match quirk.iter().find(|(word, _)| words.contains(word)) {
        Some((_, quirk)) => {
            format!(
                "set quirks = {{ {quirk} }} for the model in config.toml (`nearmiss help providers`)"
            )
        }
        None => "change the model's parameters or the prompt".to_owned(),
    }
}

/// A day: who is to wait longer is not told how long.
const MAX_STATED_WAIT: Duration = Duration::from_secs(24 * 60 * 60);

fn limited_text(
    place: &ProviderAddress,
    status: u16,
    message: &str,
    retry_after: Option<Duration>,
    exhausted: bool,
) -> String {
    if exhausted {
        return format!(
            "the quota or credit at {place} is exhausted ({status}: {message}); top it up or choose another model"
        );
    }
    let wait = match retry_after {
        // As some servers say it.
        Some(wait) if wait.is_zero() => "wait a moment".to_owned(),
        Some(wait) if wait > MAX_STATED_WAIT => "wait more than a day".to_owned(),
        Some(wait) => format!("wait {wait:?}"),
        None => "wait a moment".to_owned(),
    };
    format!("{place} is rate-limiting requests ({status}: {message}); {wait}, or lower concurrency")
}

impl Error {
    /// The last step before an error leaves this module: secrets are taken out of everything the server said, since
    /// servers quote what they were sent, and control characters with them.
    pub(super) fn redacted(mut self, secrets: &Secrets) -> Self {
        let clear = |text: &mut String| *text = tidy(&secrets.redact_cut(text), MAX_QUOTE_LENGTH);
        match &mut self {
            Self::Setup { why, .. } | Self::Budget { why, .. } => {
                *why = tidy(&secrets.redact_cut(why), 1000);
            }
            Self::Refused { why, .. } | Self::Unreachable { why, .. } => clear(why),
            Self::Tls { why, .. } | Self::Truncated { why, .. } => clear(why),
            Self::Timeout { .. } => {}
            Self::Unauthorized { message, .. }
            | Self::NotFound { message, .. }
            | Self::RateLimited { message, .. } => clear(message),
            Self::BadRequest { message, .. } | Self::Server { message, .. } => clear(message),
            Self::Redirected { to, .. } => clear(to),
            Self::Malformed { what, .. } => clear(what),
            Self::Provider { message, code, .. } => {
                clear(message);
                if let Some(code) = code {
                    clear(code);
                }
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::super::endpoint::Endpoint;
    use super::*;

    fn place() -> ProviderAddress {
        ProviderAddress {
            provider: "openai".into(),
            url: "https://api.openai.com/v1/chat/completions".into(),
        }
    }

    #[test]
    fn the_key_is_named_not_shown() {
        let error = Error::Unauthorized {
            place: place(),
            status: 401,
            message: "Incorrect API key provided:\x1b[31m sk-abcdef\r\n".into(),
            key_source: Some("OPENAI_API_KEY".into()),
            key_sent: true,
            retry: RetryHint::default(),
        };
        let endpoint = Endpoint {
            key: Some("sk-abcdef".into()),
            ..Endpoint::new("openai", "https://api.openai.com/v1")
        };
        let text = error.redacted(&endpoint.secrets()).to_string();
        assert_eq!(
            text,
            "openai (https://api.openai.com/v1/chat/completions) rejected the key from OPENAI_API_KEY (401: Incorrect API key provided: [31m [key]); check the key and its permissions"
        );
    }

    #[test]
    fn a_missing_key_is_asked_for() {
        let text = unauthorized_text(&place(), 401, "no key", Some("OPENAI_API_KEY"), false);
        assert!(text.ends_with("set OPENAI_API_KEY"), "{text}");
    }

    #[test]
    fn waiting_is_not_advised_when_it_does_not_help() {
        assert!(limited_text(&place(), 429, "m", None, true).contains("top it up"));
        assert!(
            limited_text(&place(), 429, "m", Some(Duration::from_secs(7)), false)
                .contains("wait 7s")
        );
    }
}
