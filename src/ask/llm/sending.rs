//! A request ready to send: dialect, address, headers, body, rate-limit permit and reserved budget.

use std::borrow::Cow;
use std::sync::Arc;

use backon::ExponentialBackoff;
use reqwest::Url;
use reqwest::header::{CONTENT_TYPE, HeaderMap, HeaderName, HeaderValue};
use tokio::sync::OwnedSemaphorePermit;

use super::attempt::waits;
use super::body_text::Deadlines;
use super::client::Client;
use super::dialect::Notes;
use super::endpoint::Endpoint;
use super::error::Error;
use super::limits::{Gate, Reservation};
use super::quirks;
use super::request::Request;

/// A request ready to go, any number of times.
pub(super) struct Sending {
    pub http: reqwest::Client,
    pub url: Url,
    pub headers: HeaderMap,
    pub body: Vec<u8>,
    pub gate: Arc<Gate>,
    /// The request's share of the tokens per minute.
    pub tokens: u32,
    pub patience: Deadlines,
    pub waits: ExponentialBackoff,
    pub attempt: u32,
}

/// A request that may be sent now.
pub(super) struct Ready {
    pub sending: Sending,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// Its place among the requests on their way.
    pub place: Option<OwnedSemaphorePermit>,
    /// Money set aside for it.
    pub reserved: Option<Reservation>,
}

impl Ready {
    /// Makes a request ready: fetches its key if a command has it, waits for its place, and sets money aside.
    pub async fn new(
        client: &Client,
        endpoint: &mut Endpoint,
        request: &Request,
    ) -> Result<Self, Error> {
        let wrong = |place| |why| Error::Setup { place, why };
        quirks::check(endpoint, request)?;
        check_images(endpoint, request)?;
        check_tools(endpoint, request)?;
        let (url, headers) = addressed(client, endpoint, request).await?;
        let endpoint = &*endpoint;
        let mut notes = Notes::default();
        let body = endpoint
            .dialect
            .protocol()
            .body(endpoint, request, &mut notes);
        let connect = endpoint.timeouts.connect;
        let http = client
            .http(endpoint, connect)
            .map_err(wrong(endpoint.place()))?;
        let gate = client.gate(&endpoint.name, endpoint.limits);
        let place = gate.enter().await;
        let limit = endpoint.answer_limit(&request.parameters);
        let sending = Sending {
            http,
            url,
            headers,
            body: body.to_string().into_bytes(),
            gate,
            tokens: endpoint.tokens(request).saturating_add(limit.unwrap_or(0)),
            patience: Deadlines::starting_now(endpoint.timeouts),
            waits: waits(endpoint.retry),
            attempt: 1,
        };
        Ok(Self {
            sending,
            notes: notes.0,
            place,
            reserved: reserve(endpoint, request)?,
        })
    }
}

/// Whether a request can be sent as things stand: its address, its key, its size and the money for it. Sends nothing.
///
/// # Errors
/// Why it would never be sent, as [`super::stream`] says it.
pub(super) async fn sendable(
    client: &Client,
    endpoint: &mut Endpoint,
    request: &Request,
) -> Result<(), Error> {
    // The budget is checked before a command asks the user for a password.
    quirks::check(endpoint, request)?;
    check_images(endpoint, request)?;
    check_tools(endpoint, request)?;
    drop(reserve(endpoint, request)?);
    let limit = endpoint.answer_limit(&request.parameters);
    let tokens = endpoint.tokens(request).saturating_add(limit.unwrap_or(0));
    endpoint.limits.allow(tokens).map_err(|why| Error::Setup {
        place: endpoint.place(),
        why,
    })?;
    addressed(client, endpoint, request).await.map(drop)
}

/// Refuses images for a model that is known not to see.
fn check_images(endpoint: &Endpoint, request: &Request) -> Result<(), Error> {
    let blind = endpoint.quirks.images == Some(false);
    if !blind || request.images().next().is_none() {
        return Ok(());
    }
    let (model, name) = (&request.model, &endpoint.name);
    Err(Error::Setup {
        place: endpoint.place(),
        why: format!(
            "{model} takes no pictures; choose a frame in words or a model that sees, or, if it does see, set quirks = {{ images = true }} for it in [provider.{name}]"
        ),
    })
}

/// Refuses tools for a model that is known not to call any.
fn check_tools(endpoint: &Endpoint, request: &Request) -> Result<(), Error> {
    if endpoint.quirks.tools != Some(false) || request.offered().is_none() {
        return Ok(());
    }
    let (model, name) = (&request.model, &endpoint.name);
    Err(Error::Setup {
        place: endpoint.place(),
        why: format!(
            "{model} calls no tools; ask without tools or choose another model, or, if it does call them, set quirks = {{ tools = true }} for it in [provider.{name}]"
        ),
    })
}

/// Where a request goes and under which headers; fetches its key if a command has it.
async fn addressed(
    client: &Client,
    endpoint: &mut Endpoint,
    request: &Request,
) -> Result<(Url, HeaderMap), Error> {
    let url = endpoint.request_url(&request.model)?;
    Ok((url, authorised(client, endpoint).await?))
}

