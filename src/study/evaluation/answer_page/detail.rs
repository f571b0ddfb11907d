//! What is known of one answer: its verdict, its texts by place, its claims and its consumption.

use serde::{Serialize, Serializer};

use super::super::claims::{CheckedClaim, Judgement};
use super::super::{AnswerStatus, Scored};
use super::sent::Sent;
use nearmiss_scene::description::visible;
use nearmiss_store::Consumed;

/// A claim in the text of an answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ShownClaim {
    /// Where it begins in the shown text, UTF-16 code units, as browsers count.
    pub start: usize,
    /// Where it ends.
    pub end: usize,
    /// `R` right, `W` wrong, `?` open.
    pub letter: char,
    /// The claim and the truth, as one line.
    pub line: String,
}

impl ShownClaim {
    /// Checked claims of a text, in the order of the text.
    #[must_use]
    pub fn all(text: &str, claims: &[CheckedClaim]) -> Vec<Self> {
        let mut found: Vec<Self> = claims
            .iter()
            .filter_map(|one| Self::one(text, one))
            .collect();
        found.sort_by_key(|one| one.start);
        found
    }

    fn one(text: &str, checked: &CheckedClaim) -> Option<Self> {
        let span = &checked.claim.span;
        let units = |part: Option<&str>| part.map(|part| part.encode_utf16().count());
        let start = units(text.get(..span.start))?;
        Some(Self {
            start,
            end: start + units(text.get(span.clone()))?,
            letter: match checked.judgement {
                Judgement::Right => 'R',
                Judgement::Wrong => 'W',
                Judgement::Unknown(_) => '?',
            },
            line: checked.line(),
        })
    }
}

/// What is known of an answer.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct AnswerDetail {
    status: Option<Said>,
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
enum Said {
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
    pub(super) fn of(one: &Scored) -> Self {
        Self {
            status: Some(Said::of(&one.status)),
            used: one.consumed,
            ..Self::default()
        }
    }
}

fn shown<S: Serializer>(text: &Option<String>, to: S) -> Result<S::Ok, S::Error> {
    text.as_deref().map(visible).serialize(to)
}

impl Said {
    fn of(status: &AnswerStatus) -> Self {
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
