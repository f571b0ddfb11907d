//! Streamable HTTP on loopback: a guard in front of `rmcp`, which asks for a token, refuses pages of browsers and counts connections.
//!
//! The server has nothing to say of its own, so that `GET` is refused.

use std::convert::Infallible;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use http_body_util::combinators::BoxBody;
use http_body_util::{BodyExt, Full, LengthLimitError, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{
    ALLOW, AUTHORIZATION, CACHE_CONTROL, CONTENT_TYPE, HOST, HeaderMap, HeaderValue, ORIGIN,
    WWW_AUTHENTICATE,
};
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use rmcp::ErrorData;
use rmcp::model::{JsonRpcError, RequestId};
use rmcp::transport::streamable_http_server::session::local::LocalSessionManager;
use rmcp::transport::{StreamableHttpServerConfig, StreamableHttpService};
use sha2::{Digest, Sha256};
use tokio::net::TcpListener;
use tokio::task::AbortHandle;
use tokio::time::timeout;

use super::stdio::{LONGEST, id_of, too_long};
use super::{Handler, Server};
use crate::{Failure, Outcome, ending, output};

/// The path of the only address.
const PATH: &str = "/mcp";

/// How long head and body of a request may take.
const READ: Duration = Duration::from_secs(20);

/// Longest message whose `id` is looked for, bytes; longer ones are not read.
const LONGEST_NAMED: usize = 16 << 20;

/// After this a session that is silent ends.
const SILENT: Duration = Duration::from_secs(24 * 3600);

/// The body of a response.
type Body = BoxBody<Bytes, Infallible>;

/// Serves clients until the program is interrupted; then jobs that still run are ended.
pub async fn serve(server: Arc<Server>, address: SocketAddr, token: Token) -> Outcome {
    let listener = TcpListener::bind(address)
        .await
        .map_err(|why| Failure::input(format!("{address}: {why}")))?;
    let address = listener.local_addr().map_err(Failure::input)?;
    output::say(&format!(
        "nearmiss: MCP server at http://{address}{PATH}; {}",
        server.places.words()
    ));
    output::say(&token.words());
    let guard = Arc::new(Guard::new(server, token));
    let connections = Connections::default();
    loop {
        let stream = tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, _)) => stream,
                // Too many open files, say: it may be over soon.
                Err(_) => {
                    tokio::time::sleep(Duration::from_millis(100)).await;
                    continue;
                }
            },
            () = ending::signal() => return Ok(()),
        };
        let guard = Arc::clone(&guard);
        connections.add(|admitted| {
            let served = async move {
                let answer = hyper::service::service_fn(move |request| {
                    let (guard, admitted) = (Arc::clone(&guard), Arc::clone(&admitted));
                    async move { Ok::<_, Infallible>(guard.answer(request, &admitted).await) }
                });
                let mut connection = hyper::server::conn::http1::Builder::new();
                connection
                    .timer(TokioTimer::new())
                    .header_read_timeout(READ);
                // A client that breaks off is no error of ours.
                let _ = connection
                    .serve_connection(TokioIo::new(stream), answer)
                    .await;
            };
            tokio::spawn(served).abort_handle()
        });
    }
}

/// Admits requests to the service.
struct Guard {
    service: StreamableHttpService<Handler, LocalSessionManager>,
    token: Token,
}

impl Guard {
    fn new(server: Arc<Server>, token: Token) -> Self {
        let mut sessions = LocalSessionManager::default();
        sessions.session_config.keep_alive = Some(SILENT);
        // Streams are not taken up again.
        sessions.session_config.sse_retry = None;
        let config = StreamableHttpServerConfig::default()
            .with_sse_retry(None)
            .disable_allowed_hosts();
        let handler = move || Ok(Handler(Arc::clone(&server)));
        let service = StreamableHttpService::new(handler, Arc::new(sessions), config);
        Self { service, token }
    }

    async fn answer(&self, request: Request<Incoming>, admitted: &AtomicBool) -> Response<Body> {
        let mut response = match self.admitted(&request) {
            Ok(()) => {
                admitted.store(true, Ordering::SeqCst);
                self.served(request).await
            }
            Err((status, why)) => refused(status, None, why),
        };
        let never = HeaderValue::from_static("no-store");
        response.headers_mut().insert(CACHE_CONTROL, never);
        response
    }

