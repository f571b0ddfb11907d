//! Sentences and their claims for programs.

use schemars::JsonSchema;
use serde::Serialize;

use super::{CheckedClaim, CheckedSentence, Judgement, SentenceOutcome};

/// A sentence that says something of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SentenceRecord {
    /// The sentence.
    pub text: String,
    /// What it comes to: right, wrong, open, not_understood.
    pub outcome: SentenceOutcome,
    /// Its claims.
    pub claims: Vec<ClaimRecord>,
}

/// A claim with the truth beside it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ClaimRecord {
    /// Where its value stands.
    pub text: String,
    /// right, wrong or open.
    pub outcome: SentenceOutcome,
    /// Why an open one cannot be decided.
    pub why: Option<&'static str>,
    /// What is claimed.
    pub kind: &'static str,
    /// Id of the obstacle; none of what is said of the ego.
    pub obstacle: Option<i64>,
    /// The step at which it was checked.
    pub step: i64,
    /// The claimed value.
    pub stated: String,
    /// The true value, where it is a number.
    pub actual: Option<f64>,
    /// Its unit; empty for what is no number.
    pub unit: &'static str,
    /// The truth, in words.
    pub truth: String,
}

impl SentenceRecord {
    /// Of a sentence of a text, about a scene whose ego has this id.
    #[must_use]
    pub fn new(text: &str, sentence: &CheckedSentence, ego: i64) -> Self {
        let claims = sentence.claims.iter();
        Self {
            text: text.get(sentence.span.clone()).unwrap_or_default().into(),
            outcome: sentence.outcome,
            claims: claims.map(|one| ClaimRecord::new(text, one, ego)).collect(),
        }
    }
}

impl ClaimRecord {
    fn new(text: &str, one: &CheckedClaim, ego: i64) -> Self {
        let (outcome, why) = match one.judgement {
            Judgement::Right => (SentenceOutcome::Right, None),
            Judgement::Wrong => (SentenceOutcome::Wrong, None),
            Judgement::Unknown(why) => (SentenceOutcome::Open, Some(why)),
        };
        Self {
            text: text.get(one.claim.span.clone()).unwrap_or_default().into(),
            outcome,
            why,
            kind: one.claim.quantity.name(),
            obstacle: Some(one.claim.obstacle).filter(|id| *id != ego),
            step: one.step,
            stated: one.stated(),
            actual: one.truth.filter(|truth| truth.is_finite()),
            unit: one.claim.quantity.unit(),
            truth: one.is.clone(),
        }
    }
}
