//! Bodies with images, held against the documented form of each API.

use serde_json::{Value, json};

use crate::llm::image::Image;
use crate::llm::{Dialect, Endpoint, Message, Parameters, Request, Role, body};

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