    /// Whether a request may say anything at all.
    fn admitted(&self, request: &Request<Incoming>) -> Result<(), (StatusCode, &'static str)> {
        let headers = request.headers();
        // A page in a browser has an origin, and may reach this machine under a name of its own.
        let fits = |name, is_here: fn(&str) -> bool| {
            let value = headers.get(name);
            value.is_none_or(|value| value.to_str().is_ok_and(is_here))
        };
        if !fits(ORIGIN, is_origin_here) || !fits(HOST, is_host_here) {
            let why = "the request comes from another origin";
            return Err((StatusCode::FORBIDDEN, why));
        }
        let given = header(headers, AUTHORIZATION.as_str());
        if !given.is_some_and(|given| self.token.is_in(given)) {
            let why = "the token is missing or wrong; the server prints it when it starts";
            return Err((StatusCode::UNAUTHORIZED, why));
        }
        if request.uri().path() != PATH {
            return Err((StatusCode::NOT_FOUND, "the only path is /mcp"));
        }
        if [Method::POST, Method::DELETE].contains(request.method()) {
            Ok(())
        } else {
            let why = "messages are sent by POST; the server opens no stream of its own";
            Err((StatusCode::METHOD_NOT_ALLOWED, why))
        }
    }

    /// The answer of the service to a message that is not too long.
    async fn served(&self, request: Request<Incoming>) -> Response<Body> {
        let long = |id| error(StatusCode::PAYLOAD_TOO_LARGE, id, too_long());
        let length = header(request.headers(), "content-length").and_then(|n| n.parse().ok());
        if length.is_some_and(|length: usize| length > LONGEST_NAMED) {
            return long(None);
        }
        let (head, body) = request.into_parts();
        let body = Limited::new(body, LONGEST_NAMED);
        let body = match timeout(READ, body.collect()).await {
            Ok(Ok(body)) => body.to_bytes(),
            Ok(Err(why)) if why.is::<LengthLimitError>() => return long(None),
            Ok(Err(_)) => return refused(StatusCode::BAD_REQUEST, None, "the message broke off"),
            Err(_) => {
                let why = "the message came too slowly";
                return refused(StatusCode::REQUEST_TIMEOUT, None, why);
            }
        };
        let id = || id_of(&body, std::io::empty());
        if body.len() as u64 > LONGEST {
            return match id() {
                None => long(None),
                // Clients of before look for an answer in what succeeds alone.
                id => error(StatusCode::OK, id, too_long()),
            };
        }
        let request = Request::from_parts(head, Full::new(body.clone()));
        let response = self.service.handle(request).await;
        let (status, kind) = (response.status(), response.headers().get(CONTENT_TYPE));
        if status.is_success() || kind.is_some() {
            return response;
        }
        // What is wrong is told in plain text.
        let why = response.into_body().collect().await.unwrap_or_default();
        refused(status, id(), &String::from_utf8_lossy(&why.to_bytes()))
    }
}

/// Why the request with this id is refused.
fn refused(status: StatusCode, id: Option<RequestId>, why: &str) -> Response<Body> {
    error(
        status,
        id,
        ErrorData::invalid_request(why.to_string(), None),
    )
}

fn error(status: StatusCode, id: Option<RequestId>, error: ErrorData) -> Response<Body> {
    let message = serde_json::to_vec(&JsonRpcError::new(id, error)).unwrap_or_default();
    let mut response = Response::new(Full::new(Bytes::from(message)).boxed());
    *response.status_mut() = status;
    let mut header = |name, value| {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    };
    header(CONTENT_TYPE, "application/json");
    match status {
        StatusCode::UNAUTHORIZED => header(WWW_AUTHENTICATE, "Bearer"),
        StatusCode::METHOD_NOT_ALLOWED => header(ALLOW, "POST, DELETE"),
        _ => {}
    }
    response
}

fn header<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    headers.get(name)?.to_str().ok()
}

/// Whether an origin is a page of this machine.
fn is_origin_here(origin: &str) -> bool {
    let host = origin
        .strip_prefix("http://")
        .or_else(|| origin.strip_prefix("https://"));
    host.is_some_and(is_host_here)
}

/// Whether a host, with a port or without, is this machine, and nothing else.
fn is_host_here(host: &str) -> bool {
    let (name, port) = match host.strip_prefix('[') {
        Some(rest) => rest.split_once(']').unwrap_or_default(),
        None => host.split_at(host.find(':').unwrap_or(host.len())),
    };
    let is_number = |port: &str| port.bytes().all(|byte| byte.is_ascii_digit());
    let is_port = |port: &str| is_number(port) && port.parse::<u16>().is_ok();
    if !(port.is_empty() || port.strip_prefix(':').is_some_and(is_port)) {
        return false;
    }
    if host.starts_with('[') {
        name.parse::<Ipv6Addr>().is_ok_and(|ip| ip.is_loopback())
    } else {
        name.eq_ignore_ascii_case("localhost")
            || name.parse::<Ipv4Addr>().is_ok_and(|ip| ip.is_loopback())
    }
}

/// Connections at once.
const MAX_CONNECTIONS: usize = 64;

/// The open ones, the oldest first.
#[derive(Debug, Default)]
struct Connections(Mutex<Vec<Connection>>);

#[derive(Debug)]
struct Connection {
    task: AbortHandle,
    /// Whether a request with the token came on it.
    admitted: Arc<AtomicBool>,
}

