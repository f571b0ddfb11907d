//! Requests to batch APIs: keys, limits, timeouts and retries as for questions, but no redirects.

use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use reqwest::header::{CONTENT_LENGTH, CONTENT_TYPE, HeaderMap, HeaderValue, TRANSFER_ENCODING};
use reqwest::{Method, Response, Url, Version};
use serde_json::Value;

use super::super::attempt::waits;
use super::super::body_text::{Deadlines, MAX_VALUES, is_bounded};
use super::super::client::{Client, deepest};
use super::super::endpoint::Endpoint;
use super::super::error::Error;
use super::super::limits::Gate;
use super::super::redaction::Secrets;
use super::super::sending::authorised;

/// Longest document, in bytes: some providers have all results of a batch in one.
const MAX_DOCUMENT_BYTES: usize = 256 << 20;

/// Longest result line, in bytes: one answer with its metadata.
const LONGEST_LINE: usize = 32 << 20;

/// Longest page of a list, in bytes.
const MAX_PAGE_BYTES: usize = 16 << 20;

/// Most values of a document that holds many answers.
const MAX_ALL_VALUES: usize = 4 * MAX_VALUES;

/// Longest excerpt of a response that is not JSON.
const MAX_SHOWN_BYTES: usize = 64 << 10;

/// Requests to one endpoint.
pub struct Calls {
    http: reqwest::Client,
    endpoint: Endpoint,
    secrets: Secrets,
    headers: HeaderMap,
    gate: Arc<Gate>,
    model: String,
}

// Written by hand because headers hold the key.
impl std::fmt::Debug for Calls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Calls")
            .field("endpoint", &self.endpoint)
            .finish_non_exhaustive()
    }
}

/// Which failures are worth a retry.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum RetryPolicy {
    /// All that may pass: doing it twice does no harm.
    Harmless,
    /// Only refusals: what failed at the server may have been done.
    Refused,
}

impl Calls {
    pub async fn new(client: &Client, endpoint: &Endpoint, model: &str) -> Result<Self, Error> {
        let mut endpoint = endpoint.clone();
        endpoint.url()?;
        let headers = authorised(client, &mut endpoint).await?;
        let http = client
            .http(&endpoint, endpoint.timeouts.connect)
            .map_err(|why| Error::Setup {
                place: endpoint.place(),
                why,
            })?;
        Ok(Self {
            http,
            headers,
            gate: client.gate(&endpoint.name, endpoint.limits),
            secrets: endpoint.secrets(),
            endpoint,
            model: model.to_owned(),
        })
    }

    pub fn endpoint(&self) -> &Endpoint {
        &self.endpoint
    }

    /// Secrets sent, which must not appear in responses.
    pub fn secrets(&self) -> &Secrets {
        &self.secrets
    }

    /// An address: that of questions without its last part `without`, and then these parts.
    pub fn url(&self, without: &[&str], parts: &[&str]) -> Result<Url, Error> {
        let mut url = self.endpoint.url()?;
        let path = url.path().to_owned();
        let root = without.iter().find_map(|end| path.strip_suffix(end));
        url.set_path(root.unwrap_or(&path));
        if let Ok(mut segments) = url.path_segments_mut() {
            segments.pop_if_empty().extend(parts);
        }
        Ok(url)
    }

    /// The id that a document has in a field; it becomes part of addresses, so that it may not be anything.
    pub fn id(&self, document: &Value, field: &str) -> Result<String, Error> {
        let id = document.get(field).and_then(Value::as_str);
        match id.filter(|id| is_id(id) && !self.secrets.are_in(id)) {
            Some(id) => Ok(id.to_owned()),
            None => Err(self.malformed(&format!("no `{field}` of a batch or file: {document}"))),
        }
    }

    /// The response is not what was requested.
    pub fn malformed(&self, what: &str) -> Error {
        let what = what.to_owned();
        let place = self.endpoint.place();
        Error::Malformed { place, what }.redacted(&self.secrets)
    }

