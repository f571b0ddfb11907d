//! Messages a line each: reading them within bounds, writing them whole.

use std::fmt;
use std::io::{BufRead, BufReader, Read, Write, copy, sink};

use serde::de::{Deserializer as _, IgnoredAny, MapAccess, Visitor};
use serde_json::{Value, json};
use tokio::sync::mpsc::UnboundedSender;

/// Longest message that is read, bytes.
pub const LONGEST: u64 = 1 << 20;

/// Longest message whose `id` is looked for, bytes; nothing else of it is kept.
const LONGEST_NAMED: u64 = 1 << 30;

/// A line of input.
#[derive(Debug)]
pub enum Line {
    /// A message, not yet read as JSON.
    Message(Vec<u8>),
    /// A line longer than [`LONGEST`], with its `id`; the rest was skipped.
    TooLong(Value),
}

/// The next line; `None` at the end.
pub fn next(input: &mut impl BufRead) -> Option<Line> {
    let mut line = Vec::new();
    let read = (&mut *input).take(LONGEST + 1).read_until(b'\n', &mut line);
    match read {
        Err(_) | Ok(0) => return None,
        Ok(_) => {}
    }
    if line.ends_with(b"\n") || line.len() as u64 <= LONGEST {
        return Some(Line::Message(line));
    }
    let mut rest = Rest(input, false);
    let id = id_of(&line, &mut rest);
    copy(&mut rest, &mut sink()).ok()?;
    Some(Line::TooLong(id))
}

/// What follows of a line; whether that is all.
struct Rest<'a, R>(&'a mut R, bool);

impl<R: BufRead> Read for Rest<'_, R> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
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

/// The `id` of a message that is too long or no JSON, as far as it can be read; null where there is none.
pub fn id_of(message: &[u8], rest: impl Read) -> Value {
    let message = BufReader::new(message.chain(rest).take(LONGEST_NAMED));
    let mut id = Value::Null;
    // What is wrong elsewhere is told otherwise.
    let _ = serde_json::Deserializer::from_reader(message).deserialize_map(Id(&mut id));
    if id.is_string() || id.is_number() {
        id
    } else {
        Value::Null
    }
}

/// Keeps the `id` of an object, and nothing else of it.
struct Id<'a>(&'a mut Value);

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

/// Where answers go.
#[derive(Debug, Clone)]
pub enum Wire {
    /// Standard output: one message a line, never two at once.
    Output,
    /// The response to a request over HTTP.
    Response(UnboundedSender<Value>),
}

impl Wire {
    /// Standard output.
    pub fn stdout() -> Self {
        Self::Output
    }

    /// Sends a message. A client that has gone is no error: its input ends too.
    pub fn send(&self, message: &Value) {
        match self {
            Self::Output => {
                let mut out = std::io::stdout().lock();
                let _ = out
                    .write_all(format!("{message}\n").as_bytes())
                    .and_then(|()| out.flush());
            }
            Self::Response(response) => drop(response.send(message.clone())),
        }
    }

    /// Answers a request.
    pub fn result(&self, id: &Value, result: &Value) {
        self.send(&json!({"jsonrpc": "2.0", "id": id, "result": result}));
    }

    /// Refuses a request.
    pub fn error(&self, id: &Value, error: &RpcError) {
        self.send(&error.answer(id));
    }
}

/// Why a request is refused, as JSON-RPC has it.
#[derive(Debug)]
pub struct RpcError {
    /// The code of JSON-RPC or of the protocol.
    pub code: i64,
    /// In words.
    pub message: String,
}

impl RpcError {
    /// The answer to the request with this id.
    pub fn answer(&self, id: &Value) -> Value {
        let error = json!({"code": self.code, "message": self.message});
        json!({"jsonrpc": "2.0", "id": id, "error": error})
    }

    /// The message is longer than [`LONGEST`].
    pub fn too_long() -> Self {
        Self::request(format!("the message has more than {LONGEST} bytes"))
    }

    /// The message is no JSON.
    pub fn parse(message: impl Into<String>) -> Self {
        let message = message.into();
        Self {
            code: -32700,
            message,
        }
    }

    /// The message is no request.
    pub fn request(message: impl Into<String>) -> Self {
        let message = message.into();
        Self {
            code: -32600,
            message,
        }
    }

    /// There is no such method.
    pub fn method(name: &str) -> Self {
        let name: String = name.chars().take(80).collect();
        let message = format!("no method `{name}`");
        Self {
            code: -32601,
            message,
        }
    }

    /// The parameters are wrong.
    pub fn parameters(message: impl Into<String>) -> Self {
        let message = message.into();
        Self {
            code: -32602,
            message,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn id(message: &str) -> Value {
        id_of(message.as_bytes(), std::io::empty())
    }

    #[test]
    fn ids_are_found_at_both_ends_of_what_cannot_be_read() {
        let long = "x\\\"}".repeat(1 << 20);
        let lines = format!(
            "{{\"method\":\"m\",\"params\":{{\"id\":1,\"a\":[\"{long}\"]}},\"id\":7}}\n{{\"id\":\"a\",\"x\":\"{long}\"}}\n{{}}\n"
        );
        let mut input = BufReader::new(lines.as_bytes());
        let mut ids = || match next(&mut input) {
            Some(Line::TooLong(id)) => id,
            other => panic!("{other:?}"),
        };
        assert_eq!([ids(), ids()], [json!(7), json!("a")]);
        assert!(matches!(next(&mut input), Some(Line::Message(line)) if line == b"{}\n"));
        assert_eq!(id(r#"{"x":"\ud800","id":3}"#), json!(3));
        assert_eq!(id(r#"{"id":4,"x":"#), json!(4));
        for none in ["", "[1]", "{", r#"{"x":{"id":5}}"#, r#"{"id":{}}"#] {
            assert_eq!(id(none), Value::Null, "{none}");
        }
    }
}