impl Connections {
    /// Serves a new connection by the task that `serve` starts; it is given the flag for a request with the token. Where
    /// there are too many, the oldest without such a request is closed; where all have one, the new one is.
    fn add(&self, serve: impl FnOnce(Arc<AtomicBool>) -> AbortHandle) {
        let mut open = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        open.retain(|connection| !connection.task.is_finished());
        if open.len() >= MAX_CONNECTIONS {
            let silent = |one: &Connection| !one.admitted.load(Ordering::SeqCst);
            let Some(oldest) = open.iter().position(silent) else {
                return;
            };
            open.remove(oldest).task.abort();
        }
        let admitted = Arc::new(AtomicBool::new(false));
        let task = serve(Arc::clone(&admitted));
        open.push(Connection { task, admitted });
    }
}

/// The variable that may hold it.
pub const VARIABLE: &str = "NEARMISS_MCP_TOKEN";

/// Fewest characters of a token.
const SHORTEST: usize = 16;

/// A token: that of the environment, or a random one that is printed.
pub struct Token {
    /// Two tokens take equally long to compare, whatever they have in common.
    hash: [u8; 32],
    /// The token itself, where it has to be printed.
    printed: Option<String>,
}

impl Token {
    /// The token of the environment, else a new one.
    ///
    /// # Errors
    /// In words: that of the environment is too short, or there are no random numbers.
    pub fn new(given: Option<&str>) -> Result<Self, String> {
        match given {
            Some(token) if token.len() >= SHORTEST => Ok(Self {
                hash: hash(token),
                printed: None,
            }),
            Some(_) => Err(format!(
                "{VARIABLE} is too short; use {SHORTEST} characters or more, or leave it out for a random token"
            )),
            None => random().map(|token| Self {
                hash: hash(&token),
                printed: Some(token),
            }),
        }
    }

    /// Whether a header `Authorization` shows it.
    pub fn is_in(&self, header: &str) -> bool {
        let mut words = header.splitn(2, ' ');
        let bearer = words
            .next()
            .is_some_and(|word| word.eq_ignore_ascii_case("bearer"));
        bearer && hash(words.next().unwrap_or_default().trim()) == self.hash
    }

    /// What clients have to send.
    pub fn words(&self) -> String {
        match &self.printed {
            Some(token) => {
                format!("nearmiss: clients send the header `Authorization: Bearer {token}`")
            }
            None => format!(
                "nearmiss: clients send the header `Authorization: Bearer …` with the token of {VARIABLE}"
            ),
        }
    }
}

fn hash(text: &str) -> [u8; 32] {
    Sha256::digest(text.as_bytes()).into()
}

/// 256 random bits in hexadecimal digits.
///
/// # Errors
/// In words: the system gives none.
fn random() -> Result<String, String> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes)
        .map_err(|why| format!("the system gives no random numbers: {why}"))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn origins_and_hosts_of_this_machine() {
        let hosts = [
            "localhost:3000",
            "127.0.0.1",
            "[::1]:80",
            "LocalHost",
            "[::1]",
        ];
        for host in hosts {
            assert!(is_host_here(host), "{host}");
            assert!(is_origin_here(&format!("http://{host}")), "{host}");
            assert!(is_origin_here(&format!("https://{host}")), "{host}");
            assert!(!is_origin_here(host), "{host}");
        }
        for host in [
            "evil.example",
            "127.0.0.1.evil.example",
            "127.0.0.1:38395.evil.example",
            "localhost:80@evil.example",
            "localhost:80/x",
            "localhost/",
            "localhost:",
            "localhost:+80",
            "localhost:65536",
            "[::1].evil.example",
            "[::1]:80.evil.example",
            "[::1",
            "::1",
            "[127.0.0.1]",
            "localhost.evil",
            "null",
            "",
        ] {
            assert!(!is_host_here(host), "{host}");
            assert!(!is_origin_here(&format!("http://{host}")), "{host}");
        }
        assert!(!is_origin_here("file://localhost") && !is_origin_here("null"));
    }

    #[test]
    fn only_the_whole_token_is_taken() {
        let Ok(token) = Token::new(Some("0123456789abcdef")) else {
            panic!("long enough");
        };
        assert!(token.is_in("Bearer 0123456789abcdef") && token.is_in("bearer  0123456789abcdef"));
        for wrong in [
            "",
            "Bearer",
            "Bearer ",
            "0123456789abcdef",
            "Basic 0123456789abcdef",
            "Bearer 0123456789abcde",
        ] {
            assert!(!token.is_in(wrong), "{wrong}");
        }
        assert!(Token::new(Some("short")).is_err());
        assert!(Token::new(None).is_ok_and(|token| token.words().len() > 64));
        assert_ne!(random(), random());
    }
}
