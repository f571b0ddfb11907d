//! What is wrong with the answer before its first event: connections, heads, statuses, whole documents.

use serde_json::json;

use super::support::server::Script;
use super::{End, KEY, MS, Row, row, usual, verdict};

/// Sets a title, clears the screen, and the one-byte form of the same.
const EVIL: &str = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{9b}31m";

fn raw(bytes: impl AsRef<[u8]>) -> Script {
    Script::silent().send(bytes)
}

fn failing(status: u16, headers: &[(&str, &str)], message: &str) -> Script {
    let body = json!({"error": {"message": message}}).to_string();
    Script::answer(status, headers, &body)
}

fn ok(kind: &str, body: &str) -> Script {
    Script::answer(200, &[("Content-Type", kind)], body)
}

pub fn rows() -> Vec<Row> {
    use End::{Any, Says, Verdict};
    let head = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n";
    let chunked = format!("{head}Transfer-Encoding: chunked\r\n\r\n");
    let whole = json!({"model": "m", "choices": [{"message": {"content": verdict()}, "finish_reason": "stop"}]}).to_string();
    let utf16: Vec<u8> = usual().encode_utf16().flat_map(u16::to_le_bytes).collect();
    let mut rows = vec![
        row("closes at once", Script::silent(), Says("broke off")),
        row(
            "says nothing",
            Script::silent().await_close(),
            Says("sent nothing for 1s"),
        ),
        row(
            "is no web server",
            raw("\0\u{1}\u{2}220 smtp ready\r\n"),
            Says("broke off"),
        ),
        row("stops in its status line", raw("HTTP/1.1 2"), Any),
        row(
            "has a status line alone",
            raw("HTTP/1.1 200 OK\r\n").await_close(),
            Says("sent nothing"),
        ),
        row(
            "has a status of four digits",
            raw("HTTP/1.1 2000 OK\r\n\r\n"),
            Says("broke off"),
        ),
        row(
            "has one header of a megabyte",
            raw(format!(
                "HTTP/1.1 200 OK\r\nX: {}\r\n\r\n",
                "x".repeat(1 << 20)
            )),
            Says("broke off"),
        ),
        row(
            "has a thousand headers",
            raw(format!(
                "HTTP/1.1 200 OK\r\n{}\r\n",
                "X: y\r\n".repeat(1000)
            )),
            Says("broke off"),
        ),
        row(
            "has control characters in a header",
            raw(format!(
                "{head}X: {EVIL}\r\nConnection: close\r\n\r\n{}",
                usual()
            )),
            Any,
        ),
        row(
            "switches protocols",
            raw("HTTP/1.1 101 Switching Protocols\r\nUpgrade: x\r\nConnection: upgrade\r\n\r\n"),
            Any,
        ),
        row(
            "has no content",
            raw("HTTP/1.1 204 No Content\r\n\r\n"),
            Any,
        ),
        row(
            "has an empty body",
            ok("text/event-stream", ""),
            Says("broke off"),
        ),
        row(
            "has an empty document",
            ok("application/json", ""),
            Says("broke off"),
        ),
        row(
            "has a page for people",
            ok("text/html", "<html>"),
            Says("a web page"),
        ),
        row("has plain words", ok("text/plain", "hello"), Any),
        row(
            "has a picture",
            Script::silent().send(
                [
                    &b"HTTP/1.1 200 OK\r\nContent-Type: image/png\r\nConnection: close\r\n\r\n"[..],
                    b"\x89PNG\r\n\x1a\n\xff\xfe",
                ]
                .concat(),
            ),
            Says("not UTF-8 text"),
        ),
        row(
            "has no type",
            raw(format!(
                "HTTP/1.1 200 OK\r\nConnection: close\r\n\r\n{}",
                usual()
            )),
            Verdict,
        ),
        row(
            "is in the single bytes that it names",
            Script::silent().send(
                [
                    &b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream; charset=ISO-8859-1\r\nConnection: close\r\n\r\n: gr"[..],
                    b"\xfc\xdfe\n\n",
                    usual().as_bytes(),
                ]
                .concat(),
            ),
            Verdict,
        ),
        row(
            "breaks off in what is compressed",
            Script::silent().send(
                [
                    format!("{head}Content-Encoding: gzip\r\nConnection: close\r\n\r\n").as_bytes(),
                    b"\x1f\x8b\x08\x00\xff\xff\xff\xff\xff",
                ]
                .concat(),
            ),
            Says("broke off"),
        ),
        row(
            "promises more than it sends",
            raw(format!(
                "{head}Content-Length: 100000\r\n\r\ndata: {{}}\n\n"
            )),
            Says("broke off"),
        ),
        row(
            "sends more than it promises",
            raw(format!("{head}Content-Length: 5\r\n\r\n{}", usual())),
            Says("broke off"),
        ),
        row(
            "has a negative length",
            raw(format!("{head}Content-Length: -1\r\n\r\n{}", usual())),
            Says("broke off"),
        ),
        row(
            "has two lengths",
            raw(format!(
                "{head}Content-Length: 5\r\nContent-Length: 6\r\n\r\n{}",
                usual()
            )),
            Says("broke off"),
        ),
        row(
            "has a length of twenty digits",
            raw(format!(
                "{head}Content-Length: 99999999999999999999\r\n\r\n"
            )),
            Says("broke off"),
        ),
        row(
            "has a chunk without a size",
            raw(format!("{chunked}zz\r\n")),
            Says("broke off"),
        ),
        row(
            "has a chunk larger than memory",
            raw(format!("{chunked}ffffffffffffffff\r\ndata")),
            Says("broke off"),
        ),
        row(
            "never ends its chunks",
            raw(format!("{chunked}5\r\ndata:")),
            Says("broke off"),
        ),
        row(
            "redirects to itself",
            Script::answer(302, &[("Location", "/")], ""),
            Says("redirects to"),
        ),
        row(
            "redirects to nowhere",
            Script::answer(307, &[], ""),
            Says("does not name"),
        ),
        row(
            "redirects with the key",
            Script::answer(
                308,
                &[("Location", &format!("https://evil.test/?key={KEY}"))],
                "",
            ),
            Says("redirects to"),
        ),
        row(
            "redirects to another protocol",
            Script::answer(301, &[("Location", "file:///etc/passwd")], ""),
            Says("redirects to"),
        ),
        row(
            "quotes the key that it refuses",
            failing(401, &[], &format!("no such key {KEY}")),
            Says("rejected the key from LAB_KEY"),
        ),
        row(
            "refuses with a page",
            ok("text/html", "").append(Script::silent()),
            Any,
        ),
        row(
            "forbids in control characters",
            failing(403, &[], EVIL),
            Says("rejected the key"),
        ),
        row(
            "does not know the model",
            Script::json(404, ""),
            Says("does not know model"),
        ),
        row(
            "waited too long itself",
            failing(408, &[], "late"),
            Says("try again later"),
        ),
        row(
            "finds the question too long",
            failing(413, &[], "too long"),
            Says("did not accept"),
        ),
        row(
            "explains in a list",
            Script::json(422, r#"{"detail":[{"loc":["body"],"msg":"no"}]}"#),
            Says("did not accept"),
        ),
        row(
            "explains at length",
            failing(400, &[], &"why ".repeat(300_000)),
            Says("did not accept"),
        ),
        row(
            "explains in two-byte letters",
            Script::silent()
                .send([&b"HTTP/1.1 400 X\r\nConnection: close\r\n\r\n"[..], &utf16].concat()),
            Says("did not accept"),
        ),
        row(
            "explains in deep lists",
            Script::json(400, &"[".repeat(60_000)),
            Says("did not accept"),
        ),
        row(
            "explains and never ends",
            raw("HTTP/1.1 500 X\r\n\r\n").endless("why ", MS),
            Says("try again later"),
        ),
        row(
            "explains and falls silent",
            raw("HTTP/1.1 500 X\r\n\r\nbecause").await_close(),
            Says("try again later"),
        ),
        row(
            "asks to wait for ever",
            failing(429, &[("Retry-After", "1e300")], "slow"),
            Says("limiting requests"),
        ),
        row(
            "asks to wait for years",
            failing(429, &[("Retry-After", "99999999999")], "slow"),
            Says("limiting requests"),
        ),
        row(
            "asks to wait until long ago",
            failing(
                429,
                &[("Retry-After", "Wed, 21 Oct 1815 07:28:00 GMT")],
                "slow",
            ),
            Says("limiting requests"),
        ),
        row(
            "asks to wait a negative time",
            failing(429, &[("retry-after-ms", "-5")], "slow"),
            Says("limiting requests"),
        ),
        row(
            "asks to wait for nonsense",
            failing(429, &[("Retry-After", "soon\u{1b}[2J")], "slow"),
            Any,
        ),
        row(
            "says that the quota is used up",
            Script::json(
                429,
                r#"{"error":{"message":"m","code":"insufficient_quota"}}"#,
            ),
            Says("top it up"),
        ),
        row(
            "is overloaded",
            failing(529, &[], "busy"),
            Says("try again later"),
        ),
        row(
            "has a status beyond all",
            failing(999, &[], "odd"),
            Says("try again later"),
        ),
        row(
            "has a status below all",
            raw("HTTP/1.1 199 Odd\r\n\r\n").await_close(),
            Any,
        ),
        row(
            "answers in a document",
            ok("application/json", &whole),
            Verdict,
        ),
        row(
            "answers in a document with a mark",
            ok("application/json", &format!("\u{feff}{whole}")),
            Verdict,
        ),
        row(
            "answers in a cut document",
            ok("application/json", &whole[..whole.len() - 9]),
            Says("broke off"),
        ),
        row(
            "answers in a document of lists",
            ok("application/json", &"[".repeat(200_000)),
            Says("no answer"),
        ),
        row(
            "answers in a document of two million values",
            ok(
                "application/json",
                &format!("[{}0]", "0,".repeat(2_000_000)),
            ),
            Says("more than 1000000 values"),
        ),
        row(
            "answers in a document of 20 MB",
            ok(
                "application/json",
                &format!("{{\"a\":\"{}\"}}", "x".repeat(20_000_000)),
            ),
            Says("too large for an answer"),
        ),
        row(
            "answers with a number",
            ok("application/json", "7"),
            Says("no answer"),
        ),
        row(
            "answers with an error that is none",
            ok("application/json", r#"{"error":"no"}"#),
            Says("reported an error"),
        ),
    ];
    rows.push(row(
        "sends one byte at a time",
        {
            let bytes = usual().into_bytes();
            bytes
                .iter()
                .fold(raw(&chunked), |script, byte| script.chunk([*byte]))
                .end_of_chunks()
        },
        Verdict,
    ));
    rows
}
