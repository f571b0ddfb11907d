//! Where a model is served: address, key, patience.

use std::fmt;
use std::time::Duration;

use reqwest::Url;
use secrecy::{ExposeSecret, SecretString};

use super::error::{Error, Place};

/// A server that speaks the OpenAI chat protocol, and how to treat it.
#[derive(Clone)]
pub struct Endpoint {
    /// The provider's name as people know it, e.g. `openai`.
    pub name: String,
    /// The address: with or without `/v1`, a trailing slash or `/chat/completions`; see [`Endpoint::chat_url`].
    pub base_url: String,
    /// The key, sent as `Authorization: Bearer`; blank counts as none.
    pub key: Option<SecretString>,
    /// Name of the environment variable the key is read from, for error texts.
    pub key_source: Option<String>,
    /// How long to wait for what.
    pub timeouts: Timeouts,
    /// How often to try again.
    pub retry: Retry,
    /// How much of a schema the server understands.
    pub response_format: ResponseFormat,
}

/// How long to wait before giving up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timeouts {
    /// For the connection, encryption included.
    pub connect: Duration,
    /// Between two received bytes, and for the first one; keep-alive comments count.
    pub idle: Duration,
    /// For everything together, repetitions included.
    pub total: Duration,
}

impl Default for Timeouts {
    fn default() -> Self {
        Self {
            connect: Duration::from_secs(10),
            idle: Duration::from_secs(120),
            total: Duration::from_secs(30 * 60),
        }
    }
}

/// How to repeat a request that failed in a way that may pass. Nothing is repeated once an answer has begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Retry {
    /// Tries in all; 0 counts as 1.
    pub attempts: u32,
    /// The wait before the second try, doubled for each further one, each with up to as much again added at random.
    pub first_wait: Duration,
    /// The longest wait; a server that asks for more is reported at once.
    pub longest_wait: Duration,
}

impl Default for Retry {
    fn default() -> Self {
        Self {
            attempts: 3,
            first_wait: Duration::from_secs(1),
            longest_wait: Duration::from_secs(120),
        }
    }
}

/// What is sent of a [`super::Schema`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ResponseFormat {
    /// The whole schema, as `json_schema` with `strict`.
    #[default]
    JsonSchema,
    /// Only that JSON is wanted, as `json_object`.
    JsonObject,
    /// Nothing: the prompt has to say it.
    Off,
}

impl Endpoint {
    /// An endpoint without key, with the usual patience and schemas on.
    pub fn new(name: impl Into<String>, base_url: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            base_url: base_url.into(),
            key: None,
            key_source: None,
            timeouts: Timeouts::default(),
            retry: Retry::default(),
            response_format: ResponseFormat::default(),
        }
    }

    /// The address requests go to: a bare host gets `/v1/chat/completions`, a path gets `/chat/completions` unless it ends so.
    /// A query (`?api-version=…`) is kept.
    ///
    /// # Errors
    /// [`Error::Setup`] if the base URL is no URL, or not an http(s) one.
    pub fn chat_url(&self) -> Result<Url, Error> {
        let wrong = |why: String| Error::Setup {
            place: self.place_as_written(),
            why,
        };
        let mut url = Url::parse(self.base_url.trim()).map_err(|e| {
            wrong(format!(
                "this is not a web address ({e}); write it like https://api.openai.com/v1"
            ))
        })?;
        if !matches!(url.scheme(), "http" | "https") {
            let scheme = url.scheme();
            return Err(wrong(format!(
                "this starts with `{scheme}:`; write http:// or https:// before the host"
            )));
        }
        let path = url.path().trim_end_matches('/').to_owned();
        let path = match path.as_str() {
            "" => "/v1/chat/completions".to_owned(),
            full if full.ends_with("/chat/completions") => path,
            base => format!("{base}/chat/completions"),
        };
        url.set_path(&path);
        url.set_fragment(None);
        Ok(url)
    }

    /// Name and address for messages to people; without user, password and query, which may hold secrets.
    pub fn place(&self) -> Place {
        match self.chat_url() {
            Ok(url) => Place {
                provider: self.name.clone(),
                url: plain(&url),
            },
            Err(_) => self.place_as_written(),
        }
    }

    /// The key without the line end that files and shells leave on it; `None` if nothing is left.
    pub(super) fn usable_key(&self) -> Option<&str> {
        let key = self.key.as_ref()?.expose_secret().trim();
        (!key.is_empty()).then_some(key)
    }

    fn place_as_written(&self) -> Place {
        let written = self.base_url.split(['?', '#']).next().unwrap_or_default();
        let shown = match written.rsplit_once('@') {
            Some((_, host)) => format!("…@{host}"),
            None => written.to_owned(),
        };
        Place {
            provider: self.name.clone(),
            url: format!("\"{}\"", shown.escape_debug()),
        }
    }
}

