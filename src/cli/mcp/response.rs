//! Responses over HTTP: JSON, a stream of events, or nothing.

use std::convert::Infallible;
use std::time::Duration;

use futures_util::stream;
use http_body_util::{BodyExt, Empty, Full, StreamBody, combinators::UnsyncBoxBody};
use hyper::body::{Bytes, Frame};
use hyper::header::{CACHE_CONTROL, CONTENT_TYPE, HeaderValue, WWW_AUTHENTICATE};
use hyper::{Response, StatusCode};
use serde_json::Value;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::timeout;

use super::lines::RpcError;

/// The body of a response.
pub type Answer = UnsyncBoxBody<Bytes, Infallible>;

/// How often a stream without messages says that it is alive.
const ALIVE: Duration = Duration::from_secs(10);

fn of(status: StatusCode, kind: Option<&'static str>, body: Answer) -> Response<Answer> {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    if let Some(kind) = kind {
        let kind = HeaderValue::from_static(kind);
        response.headers_mut().insert(CONTENT_TYPE, kind);
    }
    let never = HeaderValue::from_static("no-store");
    response.headers_mut().insert(CACHE_CONTROL, never);
    response
}

/// A message.
pub fn json(status: StatusCode, message: &Value) -> Response<Answer> {
    let body = Full::new(Bytes::from(message.to_string())).boxed_unsync();
    of(status, Some("application/json"), body)
}

/// Nothing is answered.
pub fn accepted(status: StatusCode) -> Response<Answer> {
    of(status, None, Empty::new().boxed_unsync())
}

/// Why the request with this id is refused; null where it is not known.
pub fn refused(status: StatusCode, id: &Value, error: &RpcError) -> Response<Answer> {
    let mut response = json(status, &error.answer(id));
    if status == StatusCode::UNAUTHORIZED {
        let bearer = HeaderValue::from_static("Bearer");
        response.headers_mut().insert(WWW_AUTHENTICATE, bearer);
    }
    response
}

/// Messages as they come, until nothing more can come; `begun` came already.
pub fn events(begun: Option<Value>, messages: UnboundedReceiver<Value>) -> Response<Answer> {
    let each = stream::unfold((begun, messages), |(begun, mut messages)| async move {
        let next = match begun {
            Some(message) => Ok(Some(message)),
            None => timeout(ALIVE, messages.recv()).await,
        };
        let text = match next {
            Ok(Some(message)) => format!("event: message\ndata: {message}\n\n"),
            Ok(None) => return None,
            Err(_) => ": working\n\n".into(),
        };
        Some((Ok(Frame::data(Bytes::from(text))), (None, messages)))
    });
    of(
        StatusCode::OK,
        Some("text/event-stream"),
        StreamBody::new(each).boxed_unsync(),
    )
}
