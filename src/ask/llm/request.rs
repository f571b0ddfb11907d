//! A request to a language model: messages, images, tools and their calls, parameters, and the schema of the answer.

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::portable_schema::{bounded, portable};
use super::quirks::Effort;

/// Author of a [`Message`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Standing instructions.
    System,
    /// The question.
    User,
    /// An answer of the model, given as an example or as history.
    Assistant,
}

impl Role {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::System => "system",
            Self::User => "user",
            Self::Assistant => "assistant",
        }
    }
}

/// One turn of the conversation.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Message {
    /// Who speaks.
    pub role: Role,
    /// The message as plain text.
    pub content: String,
    /// Images that are shown with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<Image>,
}

impl Message {
    /// A message without images.
    #[must_use]
    pub fn new(role: Role, content: impl Into<String>) -> Self {
        Self {
            role,
            content: content.into(),
            images: Vec::new(),
        }
    }

    /// The message for people: its text, and a line for each image.
    #[must_use]
    pub fn to_text(&self) -> String {
        let image = |image: &Image| format!("\n\n[picture: {image:?}]");
        let images: String = self.images.iter().map(image).collect();
        self.content.clone() + &images
    }
}

/// The JSON schema an answer has to follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Schema {
    /// A name for the server's error texts; letters, digits, `_` and `-` are kept on the wire.
    pub name: String,
    /// The JSON Schema document itself.
    pub schema: serde_json::Value,
    /// Whether its bounds are sent, and bounds of all texts and lists: not every API takes them.
    pub is_bounded: bool,
}

impl Schema {
    /// The document as it is sent.
    pub(super) fn sent(&self) -> serde_json::Value {
        if self.is_bounded {
            bounded(&self.schema)
        } else {
            portable(&self.schema)
        }
    }
}

/// Sampling parameters; what is `None` is not sent, so the server's own default holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Parameters {
    /// Sampling temperature, without unit; most servers take 0 to 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<f64>,
    /// Most tokens the answer may have, reasoning included where the server counts it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_tokens: Option<u32>,
    /// Seed of the sampling, for servers that are reproducible.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How much the model is to reason before it answers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<Effort>,
    /// Whether the log probabilities of the answer's tokens are asked for.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub log_probabilities: bool,
    /// Whether the model may call tools, and how often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tools: Option<ToolLimits>,
}

/// One question to one model.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The model's name as the server knows it (without our provider prefix).
    pub model: String,
    /// The conversation so far, oldest first.
    pub messages: Vec<Message>,
    /// Sampling parameters.
    pub parameters: Parameters,
    /// The shape wanted of the answer; see [`super::ResponseFormat`] for what is sent of it.
    pub schema: Option<Schema>,
    /// The tools that the model may call, with the rounds of calls so far.
    pub tools: Option<Toolbox>,
}

impl Request {
    /// Tokens of the question, estimated to be rather too many than too few: half of the bytes. Numbers, which scenes
    /// in words are full of, are two to three bytes a token. Images count as the endpoint's documentation says, and
    /// turns that called tools as `answer` tokens at most, the most that an answer may have.
    #[must_use]
    pub fn tokens(&self, counted: ImageTokens, answer: Option<u32>) -> u32 {
        let messages: usize = self.messages.iter().map(|m| m.content.len() + 16).sum();
        let schema = self
            .schema
            .as_ref()
            .map_or(0, |s| s.schema.to_string().len());
        let tools = self.tools.as_ref().map_or(0, |tools| tools.bytes(answer));
        let words = u32::try_from((messages + schema + tools) / 2).unwrap_or(u32::MAX);
        let images = self.images().map(|i| counted.count(i.width, i.height));
        images.fold(words, u32::saturating_add)
    }

    /// Every image of the conversation.
    pub fn images(&self) -> impl Iterator<Item = &Image> {
        self.messages.iter().flat_map(|message| &message.images)
    }

    /// Whether the model may call tools now.
    pub(super) fn may_call(&self) -> bool {
        self.tools.as_ref().is_some_and(|tools| tools.may_call)
    }

    /// The tools, where the request has some.
    pub(super) fn offered(&self) -> Option<&Toolbox> {
        self.tools.as_ref().filter(|tools| !tools.specs.is_empty())
    }

    /// The schema to send; `beside_tools` says whether the server takes one while the model may call tools.
    pub(super) fn schema_to_send(&self, beside_tools: bool) -> Option<&Schema> {
        let wanted = beside_tools || !self.may_call();
        self.schema.as_ref().filter(|_| wanted)
    }
}

/// An image of a [`super::Message`].
///
/// Two images are the same if their bytes are: the hash stands for them, and only it is written where messages are
/// stored or make up the key of a request.
#[derive(Clone, Serialize, Deserialize)]
pub struct Image {
    /// Its media type, such as `image/png`.
    pub media_type: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// The bytes of the file; empty where a stored message was read.
    #[serde(skip)]
    pub bytes: Arc<[u8]>,
}