    /// Asks for a document.
    pub async fn get(&self, url: Url) -> Result<Value, Error> {
        self.document(
            Method::GET,
            url,
            None,
            RetryPolicy::Harmless,
            MAX_DOCUMENT_BYTES,
        )
        .await
    }

    /// Asks for a page of a list.
    pub async fn page(&self, url: Url) -> Result<Value, Error> {
        self.document(
            Method::GET,
            url,
            None,
            RetryPolicy::Harmless,
            MAX_PAGE_BYTES,
        )
        .await
    }

    /// Sends a document.
    pub async fn post(&self, url: Url, body: &Value, again: RetryPolicy) -> Result<Value, Error> {
        let body = ("application/json".to_owned(), body.to_string().into_bytes());
        self.document(Method::POST, url, Some(body), again, MAX_PAGE_BYTES)
            .await
    }

    /// Sends bytes of a type.
    pub async fn upload(&self, url: Url, kind: String, bytes: Vec<u8>) -> Result<Value, Error> {
        // A file uploaded twice is asked about once.
        let body = Some((kind, bytes));
        self.document(
            Method::POST,
            url,
            body,
            RetryPolicy::Harmless,
            MAX_PAGE_BYTES,
        )
        .await
    }

    async fn document(
        &self,
        method: Method,
        url: Url,
        body: Option<(String, Vec<u8>)>,
        again: RetryPolicy,
        longest: usize,
    ) -> Result<Value, Error> {
        let mut whole = Vec::new();
        self.exchange((method, url, body), again, longest, |piece| {
            whole.extend_from_slice(piece);
            Ok::<_, Error>(whole.len())
        })
        .await?;
        if !is_bounded(&whole, MAX_ALL_VALUES) {
            let what = format!("a document of more than {MAX_ALL_VALUES} values");
            return Err(self.malformed(&what));
        }
        serde_json::from_slice(&whole).map_err(|_| self.malformed(&format!("`{}`", start(&whole))))
    }

    /// Asks for lines and gives each to `each`, as a JSON document. Whether a cut would have been noticed.
    pub async fn lines<E: From<Error>>(
        &self,
        url: Url,
        mut each: impl FnMut(Value) -> Result<(), E>,
    ) -> Result<bool, E> {
        let mut line = Vec::new();
        let mut take = |line: &mut Vec<u8>| -> Result<(), E> {
            let bytes = std::mem::take(line);
            if bytes.trim_ascii().is_empty() {
                return Ok(());
            }
            let bounded = is_bounded(&bytes, MAX_VALUES).then_some(&bytes);
            match bounded.and_then(|bytes| serde_json::from_slice(bytes).ok()) {
                Some(value) => each(value),
                None => {
                    let line = format!("the line `{}`", start(&bytes));
                    Err(self.malformed(&line).into())
                }
            }
        };
        let request = (Method::GET, url, None);
        let framed = self
            .exchange(request, RetryPolicy::Harmless, LONGEST_LINE, |mut piece| {
                while let Some(end) = piece.iter().position(|b| *b == b'\n') {
                    line.extend_from_slice(&piece[..end]);
                    piece = &piece[end + 1..];
                    take(&mut line)?;
                }
                line.extend_from_slice(piece);
                Ok::<_, E>(line.len())
            })
            .await?;
        take(&mut line)?;
        Ok(framed)
    }

