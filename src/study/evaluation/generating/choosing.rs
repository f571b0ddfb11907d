//! Attacker selection: the model's votes beside the reference ranking, and which of them is used.

use futures_util::future::BoxFuture;
use futures_util::{FutureExt, StreamExt, stream};
use strum::{IntoStaticStr, VariantArray};

use super::super::answer::{Answer, JudgeOutcome};
use super::super::question::{CaseError, Question};
use super::super::settings::{Settings, default_frame};
use super::{AuthorError, AuthorSession, AuthoringUsage, Progress};
use nearmiss_drive::generation::attacker::{self, Candidate};
use nearmiss_drive::generation::{Capability, ChangeError, Reason, Refusal};
use nearmiss_scene::scenario::{ObstacleRole, ObstacleType, Window};
use nearmiss_scene::verdict::{AttackerChoice, ParsedAnswer, Task};
use nearmiss_store::RunId;

/// The chosen attacker, and the source of the choice.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The reference's ranking, the one that needs the least change first.
    pub ranked: Vec<Candidate>,
    /// The model's answer that decided, if it was asked: the first one for the attacker; where no vote can be taken,
    /// the first of all.
    pub proposal: Option<Proposal>,
    /// All votes in order, the one that decided among them.
    pub votes: Vec<Proposal>,
    /// Others that got as many votes as the attacker, which the reference ranks first.
    pub tied: Vec<i64>,
    /// The model chose among obstacles this near ahead of the ego or beside it, metres; `None` where it was not asked.
    pub within: Option<f64>,
    /// No obstacle comes this near ahead of the ego or beside it, metres: the model has nothing to choose from and was
    /// not asked. `None` where one does, or the user named the attacker.
    pub none_within: Option<f64>,
    /// The attacker, if there is one.
    pub attacker: Option<i64>,
    /// The origin of the choice.
    pub by: ChosenBy,
}

impl Choice {
    /// How many votes each obstacle got, the most first; ties as the reference ranks them. Votes that cannot be taken
    /// do not count.
    #[must_use]
    pub fn tally(&self) -> Vec<(i64, usize)> {
        tally(&self.votes, &self.ranked)
    }

    /// Why the model was not asked for an attacker, where no obstacle comes near enough.
    #[must_use]
    pub fn not_asked(&self) -> Option<String> {
        self.none_within.map(|within| {
            format!("no obstacle comes within {within} m ahead of the ego or beside it")
        })
    }
}

/// How many votes that can be taken each obstacle got, the most first, then in the order of the reference ranking.
fn tally(votes: &[Proposal], ranked: &[Candidate]) -> Vec<(i64, usize)> {
    let place = |id: i64| ranked.iter().position(|c| c.obstacle == id);
    let mut counts: Vec<(i64, usize)> = Vec::new();
    for id in votes.iter().filter_map(Proposal::taken) {
        match counts.iter_mut().find(|(of, _)| *of == id) {
            Some((_, count)) => *count += 1,
            None => counts.push((id, 1)),
        }
    }
    counts.sort_by_key(|(id, count)| (std::cmp::Reverse(*count), place(*id)));
    counts
}

/// The origin of the choice of attacker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum ChosenBy {
    /// The user named it.
    User,
    /// The model chose it.
    Model,
    /// It is the first of the reference's ranking: the model's choice cannot be taken, or it had none to choose from.
    Reference,
    /// No attacker: no obstacle can attack, or only the model may choose and it did not.
    #[strum(to_string = "none")]
    NoAttacker,
}

nearmiss_record::named!(ChosenBy);

/// A model's answer to the attacker task.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Its run in the store.
    pub run: Option<RunId>,
    /// First and last time step that were described.
    pub window: (i64, i64),
    /// Its choice, its ranking and its justification, where they could be read.
    pub choice: Option<AttackerChoice>,
    /// Its reasoning, where that came apart from the answer.
    pub reasoning: String,
    /// Why its choice cannot be taken, where that is so.
    pub refused: Option<Refusal>,
}

impl Proposal {
    /// The obstacle that it names, where that can be taken.
    #[must_use]
    pub fn taken(&self) -> Option<i64> {
        let choice = self.choice.as_ref().filter(|_| self.refused.is_none());
        choice.and_then(|choice| choice.attacker)
    }
}

/// What the model is asked to choose from.
struct Field {
    window: Window,
    /// The steps of the window that are described.
    steps: Vec<i64>,
    /// See [`Choice::within`].
    within: f64,
}

