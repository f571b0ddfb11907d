//! What is known of one answer: its verdict, its texts by place, its claims and its consumption.

use serde::Serialize;
use serde_json::{Value, json};

use super::super::claims::{CheckedClaim, Judgement};
use super::super::{AnswerStatus, Scored};
use super::sent::Sent;
use nearmiss_scene::description::visible;

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
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AnswerDetail {
    /// Roles and places of the texts of the question.
    pub(super) messages: Vec<(String, usize)>,
    /// The pictures that the question was sent with.
    pub(super) sent: Vec<Sent>,
    /// The place of the answer's text.
    pub(super) text: Option<usize>,
    /// Its claims; `None` where they cannot be checked.
    pub claims: Option<Vec<ShownClaim>>,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// Why the model stopped.
    pub finish: Option<String>,
    status: Value,
    consumed: Value,
}

impl AnswerDetail {
    /// What an answer says and cost; its texts are added later.
    pub(super) fn of(one: &Scored) -> Self {
        let used = &one.consumed;
        Self {
            status: status(&one.status),
            consumed: json!({
                "seconds": used.duration_ms.map(|ms| ms as f64 / 1000.0),
                "input": used.input_tokens,
                "output": used.output_tokens,
                "usd": used.cost_usd,
            }),
            ..Self::default()
        }
    }

    pub(super) fn json(&self) -> Value {
        let shown = |text: &Option<String>| text.as_deref().map(|text| visible(text).into_owned());
        json!({
            "status": self.status,
            "messages": self.messages,
            "sent": self.sent.iter().map(Sent::json).collect::<Vec<_>>(),
            "text": self.text,
            "claims": self.claims,
            "returned": shown(&self.model_returned),
            "finish": shown(&self.finish),
            "used": self.consumed,
        })
    }
}

fn status(status: &AnswerStatus) -> Value {
    let missing = |how: &str, why: &str| json!({ "missing": how, "why": visible(why) });
    let verdict = match status {
        AnswerStatus::Verdict(verdict) => verdict,
        AnswerStatus::Unparsed(why) => return missing("no verdict in the answer", why),
        AnswerStatus::Failed(why) => return missing("no complete answer", why),
        AnswerStatus::Unasked(why) => return missing("not asked", why),
    };
    let obstacles = verdict.obstacles.iter();
    let obstacles: Vec<Value> = obstacles
        .map(|one| json!([one.id, one.risk_score, visible(&one.reason)]))
        .collect();
    let critical = verdict.critical.as_ref();
    json!({
        "word": verdict.word(),
        "why": visible(&verdict.justification),
        "obstacles": obstacles,
        "critical": critical.map(|all| all.iter().map(|one| (one.id, one.probability)).collect::<Vec<_>>()),
        "probability": verdict.probability,
        "token_probability": verdict.token_probability,
    })
}