    /// One request, tried again where that may help, and the body of its answer in pieces; `each` says how many bytes
    /// it holds back, at most `longest_part`. Whether a cut would have been noticed.
    async fn exchange<E: From<Error>>(
        &self,
        (method, url, body): (Method, Url, Option<(String, Vec<u8>)>),
        again: RetryPolicy,
        longest_part: usize,
        mut each: impl FnMut(&[u8]) -> Result<usize, E>,
    ) -> Result<bool, E> {
        let cleared = |error: Error| error.redacted(&self.secrets);
        let admitted = self.gate.admit(0).await;
        admitted.map_err(|why| Error::Setup {
            place: self.endpoint.place(),
            why,
        })?;
        let patience = Deadlines::starting_now(self.endpoint.timeouts);
        let mut waits = waits(self.endpoint.retry);
        let response = loop {
            let error = match self.once(&method, &url, body.as_ref(), patience).await {
                Ok(response) => break response,
                Err(error) => error,
            };
            let retry = error.retry();
            let refused = matches!(error.status(), None | Some(429 | 503 | 529));
            let worth = retry.may_pass && (again == RetryPolicy::Harmless || refused);
            let longest = self.endpoint.retry.longest_wait;
            let wait = waits
                .next()
                .filter(|_| worth)
                .map(|wait| retry.after().unwrap_or(wait.min(longest)));
            match wait.filter(|wait| *wait <= longest && *wait < patience.left()) {
                Some(wait) => tokio::time::sleep(wait.max(Duration::from_millis(1))).await,
                None => return Err(cleared(error).into()),
            }
        };
        let framed = is_framed(&response);
        let mut pieces = response.bytes_stream();
        let mut received = 0;
        loop {
            let piece = match patience.wait(pieces.next()).await {
                Ok(None) => return Ok(framed),
                Ok(Some(Ok(piece))) => piece,
                Ok(Some(Err(error))) => {
                    return Err(cleared(self.cut(received, deepest(&error))).into());
                }
                Err(elapsed) => return Err(cleared(Error::silence(elapsed, &self.endpoint)).into()),
            };
            received += piece.len();
            if each(&piece)? > longest_part {
                let why = format!("more than {longest_part} bytes in one document");
                return Err(cleared(self.cut(received, why)).into());
            }
        }
    }

    fn cut(&self, received: usize, why: String) -> Error {
        let place = self.endpoint.place();
        Error::Truncated {
            place,
            received,
            why,
        }
    }

    async fn once(
        &self,
        method: &Method,
        url: &Url,
        body: Option<&(String, Vec<u8>)>,
        patience: Deadlines,
    ) -> Result<Response, Error> {
        let mut headers = self.headers.clone();
        headers.remove(CONTENT_TYPE);
        let mut request = self.http.request(method.clone(), url.clone());
        if let Some((kind, bytes)) = body {
            if let Ok(kind) = HeaderValue::from_str(kind) {
                headers.insert(CONTENT_TYPE, kind);
            }
            request = request.body(bytes.clone());
        }
        match patience.wait(request.headers(headers).send()).await {
            Ok(Ok(response)) if response.status().is_success() => Ok(response),
            Ok(Ok(response)) => {
                Err(Error::answered(response, &self.endpoint, &self.model, patience).await)
            }
            Ok(Err(error)) => Err(Error::unanswered(&error, &self.endpoint)),
            Err(elapsed) => Err(Error::silence(elapsed, &self.endpoint)),
        }
    }
}

/// The beginning of a response that is not JSON, longer than displayed, so that redaction sees whole secrets.
fn start(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(MAX_SHOWN_BYTES)]).into_owned()
}

/// Whether the body's framing marks its end, not just the closed connection.
fn is_framed(response: &Response) -> bool {
    let headers = response.headers();
    response.version() >= Version::HTTP_2
        || headers.contains_key(CONTENT_LENGTH)
        || headers.contains_key(TRANSFER_ENCODING)
}

/// Whether a word can be a provider's id: it becomes part of addresses and is shown to people.
pub fn is_id(id: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let parts = || id.split('/');
    id.len() <= 200 && parts().all(|p| !p.is_empty() && p.chars().all(plain) && !p.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_lead_nowhere_else() {
        for id in ["batch_68f", "msgbatch_01", "batches/abc-1", "files/x.y"] {
            assert!(is_id(id), "{id}");
        }
        for id in [
            "",
            "../x",
            "a/../b",
            "a//b",
            "a?b",
            "a\u{1b}[2J",
            "a b",
            "/a",
            "%2e",
        ] {
            assert!(!is_id(id), "{id}");
        }
    }
}
