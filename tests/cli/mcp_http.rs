//! `mcp --http`: sessions over streamable HTTP, and what is refused before it reaches the server.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};

use serde_json::{Value, json};

use super::mcp_jobs::{FAR, write_far};
use super::support::program::Home;

const TOKEN: &str = "Bearer 0123456789abcdef";

/// A server on a port of its own.
struct Http {
    child: Child,
    address: String,
}

/// Status, head and body of a response.
struct Answer(u16, String, String);

impl Answer {
    fn header(&self, name: &str) -> Option<&str> {
        let mut lines = self.1.lines().filter_map(|line| line.split_once(": "));
        lines
            .find(|(known, _)| known.eq_ignore_ascii_case(name))
            .map(|(_, value)| value)
    }

    /// The message, or the last one of a stream.
    fn json(&self) -> Value {
        let mut events = self
            .2
            .lines()
            .filter_map(|line| line.strip_prefix("data: "));
        let message = events.next_back().unwrap_or(&self.2);
        serde_json::from_str(message).unwrap_or_else(|_| panic!("{} {} {}", self.0, self.1, self.2))
    }
}

impl Http {
    fn start(home: &Home, folders: &[&str]) -> Self {
        let mut command = home.command();
        command
            .args(["mcp", "--http", "127.0.0.1:0"])
            .args(folders)
            .env("NEARMISS_MCP_TOKEN", "0123456789abcdef");
        let mut child = command
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        let address = line
            .split("http://")
            .nth(1)
            .and_then(|rest| rest.split('/').next())
            .unwrap_or_else(|| panic!("{line}"))
            .to_string();
        line.clear();
        said.read_line(&mut line).unwrap();
        // A token of the user is not printed.
        assert!(!line.contains("0123456789abcdef"), "{line}");
        Self { child, address }
    }

    fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Answer {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        let mut head = format!(
            "{method} {path} HTTP/1.1\r\nConnection: close\r\nContent-Length: {}\r\n",
            body.len()
        );
        if !headers.iter().any(|(name, _)| *name == "Host") {
            head += &format!("Host: {}\r\n", self.address);
        }
        for (name, value) in headers {
            head += &format!("{name}: {value}\r\n");
        }
        stream
            .write_all(format!("{head}\r\n{body}").as_bytes())
            .unwrap();
        let mut all = String::new();
        stream.read_to_string(&mut all).unwrap();
        let (head, body) = all
            .split_once("\r\n\r\n")
            .unwrap_or_else(|| panic!("{all}"));
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok())
            .unwrap();
        Answer(status, head.into(), body.into())
    }

    fn post(&self, session: Option<&str>, message: &Value) -> Answer {
        let mut headers = vec![
            ("Authorization", TOKEN),
            ("Content-Type", "application/json"),
            ("Accept", "application/json, text/event-stream"),
            ("MCP-Protocol-Version", "2025-06-18"),
        ];
        headers.extend(session.map(|session| ("Mcp-Session-Id", session)));
        self.send("POST", "/mcp", &headers, &message.to_string())
    }

    fn begin(&self) -> String {
        let hello = json!({"jsonrpc": "2.0", "id": 0, "method": "initialize", "params":
            {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "t", "version": "0"}}});
        let hello = self.post(None, &hello);
        assert_eq!(hello.json()["result"]["protocolVersion"], "2025-06-18");
        let session = hello.header("mcp-session-id").unwrap().to_string();
        let ready = json!({"jsonrpc": "2.0", "method": "notifications/initialized"});
        let ready = self.post(Some(&session), &ready);
        assert_eq!((ready.0, ready.2.as_str()), (202, ""));
        session
    }
}

impl Drop for Http {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn request(id: u64, method: &str, params: Value) -> Value {
    json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params})
}

