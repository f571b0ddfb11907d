//! Tests of every dialect: base URLs in every spelling, and bodies with images as documented.
#![allow(clippy::unwrap_used)]

use serde_json::{Value, json};

use super::super::endpoint::Endpoint;
use crate::llm::request::Image;
use crate::llm::{Dialect, Message, Parameters, Request, Role, body};

fn url(dialect: Dialect, base: &str, model: &str) -> String {
    let endpoint = Endpoint {
        dialect,
        ..Endpoint::new("test", base)
    };
    endpoint.request_url(model).unwrap().to_string()
}

fn same(dialect: Dialect, expected: &str, bases: &[&str]) {
    for base in bases {
        assert_eq!(url(dialect, base, "m"), expected, "{base}");
    }
}

#[test]
fn every_way_to_write_a_base_url() {
    same(
        Dialect::OpenAiChat,
        "http://h:1/v1/chat/completions",
        &[
            "http://h:1",
            "http://h:1/",
            " http://h:1/v1// \n",
            "http://h:1/v1/chat/completions/",
        ],
    );
    same(
        Dialect::OpenAiChat,
        "https://o.ai/api/v1/chat/completions",
        &["https://o.ai/api/v1"],
    );
    same(
        Dialect::OpenAiChat,
        "https://g.com/v1beta/openai/chat/completions",
        &["https://g.com/v1beta/openai/"],
    );
    same(
        Dialect::OpenAiChat,
        "https://a.azure.com/d/x/chat/completions?api-version=2",
        &["https://a.azure.com/d/x?api-version=2#f"],
    );
    same(
        Dialect::OpenAiChat,
        "http://[::1]:11434/v1/chat/completions",
        &["http://[::1]:11434"],
    );
    same(
        Dialect::OpenAiResponses,
        "http://h/v1/responses",
        &["http://h", "http://h/v1/", "http://h/v1/responses"],
    );
    same(
        Dialect::Anthropic,
        "http://h/v1/messages",
        &[
            "http://h",
            "http://h/",
            "http://h/v1",
            "http://h/v1/messages",
        ],
    );
    same(
        Dialect::Anthropic,
        "https://d.com/anthropic/v1/messages",
        &["https://d.com/anthropic", "https://d.com/anthropic/v1/"],
    );
    same(
        Dialect::Ollama,
        "http://h:11434/api/chat",
        &[
            "http://h:11434",
            "http://h:11434/v1",
            "http://h:11434/api/",
            "http://h:11434/api/chat",
        ],
    );
    same(
        Dialect::Gemini,
        "http://h/v1beta/models/m:streamGenerateContent?alt=sse",
        &["http://h", "http://h/v1beta", "http://h/v1beta/models/"],
    );
    same(
        Dialect::Gemini,
        "http://h/proxy/v1/models/m:streamGenerateContent?k=1&alt=sse",
        &["http://h/proxy/v1?k=1"],
    );
}

#[test]
fn a_model_cannot_leave_its_place_in_the_address() {
    let url = |model| url(Dialect::Gemini, "http://h", model);
    assert_eq!(
        url("models/gemini-x"),
        "http://h/v1beta/models/gemini-x:streamGenerateContent?alt=sse"
    );
    for model in ["../../x", "a/b", "x?key=1", "x#y", "..", "%2e%2e"] {
        let url = url(model);
        assert!(
            url.starts_with("http://h/v1beta/models/")
                && url.matches('/').count() == 5
                && url.ends_with(":streamGenerateContent?alt=sse"),
            "{url}"
        );
    }
}

/// The body of a question with an image of three bytes.
fn asked(dialect: Dialect) -> Value {
    let mut endpoint = Endpoint::new("lab", "http://127.0.0.1:9");
    endpoint.dialect = dialect;
    let image = Image::png(b"abc".to_vec(), (1152, 768));
    let request = Request {
        model: "seer".into(),
        messages: vec![
            Message::new(Role::System, "Judge."),
            Message {
                images: vec![image],
                ..Message::new(Role::User, "Is this dangerous?")
            },
        ],
        parameters: Parameters::default(),
        schema: None,
        tools: None,
    };
    body(&endpoint, &request)
}

#[test]
fn chat_has_parts_with_a_data_address() {
    assert_eq!(
        asked(Dialect::OpenAiChat)["messages"],
        json!([
            {"role": "system", "content": "Judge."},
            {"role": "user", "content": [
                {"type": "image_url", "image_url": {"url": "data:image/png;base64,YWJj"}},
                {"type": "text", "text": "Is this dangerous?"},
            ]},
        ])
    );
}

#[test]
fn responses_have_parts_of_input() {
    assert_eq!(
        asked(Dialect::OpenAiResponses)["input"],
        json!([
            {"role": "system", "content": "Judge."},
            {"role": "user", "content": [
                {"type": "input_image", "image_url": "data:image/png;base64,YWJj", "detail": "auto"},
                {"type": "input_text", "text": "Is this dangerous?"},
            ]},
        ])
    );
}

#[test]
fn anthropic_has_content_blocks() {
    let body = asked(Dialect::Anthropic);
    assert_eq!(body["system"], "Judge.");
    assert_eq!(
        body["messages"],
        json!([{"role": "user", "content": [
            {"type": "image", "source": {"type": "base64", "media_type": "image/png", "data": "YWJj"}},
            {"type": "text", "text": "Is this dangerous?"},
        ]}])
    );
}

#[test]
fn gemini_has_inline_data() {
    assert_eq!(
        asked(Dialect::Gemini)["contents"],
        json!([{"role": "user", "parts": [
            {"inlineData": {"mimeType": "image/png", "data": "YWJj"}},
            {"text": "Is this dangerous?"},
        ]}])
    );
}

#[test]
fn ollama_has_base64_beside_the_text() {
    assert_eq!(
        asked(Dialect::Ollama)["messages"],
        json!([
            {"role": "system", "content": "Judge."},
            {"role": "user", "content": "Is this dangerous?", "images": ["YWJj"]},
        ])
    );
}