impl AuthorSession<'_> {
    /// Decides who attacks; the model votes unless the user has named the attacker or no obstacle can attack.
    pub(super) async fn choose(&self, spent: &mut AuthoringUsage) -> Result<Choice, AuthorError> {
        let mut choice = Choice {
            ranked: attacker::rank(self.ground.stage),
            proposal: None,
            votes: Vec::new(),
            tied: Vec::new(),
            within: None,
            none_within: None,
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
        let Some((aim, within)) = self.aim(&choice.ranked) else {
            return Ok(choice);
        };
        let Some(within) = within else {
            // The question would describe no obstacle that can be named.
            choice.none_within = Some(self.author.method.within);
            if !self.author.obey {
                choice.attacker = Some(aim.obstacle);
                choice.by = ChosenBy::Reference;
            }
            return Ok(choice);
        };
        choice.within = Some(within);
        choice.votes = self.poll(&aim, within, &choice.ranked, spent).await?;
        let counts = choice.tally();
        match counts.first() {
            Some(&(winner, most)) => {
                let others = counts[1..].iter().filter(|(_, count)| *count == most);
                choice.tied = others.map(|(id, _)| *id).collect();
                choice.attacker = Some(winner);
                choice.by = ChosenBy::Model;
            }
            None if !self.author.obey => {
                choice.attacker = Some(aim.obstacle);
                choice.by = ChosenBy::Reference;
            }
            None => {}
        }
        let decided =
            |vote: &&Proposal| choice.by != ChosenBy::Model || vote.taken() == choice.attacker;
        choice.proposal = choice.votes.iter().find(decided).cloned();
        Ok(choice)
    }

    /// The first of a ranking that comes near, ahead of the ego or beside it, and how near; where none does, the first of
    /// all, and nothing is left to vote on.
    pub(super) fn aim(&self, ranked: &[Candidate]) -> Option<(Candidate, Option<f64>)> {
        let within = self.author.method.within;
        let near =
            |c: &&Candidate| c.reaches && !c.behind && self.is_near(c.obstacle, c.step, within);
        match ranked.iter().find(near) {
            Some(near) => Some((*near, Some(within))),
            None => ranked.first().map(|first| (*first, None)),
        }
    }

    /// The question who attacks, about the steps that end where the aim would reach the ego.
    pub(super) fn choice_question(
        &self,
        aim: &Candidate,
        within: f64,
    ) -> Result<Question, CaseError> {
        let task = Task::Attacker;
        let usual = || default_frame(&self.author.library, task);
        let frame = self.author.frame.unwrap_or_else(usual);
        let window = Window::ending_at(self.scene, aim.step, self.history(task, frame)?);
        let settings = Settings {
            obstacle: None,
            radius: Some(within),
            ..self.author.settings
        };
        self.question((task, frame), window, settings)
    }

    /// Asks the model for every vote. An error counts only where there is no vote.
    async fn poll(
        &self,
        aim: &Candidate,
        within: f64,
        ranked: &[Candidate],
        spent: &mut AuthoringUsage,
    ) -> Result<Vec<Proposal>, AuthorError> {
        let question = self.choice_question(aim, within)?;
        let window = question.case.window;
        let field = Field {
            steps: question.case.options.steps(&window),
            window,
            within,
        };
        let of = self.author.method.votes.max(1);
        let asks: Vec<BoxFuture<'_, _>> = (0..of)
            .map(|vote| {
                let question = &question;
                async move {
                    if self.is_barred() {
                        return None;
                    }
                    (self.listener)(Progress::Choosing { vote, of });
                    Some(self.ask(question, vote, None).await)
                }
                .boxed()
            })
            .collect();
        let mut asks = stream::iter(asks).buffered(self.author.at_once.max(1));
        let (mut votes, mut failed) = (Vec::new(), None);
        while let Some(answer) = asks.next().await {
            match answer {
                Some(Ok(answer)) => {
                    spent.add(&answer);
                    votes.push(self.read(&answer, &field, ranked));
                }
                Some(Err(error)) => failed = failed.or(Some(error)),
                None => {}
            }
        }
        match failed {
            Some(error) if votes.is_empty() => Err(error.into()),
            _ => Ok(votes),
        }
    }

    /// Whether an obstacle is this near to the ego at a step of its drive, ahead of it or beside it, metres between
    /// the centres, as descriptions count.
    fn is_near(&self, id: i64, step: i64, within: f64) -> bool {
        let stage = self.ground.stage;
        let obstacle = stage.scenario.obstacle(id);
        let there = obstacle.and_then(|obstacle| obstacle.placed_at(step));
        let (Some(there), Some(ego)) = (there, stage.ego.at(step)) else {
            return false;
        };
        let at = ego.pose.to_local(&there.pose.position);
        at.x.hypot(at.y) <= within && at.x >= -stage.footprint.shape().size().0 / 2.0
    }

    fn read(&self, answer: &Answer, field: &Field, ranked: &[Candidate]) -> Proposal {
        let (stated, refused) = match &answer.judged {
            JudgeOutcome::Other(reading) => match &reading.said {
                ParsedAnswer::Attacker(choice) => {
                    let refused = match choice.attacker {
                        Some(id) => self.can_be_chosen(id, field, ranked).err(),
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
        let proposed = stated.as_ref().and_then(|choice| choice.attacker);
        let refused = match proposed {
            Some(id) => refused.map(|refusal: Refusal| refusal.about(id, None)),
            None => refused,
        };
        Proposal {
            run: answer.run,
            window: (field.window.first(), field.window.last()),
            choice: stated,
            reasoning: answer.reasoning.clone(),
            refused,
        }
    }

    /// Whether an obstacle can be given another motion, and is one of those that can be chosen.
    fn can_be_chosen(&self, id: i64, field: &Field, ranked: &[Candidate]) -> Result<(), Refusal> {
        self.can_attack(id, ranked)?;
        let within = field.within;
        if field
            .steps
            .iter()
            .any(|step| self.is_near(id, *step, within))
        {
            Ok(())
        } else {
            Err(Refusal::answer(format!(
                "obstacle {id} is not within {within} m ahead of the ego or beside it at any described time"
            )))
        }
    }

    /// Whether an obstacle can be given another motion.
    pub(super) fn can_attack(&self, id: i64, ranked: &[Candidate]) -> Result<(), Refusal> {
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
