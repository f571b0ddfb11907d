//! Answers to learn from: which stored answers are right, and how one becomes an example of a chat.

use std::collections::{BTreeMap, HashMap, HashSet};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use sha2::{Digest, Sha256};
use strum::{IntoStaticStr, VariantArray};

use super::batch::Split;
use super::report::Truth;
use nearmiss_ask::llm::{Message, Role};
use nearmiss_scene::judge;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{Outcome, Run, RunState, SplitPart, StoredImage};

/// Why an answer is no example.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum NoExample {
    /// It answers a task without a yes or no: there is no truth to compare it with.
    OtherTask,
    /// The built-in judge gave it, which is asked without words.
    BuiltIn,
    /// It is not whole, or has no verdict.
    NoVerdict,
    /// The messages that it answers are not known, as of answers recorded with the paper.
    NoMessages,
    /// It was made with results of tools, which no example has.
    Tools,
    /// It answers pictures, and only words are wanted.
    Picture,
    /// A picture that it answers is not in the store.
    NoPicture,
    /// It answers pictures that training files cannot have: too many or too large, of another type, or not the user's.
    PictureForm,
    /// Nothing is known to compare it with.
    NoTruth,
    /// Its verdict is wrong.
    #[strum(to_string = "wrong_verdict")]
    Wrong,
    /// It says yes, and names none of the obstacles that are truly critical.
    WrongObstacle,
    /// Its claims were not checked.
    #[strum(to_string = "unchecked_claims")]
    Unchecked,
    /// It makes more wrong claims than are allowed.
    WrongClaims,
    /// The same question with the same answer is there already.
    Duplicate,
}

impl NoExample {
    /// In words, for a number of answers.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::OtherTask => "to tasks without a yes or no",
            Self::BuiltIn => "of the built-in judge",
            Self::NoVerdict => "without a whole answer or a verdict",
            Self::NoMessages => "without stored messages",
            Self::Tools => "made with tools, whose results examples do not have",
            Self::Picture => "to pictures",
            Self::NoPicture => "to pictures that the store does not have",
            Self::PictureForm => "to pictures that training files cannot have",
            Self::NoTruth => "without a known truth",
            Self::Wrong => "with a wrong verdict",
            Self::WrongObstacle => "that name none of the critical obstacles",
            Self::Unchecked => "with unchecked claims",
            Self::WrongClaims => "with wrong claims",
            Self::Duplicate => "that repeat another one",
        }
    }
}

nearmiss_record::named!(NoExample);

/// Where the reasoning of a model stands in an example.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum ReasoningForm {
    /// Between `<think>` and `</think>` before the answer.
    #[default]
    Think,
    /// Beside the answer, as `reasoning_content`.
    Field,
    /// Left out.
    None,
}

nearmiss_record::named!(ReasoningForm, "form");

/// What makes an answer an example, and how it is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExampleRules {
    /// So many wrong claims are allowed.
    pub wrong_claims: u32,
    /// Where the reasoning stands.
    pub reasoning: ReasoningForm,
    /// Whether answers to pictures are examples, with the pictures.
    pub pictures: bool,
    /// Which part a scenario's examples are in: its test part is for validation.
    pub split: Split,
}

/// Pictures of a question by their hashes, as the store has them.
pub type Pictures = HashMap<String, StoredImage>;

/// What OpenAI documents of files for training with pictures, and others that read their form have as well: pictures of
/// an example, and bytes of one, at most, and the types.
const MOST_PICTURES: usize = 10;
const MOST_BYTES: usize = 10_000_000;
const TYPES: [&str; 3] = ["image/png", "image/jpeg", "image/webp"];

/// One turn of an example.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Turn {
    role: Role,
    content: Content,
    #[serde(skip_serializing_if = "Option::is_none")]
    reasoning_content: Option<String>,
}

/// What a turn says: words, or pictures and then words, in the form of OpenAI's chats.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
enum Content {
    Words(String),
    Parts(Vec<Part>),
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Part {
    ImageUrl { image_url: ImageUrl },
    Text { text: String },
}

/// An address that holds its picture.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct ImageUrl {
    url: String,
}

/// A conversation that ends with a right answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Example {
    messages: Vec<Turn>,
}

/// The examples so far, and what was left out.
#[derive(Debug, Default)]
pub struct Examples {
    seen: HashSet<[u8; 32]>,
    /// How many answers were left out, by the first reason.
    pub left_out: BTreeMap<NoExample, usize>,
}

