//! A model as the author of attacks: it chooses the attacker by vote, writes motions, receives the gate's refusals and
//! what came of the drives, and grades its motions.
//!
//! Every request takes the path of all others, see [`crate::evaluation::run`]: an answer is stored before it is used,
//! and a stored one is not paid for again. A model's answer becomes an attack only through
//! [`nearmiss_drive::generation::admit`]; nothing else passes the gate.

mod choosing;
mod consistency;
mod feedback;
mod method;
mod outcome;
mod writing;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub use choosing::{Choice, ChosenBy, Proposal};
pub use consistency::{Agreement, Grade};
pub use feedback::{Nearest, nearest};
pub use method::{Bound, Method, RETRIES, Ranking, SAMPLES, VOTES, bound, unchanged_name};
pub use outcome::{
    AgreementRecord, Authored, AuthoredAttack, AuthoredRecord, AuthoringUsage, Place,
    RefusedAnswer, Source, Tries,
};

use super::answer::Answer;
use super::judges::Judge;
use super::question::{AttackTerms, Case, CaseError, Question, prepare, template};
use super::run_case::{self, AskError, Event, RunOptions};
use super::settings::{Settings, default_frame};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::generation::{AttackSetup, Refusal};
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Consumed, Store, StoreError};

/// The authoring model, and its request settings.
#[derive(Debug, Clone)]
pub struct Author {
    /// Name of the scenario, for people and for the store.
    pub name: String,
    /// The model.
    pub judge: Judge,
    /// Where answers are kept, and looked for; nothing to keep none.
    pub store: Option<Arc<Store>>,
    /// The templates.
    pub library: Library,
    /// Thresholds of the risk scores.
    pub thresholds: Arc<Thresholds>,
    /// The user's settings for descriptions and techniques. Their obstacle is ignored.
    pub settings: Settings,
    /// How the choice of the attacker is described; `None` for the usual frame, which is the metrics.
    pub frame: Option<Frame>,
    /// How often it is asked, and what for.
    pub method: Method,
    /// How many conversations go on at once.
    pub at_once: usize,
    /// The attacker, where the user names it; the model is not asked to choose then.
    pub attacker: Option<i64>,
    /// Whether to write nothing if the model's choice of attacker cannot be used. Otherwise the first of the reference
    /// ranking replaces it, recorded in [`Choice::by`].
    pub obey: bool,
    /// Ask in any case, even where the store has the answer.
    pub fresh: bool,
    /// The batch that the runs are for.
    pub batch: Option<String>,
}

impl Author {
    /// The templates that are asked with: file and hash.
    #[must_use]
    pub fn templates(&self) -> BTreeMap<String, String> {
        let usual = |task| default_frame(&self.library, task);
        let choice = self.frame.unwrap_or_else(|| usual(Task::Attacker));
        let graded = self.method.grades.then_some((Task::Safety, Frame::Metrics));
        let asked = [
            (Task::Attacker, choice),
            (Task::Trajectory, usual(Task::Trajectory)),
        ];
        let found = { asked.into_iter().chain(graded).collect::<Vec<_>>() };
        let found = found
            .iter()
            .filter_map(|(task, frame)| template(&self.library, *task, *frame).ok());
        found
            .map(|(file, template)| (file.to_string(), self.library.hash(&template.source)))
            .collect()
    }
}

/// Progress of a model's authoring.
#[derive(Debug, Clone)]
pub enum Progress {
    /// The model is asked who is to attack.
    Choosing {
        /// Which vote, from 0.
        vote: u32,
        /// How many votes there are.
        of: u32,
    },
    /// It is decided who attacks.
    Chosen(Box<Choice>),
    /// A motion is asked for: the conversation, from 0, and the retry in it, 0 for the first answer.
    Writing {
        /// Which conversation.
        sample: u32,
        /// Which answer in it.
        retry: u32,
    },
    /// An event of a request: of a conversation, of the choice, or of a grade.
    Heard {
        /// Which conversation; `None` for the choice and for grades.
        sample: Option<u32>,
        /// The event.
        event: Event,
    },
    /// An answer is complete, whatever it says.
    Answered {
        /// Which conversation; `None` for the choice and for grades.
        sample: Option<u32>,
        /// Its consumption.
        consumed: Consumed,
        /// Whether it was in the store before, so that nothing was sent for it.
        stored: bool,
    },
    /// An answer became an attack that passes the gate.
    Made(Source),
    /// The ego is driven against an attack.
    Driving(Source),
    /// What came of it goes back to the model, since it is not what was wanted.
    ToldOfDrive(Source),
    /// An answer was refused.
    Refused(Box<RefusedAnswer>),
    /// A conversation is over.
    Ended {
        /// Which conversation.
        sample: u32,
    },
    /// The model is asked to grade a motion.
    Grading {
        /// Which motion, from 0.
        motion: usize,
        /// How many there are.
        of: usize,
    },
}

/// Receives progress.
pub type Listener<'a> = &'a (dyn Fn(Progress) + Sync);

