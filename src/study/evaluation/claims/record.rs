//! Sentences and their claims for programs.

use schemars::JsonSchema;
use serde::Serialize;

use std::ops::Range;

use super::{CheckedClaim, CheckedSentence, ClaimBasis, Judgement, SentenceOutcome, Subject};

/// A sentence that says something of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SentenceRecord {
    /// The sentence.
    pub text: String,
    /// What it comes to: right, wrong, open, not_understood.
    pub outcome: SentenceOutcome,
    /// Its claims.
    pub claims: Vec<ClaimRecord>,
    /// Sentences that cannot be true beside it.
    pub contradicts: Vec<String>,
    /// What a second reader made of it; empty where only the rules read it.
    pub translated: Vec<String>,
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
    /// The geometry it was checked against: exact bodies, the distance of centres, or the paper's convention.
    pub basis: ClaimBasis,
    /// Whether its number does not hold and is none of those that the model was shown; null where that is not known.
    pub invented: Option<bool>,
}

impl SentenceRecord {
    /// Of a sentence of a text.
    #[must_use]
    pub fn new(text: &str, sentence: &CheckedSentence, subject: &Subject<'_>) -> Self {
        let ego = subject.scene.ego.id;
        let said = |span: &Range<usize>| text.get(span.clone()).unwrap_or_default().to_owned();
        let claims = sentence.claims.iter().enumerate();
        let invented = |place| subject.prompt.map(|_| sentence.invented.contains(&place));
        Self {
            text: text.get(sentence.span.clone()).unwrap_or_default().into(),
            outcome: sentence.outcome,
            claims: claims
                .map(|(place, one)| ClaimRecord::new(text, one, (ego, invented(place))))
                .collect(),
            contradicts: sentence.contradicts.iter().map(said).collect(),
            translated: sentence.translated.clone(),
        }
    }
}

impl ClaimRecord {
    fn new(text: &str, one: &CheckedClaim, (ego, invented): (i64, Option<bool>)) -> Self {
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
            basis: one.basis,
            invented,
        }
    }
}