/// The headers of any request to an endpoint; fetches its key if a command has it.
///
/// # Errors
/// [`Error::Setup`]: the key is missing, no header can be made of it, or it would be sent unencrypted.
pub(super) async fn authorised(
    client: &Client,
    endpoint: &mut Endpoint,
) -> Result<HeaderMap, Error> {
    if let Some(missing) = &endpoint.missing_key {
        return Err(Error::Setup {
            place: endpoint.place(),
            why: missing.clone(),
        });
    }
    // Before a command is asked for a key that is not sent.
    endpoint.keeps_secrets()?;
    if let (None, Some(command)) = (endpoint.usable_key(), &endpoint.key_command) {
        let key = client.key(command).await.map_err(|why| Error::Setup {
            place: endpoint.place(),
            why,
        })?;
        endpoint.key = Some(key);
    }
    headers(endpoint)
}

/// Sets aside the most that the request can cost, if there is a budget.
fn reserve(endpoint: &Endpoint, request: &Request) -> Result<Option<Reservation>, Error> {
    let Some(budget) = &endpoint.budget else {
        return Ok(None);
    };
    let (pricing, limit) = endpoint.worst_case(&request.model, &request.parameters)?;
    let tokens = endpoint.tokens(request);
    let most = pricing
        .at_most(tokens, limit)
        .ok_or_else(|| Error::Budget {
            place: endpoint.place(),
            why: format!(
                "a budget needs a price, but the known one for {} does not cover questions of about {tokens} tokens; set one as [[provider.{}.prices]] in config.toml, or drop the budget",
                request.model, endpoint.name
            ),
        })?;
    let reserved = budget.reserve(most).map_err(|over| Error::Budget {
        place: endpoint.place(),
        why: over.to_string(),
    })?;
    Ok(Some(reserved))
}

/// Every header of a request.
fn headers(endpoint: &Endpoint) -> Result<HeaderMap, Error> {
    let mut headers = HeaderMap::new();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static("application/json"));
    for (name, value) in endpoint.dialect.protocol().headers() {
        let name = HeaderName::from_static(name);
        headers.insert(name, HeaderValue::from_static(value));
    }
    for (name, value) in &endpoint.headers {
        let header = (name.parse::<HeaderName>(), HeaderValue::from_str(value));
        let (Ok(name), Ok(mut value)) = header else {
            return Err(Error::Setup {
                place: endpoint.place(),
                why: format!("`{name}` or its value is not a valid header; check header_env"),
            });
        };
        value.set_sensitive(true);
        headers.insert(name, value);
    }
    if let Some((name, value)) = endpoint.key_header()? {
        headers.insert(name, value);
    }
    Ok(headers)
}

impl Endpoint {
    /// The endpoint as it is for this request: one with tools is asked in [`super::Quirks::tools_dialect`], with the same
    /// key, limits and prices. What is stored of the request is of this one.
    #[must_use]
    pub fn for_request(&self, request: &Request) -> Cow<'_, Self> {
        let dialect = self.quirks.tools_dialect;
        let Some(dialect) = dialect.filter(|_| request.offered().is_some()) else {
            return Cow::Borrowed(self);
        };
        // An address may be written with the method of the other dialect.
        let method = self.dialect.protocol().method();
        let (path, query) = match self.base_url.trim().split_once('?') {
            Some((path, query)) => (path, format!("?{query}")),
            None => (self.base_url.trim(), String::new()),
        };
        let path = path.trim_end_matches('/');
        let root = path.strip_suffix(method).unwrap_or(path);
        Cow::Owned(Self {
            dialect,
            base_url: format!("{root}{query}"),
            ..self.clone()
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::llm::{Dialect, ToolSpec, Toolbox};

    fn request(tools: bool) -> Request {
        let spec = ToolSpec {
            name: "distance".into(),
            about: String::new(),
            schema: serde_json::json!({"type": "object"}),
        };
        Request {
            model: "m".into(),
            messages: Vec::new(),
            parameters: Default::default(),
            schema: None,
            tools: tools.then(|| Toolbox {
                specs: vec![spec],
                rounds: Vec::new(),
                may_call: true,
            }),
        }
    }

    #[test]
    fn only_questions_with_tools_go_elsewhere_however_the_address_is_written() {
        for (base, url) in [
            ("https://x.org/v1", "https://x.org/v1/responses"),
            ("https://x.org", "https://x.org/v1/responses"),
            (
                "https://x.org/v1/chat/completions/",
                "https://x.org/v1/responses",
            ),
            (
                "https://x.org/v1?api-version=2",
                "https://x.org/v1/responses?api-version=2",
            ),
        ] {
            let mut endpoint = Endpoint::new("mine", base);
            assert_eq!(
                endpoint.for_request(&request(true)).dialect,
                Dialect::OpenAiChat
            );
            endpoint.quirks.tools_dialect = Some(Dialect::OpenAiResponses);
            let asked = endpoint.for_request(&request(true));
            assert_eq!(asked.request_url("m").unwrap().as_str(), url);
            let plain = endpoint.for_request(&request(false));
            assert_eq!(plain.dialect, Dialect::OpenAiChat, "{base}");
        }
    }
}
