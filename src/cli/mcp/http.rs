//! Streamable HTTP on loopback: one address, `POST /mcp` for each message; a token, and no page of a browser.
//!
//! As the specification of 2025-06-18 has it. Answers that come at once are JSON, those of jobs a stream of events with
//! their progress. The server has nothing to say of its own, so that `GET` is refused.

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::Incoming;
use hyper::header::{ACCEPT, AUTHORIZATION, CONTENT_TYPE, HOST, HeaderMap, ORIGIN};
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use serde_json::Value;
use tokio::net::TcpListener;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::time::timeout;

use super::clients::Clients;
use super::connections::Connections;
use super::lines::{LONGEST, RpcError, Wire, id_of};
use super::response::{Answer, accepted, events, json, refused};
use super::server::{Server, VERSIONS};
use super::token::Token;
use crate::{Failure, Outcome, interrupt, output};

/// The path of the only address.
const PATH: &str = "/mcp";

/// How long head and body of a request may take.
const READ: Duration = Duration::from_secs(20);

/// Longest message whose `id` is looked for, bytes; longer ones are not read.
const LONGEST_NAMED: u64 = 16 << 20;

/// How long an answer may take before it becomes a stream.
const AT_ONCE: Duration = Duration::from_secs(1);

/// The header of sessions.
const SESSION: &str = "mcp-session-id";

