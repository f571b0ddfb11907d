//! Self-consistency: the model grades each of its motions by the metrics prompt, and the lowest score wins.
//!
//! A motion is graded in the scene with it and the drive that the ego had planned without it: how the ego really
//! answered is the outcome, and no question gives that away. The window ends before the two would be nearest on that
//! drive, so it shows no contact either: the model has to see it coming.

use std::sync::Arc;

use futures_util::future::BoxFuture;
use futures_util::{FutureExt, StreamExt, stream};

use super::super::answer::{Answer, JudgeOutcome};
use super::super::question::{CaseError, Question};
use super::super::run_case::AskError;
use super::super::settings::Settings;
use super::choosing::other_task;
use super::feedback::nearest;
use super::method::CANDIDATE;
use super::outcome::{Authored, AuthoredAttack, Source};
use super::{AuthorError, AuthorSession, Progress};
use nearmiss_drive::generation::{Attack, Refusal, RequestedMotion};
use nearmiss_scene::description::Frame;
use nearmiss_scene::scenario::{ContentHash, Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::RunId;

/// The model's grade of one of its motions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grade {
    /// Its run in the store.
    pub run: Option<RunId>,
    /// First and last time step that were described.
    pub window: (i64, i64),
    /// The attacker's risk score, 0 (collision) to 5 (negligible), where the answer has one.
    pub score: Option<u8>,
    /// Why there is none.
    pub problem: Option<String>,
}

/// Whether the model's grades and the exact ranking prefer the same motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// The motion with the lowest grade; of several the one written first.
    pub model: Source,
    /// The best of the same motions in the closed loop.
    pub exact: Source,
    /// How many different motions were compared.
    pub of: usize,
    /// How probable it is that they agree if the model's answer is drawn by lot.
    pub by_chance: f64,
    /// Whether they are the same motion.
    pub agrees: bool,
}

/// The window ends so long before the motion is nearest to the ego's planned drive, seconds.
const BEFORE: f64 = 0.5;

impl AuthorSession<'_> {
    /// Has the model grade every motion that passed the gate.
    pub(super) async fn grade(&self, authored: &mut Authored) -> Result<(), AuthorError> {
        let of = authored.attacks.len();
        let questions: Result<Vec<Question>, CaseError> = { authored.attacks.iter() }
            .map(|one| self.grade_question(&one.admitted.attack))
            .collect();
        let questions = questions?;
        let asks: Vec<BoxFuture<'_, Option<Result<Answer, AskError>>>> = { questions.iter() }
            .enumerate()
            .map(|(motion, question)| {
                async move {
                    if self.is_barred() {
                        return None;
                    }
                    (self.listener)(Progress::Grading { motion, of });
                    Some(self.ask(question, 0, None).await)
                }
                .boxed()
            })
            .collect();
        let mut asks = stream::iter(asks)
            .buffered(self.author.at_once.max(1))
            .enumerate();
        while let Some((place, answer)) = asks.next().await {
            match answer {
                Some(Ok(answer)) => {
                    authored.spent.add(&answer);
                    let one = &mut authored.attacks[place];
                    let attacker = one.admitted.attack.change.changes()[0].obstacle;
                    let window = questions[place].case.window;
                    let score = read_score(&answer, attacker);
                    one.grade = Some(Grade {
                        run: answer.run,
                        window: (window.first(), window.last()),
                        problem: score.as_ref().err().map(ToString::to_string),
                        score: score.ok(),
                    });
                    if !answer.arrived() && self.is_barred() {
                        let grade = authored.attacks[place].grade.as_ref();
                        authored.stopped = grade
                            .and_then(|grade| grade.problem.as_deref())
                            .map(grades_failed);
                    }
                }
                Some(Err(error)) => {
                    let why = grades_failed(&error.to_string());
                    authored.stopped.get_or_insert(why);
                }
                None => {}
            }
        }
        Ok(())
    }

    /// The question about a motion.
    fn grade_question(&self, attack: &Attack) -> Result<Question, CaseError> {
        let stage = self.ground.stage;
        // A model writes for one attacker.
        let (change, written) = (&attack.change.changes()[0], &attack.asked[0]);
        let mut scenario = match attack.change.apply(stage.scenario) {
            Ok(scenario) => scenario,
            // It passed the gate, so it can be applied.
            Err(_) => stage.scenario.clone(),
        };
        // An answer about it is none about the original.
        let asked = serde_json::json!(RequestedMotion::from(written));
        let motion = format!("{asked} {:?}", change.motions);
        let parts = [&stage.scenario.hash.bytes()[..], motion.as_bytes()];
        scenario.hash = ContentHash::of_parts(parts);
        let scene = Scene::new(Arc::new(scenario), self.scene.ego.clone());
        let from = change.from().unwrap_or(*stage.steps.start());
        let near = nearest(
            &scene.scenario,
            change.obstacle,
            (stage.footprint, stage.ego),
            from,
        );
        let before = (BEFORE / stage.dt()).round() as i64;
        let end = near.map_or(attack.rehearsal.step, |near| near.step - before);
        self.grade_question_about(Arc::new(scene), end.max(from))
    }

    /// The question about the attacker's risk in a scene, until a step.
    pub(super) fn grade_question_about(
        &self,
        scene: Arc<Scene>,
        end: i64,
    ) -> Result<Question, CaseError> {
        let (task, frame) = (Task::Safety, Frame::Metrics);
        let window = Window::ending_at(&scene, end, self.history(task, frame)?);
        let settings = Settings {
            obstacle: None,
            ..self.author.settings
        };
        let name = format!("{}{CANDIDATE}", self.author.name);
        self.question_about((name, scene), (task, frame), window, settings)
    }
}

