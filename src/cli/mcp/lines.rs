//! Messages a line each: reading them within bounds, writing them whole.

use std::io::{BufRead, Read, Write};

use serde_json::{Value, json};
use tokio::sync::mpsc::UnboundedSender;

/// Longest message that is read, bytes.
pub const LONGEST: u64 = 1 << 20;

/// A line of input.
#[derive(Debug)]
pub enum Line {
    /// A message, not yet read as JSON.
    Message(Vec<u8>),
    /// A line longer than [`LONGEST`]; it was skipped.
    TooLong,
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
    loop {
        let rest = input.fill_buf().ok()?;
        let length = rest.len();
        if length == 0 {
            return Some(Line::TooLong);
        }
        let end = rest.iter().position(|byte| *byte == b'\n');
        input.consume(end.map_or(length, |end| end + 1));
        if end.is_some() {
            return Some(Line::TooLong);
        }
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
        let (code, message) = (error.code, &error.message);
        let error = json!({"code": code, "message": message});
        self.send(&json!({"jsonrpc": "2.0", "id": id, "error": error}));
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
