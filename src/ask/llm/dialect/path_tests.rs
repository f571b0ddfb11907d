//! Tests of base URLs in every spelling, in every dialect.
#![allow(clippy::unwrap_used)]

use super::super::endpoint::Endpoint;
use super::*;

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