/// Why nothing was written at all.
#[derive(Debug, thiserror::Error)]
pub enum AuthorError {
    /// The first request was refused before it was sent, or the store failed.
    #[error(transparent)]
    Ask(#[from] AskError),
    /// No prompt can be made.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The attacker that the user names cannot be one.
    #[error("no attacker: {0}")]
    Attacker(Refusal),
}

/// Lets a model choose the attacker, write motions for it and grade them, on the ego's drive in `scene`, which is the
/// ground's baseline: at most [`Method::requests`]. With [`Method::feedback`] the ego is driven against each motion that
/// passes the gate, and a model whose motion an ideal driver with a reaction time of `delay` seconds does not survive, or
/// that has no effect, is told and asked for another one. What is not driven by then, [`Authored::drive_watched`] drives.
///
/// Dropping the future cancels what is on its way and writes that down; what was answered is in the store.
///
/// # Errors
/// Nothing could be asked. A request that is refused later ends the work, and [`Authored::stopped`] says why.
pub async fn write(
    author: &Author,
    ground: &AttackSetup<'_>,
    scene: &Arc<Scene>,
    delay: f64,
    listener: Listener<'_>,
) -> Result<Authored, AuthorError> {
    let session = AuthorSession {
        author,
        ground,
        scene,
        delay,
        listener,
        barred: AtomicBool::new(false),
    };
    let mut spent = AuthoringUsage::default();
    let choice = session.choose(&mut spent).await?;
    listener(Progress::Chosen(Box::new(choice.clone())));
    let mut authored = Authored::new(choice, spent, author.method.rank);
    if session.is_barred() {
        let refused = authored.choice.proposal.as_ref();
        let why = refused.and_then(|p| p.refused.as_ref());
        authored.stopped = why.map(ToString::to_string);
        return Ok(authored);
    }
    if let Some(attacker) = authored.choice.attacker {
        session.write(attacker, &mut authored).await?;
        if author.method.grades && authored.stopped.is_none() {
            session.grade(&mut authored).await?;
        }
    }
    Ok(authored)
}

/// One author at work on one scenario.
struct AuthorSession<'a> {
    author: &'a Author,
    ground: &'a AttackSetup<'a>,
    scene: &'a Arc<Scene>,
    delay: f64,
    listener: Listener<'a>,
    /// Whether a request has failed in a way in which all others would.
    barred: AtomicBool,
}

impl AuthorSession<'_> {
    /// Nothing more is asked.
    fn bar(&self) {
        self.barred.store(true, Ordering::Relaxed);
    }

    fn is_barred(&self) -> bool {
        self.barred.load(Ordering::Relaxed)
    }

    /// The steps in a window of a task, as the user or the template says.
    fn history(&self, task: Task, frame: Frame) -> Result<usize, CaseError> {
        let (_, template) = template(&self.author.library, task, frame)?;
        Ok(self.author.settings.with(&template.front.defaults).history)
    }

    /// A question about the ego's drive as it was recorded.
    fn question(
        &self,
        (task, frame): (Task, Frame),
        window: Window,
        settings: Settings,
    ) -> Result<Question, CaseError> {
        let about = (self.author.name.clone(), Arc::clone(self.scene));
        self.question_about(about, (task, frame), window, settings)
    }

    /// A question about a scene of this name.
    fn question_about(
        &self,
        (name, scene): (String, Arc<Scene>),
        (task, frame): (Task, Frame),
        window: Window,
        settings: Settings,
    ) -> Result<Question, CaseError> {
        let author = self.author;
        let (_, template) = template(&author.library, task, frame)?;
        let decided = settings.with(&template.front.defaults);
        let case = Case {
            name,
            scene,
            task,
            frame,
            techniques: decided.techniques,
            window,
            options: decided.options,
            thresholds: Arc::clone(&author.thresholds),
            horizon: Case::HORIZON,
            attack: AttackTerms {
                style: self.ground.stage.style,
                delay: self.delay,
            },
        };
        prepare(case, &author.library, None)
    }

    /// Asks the model for its answer of a number to the same request. `sample` is the conversation that it belongs to.
    async fn ask(
        &self,
        question: &Question,
        number: u32,
        sample: Option<u32>,
    ) -> Result<Answer, AskError> {
        let wanted = RunOptions {
            sample: number,
            fresh: self.author.fresh,
            batch: self.author.batch.clone(),
        };
        let store = self.author.store.clone();
        let mut unstored = None;
        let asked = run_case::run(question, &self.author.judge, store, &wanted, |event| {
            if let Event::NotStored(words) = &event {
                unstored = Some(words.clone());
            }
            if let Event::Barred(_) = event {
                self.bar();
            }
            (self.listener)(Progress::Heard { sample, event });
        });
        let answer = asked.await?;
        if let Some(words) = unstored {
            return Err(StoreError::Unstored(words).into());
        }
        (self.listener)(Progress::Answered {
            sample,
            consumed: answer.consumed,
            stored: answer.past.is_some(),
        });
        Ok(answer)
    }
}
