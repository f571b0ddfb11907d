//! Messages a line each on standard input and output: read within bounds, and written whole.
//!
//! The transport of `rmcp` drops lines that are too long or no JSON; here each is answered, by its id where it has one.

use std::collections::HashSet;
use std::fmt;
use std::io::{self, BufRead, BufReader, Read, Write, copy, sink, stdin, stdout};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use rmcp::ErrorData;
use rmcp::model::{
    ClientJsonRpcMessage, ClientNotification, JsonRpcMessage, RequestId, ServerJsonRpcMessage,
};
use rmcp::service::{RoleServer, ServiceExt};
use rmcp::transport::Transport;
use serde::de::{Deserializer as _, IgnoredAny, MapAccess, Visitor};
use serde_json::error::Category;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::task::spawn_blocking;

use super::{Handler, Server};
use crate::{Failure, Outcome, ending};

/// Longest message that is read, bytes.
pub const LONGEST: u64 = 1 << 20;

/// Longest message whose `id` is looked for, bytes; nothing else of it is kept.
const LONGEST_NAMED: u64 = 1 << 30;

/// Requests that wait for their answers; more are not read meanwhile.
const WAITING: usize = 64;

/// Serves one client until the input ends.
///
/// # Errors
/// The program is interrupted before.
pub async fn serve(server: &Arc<Server>) -> Outcome {
    let served = async {
        let handler = Handler(Arc::clone(server));
        // Without a client that begins a session there is nothing to do.
        if let Ok(client) = handler.serve(Stdio::start(server)).await {
            client.waiting().await.map_err(Failure::input)?;
        }
        Ok(())
    };
    tokio::select! {
        served = served => served,
        () = ending::signal() => Err(Failure::interrupted("")),
    }
}

/// Standard input and output.
struct Stdio {
    messages: Receiver<ClientJsonRpcMessage>,
    open: Arc<Open>,
}

impl Stdio {
    /// Begins to read; when the input ends, what takes long does, too, and the rest is still answered.
    fn start(server: &Arc<Server>) -> Self {
        let (sender, messages) = channel(1);
        let open = Arc::<Open>::default();
        let stdio = Self {
            messages,
            open: Arc::clone(&open),
        };
        let server = Arc::clone(server);
        std::thread::spawn(move || {
            read_all(stdin().lock(), &open, &sender);
            server.end_long();
            open.wait(1);
        });
        stdio
    }
}

impl Transport<RoleServer> for Stdio {
    type Error = io::Error;

    fn send(
        &mut self,
        message: ServerJsonRpcMessage,
    ) -> impl Future<Output = io::Result<()>> + Send + 'static {
        let open = Arc::clone(&self.open);
        let written = spawn_blocking(move || {
            write(&message);
            match message {
                JsonRpcMessage::Response(answer) => open.remove(&answer.id),
                JsonRpcMessage::Error(error) => error.id.iter().for_each(|id| open.remove(id)),
                _ => {}
            }
        });
        async { written.await.map_err(io::Error::other) }
    }

    async fn receive(&mut self) -> Option<ClientJsonRpcMessage> {
        self.messages.recv().await
    }

    async fn close(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Requests without an answer.
#[derive(Default)]
struct Open {
    ids: Mutex<HashSet<RequestId>>,
    fewer: Condvar,
}

impl Open {
    fn ids(&self) -> MutexGuard<'_, HashSet<RequestId>> {
        self.ids.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn remove(&self, id: &RequestId) {
        self.ids().remove(id);
        self.fewer.notify_all();
    }

    /// Waits until there are fewer.
    fn wait(&self, fewer_than: usize) {
        let too_many = |ids: &mut HashSet<RequestId>| ids.len() >= fewer_than;
        drop(self.fewer.wait_while(self.ids(), too_many));
    }
}

/// Reads messages until the input ends, and refuses those that are none.
fn read_all(mut input: impl BufRead, open: &Open, messages: &Sender<ClientJsonRpcMessage>) {
    let mut has_begun = false;
    while let Some(line) = next(&mut input) {
        let message = line.and_then(|line| match line.trim_ascii() {
            [] => Ok(None),
            line => parse(line).map(Some),
        });
        let message = match message {
            Ok(None) => continue,
            Ok(Some(message)) => message,
            Err(refused) => {
                write(&refused);
                continue;
            }
        };
        match &message {
            JsonRpcMessage::Request(request) => {
                has_begun = true;
                if !open.ids().insert(request.id.clone()) {
                    let why = "a request with this id is still running";
                    let error = ErrorData::invalid_request(why, None);
                    write(&JsonRpcMessage::error(error, Some(request.id.clone())));
                    continue;
                }
            }
            JsonRpcMessage::Notification(told) => {
                if let ClientNotification::CancelledNotification(gone) = &told.notification {
                    gone.params.request_id.iter().for_each(|id| open.remove(id));
                }
            }
            _ => {}
        }
        // What is told before the first request would end the session.
        if has_begun && messages.blocking_send(message).is_err() {
            return;
        }
        open.wait(WAITING);
    }
}

/// The answer to a message that is refused.
type Refused = Box<ServerJsonRpcMessage>;

/// Reads a message.
///
/// # Errors
/// It is no JSON, or no message of the protocol.
fn parse(message: &[u8]) -> Result<ClientJsonRpcMessage, Refused> {
    serde_json::from_slice(message).map_err(|why| {
        let error = match why.classify() {
            Category::Data => {
                ErrorData::invalid_request("the message is none of JSON-RPC 2.0", None)
            }
            _ => ErrorData::parse_error("the message is no JSON", None),
        };
        Box::new(JsonRpcMessage::error(error, id_of(message, io::empty())))
    })
}

/// The message is longer than [`LONGEST`].
pub fn too_long() -> ErrorData {
    ErrorData::invalid_request(format!("the message has more than {LONGEST} bytes"), None)
}

/// Writes a message, never two at once. A client that has gone is no error: its input ends too.
fn write(message: &ServerJsonRpcMessage) {
    if let Ok(mut line) = serde_json::to_vec(message) {
        line.push(b'\n');
        let mut out = stdout().lock();
        let _ = out.write_all(&line).and_then(|()| out.flush());
    }
}

/// The next line, not longer than [`LONGEST`]; `None` at the end.
fn next(input: &mut impl BufRead) -> Option<Result<Vec<u8>, Refused>> {
    let mut line = Vec::new();
    let read = (&mut *input).take(LONGEST + 1).read_until(b'\n', &mut line);
    match read {
        Err(_) | Ok(0) => return None,
        Ok(_) => {}
    }
    if line.ends_with(b"\n") || line.len() as u64 <= LONGEST {
        return Some(Ok(line));
    }
    let mut rest = Rest(input, false);
    let id = id_of(&line, &mut rest);
    copy(&mut rest, &mut sink()).ok()?;
    Some(Err(Box::new(JsonRpcMessage::error(too_long(), id))))
}

/// What follows of a line; whether that is all.
struct Rest<'a, R>(&'a mut R, bool);