impl ExampleRules {
    /// Why an answer is no example, as far as can be told without its texts.
    #[must_use]
    pub fn refuses(&self, outcome: &Outcome, truth: &Truth) -> Option<NoExample> {
        if !Task::VERDICTS.contains(&outcome.task) {
            return Some(NoExample::OtherTask);
        }
        if outcome.model == judge::MODEL {
            return Some(NoExample::BuiltIn);
        }
        let verdict = outcome
            .verdict
            .as_deref()
            .and_then(|json| serde_json::from_str::<Verdict>(json).ok());
        let Some(verdict) = verdict.filter(|_| outcome.state == RunState::Answered) else {
            return Some(NoExample::NoVerdict);
        };
        let Some((label, critical)) = truth.lookup(outcome) else {
            return Some(NoExample::NoTruth);
        };
        if verdict.dangerous != label.collides() {
            return Some(NoExample::Wrong);
        }
        let names_one = || verdict.danger().iter().any(|id| critical.contains(id));
        if verdict.dangerous && !critical.is_empty() && !names_one() {
            return Some(NoExample::WrongObstacle);
        }
        match outcome.claims.known() {
            None => Some(NoExample::Unchecked),
            Some([_, wrong, _]) if wrong > self.wrong_claims => Some(NoExample::WrongClaims),
            Some(_) => None,
        }
    }

    /// The part that the examples of a scenario are in, changed or not.
    #[must_use]
    pub fn part(&self, scenario: &str) -> SplitPart {
        self.split.part(Transform::of_name(scenario).0)
    }

    fn example(&self, run: &Run, pictures: &Pictures) -> Result<Example, NoExample> {
        let asked = serde_json::from_str::<Vec<Message>>(&run.question.messages)
            .map_err(|_| NoExample::NoMessages)?;
        if !asked.iter().any(|message| message.role == Role::User) {
            return Err(NoExample::NoMessages);
        }
        if run.tool_rounds.is_some() {
            return Err(NoExample::Tools);
        }
        match asked.iter().map(|message| message.images.len()).sum() {
            0 => {}
            1.. if !self.pictures => return Err(NoExample::Picture),
            1..=MOST_PICTURES => {}
            _ => return Err(NoExample::PictureForm),
        }
        let reasoning = run.reasoning.trim();
        let answer = run.answer.trim();
        let content = match self.reasoning {
            ReasoningForm::Think if !reasoning.is_empty() => {
                format!("<think>\n{reasoning}\n</think>\n\n{answer}")
            }
            _ => answer.to_string(),
        };
        let beside = self.reasoning == ReasoningForm::Field && !reasoning.is_empty();
        let messages = asked
            .into_iter()
            .map(|message| Turn::new(message, pictures));
        let mut messages: Vec<Turn> = messages.collect::<Result<_, _>>()?;
        messages.push(Turn {
            role: Role::Assistant,
            content: Content::Words(content),
            reasoning_content: beside.then(|| reasoning.to_string()),
        });
        Ok(Example { messages })
    }
}

impl Turn {
    fn new(message: Message, pictures: &Pictures) -> Result<Self, NoExample> {
        let content = if message.images.is_empty() {
            Content::Words(message.content)
        } else if message.role != Role::User {
            return Err(NoExample::PictureForm);
        } else {
            let shown = message.images.iter().map(|image| {
                let found = pictures.get(&image.sha256).ok_or(NoExample::NoPicture)?;
                Part::picture(found)
            });
            let mut parts: Vec<Part> = shown.collect::<Result<_, _>>()?;
            // As it is sent.
            parts.push(Part::Text {
                text: message.content,
            });
            Content::Parts(parts)
        };
        Ok(Self {
            role: message.role,
            content,
            reasoning_content: None,
        })
    }
}

impl Part {
    fn picture(found: &StoredImage) -> Result<Self, NoExample> {
        let media_type = found.media_type.as_str();
        if !TYPES.contains(&media_type) || found.bytes.len() > MOST_BYTES {
            return Err(NoExample::PictureForm);
        }
        let base64 = BASE64_STANDARD.encode(&found.bytes);
        let url = format!("data:{media_type};base64,{base64}");
        Ok(Self::ImageUrl {
            image_url: ImageUrl { url },
        })
    }
}

impl Examples {
    /// Counts an answer that is left out.
    pub fn leave_out(&mut self, why: NoExample) {
        *self.left_out.entry(why).or_default() += 1;
    }

    /// The example that a run is, as one line of JSON; nothing, and counted, where it is none or repeats another one.
    /// `pictures` are those of its question that the store has.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub fn line(
        &mut self,
        rules: &ExampleRules,
        run: &Run,
        pictures: &Pictures,
    ) -> serde_json::Result<Option<String>> {
        let example = match rules.example(run, pictures) {
            Ok(example) => example,
            Err(why) => {
                self.leave_out(why);
                return Ok(None);
            }
        };
        let line = serde_json::to_string(&example)?;
        if !self.seen.insert(Sha256::digest(&line).into()) {
            self.leave_out(NoExample::Duplicate);
            return Ok(None);
        }
        Ok(Some(line))
    }
}
