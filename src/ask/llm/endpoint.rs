//! An endpoint that serves a model: address, key, timeouts.

use std::fmt;
use std::time::Duration;

use jiff::Timestamp;
use jiff::tz::TimeZone;
use reqwest::Url;
use reqwest::header::{HeaderName, HeaderValue};
use secrecy::{ExposeSecret, SecretString};

use super::api_keys::KeyCommand;
use super::dialect::{Auth, Dialect};
use super::error::{Error, ProviderAddress};
use super::limits::{Budget, Limits};
use super::price::{Prices, Pricing};
use super::quirks::{Effort, Quirks};
use super::redaction::is_loopback;
use super::request::{Parameters, Request};

/// A server that serves models, and how to treat it.
#[derive(Clone)]
pub struct Endpoint {
    /// The provider's name as people know it, e.g. `openai`.
    pub name: String,
    /// The protocol it speaks.
    pub dialect: Dialect,
    /// The address: with or without the version, a trailing slash or the method; see [`Endpoint::request_url`].
    pub base_url: String,
    /// The key; blank counts as none.
    pub key: Option<SecretString>,
    /// A command that prints the key, run before the first request if there is no key.
    pub key_command: Option<KeyCommand>,
    /// Where the key comes from, for error texts: a variable, with the file it is in.
    pub key_source: Option<String>,
    /// That the key is missing and what to do, where nothing is to be sent without it.
    pub missing_key: Option<String>,
    /// The header that carries the key; `None` is the dialect's own.
    pub auth: Option<Auth>,
    /// Further headers, name and value.
    pub headers: Vec<(String, String)>,
    /// Secrets may be sent unencrypted to another machine.
    pub allow_http: bool,
    /// How long to wait for what.
    pub timeouts: Timeouts,
    /// How often to try again.
    pub retry: Retry,
    /// How much of a schema the server understands.
    pub response_format: ResponseFormat,
    /// Whether the beginning of questions is marked for the server's cache, where [`Quirks::cache_from`] allows it.
    pub prompt_cache: bool,
    /// In what the model differs from others of its dialect.
    pub quirks: Quirks,
    /// How much may be asked at a time; shared by everyone who uses the same [`super::Client`] and provider's name.
    pub limits: Limits,
    /// Known prices of its models.
    pub prices: Prices,
    /// The money that requests share; none is sent that could exceed it.
    pub budget: Option<Budget>,
}

/// Timeouts of an exchange.
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

/// Retry policy for failures that may pass. Nothing is retried once an answer has begun.
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

