//! Templates that were tried, with what came of them.

use super::ask::{Graded, Replies};
use super::outcome::Measure;
use super::prepare::TunePlan;
use nearmiss_study::evaluation::Confusion;
use nearmiss_study::evaluation::statistics::Gain;

/// A template that was asked with on the whole selection part; the first one is the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its number; 0 is the base.
    pub number: usize,
    /// The candidate that it was made from; `None` of the base.
    pub parent: Option<usize>,
    /// The round in which it was proposed, from 1; 0 of the base.
    pub round: u32,
    /// What it changes, in the words of the reflecting model.
    pub change: String,
    /// What the reflecting model found wrong with its parent.
    pub diagnosis: String,
    /// The whole template.
    pub source: String,
    /// SHA-256 of it and of what it includes.
    pub hash: String,
    /// Its answers on the selection part.
    pub score: Score,
    /// Whether no other candidate is better and no dearer, or cheaper and no worse.
    pub on_front: bool,
    /// By how much it is better than the base; `None` of the base, and where the measure has no value.
    pub gain: Option<Gain>,
}

/// Answers of a template on a part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Score {
    /// Right and wrong answers; those that cannot be read are wrong.
    pub counts: Confusion,
    /// Questions.
    pub asked: usize,
    /// Answers that cannot be read.
    pub unreadable: usize,
    /// Questions without an answer.
    pub missing: usize,
    /// Mean cost of an answer, US dollars; `None` where one is unknown.
    pub usd: Option<f64>,
    /// Mean tokens of question and answer; `None` where the server did not count.
    pub tokens: Option<f64>,
}

/// What the front holds against the measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CostMeasure {
    /// Mean US dollars of an answer.
    Usd,
    /// Mean tokens of question and answer, where nothing is paid or a cost is unknown.
    Tokens,
    /// Nothing: the server told neither.
    Unknown,
}

impl CostMeasure {
    /// What is known of the base and not 0.
    #[must_use]
    pub fn of(base: &Score) -> Self {
        match (base.usd, base.tokens) {
            (Some(usd), _) if usd > 0.0 => Self::Usd,
            (_, Some(_)) => Self::Tokens,
            (_, None) => Self::Unknown,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Usd => "usd",
            Self::Tokens => "tokens",
            Self::Unknown => "unknown",
        }
    }

    /// Its value.
    #[must_use]
    pub fn of_score(self, score: &Score) -> f64 {
        let known = match self {
            Self::Usd => score.usd,
            Self::Tokens => score.tokens,
            Self::Unknown => Some(0.0),
        };
        known.unwrap_or(f64::INFINITY)
    }
}

impl Score {
    /// The score of these questions.
    pub(super) fn new(plan: &TunePlan, places: &[usize], replies: &Replies) -> Self {
        let mut score = Self {
            asked: places.len(),
            ..Self::default()
        };
        let mut graded: Vec<&Graded> = Vec::with_capacity(places.len());
        for place in places {
            match replies.get(place) {
                Some(Ok(one)) => {
                    let truth = plan.questions[*place].truth.collides();
                    score.counts.count(one.said, truth);
                    score.unreadable += usize::from(one.unreadable.is_some());
                    graded.push(one);
                }
                Some(Err(_)) | None => score.missing += 1,
            }
        }
        let n = graded.len() as f64;
        let mean = |all: Option<f64>| all.filter(|_| n > 0.0).map(|sum| sum / n);
        score.usd = mean(graded.iter().map(|one| one.usd).sum());
        score.tokens = mean(graded.iter().map(|one| Some(one.tokens? as f64)).sum());
        score
    }

    /// Its value of a measure.
    #[must_use]
    pub fn value(&self, measure: Measure) -> Option<f64> {
        measure.of(&self.counts)
    }
}

/// A proposal that did not become a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// The round, from 1.
    pub round: u32,
    /// Its number in the round, from 1.
    pub number: u32,
    /// The candidate that it was made from.
    pub parent: usize,
    /// What it changes; blank where that could not be read.
    pub change: String,
    /// Why it is none.
    pub because: RefusedBecause,
}

/// Why a proposal did not become a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum RefusedBecause {
    /// It is no template that may be asked with.
    Invalid(String),
    /// It was not better on a few questions of the feedback part.
    NotBetter {
        /// How many it answered right.
        right: usize,
        /// How many its parent did.
        parent: usize,
        /// Of so many.
        of: usize,
    },
    /// Too many of its questions got no answer.
    Unanswered {
        /// How many.
        missing: usize,
        /// Of so many.
        of: usize,
        /// Why the first of them got none.
        why: String,
    },
}

impl std::fmt::Display for RefusedBecause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Invalid(why) => write!(f, "refused: {why}"),
            Self::NotBetter { right, parent, of } => {
                write!(
                    f,
                    "not better: {right} of {of} shown questions right, its parent {parent}"
                )
            }
            Self::Unanswered { missing, of, why } => {
                write!(f, "{missing} of {of} questions without an answer: {why}")
            }
        }
    }
}