/// Scheme, host, port and path of a URL, nothing else.
pub(super) fn plain(url: &Url) -> String {
    let port = url.port().map(|p| format!(":{p}")).unwrap_or_default();
    format!(
        "{}://{}{port}{}",
        url.scheme(),
        url.host_str().unwrap_or_default(),
        url.path()
    )
}

// Written by hand because a base URL may hold a password or a key.
impl fmt::Debug for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Endpoint")
            .field("place", &self.place())
            .field("key", &self.key.as_ref().map(|_| "[hidden]"))
            .field("key_source", &self.key_source)
            .field("timeouts", &self.timeouts)
            .field("retry", &self.retry)
            .field("response_format", &self.response_format)
            .finish()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn url(base: &str) -> String {
        Endpoint::new("test", base).chat_url().unwrap().to_string()
    }

    #[test]
    fn every_way_to_write_a_base_url() {
        for (base, expected) in [
            (
                "http://127.0.0.1:8080",
                "http://127.0.0.1:8080/v1/chat/completions",
            ),
            (
                "http://127.0.0.1:8080/",
                "http://127.0.0.1:8080/v1/chat/completions",
            ),
            (
                " https://api.openai.com/v1 \n",
                "https://api.openai.com/v1/chat/completions",
            ),
            (
                "https://api.openai.com/v1/",
                "https://api.openai.com/v1/chat/completions",
            ),
            (
                "https://openrouter.ai/api/v1//",
                "https://openrouter.ai/api/v1/chat/completions",
            ),
            (
                "https://x.org/v1/chat/completions",
                "https://x.org/v1/chat/completions",
            ),
            (
                "https://x.org/v1/chat/completions/",
                "https://x.org/v1/chat/completions",
            ),
            (
                "https://generativelanguage.googleapis.com/v1beta/openai/",
                "https://generativelanguage.googleapis.com/v1beta/openai/chat/completions",
            ),
            (
                "https://a.azure.com/d/x?api-version=2#f",
                "https://a.azure.com/d/x/chat/completions?api-version=2",
            ),
            (
                "http://[::1]:11434",
                "http://[::1]:11434/v1/chat/completions",
            ),
        ] {
            assert_eq!(url(base), expected, "{base}");
        }
    }

    #[test]
    fn wrong_addresses_are_named() {
        for (base, part) in [
            ("", "not a web address"),
            ("api.openai.com/v1", "not a web address"),
            ("localhost:8080", "`localhost:`"),
            ("ftp://x.org", "`ftp:`"),
        ] {
            let text = Endpoint::new("mine", base)
                .chat_url()
                .unwrap_err()
                .to_string();
            assert!(
                text.contains(part) && text.contains("mine") && text.contains(base),
                "{text}"
            );
        }
    }

    #[test]
    fn neither_key_nor_password_is_shown() {
        let mut endpoint = Endpoint::new("mine", "https://me:hunter22@x.org/v1?key=topsecret");
        endpoint.key = Some("sk-verysecret".into());
        let bad = Endpoint {
            base_url: "x//me:hunter22@x.org?key=topsecret".into(),
            ..endpoint.clone()
        };
        let shown = format!(
            "{endpoint:?} {} {bad:?} {}",
            endpoint.place(),
            bad.chat_url().unwrap_err()
        );
        assert!(
            shown.contains("https://x.org/v1/chat/completions"),
            "{shown}"
        );
        for secret in ["hunter22", "topsecret", "verysecret"] {
            assert!(!shown.contains(secret), "{shown}");
        }
    }
}
