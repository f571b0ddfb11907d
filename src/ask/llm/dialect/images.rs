//! Messages with images in the documented form of each API; without images they are as they always were.

use serde_json::{Value, json};

use crate::llm::request::{Message, Role};

/// OpenAI's chat: the content is a list of parts, images as data addresses.
pub(super) fn chat(message: &Message) -> Value {
    parts(
        message,
        |text| json!({"type": "text", "text": text}),
        |image| json!({"type": "image_url", "image_url": {"url": image.data_url()}}),
    )
}

/// OpenAI's Responses API: parts of input, with the detail that the API would choose anyway.
pub(super) fn responses(message: &Message) -> Value {
    parts(
        message,
        |text| json!({"type": "input_text", "text": text}),
        |image| json!({"type": "input_image", "image_url": image.data_url(), "detail": "auto"}),
    )
}

/// Anthropic's messages: content blocks, images before the text that asks about them.
pub(super) fn anthropic(message: &Message) -> Value {
    parts(
        message,
        |text| json!({"type": "text", "text": text}),
        |image| {
            json!({"type": "image", "source": {
                "type": "base64", "media_type": image.media_type, "data": image.base64(),
            }})
        },
    )
}

/// Ollama's own chat: a list of base64 beside the text.
pub(super) fn ollama(message: &Message) -> Value {
    let mut sent = text(message);
    if !message.images.is_empty() {
        sent["images"] = message.images.iter().map(|i| i.base64()).collect();
    }
    sent
}

/// The parts of a message in Gemini's form.
pub(super) fn gemini(message: &Message) -> Value {
    let images = message
        .images
        .iter()
        .map(|image| json!({"inlineData": {"mimeType": image.media_type, "data": image.base64()}}));
    let text = json!({"text": message.content});
    images.chain([text]).collect()
}

fn text(message: &Message) -> Value {
    json!({"role": message.role, "content": message.content})
}

/// The images, and then the text.
fn parts(
    message: &Message,
    text_part: impl Fn(&str) -> Value,
    image_part: impl Fn(&crate::llm::image::Image) -> Value,
) -> Value {
    // Only the user shows images.
    if message.images.is_empty() || message.role != Role::User {
        return text(message);
    }
    let images = message.images.iter().map(image_part);
    let content: Vec<Value> = images.chain([text_part(&message.content)]).collect();
    json!({"role": message.role, "content": content})
}

#[cfg(test)]
#[path = "images_tests.rs"]
mod tests;
