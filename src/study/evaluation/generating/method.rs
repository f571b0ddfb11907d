//! How a model is asked for attacks: votes, motions, retries, grades, what decides, and what is asked at most.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nearmiss_drive::generation::{AttackSetup, attacker};
use nearmiss_scene::scenario::Scene;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use super::super::ask_model::most_usd;
use super::super::judges::Judge;
use super::super::question::Question;
use super::feedback::ANSWER;
use super::{Author, AuthorError, AuthorSession};

/// How often a model is asked, and what for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// Votes for the attacker, each an answer to the same question; 1 asks once.
    pub votes: u32,
    /// Attackers are chosen among obstacles whose centre is this near to the ego's, ahead of it or beside it, metres.
    pub within: f64,
    /// Number of motions requested, each in a separate conversation.
    pub samples: u32,
    /// How often, at most, a motion goes back to the model, in each conversation: with the reasons of a refusal, or
    /// with what came of the drive.
    pub retries: u32,
    /// Whether what came of the ego's drive goes back to the model.
    pub feedback: bool,
    /// Whether the model grades the motions that passed the gate (self-consistency).
    pub grades: bool,
    /// What decides between them.
    pub rank: Ranking,
}

/// Votes for the attacker by default.
pub const VOTES: u32 = 3;

/// Motions that are asked for by default.
pub const SAMPLES: u32 = 5;

/// How often a motion goes back to the model by default.
pub const RETRIES: u32 = 2;

/// What decides between motions that passed the gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Ranking {
    /// The closed loop, exact risk scores, and whether an ideal driver survives.
    #[default]
    Exact,
    /// The model's own grades by the metrics prompt, the lowest first, as in the paper.
    Model,
}

nearmiss_record::named!(Ranking, "ranking");

impl Default for Method {
    fn default() -> Self {
        Self {
            votes: VOTES,
            within: nearmiss_drive::generation::attacker::ATTACKER_DISTANCE,
            samples: SAMPLES,
            retries: RETRIES,
            feedback: true,
            grades: true,
            rank: Ranking::Exact,
        }
    }
}

impl Method {
    /// Answers to requests for a motion, at most: in each conversation the first one and the retries.
    #[must_use]
    pub fn motions(&self) -> u32 {
        self.samples * (1 + self.retries)
    }

    /// Votes: none where the user names the attacker.
    #[must_use]
    pub fn votes_for(&self, attacker: Option<i64>) -> u32 {
        match attacker {
            Some(_) => 0,
            None => self.votes,
        }
    }

    /// Requests for grades, at most: one for each motion that can pass the gate.
    #[must_use]
    pub fn most_grades(&self) -> u32 {
        match (self.grades, self.feedback) {
            (false, _) => 0,
            (true, true) => self.motions(),
            // Without news of the drive a conversation ends with its first motion that passes.
            (true, false) => self.samples,
        }
    }

    /// Requests at most for one scenario.
    #[must_use]
    pub fn requests(&self, attacker: Option<i64>) -> u32 {
        self.votes_for(attacker) + self.motions() + self.most_grades()
    }
}

/// Requests at most, and what they consume at most.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bound {
    /// Votes for the attacker.
    pub votes: u32,
    /// Answers about motions.
    pub motions: u32,
    /// Grades of motions.
    pub grades: u32,
    /// Tokens of all questions, estimated.
    pub tokens: usize,
    /// Their cost with answers as long as they may get, US dollars; `None` where price or length is not known.
    pub usd: Option<f64>,
}

/// Characters of what is said about a refused motion or a drive, at most.
const REPLY: usize = 3600;

impl Bound {
    /// Requests in all.
    #[must_use]
    pub fn requests(&self) -> u32 {
        self.votes + self.motions + self.grades
    }

    /// This and another one together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            votes: self.votes + other.votes,
            motions: self.motions + other.motions,
            grades: self.grades + other.grades,
            tokens: self.tokens + other.tokens,
            usd: self.usd.zip(other.usd).map(|(a, b)| a + b),
        }
    }
}

