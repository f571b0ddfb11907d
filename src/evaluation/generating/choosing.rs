//! Attacker selection: the model's choice beside the reference ranking, and which of them is used.

use super::super::answer::{Answer, JudgeOutcome};
use super::super::defaults::default_frame;
use super::{AuthorError, AuthorSession, AuthoringUsage, Progress};
use crate::generation::attacker::{self, Candidate};
use crate::generation::{Capability, ChangeError, Reason, Refusal};
use crate::scenario::{ObstacleRole, ObstacleType, Window};
use crate::store::RunId;
use crate::verdict::{AttackerChoice, ParsedAnswer, Task};

/// The chosen attacker, and the source of the choice.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The reference's ranking, the one that needs the least change first.
    pub ranked: Vec<Candidate>,
    /// The model's answer, if it was asked.
    pub proposal: Option<Proposal>,
    /// The attacker, if there is one.
    pub attacker: Option<i64>,
    /// The origin of the choice.
    pub by: ChosenBy,
}

/// The origin of the choice of attacker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChosenBy {
    /// The user named it.
    User,
    /// The model chose it.
    Model,
    /// It is the first of the reference's ranking, since the model's choice cannot be taken.
    Reference,
    /// No attacker: no obstacle can attack, or the model's choice is binding and cannot be used.
    NoAttacker,
}

impl ChosenBy {
    /// Its name in documents.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::User => "user",
            Self::Model => "model",
            Self::Reference => "reference",
            Self::NoAttacker => "nobody",
        }
    }
}

/// A model's answer to the attacker task.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Its run in the store.
    pub run: Option<RunId>,
    /// First and last time step that were described.
    pub window: (i64, i64),
    /// Its choice, its ranking and its justification, where they could be read.
    pub said: Option<AttackerChoice>,
    /// Its reasoning, where that came apart from the answer.
    pub reasoning: String,
    /// Why its choice cannot be taken, where that is so.
    pub refused: Option<Refusal>,
}

impl AuthorSession<'_> {
    /// Decides who attacks; the model is asked unless the user has named the attacker or no obstacle can attack.
    pub(super) async fn choose(&self, spent: &mut AuthoringUsage) -> Result<Choice, AuthorError> {
        let mut choice = Choice {
            ranked: attacker::rank(self.ground.stage),
            proposal: None,
            attacker: None,
            by: ChosenBy::NoAttacker,
        };
        if let Some(id) = self.author.attacker {
            self.can_attack(id, &choice.ranked)
                .map_err(AuthorError::Attacker)?;
            choice.attacker = Some(id);
            choice.by = ChosenBy::User;
            return Ok(choice);
        }
        let Some(first) = choice.ranked.first().copied() else {
            return Ok(choice);
        };
        let proposal = self.propose(&first, &choice.ranked, spent).await?;
        if proposal.refused.is_none() {
            choice.attacker = proposal.said.as_ref().and_then(|said| said.attacker);
            choice.by = ChosenBy::Model;
        } else if !self.author.obey {
            choice.attacker = Some(first.obstacle);
            choice.by = ChosenBy::Reference;
        }
        choice.proposal = Some(proposal);
        Ok(choice)
    }

    /// Asks the model, about the steps that end where the reference's first would reach the ego.
    async fn propose(
        &self,
        first: &Candidate,
        ranked: &[Candidate],
        spent: &mut AuthoringUsage,
    ) -> Result<Proposal, AuthorError> {
        (self.listener)(Progress::Choosing);
        let task = Task::Attacker;
        let usual = || default_frame(&self.author.library, task);
        let frame = self.author.frame.unwrap_or_else(usual);
        let window = Window::ending_at(self.scene, first.step, self.history(task, frame)?);
        let question = self.question(task, frame, window, None)?;
        let answer = self.ask(&question, None).await?;
        spent.add(&answer);
        Ok(self.read(&answer, &window, ranked))
    }

    fn read(&self, answer: &Answer, window: &Window, ranked: &[Candidate]) -> Proposal {
        let (said, refused) = match &answer.judged {
            JudgeOutcome::Other(reading) => match &reading.said {
                ParsedAnswer::Attacker(choice) => {
                    let refused = match choice.attacker {
                        Some(id) => self.can_attack(id, ranked).err(),
                        None => Some(Refusal::answer(
                            "the model says that no obstacle can attack the ego",
                        )),
                    };
                    (Some(choice.clone()), refused)
                }
                other => (None, Some(other_task(other.task()))),
            },
            JudgeOutcome::Verdict(parsed) => (None, Some(other_task(parsed.verdict.task))),
            JudgeOutcome::Missing(missing) => (None, Some(Refusal::answer(missing.to_string()))),
        };
        let proposed = said.as_ref().and_then(|said| said.attacker);
        let refused = match proposed {
            Some(id) => refused.map(|refusal: Refusal| refusal.about(id, None)),
            None => refused,
        };
        Proposal {
            run: answer.run,
            window: (window.first(), window.last()),
            said,
            reasoning: answer.reasoning.clone(),
            refused,
        }
    }

    /// Whether any obstacle can be given another motion.
    fn can_attack(&self, id: i64, ranked: &[Candidate]) -> Result<(), Refusal> {
        let driver = self.ground.closed_loop.driver();
        let own = [
            self.scene.ego.id,
            driver.problem().id,
            driver.settings().without.unwrap_or(self.scene.ego.id),
        ];
        if own.contains(&id) {
            return Err(Refusal::answer(format!("{id} is the ego itself")));
        }
        let obstacle = self.ground.obstacle(id)?;
        let parked = obstacle.kind == ObstacleType::ParkedVehicle;
        if obstacle.role == ObstacleRole::Static || parked {
            let what = if parked { "is parked" } else { "is static" };
            return Err(Refusal::answer(format!(
                "obstacle {id} {what} and does not move"
            )));
        }
        if obstacle.role != ObstacleRole::Dynamic {
            return Err(Refusal::whole_motion(Reason::Obstacle(
                ChangeError::DoesNotMove(id),
            )));
        }
        if Capability::for_obstacle(obstacle, self.ground.stage.style).is_none() {
            return Err(Refusal::whole_motion(Reason::Unable(id)));
        }
        if ranked.iter().all(|candidate| candidate.obstacle != id) {
            return Err(Refusal::answer(format!(
                "obstacle {id} is not present long enough during the ego's drive"
            )));
        }
        Ok(())
    }
}

pub(super) fn other_task(task: Task) -> Refusal {
    let task = task.name();
    Refusal::answer(format!("it answers another task: {task}"))
}