impl Image {
    /// A PNG of so many pixels.
    #[must_use]
    pub fn png(bytes: Vec<u8>, (width, height): (u32, u32)) -> Self {
        Self {
            media_type: "image/png".into(),
            sha256: sha256(&bytes),
            width,
            height,
            bytes: bytes.into(),
        }
    }

    /// The bytes in base64, as every API takes them.
    #[must_use]
    pub fn base64(&self) -> String {
        STANDARD.encode(&self.bytes)
    }

    /// The image as an address that holds it.
    #[must_use]
    pub(super) fn data_url(&self) -> String {
        format!("data:{};base64,{}", self.media_type, self.base64())
    }
}

/// SHA-256 of some bytes, hexadecimal.
fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        (&self.sha256, &self.media_type) == (&other.sha256, &other.media_type)
    }
}

impl Eq for Image {}

impl std::hash::Hash for Image {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.sha256.hash(state);
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (width, height) = (self.width, self.height);
        write!(f, "{} {width}×{height} {}", self.media_type, self.sha256)
    }
}

/// How a server turns an image into tokens, as its documentation says: an estimate, which the usage in the answer
/// replaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ImageTokens {
    /// So many, and so many for each tile of 512 pixels: after the image is made to fit 2048 × 2048 and its shorter side
    /// 768 pixels (OpenAI, models up to GPT-5).
    Tiles([u32; 2]),
    /// A patch of 32 × 32 pixels is so many hundredths of a token, of at most 1536 patches (OpenAI, later models).
    Patches(u32),
    /// A token for each patch of so many pixels squared (Anthropic: 28).
    Squares(u32),
    /// 258 for an image of up to 384 × 384, else for each crop of it: crops are two thirds of the shorter side wide and
    /// high, and 256 to 768 pixels (Gemini 2).
    Crops(u32),
    /// The same number for any image (Gemini 3).
    Each(u32),
}

impl Default for ImageTokens {
    /// Patches of 28 pixels: what is documented of most models that see, those with open weights included.
    fn default() -> Self {
        Self::Squares(28)
    }
}

/// Patches of an image that are counted at most, by [`ImageTokens::Patches`].
const MAX_PATCHES: u32 = 1536;

impl ImageTokens {
    /// Tokens of an image of so many pixels.
    #[must_use]
    pub fn count(self, width: u32, height: u32) -> u32 {
        let (width, height) = (width.max(1), height.max(1));
        match self {
            Self::Tiles([base, tile]) => {
                let (mut w, mut h) = (f64::from(width), f64::from(height));
                let fit = (2048.0 / w.max(h)).min(1.0);
                (w, h) = (w * fit, h * fit);
                let fit = (768.0 / w.min(h)).min(1.0);
                let tiles = (w * fit / 512.0).ceil() * (h * fit / 512.0).ceil();
                base + tile * tiles as u32
            }
            Self::Patches(hundredths) => {
                let patches = width.div_ceil(32) * height.div_ceil(32);
                (patches.min(MAX_PATCHES) * hundredths).div_ceil(100)
            }
            Self::Squares(side) => width.div_ceil(side.max(1)) * height.div_ceil(side.max(1)),
            Self::Crops(each) => {
                if width <= 384 && height <= 384 {
                    return each;
                }
                let crop = (width.min(height) * 2 / 3).clamp(256, 768);
                each * width.div_ceil(crop) * height.div_ceil(crop)
            }
            Self::Each(tokens) => tokens,
        }
    }
}

/// A tool as a model is told of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolSpec {
    /// Its name: letters, digits and `_`.
    pub name: String,
    /// What it computes.
    pub about: String,
    /// The JSON schema of its arguments.
    pub schema: Value,
}

/// Bytes that a call adds to a request beside its name, arguments and result, roughly.
pub const CALL_OVERHEAD: usize = 32;

/// Limits of the calls of one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ToolLimits {
    /// Most requests that may end in calls; after them the model answers once without tools.
    pub rounds: u32,
    /// Most calls of all rounds together; further ones get an error as their result.
    pub calls: u32,
}

impl Default for ToolLimits {
    fn default() -> Self {
        Self {
            rounds: 8,
            calls: 32,
        }
    }
}

/// One call.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ToolCall {
    /// What the server knows it by.
    pub id: String,
    /// The tool.
    pub name: String,
    /// The arguments as the model wrote them: JSON, if it wrote it well.
    pub arguments: String,
}

/// A turn of the model that ends in calls.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToolTurn {
    /// What the model said beside them.
    pub text: String,
    /// What it thought, where the server has to see that again.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub thought: String,
    /// The calls.
    pub calls: Vec<ToolCall>,
    /// Parts of the turn that the server has to see again as it sent them, such as signed thoughts; in the form of its
    /// dialect.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub echo: Vec<Value>,
}