#[test]
fn sessions_call_tools_and_jobs_stream_their_progress() {
    let home = Home::new();
    write_far(&home);
    let server = Http::start(&home, &["in"]);
    let session = server.begin();
    let other = server.begin();
    assert_ne!(session, other);
    let call = request(
        1,
        "tools/call",
        json!({"name": "inspect", "arguments": {"scenario": FAR}}),
    );
    let answer = server.post(Some(&session), &call);
    assert_eq!(
        (answer.0, answer.header("content-type")),
        (200, Some("text/event-stream"))
    );
    assert!(answer.json()["result"]["structuredContent"]["moments"].is_array());
    // The stream of a job has its progress; it ends with the result.
    let job = request(
        2,
        "tools/call",
        json!({"name": "generate", "arguments": {"scenario": FAR, "candidates": 100_000}, "_meta": {"progressToken": 1}}),
    );
    let streamed = std::thread::scope(|scope| {
        let job = scope.spawn(|| server.post(Some(&session), &job));
        std::thread::sleep(std::time::Duration::from_millis(2500));
        // Another session cannot end it; its own can, and then nothing is answered.
        let gone = json!({"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": 2}});
        assert_eq!(server.post(Some(&other), &gone).0, 202);
        std::thread::sleep(std::time::Duration::from_millis(1500));
        assert!(!job.is_finished());
        assert_eq!(server.post(Some(&session), &gone).0, 202);
        job.join().unwrap()
    });
    assert_eq!(streamed.header("content-type"), Some("text/event-stream"));
    assert!(
        streamed.2.contains("notifications/progress"),
        "{}",
        streamed.2
    );
    assert!(!streamed.2.contains("\"result\""), "{}", streamed.2);
    let render = request(
        3,
        "tools/call",
        json!({"name": "render", "arguments": {"scenario": FAR, "at": 5}}),
    );
    assert!(
        server
            .post(Some(&session), &render)
            .2
            .contains("\"image/png\"")
    );
    let headers = [
        ("Authorization", TOKEN),
        ("Mcp-Session-Id", session.as_str()),
    ];
    assert_eq!(server.send("DELETE", "/mcp", &headers, "").0, 202);
    assert_eq!(server.post(Some(&session), &call).0, 404);
    assert_eq!(server.post(Some(&other), &call).0, 200);
}

#[test]
fn who_has_no_token_or_comes_from_a_page_is_refused() {
    let home = Home::new();
    let server = Http::start(&home, &[]);
    let message = request(1, "ping", json!({})).to_string();
    let good = [
        ("Authorization", TOKEN),
        ("Content-Type", "application/json"),
        ("Accept", "application/json, text/event-stream"),
    ];
    // `initialize` begins a session; all else needs one.
    assert_eq!(server.send("POST", "/mcp", &good, &message).0, 400);
    for (name, value, status) in [
        ("Authorization", "", 401),
        ("Authorization", "Bearer 0123456789abcdeg", 401),
        ("Origin", "https://pages.example", 403),
        ("Origin", "null", 403),
        ("Host", "pages.example", 403),
        ("Content-Type", "text/plain", 415),
        ("Accept", "text/html", 406),
        ("MCP-Protocol-Version", "1999-01-01", 400),
        ("Mcp-Session-Id", "none", 404),
        ("Origin", "http://localhost:6274", 400),
    ] {
        let mut headers = good.to_vec();
        headers.retain(|(known, _)| *known != name);
        headers.extend((!value.is_empty()).then_some((name, value)));
        let said = server.send("POST", "/mcp", &headers, &message);
        assert_eq!(said.0, status, "{name}: {value}: {}", said.2);
        assert!(said.json()["error"]["message"].is_string());
    }
    assert_eq!(server.send("GET", "/mcp", &good, "").0, 405);
    assert_eq!(server.send("POST", "/other", &good, &message).0, 404);
    assert_eq!(server.send("POST", "/mcp", &good, "{").0, 415);
    assert_eq!(
        server
            .send("POST", "/mcp", &good, &"x".repeat((1 << 20) + 1))
            .0,
        413
    );
    // What is too long is answered by its id, if it has one.
    let long = request(5, "ping", json!({"x": "x".repeat(1 << 20)})).to_string();
    let said = server.send("POST", "/mcp", &good, &long);
    assert_eq!((said.0, &said.json()["id"]), (200, &json!(5)));
    assert_eq!(said.json()["error"]["code"], -32600);
    let lost = server.send("POST", "/mcp", &good, &message);
    assert_eq!(lost.json()["id"], 1);
    // Nothing but this machine.
    home.run(&["mcp", "--http", "0.0.0.0:0"])
        .status(2)
        .says(&["only addresses of this machine"]);
    home.run_with(
        &["mcp", "--http", "127.0.0.1:0"],
        &[("NEARMISS_MCP_TOKEN", "short")],
    )
    .status(2)
    .says(&["NEARMISS_MCP_TOKEN", "too short"]);
}

#[test]
fn connections_that_say_nothing_shut_nobody_out() {
    let home = Home::new();
    let server = Http::start(&home, &[]);
    let begun = std::time::Instant::now();
    let silent: Vec<TcpStream> = (0..100)
        .map(|_| TcpStream::connect(&server.address).unwrap())
        .collect();
    let session = server.begin();
    let ping = server.post(Some(&session), &request(1, "ping", json!({})));
    assert_eq!(ping.json()["result"], json!({}));
    assert!(begun.elapsed() < std::time::Duration::from_secs(15));
    drop(silent);
}
