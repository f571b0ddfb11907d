//! What is known of one answer: its verdict, its texts by place, its claims, its consumption, and the pictures sent.

use std::collections::HashMap;
use std::ops::Range;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nearmiss_scene::description::visible;
use nearmiss_store::{Consumed, StoredImage};
use serde::{Serialize, Serializer};

use super::super::claims::{CheckedSentence, Judgement};
use super::super::{AnswerStatus, Scored};

/// A claim in the text of an answer, or a sentence of it that was not understood.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ShownClaim {
    /// Where it begins in the shown text, UTF-16 code units, as browsers count.
    pub start: usize,
    /// Where it ends.
    pub end: usize,
    /// `R` right, `W` wrong, `?` open, `N` not understood.
    pub letter: char,
    /// The claim and the truth, as one line.
    pub line: String,
}

impl ShownClaim {
    /// What the sentences of a text claim, in the order of the text.
    #[must_use]
    pub fn all(text: &str, sentences: &[CheckedSentence]) -> Vec<Self> {
        let claims = sentences.iter().flat_map(|one| &one.claims);
        let unread = sentences.iter().filter(|one| one.claims.is_empty());
        let mut found: Vec<Self> = claims
            .filter_map(|one| {
                let letter = match one.judgement {
                    Judgement::Right => 'R',
                    Judgement::Wrong => 'W',
                    Judgement::Unknown(_) => '?',
                };
                Self::one(text, &one.claim.span, letter, one.line())
            })
            .chain(
                unread.filter_map(|one| Self::one(text, &one.span, 'N', "not understood".into())),
            )
            .collect();
        found.sort_by_key(|one| one.start);
        found
    }

    fn one(text: &str, span: &Range<usize>, letter: char, line: String) -> Option<Self> {
        let units = |part: Option<&str>| part.map(|part| part.encode_utf16().count());
        let start = units(text.get(..span.start))?;
        Some(Self {
            start,
            end: start + units(text.get(span.clone()))?,
            letter,
            line,
        })
    }
}

/// What is known of an answer.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct AnswerDetail {
    status: Option<PageVerdict>,
    /// Roles and places of the texts of the question.
    pub(super) messages: Vec<(String, usize)>,
    /// The pictures that the question was sent with.
    pub(super) sent: Vec<Sent>,
    /// The place of the answer's text.
    pub(super) text: Option<usize>,
    /// Its claims; `None` where they cannot be checked.
    pub claims: Option<Vec<ShownClaim>>,
    /// The model as the server named it.
    #[serde(rename = "returned", serialize_with = "shown")]
    pub model_returned: Option<String>,
    /// Why the model stopped.
    #[serde(serialize_with = "shown")]
    pub finish: Option<String>,
    used: Consumed,
}

/// What an answer says, or why it has no verdict.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
enum PageVerdict {
    Verdict {
        word: &'static str,
        why: String,
        /// Ids, risk scores and reasons.
        obstacles: Vec<(i64, u8, String)>,
        /// Ids and probabilities.
        critical: Option<Vec<(i64, Option<f64>)>>,
        probability: Option<f64>,
        token_probability: Option<f64>,
    },
    Missing {
        missing: &'static str,
        why: String,
    },
}

impl AnswerDetail {
    /// What an answer says and cost; its texts are added later.
    pub(super) fn from_scored(one: &Scored) -> Self {
        Self {
            status: Some(PageVerdict::from_status(&one.status)),
            used: one.consumed,
            ..Self::default()
        }
    }
}

fn shown<S: Serializer>(text: &Option<String>, to: S) -> Result<S::Ok, S::Error> {
    text.as_deref().map(visible).serialize(to)
}

impl PageVerdict {
    fn from_status(status: &AnswerStatus) -> Self {
        let missing = |missing, why: &str| Self::Missing {
            missing,
            why: visible(why).into_owned(),
        };
        let verdict = match status {
            AnswerStatus::Verdict(verdict) => verdict,
            AnswerStatus::Unparsed(why) => return missing("no verdict in the answer", why),
            AnswerStatus::Failed(why) => return missing("no complete answer", why),
            AnswerStatus::Unasked(why) => return missing("not asked", why),
        };
        let obstacles = verdict.obstacles.iter();
        let critical = verdict.critical.as_ref();
        Self::Verdict {
            word: verdict.word(),
            why: visible(&verdict.justification).into_owned(),
            obstacles: obstacles
                .map(|one| (one.id, one.risk_score, visible(&one.reason).into_owned()))
                .collect(),
            critical: critical.map(|all| all.iter().map(|one| (one.id, one.probability)).collect()),
            probability: verdict.probability,
            token_probability: verdict.token_probability,
        }
    }
}