/// How much of a [`super::Schema`] is sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
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
            dialect: Dialect::default(),
            base_url: base_url.into(),
            key: None,
            key_command: None,
            key_source: None,
            missing_key: None,
            auth: None,
            headers: Vec::new(),
            allow_http: false,
            timeouts: Timeouts::default(),
            retry: Retry::default(),
            response_format: ResponseFormat::default(),
            prompt_cache: true,
            quirks: Quirks::default(),
            limits: Limits::default(),
            prices: Prices::default(),
            budget: None,
        }
    }

    /// The address that requests for a model go to. What of version and method the base URL lacks is added, a query
    /// (`?api-version=…`) is kept.
    ///
    /// # Errors
    /// [`Error::Setup`] if the base URL is no URL, or not an http(s) one.
    pub fn request_url(&self, model: &str) -> Result<Url, Error> {
        Ok(self.dialect.protocol().with_model(self.url()?, model))
    }

    /// Most tokens an answer may have, if there is a limit.
    #[must_use]
    pub fn answer_limit(&self, parameters: &Parameters) -> Option<u32> {
        parameters.max_tokens.or(self.quirks.max_tokens)
    }

    /// What bounds the cost of an answer: the model's price and the most tokens it may have, where these cost something.
    ///
    /// # Errors
    /// [`Error::Budget`] if one of them is not known, so that no budget can be kept.
    pub fn worst_case(
        &self,
        model: &str,
        parameters: &Parameters,
    ) -> Result<(Pricing, u32), Error> {
        let no = |why| Error::Budget {
            place: self.place(),
            why,
        };
        let today = Timestamp::now().to_zoned(TimeZone::UTC).date();
        let pricing = self.prices.pricing_for(model, today).ok_or_else(|| {
            let name = &self.name;
            no(format!(
                "a budget needs a price, but none is known for {model}; set one as [[provider.{name}.prices]] in config.toml, or drop the budget"
            ))
        })?;
        let off = parameters.effort == Some(Effort::Off);
        if self.quirks.reasoning_unlimited && !off && !pricing.is_free() {
            return Err(no(format!(
                "a budget needs a limit, but {model} does not count its reasoning in the one it takes; ask with effort off, or drop the budget"
            )));
        }
        let limit = self
            .answer_limit(parameters)
            .or(pricing.is_free().then_some(0))
            .ok_or_else(|| no("a budget needs a token limit; set max_tokens".into()))?;
        Ok((pricing, limit))
    }

    /// Tokens of a request, its images as the documentation of this provider counts them.
    #[must_use]
    pub fn tokens(&self, request: &Request) -> u32 {
        request.tokens(
            self.quirks.image_tokens,
            self.answer_limit(&request.parameters),
        )
    }

    /// The most that a request can cost, US dollars, if price and limit of the answer are known.
    #[must_use]
    pub fn at_most(&self, request: &Request) -> Option<f64> {
        let (pricing, limit) = self.worst_case(&request.model, &request.parameters).ok()?;
        pricing.at_most(self.tokens(request), limit)
    }

    /// The same for a request that is `added` tokens longer.
    #[must_use]
    pub fn at_most_with(&self, request: &Request, added: u32) -> Option<f64> {
        let (pricing, limit) = self.worst_case(&request.model, &request.parameters).ok()?;
        pricing.at_most(self.tokens(request).saturating_add(added), limit)
    }

    /// Whether the server is on this machine; such servers rarely want a key.
    #[must_use]
    pub fn is_here(&self) -> bool {
        self.url().ok().is_none_or(|url| is_loopback(&url))
    }

    /// The address without the model.
    pub(super) fn url(&self) -> Result<Url, Error> {
        let wrong = |why: String| Error::Setup {
            place: self.place_as_written(),
            why,
        };
        let mut url = Url::parse(self.base_url.trim()).map_err(|e| {
            wrong(format!(
                "not a valid address{}; write it like http://127.0.0.1:4021 or https://api.openai.com/v1",
                not_an_address(&e.to_string())
            ))
        })?;
        if !matches!(url.scheme(), "http" | "https") {
            let scheme = url.scheme();
            return Err(wrong(format!(
                "this starts with `{scheme}:`; write http:// or https:// before the host"
            )));
        }
        let path = self.dialect.protocol().path(url.path());
        url.set_path(&path);
        url.set_fragment(None);
        Ok(url)
    }

    /// Name and address for messages to people; without user, password and query, which may hold secrets.
    pub fn place(&self) -> ProviderAddress {
        match self.url() {
            Ok(url) => ProviderAddress {
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

    /// The header that carries the key, if there is a key.
    pub(super) fn key_header(&self) -> Result<Option<(HeaderName, HeaderValue)>, Error> {
        let Some(key) = self.usable_key() else {
            return Ok(None);
        };
        let (name, word) = self.auth.unwrap_or(self.dialect.auth()).header();
        let source = self.key_source.as_deref().unwrap_or("the configuration");
        let mut value =
            HeaderValue::from_str(&format!("{word}{key}")).map_err(|_| Error::Setup {
                place: self.place(),
                why: format!("the key from {source} contains invalid characters; copy it again"),
            })?;
        value.set_sensitive(true);
        Ok(Some((HeaderName::from_static(name), value)))
    }

    fn place_as_written(&self) -> ProviderAddress {
        let written = self.base_url.split(['?', '#']).next().unwrap_or_default();
        let shown = match written.rsplit_once('@') {
            Some((_, host)) => format!("…@{host}"),
            None => written.to_owned(),
        };
        ProviderAddress {
            provider: self.name.clone(),
            url: format!("\"{}\"", shown.escape_debug()),
        }
    }
}

/// The missing part of an address, if that can be told.
fn not_an_address(error: &str) -> &'static str {
    match error {
        "relative URL without a base" => ": it must start with http:// or https://",
        "empty host" => ": no host",
        "invalid port number" => ": the port must be a number up to 65535",
        "invalid IPv4 address" | "invalid IPv6 address" => ": invalid host",
        _ => "",
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
            .field("dialect", &self.dialect)
            .field("key", &self.key.as_ref().map(|_| "[hidden]"))
            .field("key_source", &self.key_source)
            .field("timeouts", &self.timeouts)
            .field("retry", &self.retry)
            .field("response_format", &self.response_format)
            .field("quirks", &self.quirks)
            .field("limits", &self.limits)
            .field("prices", &self.prices)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn wrong_addresses_are_named() {
        for (base, part) in [
            ("", "not a valid address"),
            ("api.openai.com/v1", "must start with http://"),
            ("localhost:8080", "`localhost:`"),
            ("ftp://x.org", "`ftp:`"),
        ] {
            let text = Endpoint::new("mine", base).url().unwrap_err().to_string();
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
            bad.url().unwrap_err()
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
