//! What never ends: the limits of time and size end it.

use std::time::Duration;

use serde_json::json;

use super::support::server::Script;
use super::{End, MS, Row, data, delta, row, verdict};

/// Between pieces that come without a pause.
const NOW: Duration = Duration::ZERO;

pub fn rows() -> Vec<Row> {
    use End::{Any, Says};
    let events = |text: &str| Script::events().endless(text.repeat((64 << 10) / text.len()), NOW);
    let slow = |text: &str| Script::events().endless(text, 100 * MS);
    let late = "did not finish within 3s";
    let reasoning = data(&json!({"choices": [{"delta": {"reasoning": "hm ".repeat(2000)}}]}));
    let refusal = data(&json!({"choices": [{"delta": {"refusal": "no ".repeat(2000)}}]}));
    let nothing = data(&json!({"choices": [{"delta": {"content": ""}}]}));
    let raw = |head: &str| Script::silent().send(head);
    let chunked =
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nTransfer-Encoding: chunked\r\n\r\n";
    let other = |dialect, name: &str, script: Script, end| Row {
        dialect,
        ..row(name, script, end)
    };
    let lines = |text: &str| Script::lines().endless(text.repeat((64 << 10) / text.len()), NOW);
    vec![
        row("endless line feeds", events("\n"), Any),
        row("endless carriage returns", events("\r"), Any),
        row("endless line ends of both", events("\r\n"), Any),
        row("endless comments", events(": keep-alive\n\n"), Any),
        row("endless names", events("event: error\n"), Any),
        row("endless ids", events("id: 1\n"), Any),
        row("endless fields without a name", events(":\n"), Any),
        row("endless lines of one event", events("data: x\n"), Any),
        row("endless empty lines of one event", events("data\n"), Any),
        row("one line without an end", events("x"), Any),
        row(
            "one event without an end",
            Script::events()
                .send("data: {\"a\":\"")
                .endless("x".repeat(64 << 10), NOW),
            Any,
        ),
        row("endless empty events", events("data: {}\n\n"), Any),
        row("endless events of nothing", events(&nothing), Any),
        row("endless white space", events(&delta("    ")), Any),
        row("endless words", events(&delta(&"so ".repeat(2000))), Any),
        row(
            "endless words behind a verdict",
            Script::events()
                .send(delta(&verdict()))
                .endless(delta(&" so".repeat(2000)).repeat(9), NOW),
            Any,
        ),
        row("endless reasoning", events(&reasoning), Any),
        row(
            "endless thoughts in tags",
            Script::events()
                .send(delta("<think>"))
                .endless(delta(&"hm ".repeat(2000)).repeat(9), NOW),
            Any,
        ),
        row("endless refusals", events(&refusal), Any),
        row("slow line feeds", slow("\n"), Says(late)),
        row("slow comments", slow(": keep-alive\n\n"), Says(late)),
        row("slow words", slow(&delta("so ")), Says(late)),
        row("slow events of nothing", slow(&nothing), Says(late)),
        row(
            "slow letters of one event",
            Script::events().send("data: ").endless("x", 100 * MS),
            Says(late),
        ),
        row(
            "slow words in a document",
            raw("HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n\r\n{")
                .endless(" ", 100 * MS),
            Says(late),
        ),
        row(
            "endless words in a document",
            raw("HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n\r\n[\"")
                .endless("x".repeat(64 << 10), NOW),
            Any,
        ),
        row(
            "endless headers",
            raw("HTTP/1.1 200 OK\r\n").endless("X: y\r\n".repeat(100), NOW),
            Any,
        ),
        row(
            "slow headers",
            raw("HTTP/1.1 200 OK\r\n").endless("X: y\r\n", 200 * MS),
            Any,
        ),
        row(
            "an endless header",
            raw("HTTP/1.1 200 OK\r\nX: ").endless("x".repeat(4096), NOW),
            Any,
        ),
        row(
            "an endless status line",
            raw("HTTP/1.1 200 ").endless("x".repeat(4096), NOW),
            Any,
        ),
        row(
            "endless promises to go on",
            Script::silent().endless("HTTP/1.1 100 Continue\r\n\r\n", MS),
            Any,
        ),
        row(
            "endless trailers",
            raw(chunked)
                .send("0\r\n")
                .endless("X: y\r\n".repeat(100), NOW),
            Any,
        ),
        row(
            "an endless extension of a chunk",
            raw(chunked).send("5;").endless("x".repeat(4096), NOW),
            Any,
        ),
        row(
            "an endless size of a chunk",
            raw(chunked).endless("0".repeat(4096), NOW),
            Any,
        ),
        row(
            "endless empty-handed chunks",
            raw(chunked).endless("1\r\n\n\r\n".repeat(1000), NOW),
            Any,
        ),
        other("ollama", "ollama: endless line feeds", lines("\n"), Any),
        other("ollama", "ollama: one line without an end", lines("x"), Any),
        other(
            "ollama",
            "ollama: endless words",
            lines(&format!(
                "{}\n",
                json!({"message": {"content": "so ".repeat(2000)}})
            )),
            Any,
        ),
        other(
            "anthropic",
            "anthropic: endless pings",
            events("data: {\"type\":\"ping\"}\n\n"),
            Any,
        ),
        other(
            "gemini",
            "gemini: endless candidates",
            events("data: {\"candidates\":[]}\n\n"),
            Any,
        ),
        other(
            "gemini",
            "gemini: endless words",
            events(&data(
                &json!({"candidates": [{"content": {"parts": [{"text": "so ".repeat(2000)}]}}]}),
            )),
            Any,
        ),
        other(
            "openai_responses",
            "responses: endless states",
            events(
                "data: {\"type\":\"response.in_progress\",\"response\":{\"status\":\"in_progress\"}}\n\n",
            ),
            Any,
        ),
        other(
            "anthropic",
            "anthropic: more than any answer at once",
            Script::events()
                .send(format!("data: \"{}", "x".repeat(9 << 20)))
                .await_close(),
            Any,
        ),
    ]
}