/// All of them together have at most so many bytes as they stand on the page; one with more opens slowly.
const MAX_PICTURE_BYTES: usize = 64 << 20;

/// Media types that a page shows: none of them can hold anything that runs.
const SHOWN: [&str; 4] = ["image/png", "image/jpeg", "image/webp", "image/gif"];

/// Where a picture that a question was sent with stands, or why it does not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(super) enum Sent {
    /// Its place among the pictures of the page, and its size in pixels.
    Shown { picture: usize, size: (u32, u32) },
    /// In words.
    Missing { missing: String },
}

/// The pictures of a page.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct SentPictures {
    /// `data:image/png;base64,…`
    pub(super) all: Vec<String>,
    known: HashMap<String, Sent>,
    bytes: usize,
    /// How many did not fit.
    pub(super) left_out: usize,
}

impl SentPictures {
    /// The picture with this hash, if it was looked for before.
    pub(super) fn get(&self, sha256: &str) -> Option<&Sent> {
        self.known.get(sha256)
    }

    /// Takes what was found under a hash.
    pub(super) fn take(&mut self, sha256: &str, found: Option<&StoredImage>) -> Sent {
        let short: String = sha256.chars().take(12).collect();
        let missing = |missing| Sent::Missing { missing };
        let sent = match found {
            None => missing(format!(
                "The store does not have the picture {short}…; import the export or bundle again that has it."
            )),
            Some(picture) if !SHOWN.contains(&picture.media_type.as_str()) => {
                missing(format!("The picture {short}… is of a type that pages do not show."))
            }
            Some(picture) => self.add(picture).unwrap_or_else(|| {
                self.left_out += 1;
                missing(format!(
                    "The page would become too large with the picture {short}…; \"nearmiss runs show\" writes it."
                ))
            }),
        };
        self.known.insert(sha256.to_string(), sent.clone());
        sent
    }

    fn add(&mut self, picture: &StoredImage) -> Option<Sent> {
        let bytes = self.bytes + picture.bytes.len().div_ceil(3) * 4;
        if bytes > MAX_PICTURE_BYTES {
            return None;
        }
        self.bytes = bytes;
        let base64 = BASE64_STANDARD.encode(&picture.bytes);
        self.all
            .push(format!("data:{};base64,{base64}", picture.media_type));
        let size = (picture.width, picture.height);
        Some(Sent::Shown {
            picture: self.all.len() - 1,
            size,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(bytes: usize) -> StoredImage {
        StoredImage {
            sha256: "ab".into(),
            media_type: "image/png".into(),
            width: 3,
            height: 2,
            bytes: vec![0; bytes].into(),
        }
    }

    fn shown(picture: usize) -> Sent {
        let size = (3, 2);
        Sent::Shown { picture, size }
    }

    #[test]
    fn what_does_not_fit_is_counted_and_smaller_ones_still_fit() {
        let mut all = SentPictures::default();
        let large = picture(MAX_PICTURE_BYTES / 2);
        assert_eq!(all.take("a", Some(&large)), shown(0));
        let Sent::Missing { missing: why } = all.take("b", Some(&large)) else {
            panic!("it does not fit");
        };
        assert!(why.contains("too large"), "{why}");
        assert_eq!(all.take("c", Some(&picture(1))), shown(1));
        assert_eq!((all.left_out, all.all.len()), (1, 2));
        assert_eq!(all.all[1], "data:image/png;base64,AA==");
        assert_eq!(all.get("a"), Some(&shown(0)));
    }

    #[test]
    fn what_is_not_there_or_no_picture_is_said() {
        let mut all = SentPictures::default();
        let odd = StoredImage {
            media_type: "image/svg+xml".into(),
            ..picture(1)
        };
        for (found, words) in [(None, "does not have"), (Some(&odd), "do not show")] {
            let Sent::Missing { missing: why } = all.take("0123456789abcdef", found) else {
                panic!("nothing is shown");
            };
            assert!(
                why.contains(words) && why.contains("0123456789ab…"),
                "{why}"
            );
        }
        assert!(all.all.is_empty() && all.left_out == 0);
    }
}