/// A turn with the results of its calls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolRound {
    /// The calls.
    #[serde(flatten)]
    pub turn: ToolTurn,
    /// Their results, in the order of the calls: JSON as text.
    pub results: Vec<String>,
}

/// The tools of a request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolbox {
    /// The tools.
    pub specs: Vec<ToolSpec>,
    /// The rounds before this request.
    pub rounds: Vec<ToolRound>,
    /// Whether the model may call tools now; otherwise it has to answer.
    pub may_call: bool,
}

impl ToolTurn {
    /// The same without secrets. What cannot be read afterwards held one, and is left out.
    pub(super) fn cleared(self, clear: impl Fn(String) -> String) -> Self {
        let echo = self.echo.into_iter().filter_map(|part| {
            let text = part.to_string();
            let cleared = clear(text.clone());
            if cleared == text {
                Some(part)
            } else {
                serde_json::from_str(&cleared).ok()
            }
        });
        Self {
            echo: echo.collect(),
            text: clear(self.text),
            thought: clear(self.thought),
            calls: self
                .calls
                .into_iter()
                .map(|call| ToolCall {
                    id: clear(call.id),
                    name: clear(call.name),
                    arguments: clear(call.arguments),
                })
                .collect(),
        }
    }
}

impl ToolCall {
    /// The arguments as a JSON object, for dialects that have them so; empty where the model wrote none.
    pub(super) fn object(&self) -> Value {
        let read = serde_json::from_str(&self.arguments);
        read.ok()
            .filter(Value::is_object)
            .unwrap_or_else(|| Value::Object(serde_json::Map::new()))
    }
}

impl ToolRound {
    /// Each call with its result.
    pub fn pairs(&self) -> impl Iterator<Item = (&ToolCall, &str)> {
        let results = self.results.iter().map(String::as_str);
        self.turn.calls.iter().zip(results)
    }

    /// Two bytes a token; a turn has no more tokens than an answer may have.
    fn bytes(&self, answer: Option<u32>) -> usize {
        let calls = self
            .turn
            .calls
            .iter()
            .map(|call| call.name.len() + call.arguments.len());
        let echo = self.turn.echo.iter().map(|part| part.to_string().len());
        let turn = self.turn.text.len() + self.turn.thought.len();
        let turn = turn + calls.sum::<usize>() + echo.sum::<usize>();
        let most = answer.map_or(usize::MAX, |tokens| (tokens as usize).saturating_mul(2));
        let results = self
            .results
            .iter()
            .map(|result| result.len() + CALL_OVERHEAD);
        turn.min(most) + results.sum::<usize>()
    }
}

impl Toolbox {
    /// Tokens that the tools and the rounds add to a request, estimated to be rather too many than too few.
    #[must_use]
    pub fn tokens(&self) -> usize {
        self.bytes(None).div_ceil(2)
    }

    /// Bytes that the tools and the rounds add to a request, roughly; `answer` is the most tokens of an answer.
    pub(super) fn bytes(&self, answer: Option<u32>) -> usize {
        let specs = self
            .specs
            .iter()
            .map(|s| s.name.len() + s.about.len() + s.schema.to_string().len() + 48);
        specs.sum::<usize>()
            + self
                .rounds
                .iter()
                .map(|round| round.bytes(answer))
                .sum::<usize>()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn tokens_as_the_documentation_counts_them() {
        // OpenAI's own examples: 1024 × 1024 and 2048 × 4096 in high detail.
        assert_eq!(ImageTokens::Tiles([85, 170]).count(1024, 1024), 765);
        assert_eq!(ImageTokens::Tiles([85, 170]).count(2048, 4096), 1105);
        assert_eq!(ImageTokens::Patches(100).count(1024, 1024), 1024);
        assert_eq!(ImageTokens::Patches(162).count(32, 33), 4);
        assert_eq!(ImageTokens::Squares(28).count(1152, 768), 42 * 28);
        assert_eq!(ImageTokens::Crops(258).count(384, 384), 258);
        // Google's example: 960 × 540 has crops of 360 pixels, three by two.
        assert_eq!(ImageTokens::Crops(258).count(960, 540), 6 * 258);
        assert_eq!(ImageTokens::Each(1120).count(10, 10), 1120);
    }

    #[test]
    fn the_hash_stands_for_the_bytes() {
        let image = Image::png(b"abc".to_vec(), (2, 1));
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(image.sha256, known);
        assert_eq!(image.data_url(), "data:image/png;base64,YWJj");
        let stored = serde_json::to_value(&image).unwrap();
        let wanted = serde_json::json!({
            "media_type": "image/png", "sha256": known, "width": 2, "height": 1,
        });
        assert_eq!(stored, wanted, "no bytes");
        let read: Image = serde_json::from_value(stored).unwrap();
        assert_eq!(read, image);
        assert_ne!(read, Image::png(b"abd".to_vec(), (2, 1)));
    }
}