/// Why the work stopped, where all motions were there by then.
fn grades_failed(why: &str) -> String {
    format!("the motions are complete, only grades are missing: {why}")
}

/// The score that an answer gives the attacker, or why it gives none.
fn read_score(answer: &Answer, attacker: i64) -> Result<u8, Refusal> {
    match &answer.judged {
        JudgeOutcome::Verdict(parsed) if parsed.verdict.task == Task::Safety => {
            let mut graded = parsed.verdict.obstacles.iter();
            let its = graded.find(|risk| risk.id == attacker);
            its.map(|risk| risk.stated_score()).ok_or_else(|| {
                Refusal::answer(format!("the answer does not grade obstacle {attacker}"))
            })
        }
        JudgeOutcome::Verdict(parsed) => Err(other_task(parsed.verdict.task)),
        JudgeOutcome::Other(reading) => Err(other_task(reading.said.task())),
        JudgeOutcome::Missing(missing) => Err(Refusal::answer(missing.to_string())),
    }
}

impl AuthoredAttack {
    /// The model's score, if it gave one.
    #[must_use]
    pub fn score(&self) -> Option<u8> {
        self.grade.as_ref().and_then(|grade| grade.score)
    }
}

impl Authored {
    /// The motion that the model grades lowest; of several the one written first.
    #[must_use]
    pub fn by_model(&self) -> Option<&AuthoredAttack> {
        let graded = self.attacks.iter().filter(|one| one.score().is_some());
        graded.min_by_key(|one| (one.score(), one.source.sample, one.source.retry))
    }

    /// Whether the model's grades and the exact ranking prefer the same motion; `None` where fewer than two different
    /// motions were both graded and driven against. Answers with the same motion are one motion, though a lot among the
    /// answers draws it more often.
    #[must_use]
    pub fn agreement(&self) -> Option<Agreement> {
        let both =
            |one: &&AuthoredAttack| one.score().is_some() && one.admitted.attack.effect.is_some();
        let compared: Vec<&AuthoredAttack> = self.attacks.iter().filter(both).collect();
        let cost = |one: &&&AuthoredAttack| one.admitted.attack.cost();
        let order = |one: &AuthoredAttack| (one.source.sample, one.source.retry);
        let exact = compared.iter().min_by(|a, b| {
            let costs = cost(a).total_cmp(&cost(b));
            costs.then_with(|| order(a).cmp(&order(b)))
        })?;
        let model = compared
            .iter()
            .min_by_key(|one| (one.score(), order(one)))?;
        let same = |a: &AuthoredAttack, b: &AuthoredAttack| {
            a.admitted.attack.change == b.admitted.attack.change
        };
        let is_new = |(place, one): &(usize, &&AuthoredAttack)| {
            !compared[..*place].iter().any(|other| same(other, one))
        };
        let of = compared.iter().enumerate().filter(is_new).count();
        let like_exact = compared.iter().filter(|one| same(one, exact)).count();
        (of > 1).then(|| Agreement {
            model: model.source,
            exact: exact.source,
            of,
            by_chance: like_exact as f64 / compared.len() as f64,
            agrees: same(model, exact),
        })
    }
}
