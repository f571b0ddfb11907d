//! What an author asks at most about one scenario, before anything is asked.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::super::judges::Judge;
use super::super::question::Question;
use super::super::request::most_usd;
use super::words::ANSWER;
use super::{Author, AuthorError, AuthorSession};
use crate::generation::{AttackSetup, attacker};
use crate::scenario::Scene;

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

/// The bound for a scenario with the ego's drive in it. Nothing is asked. Questions are taken to be about the reference's
/// first attacker where the user names none: other obstacles are described at about the same length.
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
    bound.votes = method.votes_for(author.attacker);
    if bound.votes > 0 {
        let question = session.choice_question(&aim, within)?;
        bound.add(author, &question, bound.votes);
    }
    let attacker = author.attacker.unwrap_or(aim.obstacle);
    let mut question = session.motion_question(attacker, &ranked)?;
    for _ in 0..=method.retries {
        bound.motions += method.samples;
        bound.add(author, &question, method.samples);
        question = question.after(&"12.34, ".repeat(ANSWER / 7), &"a word ".repeat(REPLY / 7));
    }
    bound.grades = method.most_grades();
    if bound.grades > 0 {
        let question = session.grade_question_about(Arc::clone(scene), aim.step)?;
        bound.add(author, &question, bound.grades);
    }
    Ok(bound)
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
