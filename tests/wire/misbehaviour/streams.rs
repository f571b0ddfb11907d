//! What is wrong with the events of an answer: their text, their shape, what they quote.

use serde_json::{Value, json};

use super::support::server::Script;
use super::{DONE, End, KEY, Row, STOP, data, delta, row, usual, verdict};

/// Sets a title, clears the screen, copies to the clipboard, and the one-byte form of the first.
const EVIL: &str = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{1b}]52;c;b3duZWQ=\u{7}\u{9b}31m\u{0}\u{8}\r";

fn events(body: &str) -> Script {
    Script::events().send(body)
}

fn choice(choice: &Value) -> String {
    data(&json!({"model": "m", "choices": [choice]}))
}

fn dialect(dialect: &'static str, name: &str, script: Script, end: End) -> Row {
    Row {
        dialect,
        ..row(name, script, end)
    }
}

pub fn rows() -> Vec<Row> {
    use End::{Any, Says, Verdict};
    let ok = usual();
    let utf16: Vec<u8> = ok.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let error = |message: &str| data(&json!({"error": {"message": message, "code": EVIL}}));
    let evil = json!({"collision": false, "obstacles": [{"id": 301, "risk_score": 2, "reason": EVIL}], "justification": EVIL});
    let quoting =
        json!({"collision": false, "obstacles": [], "justification": format!("your key is {KEY}")});
    let (front, back) = KEY.split_at(9);
    let stopped = |reason: &str| choice(&json!({"delta": {}, "finish_reason": reason}));
    let named = |name: &str| data(&json!({"model": name, "choices": []}));
    vec![
        row("is as it should be", events(&ok), Verdict),
        row(
            "begins with two byte order marks",
            events(&format!("\u{feff}\u{feff}{ok}")),
            Verdict,
        ),
        row(
            "ends its lines with carriage returns",
            events(&ok.replace('\n', "\r")),
            Verdict,
        ),
        row(
            "ends its lines with both",
            events(&ok.replace('\n', "\r\n")),
            Verdict,
        ),
        row(
            "sends many empty lines first",
            events(&("\n".repeat(1 << 17) + &ok)),
            Verdict,
        ),
        row(
            "sends many comments first",
            events(&(": x\n".repeat(1 << 15) + &ok)),
            Verdict,
        ),
        row("sends two-byte letters", Script::events().send(utf16), Any),
        row(
            "sends bytes that are no text",
            Script::events().send([delta("so far").as_bytes(), b"data: \xff\xfe\n\n"].concat()),
            Says("not UTF-8 text"),
        ),
        row(
            "sends half a character",
            Script::events().send(b"data: {\"choices\":\"\xf0\x9f\x9a"),
            Says("broke off"),
        ),
        row("sends NUL", events("data: \0\n\n"), Says("no answer")),
        row("sends words", events("data: hello\n\n"), Says("no answer")),
        row(
            "sends a list",
            events("data: [1,2,3]\n\n"),
            Says("no answer"),
        ),
        row(
            "sends a number",
            events("data: 1e999\n\n"),
            Says("no answer"),
        ),
        row(
            "sends NaN",
            events("data: {\"choices\": NaN}\n\n"),
            Says("no answer"),
        ),
        row(
            "sends a comma too many",
            events("data: {\"choices\": [],}\n\n"),
            Says("no answer"),
        ),
        row(
            "sends half of an event",
            events("data: {\"choices\""),
            Says("broke off"),
        ),
        row("sends a page", events("<html>\n\n"), Says("a web page")),
        row(
            "nests without end",
            events(&format!("data: {}\n\n", "[".repeat(200_000))),
            Says("no answer"),
        ),
        row(
            "nests objects without end",
            events(&format!("data: {}\n\n", "{\"a\":".repeat(100_000))),
            Says("no answer"),
        ),
        row(
            "sends two million values",
            events(&format!("data: [{}0]\n\n", "{},".repeat(1_100_000))),
            Says("more than 1000000 values"),
        ),
        row("ends at once", events(DONE), Any),
        row(
            "says nothing and is finished",
            events(&(STOP.to_string() + DONE)),
            Says("blank"),
        ),
        row(
            "says white space and is finished",
            events(&(delta(" \n\t ") + STOP + DONE)),
            Says("blank"),
        ),
        row(
            "finishes twice",
            events(&(delta(&verdict()) + STOP + &stopped("length") + DONE)),
            Any,
        ),
        row(
            "goes on after its end",
            events(&(ok.clone() + &delta("more") + &error("late"))),
            Verdict,
        ),
        row(
            "never says why it ends",
            events(&(delta(&verdict()) + DONE)),
            Verdict,
        ),
        row(
            "is cut in the middle",
            events(&delta("{\"collision\": true, ")),
            Says("broke off"),
        ),
        row(
            "is cut behind its last word",
            events(&(delta(&verdict()) + STOP)),
            Verdict,
        ),
        row(
            "does not close behind its last word",
            events(&(delta(&verdict()) + STOP)).await_close(),
            Verdict,
        ),
        row(
            "falls silent in the middle",
            events(&delta("so far")).await_close(),
            Says("sent nothing"),
        ),
        row(
            "runs into the token limit",
            events(&(delta("so far") + &stopped("length") + DONE)),
            Says("max_tokens"),
        ),
        row(
            "filters",
            events(&(delta("so far") + &stopped("content_filter") + DONE)),
            Says("content filter"),
        ),
        row(
            "declines",
            events(&(choice(&json!({"delta": {"refusal": format!("no {EVIL}")}})) + STOP + DONE)),
            Says("declined"),
        ),
        row(
            "ends for a reason in control characters",
            events(&(delta(&verdict()) + &stopped(EVIL) + DONE)),
            Verdict,
        ),
        row(
            "ends for a reason of a megabyte",
            events(&(delta(&verdict()) + &stopped(&"r".repeat(1 << 20)) + DONE)),
            Verdict,
        ),
        row(
            "is called by a megabyte",
            events(&(named(&"m".repeat(1 << 20)) + &ok)),
            Verdict,
        ),
        row(
            "is called by control characters",
            events(&(named(EVIL) + &ok)),
            Verdict,
        ),
        row("is called by the key", events(&(named(KEY) + &ok)), Verdict),
        row(
            "is called by a number",
            events(&(data(&json!({"model": 7, "choices": {}})) + &ok)),
            Verdict,
        ),
        row(
            "answers in control characters",
            events(&(delta(&evil.to_string()) + STOP + DONE)),
            Verdict,
        ),
        row(
            "chats in control characters",
            events(&(delta(EVIL) + STOP + DONE)),
            Says("no verdict"),
        ),
        row(
            "fails in control characters",
            events(&(delta("so far") + &error(EVIL))),
            Says("reported an error"),
        ),
        row(
            "fails before it begins",
            events(&error("no")),
            Says("reported an error"),
        ),
        row(
            "fails without a word",
            events("event: error\ndata:\n\n"),
            Says("reported an error"),
        ),
        row(
            "fails at length",
            events(&error(&"why ".repeat(300_000))),
            Says("reported an error"),
        ),
        row(
            "fails and quotes the key",
            events(&error(&format!("bad key {KEY}"))),
            Says("reported an error"),
        ),
        row(
            "answers with the key",
            events(&(delta(&quoting.to_string()) + STOP + DONE)),
            Verdict,
        ),
        row(
            "chats with the key in pieces",
            events(&(delta(front) + &delta(back) + STOP + DONE)),
            Says("no verdict"),
        ),
        row(
            "reasons with the key",
            events(&(choice(&json!({"delta": {"reasoning": format!("hm {KEY}")}})) + &ok)),
            Verdict,
        ),
        row(
            "declines with the key",
            events(&(choice(&json!({"delta": {"refusal": KEY}})) + STOP + DONE)),
            Says("declined"),
        ),
        row(
            "has no choices",
            events(&(data(&json!({"choices": []})).repeat(1000) + &ok)),
            Verdict,
        ),
        row(
            "has another choice",
            events(&(choice(&json!({"index": 9, "delta": {"content": "x"}})) + &ok)),
            Verdict,
        ),
        row(
            "has a choice that is null",
            events(&(choice(&Value::Null) + &ok)),
            Verdict,
        ),
        row(
            "has a delta that is a word",
            events(&(choice(&json!({"delta": "x"})) + &ok)),
            Verdict,
        ),
        row(
            "has a content that is a number",
            events(&(choice(&json!({"delta": {"content": 7}})) + &ok)),
            Verdict,
        ),
        row(
            "says a field twice",
            events(&("data: {\"choices\":[],\"choices\":7}\n\n".to_string() + &ok)),
            Verdict,
        ),
        row(
            "names its events",
            events(&ok.replace("data:", "event: message\nid: 7\nretry: 1\ndata:")),
            Verdict,
        ),
        row(
            "spreads an event over lines",
            events(&ok.replace(",\"", ",\ndata: \"")),
            Verdict,
        ),
        row(
            "speaks another dialect",
            events("event: ping\ndata: {\"type\": \"ping\"}\n\n"),
            Says("broke off"),
        ),
        row(
            "answers with 5 MiB behind the verdict",
            events(&(delta(&verdict()) + &delta(&" so".repeat(5 << 20)) + STOP + DONE)),
            Any,
        ),
        row(
            "answers with 3 MiB",
            events(&(delta(&verdict()) + &delta(&" so".repeat(1 << 20)) + STOP + DONE)),
            Any,
        ),
        dialect(
            "gemini",
            "gemini blocks",
            events(&data(&json!({"promptFeedback": {"blockReason": EVIL}}))),
            Says("blocked the question"),
        ),
        dialect(
            "gemini",
            "gemini has no candidates",
            events(&data(&json!({"candidates": []}))),
            Says("broke off"),
        ),
        dialect(
            "anthropic",
            "anthropic fails",
            events(&data(&json!({"type": "error", "error": {"message": KEY}}))),
            Says("reported an error"),
        ),
        dialect(
            "anthropic",
            "anthropic counts in a list",
            events(&data(
                &json!({"type": "message_start", "message": {"usage": [1]}}),
            )),
            Says("broke off"),
        ),
        dialect(
            "openai_responses",
            "responses fails without a reason",
            events(&data(
                &json!({"type": "response.failed", "response": {"status": "failed"}}),
            )),
            Says("reported an error"),
        ),
        dialect(
            "openai_responses",
            "responses is incomplete",
            events(&data(
                &json!({"type": "response.incomplete", "response": {"status": "incomplete", "output": 7}}),
            )),
            Any,
        ),
        dialect(
            "ollama",
            "ollama fails",
            Script::lines().send(format!("{}\n", json!({"error": EVIL}))),
            Says("reported an error"),
        ),
        dialect(
            "ollama",
            "ollama sends an event stream",
            Script::lines().send(&ok),
            Says("no answer"),
        ),
    ]
}