impl<R: BufRead> Read for Rest<'_, R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        if self.1 {
            return Ok(0);
        }
        let there = self.0.fill_buf()?;
        let there = &there[..there.len().min(to.len())];
        let end = there.iter().position(|byte| *byte == b'\n');
        let length = end.unwrap_or(there.len());
        to[..length].copy_from_slice(&there[..length]);
        self.1 = end.is_some();
        self.0.consume(length + usize::from(self.1));
        Ok(length)
    }
}

/// The `id` of a message that is too long or no JSON, as far as it can be read.
pub fn id_of(message: &[u8], rest: impl Read) -> Option<RequestId> {
    let message = BufReader::new(message.chain(rest).take(LONGEST_NAMED));
    let mut id = None;
    // What is wrong elsewhere is told otherwise.
    let _ = serde_json::Deserializer::from_reader(message).deserialize_map(Id(&mut id));
    id
}

/// Keeps the `id` of an object, and nothing else of it.
struct Id<'a>(&'a mut Option<RequestId>);

impl<'de> Visitor<'de> for Id<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a message")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "id" => *self.0 = map.next_value()?,
                _ => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn number(id: i64) -> Option<RequestId> {
        Some(RequestId::Number(id))
    }

    #[test]
    fn ids_are_found_at_both_ends_of_what_cannot_be_read() {
        let long = "x\\\"}".repeat(1 << 20);
        let lines = format!(
            "{{\"method\":\"m\",\"params\":{{\"id\":1,\"a\":[\"{long}\"]}},\"id\":7}}\n{{\"id\":\"a\",\"x\":\"{long}\"}}\n{{}}\n"
        );
        let mut input = BufReader::new(lines.as_bytes());
        let mut ids = || match *next(&mut input).unwrap().unwrap_err() {
            JsonRpcMessage::Error(error) => error.id,
            other => panic!("{other:?}"),
        };
        assert_eq!(
            [ids(), ids()],
            [number(7), Some(RequestId::String("a".into()))]
        );
        assert_eq!(next(&mut input).unwrap().unwrap(), b"{}\n");
        let id = |message: &str| id_of(message.as_bytes(), io::empty());
        assert_eq!(id(r#"{"x":"\ud800","id":3}"#), number(3));
        assert_eq!(id(r#"{"id":4,"x":"#), number(4));
        for none in ["", "[1]", "{", r#"{"x":{"id":5}}"#, r#"{"id":{}}"#] {
            assert_eq!(id(none), None, "{none}");
        }
    }
}