/// The bound for a scenario with the ego's drive in it. Nothing is asked. Where the user names no attacker, the model may
/// choose any candidate: the longest of their questions counts. Grades count as the longest about any second of the drive.
///
/// # Errors
/// No prompt can be made, or the attacker that the user names cannot be one.
pub fn bound(
    author: &Author,
    ground: &AttackSetup<'_>,
    scene: &Arc<Scene>,
    delay: f64,
) -> Result<Bound, AuthorError> {
    let session = AuthorSession {
        author,
        ground,
        scene,
        delay,
        listener: &|_| {},
        barred: AtomicBool::new(false),
    };
    let ranked = attacker::rank(ground.stage);
    if let Some(id) = author.attacker {
        session
            .can_attack(id, &ranked)
            .map_err(AuthorError::Attacker)?;
    }
    let Some((aim, within)) = session.aim(&ranked) else {
        return Ok(Bound {
            usd: Some(0.0),
            ..Bound::default()
        });
    };
    let method = &author.method;
    let mut bound = Bound {
        usd: Some(0.0),
        ..Bound::default()
    };
    let named = author.attacker;
    // Without an obstacle near enough there are no votes: the reference's first attacks, or none.
    let may_attack: Vec<i64> = match (named, within) {
        (Some(id), _) => vec![id],
        (None, Some(_)) => ranked.iter().map(|c| c.obstacle).collect(),
        (None, None) if author.obey => return Ok(bound),
        (None, None) => vec![aim.obstacle],
    };
    if let Some(within) = within {
        bound.votes = method.votes_for(named);
        if bound.votes > 0 {
            let question = session.choice_question(&aim, within)?;
            bound.add(author, &question, bound.votes);
        }
    }
    let motion = |id: i64| session.motion_question(id, &ranked);
    let Some(mut question) = longest(may_attack.into_iter().map(motion))? else {
        return Ok(bound);
    };
    for _ in 0..=method.retries {
        bound.motions += method.samples;
        bound.add(author, &question, method.samples);
        question = question.after(&"12.34, ".repeat(ANSWER / 7), &"a word ".repeat(REPLY / 7));
    }
    bound.grades = method.most_grades();
    if bound.grades > 0 {
        let steps = &ground.stage.steps;
        let second = ((1.0 / ground.stage.dt()).round() as usize).max(1);
        let ends = steps
            .clone()
            .step_by(second)
            .chain([aim.step, *steps.end()]);
        let grade = |end: i64| Ok(session.grade_question_about(Arc::clone(scene), end)?);
        if let Some(question) = longest(ends.map(grade))? {
            bound.add(author, &question, bound.grades);
        }
    }
    Ok(bound)
}

/// The longest of these questions; those that cannot be made are asked as little.
///
/// # Errors
/// None of them can be made.
fn longest(
    questions: impl Iterator<Item = Result<Question, AuthorError>>,
) -> Result<Option<Question>, AuthorError> {
    let (mut found, mut failed): (Option<Question>, _) = (None, None);
    for question in questions {
        match question {
            Ok(one) if found.as_ref().is_none_or(|f| f.tokens() < one.tokens()) => {
                found = Some(one)
            }
            Ok(_) => {}
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    match (found, failed) {
        (None, Some(error)) => Err(error),
        (found, _) => Ok(found),
    }
}

impl Bound {
    /// Adds a question that is asked so many times.
    fn add(&mut self, author: &Author, question: &Question, times: u32) {
        self.tokens += question.tokens() * times as usize;
        let usd = match &author.judge {
            Judge::Model(model) => most_usd(question, model),
            Judge::Reference | Judge::Recorded(_) => Some(0.0),
        };
        self.usd = self
            .usd
            .zip(usd)
            .map(|(all, one)| all + one * f64::from(times));
    }
}

/// What is put behind a scenario's name where it has a motion in it that is only a candidate.
pub(super) const CANDIDATE: &str = " with a candidate motion";

/// The name of the scenario that a candidate motion was put into; another name as it is.
#[must_use]
pub fn unchanged_name(name: &str) -> &str {
    name.strip_suffix(CANDIDATE).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_bounded_by_votes_motions_and_grades() {
        let method = Method {
            votes: 3,
            samples: 5,
            retries: 2,
            ..Method::default()
        };
        assert_eq!(method.requests(None), 3 + 15 + 15);
        assert_eq!(method.requests(Some(7)), 15 + 15);
        let as_before = Method {
            votes: 1,
            feedback: false,
            grades: false,
            ..method
        };
        assert_eq!(as_before.requests(None), 1 + 15);
        let graded = Method {
            grades: true,
            ..as_before
        };
        assert_eq!(graded.requests(None), 1 + 15 + 5);
    }
}
