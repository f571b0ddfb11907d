//! Conversations that produce motions: an answer, the gate's refusals or what came of the drive, another answer.

use futures_util::future::BoxFuture;
use futures_util::{FutureExt, StreamExt, stream};

use super::super::answer::{Answer, JudgeOutcome, MissingVerdict};
use super::super::question::Question;
use super::super::run_case::AskError;
use super::super::settings::{Settings, default_frame};
use super::choosing::other_task;
use super::outcome::{Authored, AuthoredAttack, RefusedAnswer, Source};
use super::{AuthorError, AuthorSession, AuthoringUsage, Progress, feedback};
use nearmiss_drive::generation::attacker::Candidate;
use nearmiss_drive::generation::{AdmittedAttack, Refusal, admit};
use nearmiss_scene::scenario::{Motion, Window};
use nearmiss_scene::verdict::{NewMotion, ParsedAnswer, Task};

/// The described steps go on for so long after the attacker could be at the ego, seconds.
const AFTER: f64 = 2.0;

/// Result of one conversation.
#[derive(Default)]
struct Conversation {
    attacks: Vec<AuthoredAttack>,
    declined: Vec<RefusedAnswer>,
    spent: AuthoringUsage,
    error: Option<AskError>,
}

impl AuthorSession<'_> {
    /// Lets motions be written for the attacker.
    pub(super) async fn write(
        &self,
        attacker: i64,
        authored: &mut Authored,
    ) -> Result<(), AuthorError> {
        let question = self.motion_question(attacker, &authored.choice.ranked)?;
        let samples = 0..self.author.method.samples;
        let talks: Vec<BoxFuture<'_, Conversation>> = samples
            .map(|sample| self.converse(&question, attacker, sample).boxed())
            .collect();
        let mut talks = stream::iter(talks).buffered(self.author.at_once.max(1));
        let mut refused = None;
        while let Some(talk) = talks.next().await {
            authored.attacks.extend(talk.attacks);
            authored.declined.extend(talk.declined);
            authored.spent.join(&talk.spent);
            refused = refused.or(talk.error);
        }
        match refused {
            // No cost, no loss.
            Some(error) if authored.spent.requests == 0 => return Err(error.into()),
            Some(error) => authored.stopped = Some(error.to_string()),
            None if self.is_barred() => {
                let last = authored.declined.last().and_then(|d| d.refusals.last());
                authored.stopped = last.map(ToString::to_string);
            }
            None => {}
        }
        Ok(())
    }

    /// The question for a motion, about steps at all of which the attacker is there, until a little after it could be
    /// at the ego.
    pub(super) fn motion_question(
        &self,
        attacker: i64,
        ranked: &[Candidate],
    ) -> Result<Question, AuthorError> {
        let task = Task::Trajectory;
        let frame = default_frame(&self.author.library, task);
        let stage = self.ground.stage;
        let obstacle = self.ground.obstacle(attacker);
        let track = obstacle.map_err(AuthorError::Attacker)?.track().steps();
        let met = ranked
            .iter()
            .find(|c| c.obstacle == attacker)
            .map_or(*stage.steps.end(), |candidate| candidate.step);
        let last = met + (AFTER / stage.dt()).ceil() as i64;
        let last = last.min(track.end - 1).min(*stage.steps.end());
        let first = track.start.max(*stage.steps.start());
        let room = usize::try_from(last - first + 1).unwrap_or(1);
        let history = self.history(task, frame)?.min(room);
        let window = Window::ending_at(self.scene, last, history);
        let settings = Settings {
            obstacle: Some(attacker),
            ..self.author.settings
        };
        Ok(self.question((task, frame), window, settings)?)
    }

    /// One conversation, until a motion passes the gate and is what is wanted, or all retries are used up.
    async fn converse(&self, question: &Question, attacker: i64, sample: u32) -> Conversation {
        let talk = self.talk(question, attacker, sample).await;
        (self.listener)(Progress::Ended { sample });
        talk
    }

    async fn talk(&self, question: &Question, attacker: i64, sample: u32) -> Conversation {
        let mut talk = Conversation::default();
        let mut question = question.clone();
        let retries = self.author.method.retries;
        for retry in 0..=retries {
            if self.is_barred() {
                break;
            }
            (self.listener)(Progress::Writing { sample, retry });
            let answer = match self.ask(&question, sample, Some(sample)).await {
                Ok(answer) => answer,
                Err(error) => {
                    talk.error = Some(error);
                    break;
                }
            };
            talk.spent.add(&answer);
            let source = Source {
                sample,
                retry,
                run: answer.run,
            };
            let motion = read_motion(&answer);
            let admitted = match &motion {
                Ok(motion) => self.admitted(attacker, motion),
                Err(refusal) => Err(vec![refusal.clone()]),
            };
            match admitted {
                Ok(admitted) => {
                    (self.listener)(Progress::Made(source));
                    let justification = motion.map(|motion| motion.justification);
                    let mut made = AuthoredAttack {
                        admitted,
                        source,
                        justification: justification.unwrap_or_default(),
                        reasoning: answer.reasoning,
                        feedback: None,
                        grade: None,
                    };
                    let better = self
                        .better(&mut made, attacker, &question, retry < retries)
                        .await;
                    made.feedback.clone_from(&better);
                    talk.attacks.push(made);
                    let Some(words) = better else { break };
                    question = question.after(&feedback::shortened(&answer.text), &words);
                }
                Err(refusals) => {
                    let mut about = (attacker, None);
                    if let Ok(stated) = &motion {
                        about = (stated.obstacle, Some(stated.motion.name()));
                    }
                    let refusals = refusals.into_iter();
                    let refusals: Vec<_> = refusals.map(|r| r.about(about.0, about.1)).collect();
                    let start = self.start(&question, attacker);
                    let words = feedback::refused(attacker, &refusals, start);
                    let declined = RefusedAnswer {
                        source,
                        arrived: answer.arrived(),
                        motion: motion.ok(),
                        refusals,
                    };
                    (self.listener)(Progress::Refused(Box::new(declined.clone())));
                    talk.declined.push(declined);
                    if !answer.arrived() {
                        // There is no attacker to write a motion for.
                        break;
                    }
                    question = question.after(&feedback::shortened(&answer.text), &words);
                }
            }
        }
        talk
    }

    /// Drives the ego against a motion where the model is to hear of it. The words for the next turn, where it is not
    /// what is wanted and another turn may come.
    async fn better(
        &self,
        made: &mut AuthoredAttack,
        attacker: i64,
        question: &Question,
        goes_on: bool,
    ) -> Option<String> {
        if !self.author.method.feedback {
            return None;
        }
        (self.listener)(Progress::Driving(made.source));
        // Others may go on before the drive, which takes the thread for its time.
        tokio::task::yield_now().await;
        let attack = &mut made.admitted.attack;
        self.ground.drive(attack);
        if attack.has_effect() {
            self.ground.survive(attack, self.delay, &[]);
        }
        if self.ground.closed_loop.driver().is_cancelled() {
            // The drive was cut short: nothing may be told of it.
            self.bar();
            return None;
        }
        if !goes_on || feedback::is_wanted(attack) {
            return None;
        }
        let drive = feedback::driven(self.ground, attack, self.delay);
        (self.listener)(Progress::ToldOfDrive(made.source));
        let start = self.start(question, attacker);
        Some(feedback::not_wanted(attacker, &drive, start))
    }

    fn admitted(&self, attacker: i64, said: &NewMotion) -> Result<AdmittedAttack, Vec<Refusal>> {
        if said.obstacle != attacker {
            let there = match self.ground.obstacle(said.obstacle) {
                Ok(_) => "",
                Err(_) => ", which is not in the scenario",
            };
            let other = said.obstacle;
            return Err(vec![Refusal::answer(format!(
                "it moves obstacle {other}{there} instead of obstacle {attacker}"
            ))]);
        }
        admit(self.ground, attacker, &said.motion)
    }

    /// The first described step and the attacker's recorded state there.
    fn start(&self, question: &Question, attacker: i64) -> Option<(i64, Motion)> {
        let case = &question.case;
        let step = case.options.steps(&case.window).first().copied()?;
        let obstacle = self.ground.obstacle(attacker).ok()?;
        Some((step, *obstacle.track().at(step)?))
    }
}

/// The motion that an answer says.
fn read_motion(answer: &Answer) -> Result<NewMotion, Refusal> {
    match &answer.judged {
        JudgeOutcome::Other(reading) => match &reading.said {
            ParsedAnswer::Trajectory(motion) => Ok(motion.clone()),
            other => Err(other_task(other.task())),
        },
        JudgeOutcome::Verdict(parsed) => Err(other_task(parsed.verdict.task)),
        JudgeOutcome::Missing(MissingVerdict::NotInAnswer(why)) => {
            Err(Refusal::answer(why.clone()))
        }
        JudgeOutcome::Missing(missing) => Err(Refusal::answer(missing.to_string())),
    }
}