/// Serves clients until the program is interrupted; then jobs that still run are ended.
pub async fn serve(server: Server, address: SocketAddr, token: Token) -> Outcome {
    let listener = TcpListener::bind(address)
        .await
        .map_err(|why| Failure::input(format!("{address}: {why}")))?;
    let address = listener.local_addr().map_err(Failure::input)?;
    output::say(&format!(
        "nearmiss: MCP server at http://{address}{PATH}; {}",
        server.places.words()
    ));
    output::say(&token.words());
    let face = Arc::new(Face {
        server: Arc::new(server),
        clients: Clients::default(),
        token,
    });
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
            () = interrupt::signal() => break,
        };
        let face = Arc::clone(&face);
        connections.add(|admitted| {
            let served = async move {
                let answer = hyper::service::service_fn(move |request| {
                    let (face, admitted) = (Arc::clone(&face), Arc::clone(&admitted));
                    async move {
                        Ok::<_, std::convert::Infallible>(face.answer(request, &admitted).await)
                    }
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
    let server = Arc::clone(&face.server);
    tokio::task::spawn_blocking(move || server.end())
        .await
        .map_err(Failure::input)
}

/// The server as it is seen over HTTP.
struct Face {
    server: Arc<Server>,
    clients: Clients,
    token: Token,
}

impl Face {
    async fn answer(&self, request: Request<Incoming>, admitted: &AtomicBool) -> Response<Answer> {
        match self.admitted(&request) {
            Ok(()) => admitted.store(true, Ordering::SeqCst),
            Err((status, why)) => return no(status, &Value::Null, why),
        }
        let session = header(request.headers(), SESSION).map(str::to_owned);
        match *request.method() {
            Method::POST => self.message(request, session).await,
            Method::DELETE => match session.and_then(|id| self.clients.end(&id)) {
                Some(ended) => {
                    self.server.jobs.cancel_all(Some(ended.number));
                    accepted(StatusCode::NO_CONTENT)
                }
                None => no(StatusCode::NOT_FOUND, &Value::Null, "no such session"),
            },
            _ => {
                let why = "messages are sent by POST; the server opens no stream of its own";
                let mut refused = no(StatusCode::METHOD_NOT_ALLOWED, &Value::Null, why);
                let allowed = hyper::header::HeaderValue::from_static("POST, DELETE");
                refused.headers_mut().insert(hyper::header::ALLOW, allowed);
                refused
            }
        }
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
            return Err((
                StatusCode::FORBIDDEN,
                "the request comes from another origin",
            ));
        }
        let given = header(headers, AUTHORIZATION.as_str());
        if !given.is_some_and(|given| self.token.is_in(given)) {
            return Err((
                StatusCode::UNAUTHORIZED,
                "the token is missing or wrong; the server prints it when it starts",
            ));
        }
        if request.uri().path() != PATH {
            return Err((StatusCode::NOT_FOUND, "the only path is /mcp"));
        }
        match header(headers, "mcp-protocol-version") {
            Some(version) if !VERSIONS.contains(&version) => Err((
                StatusCode::BAD_REQUEST,
                "the version in MCP-Protocol-Version is not spoken here",
            )),
            _ => Ok(()),
        }
    }

    async fn message(
        &self,
        request: Request<Incoming>,
        session: Option<String>,
    ) -> Response<Answer> {
        let unnamed = |status, why| no(status, &Value::Null, why);
        let headers = request.headers();
        let kind = header(headers, CONTENT_TYPE.as_str()).unwrap_or_default();
        if kind.split(';').next().map(str::trim) != Some("application/json") {
            let why = "the message must be application/json";
            return unnamed(StatusCode::UNSUPPORTED_MEDIA_TYPE, why);
        }
        let takes = header(headers, ACCEPT.as_str()).unwrap_or("*/*");
        let takes = |kind: &str| takes.contains(kind) || takes.contains("*/*");
        if !takes("application/json") || !takes("text/event-stream") {
            let why = "Accept must list application/json and text/event-stream";
            return unnamed(StatusCode::NOT_ACCEPTABLE, why);
        }
        let length = header(headers, "content-length").and_then(|n| n.parse::<u64>().ok());
        let long = |id| refused(StatusCode::PAYLOAD_TOO_LARGE, id, &RpcError::too_long());
        if length.is_some_and(|length| length > LONGEST_NAMED) {
            return long(&Value::Null);
        }
        let body = Limited::new(request.into_body(), LONGEST_NAMED as usize);
        let body = match timeout(READ, body.collect()).await {
            Ok(Ok(body)) => body.to_bytes(),
            Ok(Err(why)) if why.is::<LengthLimitError>() => return long(&Value::Null),
            Ok(Err(_)) => return unnamed(StatusCode::BAD_REQUEST, "the message broke off"),
            Err(_) => return unnamed(StatusCode::REQUEST_TIMEOUT, "the message came too slowly"),
        };
        if body.len() as u64 > LONGEST {
            let id = id_of(&body, std::io::empty());
            return if id.is_null() {
                long(&id)
            } else {
                // Clients of before look for an answer in what succeeds alone.
                json(StatusCode::OK, &RpcError::too_long().answer(&id))
            };
        }
        let Ok(message) = serde_json::from_slice::<Value>(&body) else {
            let error = RpcError::parse("the message is no JSON");
            return refused(
                StatusCode::BAD_REQUEST,
                &id_of(&body, std::io::empty()),
                &error,
            );
        };
        let id = message.get("id").cloned().unwrap_or_default();
        let begins = message.get("method").and_then(Value::as_str) == Some("initialize");
        let (client, new) = match (begins, session) {
            (true, _) => match self.clients.begin(|number| self.server.jobs.has(number)) {
                Ok((session, client)) => (client, Some(session)),
                Err(why) => return no(StatusCode::SERVICE_UNAVAILABLE, &id, &why),
            },
            (false, None) => {
                let why = "Mcp-Session-Id is missing; `initialize` answers with it";
                return no(StatusCode::BAD_REQUEST, &id, why);
            }
            (false, Some(session)) => match self.clients.of(&session) {
                Some(client) => (client, None),
                None => {
                    let why = "no such session; `initialize` again";
                    return no(StatusCode::NOT_FOUND, &id, why);
                }
            },
        };
        let (wire, mut answers) = unbounded_channel();
        let server = Arc::clone(&self.server);
        // Scenarios are read meanwhile.
        tokio::task::spawn_blocking(move || {
            server.message(&message, &client, &Wire::Response(wire), &|work| work());
        });
        let mut response = match at_once(&mut answers).await {
            Ok(response) => response,
            Err(begun) => events(begun, answers),
        };
        if let Some(session) = new.and_then(|session| session.parse().ok()) {
            response.headers_mut().insert(SESSION, session);
        }
        response
    }
}

/// Why a message is not taken.
fn no(status: StatusCode, id: &Value, why: &str) -> Response<Answer> {
    refused(status, id, &RpcError::request(why))
}

/// The response to a message that is answered at once, or that has no answer. Others get a stream, which may begin with
/// the progress that was told already.
async fn at_once(
    answers: &mut UnboundedReceiver<Value>,
) -> Result<Response<Answer>, Option<Value>> {
    match timeout(AT_ONCE, answers.recv()).await {
        Err(_) => Err(None),
        Ok(Some(progress)) if progress.get("method").is_some() => Err(Some(progress)),
        Ok(Some(answer)) => Ok(json(StatusCode::OK, &answer)),
        Ok(None) => Ok(accepted(StatusCode::ACCEPTED)),
    }
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

#[cfg(test)]
mod tests {
    use super::{is_host_here, is_origin_here};

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
}
