//! A batch as a data set for others: its questions with their truth, and the answers to them, row by row.

mod card;

pub use card::DataSetCard;

use std::collections::{BTreeMap, BTreeSet, HashSet};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nearmiss_ask::llm::{Message, Parameters, Role};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{
    AnswerState, Batch, BatchId, ClaimCounts, Consumed, CountedAs, Item, NewestAnswer, QuestionRun,
    Run, RunId, SplitPart, Store, StoreError,
};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;
use sha2::{Digest, Sha256};
use strum::{IntoStaticStr, VariantArray};

use super::scored::read;
use super::spec::Spec;
use crate::evaluation::{AnswerStatus, AxisValues, PromptConfig, Protocol, Scored};

/// The part that the questions of a batch without a split are in: what benchmarks ask by default.
const WHOLE: &str = "test";

/// Items whose texts are in memory at once.
const PIECE: u32 = 200;

/// A question of a data set: one window of a scenario in one wording.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DataSetQuestion {
    /// Names the question: the start of the SHA-256 of its scenario, window and messages.
    pub id: String,
    /// Name of the scenario: its file name without the ending.
    pub scenario: String,
    /// SHA-256 of the scenario's file.
    pub scenario_hash: Option<String>,
    /// The question: collision, safety or recording.
    #[schemars(with = "String")]
    pub task: Task,
    /// Frame of the description.
    pub frame: Option<String>,
    /// Prompting techniques: cp, cot and icl joined by +, or base.
    pub techniques: Option<String>,
    /// Form and stride of the description, where the batch has several.
    pub form: Option<String>,
    /// File name of the prompt template.
    pub template: String,
    /// SHA-256 of its text.
    pub template_hash: String,
    /// From the end of the window to the contact, or end; of a safe window, that of the dangerous one that it is like.
    #[schemars(extend("unit" = "s"))]
    pub lead: Option<String>,
    /// Change of the scene, such as mirror; null for the scene as it is.
    pub transform: Option<String>,
    /// First and last time step of the recording that the question is about.
    pub window: Option<(i64, i64)>,
    /// Obstacles near the ego at one of these steps.
    pub obstacles: Option<u64>,
    /// The ego's speed at the last step.
    #[schemars(extend("unit" = "m/s"))]
    pub speed: Option<f64>,
    /// Least distance of an obstacle in the window.
    #[schemars(extend("unit" = "m"))]
    pub nearest: Option<f64>,
    /// Least time to collision at the last step; null where nothing is on collision course.
    #[schemars(extend("unit" = "s"))]
    pub ttc: Option<f64>,
    /// The system message.
    pub system: String,
    /// The message of the user.
    pub user: String,
    /// The picture before that message, as a data URI; null without one.
    pub image: Option<String>,
    /// Key of the answer's JSON object that holds yes or no; null where the messages name none.
    pub answer_key: Option<&'static str>,
    /// The truth in the words of that key: true (yes) or false.
    pub target: &'static str,
    /// Ids of the obstacles that are truly critical, with spaces between them; empty in safe windows, and where they are
    /// not known.
    pub critical_obstacles: Vec<i64>,
}

/// An answer of a data set.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DataSetAnswer {
    /// The id of the question that it answers.
    pub question: String,
    /// Model asked, as provider/model.
    pub model: String,
    /// Model that the server says has answered.
    pub model_returned: Option<String>,
    /// Values of the axes of the batch, such as effort low; null without axes.
    pub settings: Option<String>,
    /// Whether the model could call tools.
    pub with_tools: bool,
    /// Number of the sample among answers to the same request, from 0.
    pub sample: u32,
    /// What it counts as: answered, unparsed, truncated, filtered or failed.
    #[schemars(with = "String")]
    pub state: AnswerState,
    /// The verdict, in the words of target; null without one.
    pub verdict: Option<&'static str>,
    /// Whether the verdict is the truth; without a verdict it is not.
    pub right: bool,
    /// Ids of the obstacles that a yes names, with spaces between them.
    pub named_obstacles: Vec<i64>,
    /// The probability of yes that the answer states.
    pub probability: Option<f64>,
    /// Its claims about obstacles, where they were checked.
    #[serde(flatten)]
    pub claims: ClaimCounts,
    /// Time, tokens and cost.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Text of the answer.
    pub answer: String,
}

/// A row of one of the two tables.
#[derive(Debug, Clone, PartialEq)]
pub enum DataSetRow {
    /// A question that no row before it has.
    Question(Box<DataSetQuestion>),
    /// An answer to one of the questions before it.
    Answer(Box<DataSetAnswer>),
}

/// Why a question of a batch is not in its data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum LeftOut {
    /// No model was asked, so its messages are not known.
    NotAsked,
    /// It is answered without a yes or no.
    OtherTask,
    /// The built-in judge is asked without words.
    BuiltIn,
    /// Nothing is known to compare answers with.
    NoTruth,
    /// Its messages are something else than one of the system and one of the user.
    OtherMessages,
    /// It shows several pictures, or one that the store does not have.
    Picture,
}

nearmiss_record::named!(LeftOut);

impl LeftOut {
    /// In words, for a number of questions.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::NotAsked => "that were not asked",
            Self::OtherTask => "of tasks without a yes or no",
            Self::BuiltIn => "to the built-in judge, which is asked without words",
            Self::NoTruth => "without a known truth",
            Self::OtherMessages => "whose messages are not one of the system and one of the user",
            Self::Picture => {
                "with several pictures, or with one that is not a stored PNG, JPEG or WebP"
            }
        }
    }
}

/// What a data set holds beside its rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DataSetFacts {
    /// Questions and answers by part: dev or test.
    pub parts: BTreeMap<&'static str, (usize, usize)>,
    /// Questions of the batch, each model and sample counted, that are left out.
    pub left_out: BTreeMap<LeftOut, usize>,
    /// Questions whose messages do not name the key of the answer that holds yes or no.
    pub without_key: usize,
    /// Places in the batch of the questions.
    pub places: BTreeSet<u64>,
    /// The answers.
    pub runs: BTreeSet<RunId>,
    tasks: BTreeSet<Task>,
    keys: BTreeSet<&'static str>,
    ways: BTreeSet<PromptConfig>,
    with_pictures: bool,
    with_system: bool,
    with_tools: bool,
}

/// The rows of a batch's data set, in the order of the batch.
pub struct DataSetRows<'a> {
    store: &'a Store,
    batch: BatchId,
    protocol: Protocol,
    is_locked: &'a dyn Fn(RunId) -> bool,
    next: u64,
    seen: HashSet<String>,
    facts: DataSetFacts,
}

impl<'a> DataSetRows<'a> {
    /// Those of this batch; of questions with an answer that `is_locked` nothing is told.
    #[must_use]
    pub fn new(
        store: &'a Store,
        batch: &Batch,
        spec: &Spec,
        is_locked: &'a dyn Fn(RunId) -> bool,
    ) -> Self {
        Self {
            store,
            batch: batch.id,
            protocol: spec.experiment.protocol,
            is_locked,
            next: 0,
            seen: HashSet::new(),
            facts: DataSetFacts::default(),
        }
    }

    /// What was told so far.
    #[must_use]
    pub fn into_facts(self) -> DataSetFacts {
        self.facts
    }

    /// The next rows, each with its part; `None` at the end.
    ///
    /// # Errors
    /// The store cannot be read, or holds words that this version does not know.
    pub fn next_rows(&mut self) -> Result<Option<Vec<(&'static str, DataSetRow)>>, StoreError> {
        let found = self
            .store
            .some_items_with_answers(self.batch, self.next, Some(PIECE))?;
        let runs = self
            .store
            .question_runs(self.batch, self.next, Some(PIECE))?;
        let Some((last, _)) = found.last() else {
            return Ok(None);
        };
        self.next = last.place + 1;
        let told: Vec<(Item, Option<NewestAnswer>)> = found
            .into_iter()
            .filter(|(item, _)| self.is_told(item, runs.get(&item.place)))
            .collect();
        let mut rows = Vec::new();
        for ((item, _), (_, mut scored)) in told.iter().zip(read(&told, &runs)?) {
            self.protocol.count(&mut scored);
            let any = runs.get(&item.place).and_then(|runs| runs.first());
            let Some(number) = scored.run.or(any.map(|run| run.run)) else {
                continue;
            };
            let Some(run) = self.store.run(number)? else {
                // It is gone meanwhile.
                continue;
            };
            self.add(item, &scored, &run, &mut rows)?;
        }
        Ok(Some(rows))
    }

    /// Whether there may be something to tell of a question; what there is not is counted.
    fn is_told(&mut self, item: &Item, runs: Option<&Vec<QuestionRun>>) -> bool {
        let runs = runs.map_or(&[][..], Vec::as_slice);
        if runs.iter().any(|run| (self.is_locked)(run.run)) {
            return false;
        }
        let why = if !Task::VERDICTS.contains(&item.asked.task) {
            LeftOut::OtherTask
        } else if item.asked.model == judge::MODEL {
            LeftOut::BuiltIn
        } else if runs.is_empty() {
            LeftOut::NotAsked
        } else if item.asked.collides.is_none() {
            LeftOut::NoTruth
        } else {
            return true;
        };
        self.leave_out(why);
        false
    }

    fn leave_out(&mut self, why: LeftOut) {
        *self.facts.left_out.entry(why).or_default() += 1;
    }

    fn add(
        &mut self,
        item: &Item,
        scored: &Scored,
        run: &Run,
        rows: &mut Vec<(&'static str, DataSetRow)>,
    ) -> Result<(), StoreError> {
        let messages: Vec<Message> =
            serde_json::from_str(&run.question.messages).unwrap_or_default();
        let Some(words) = Words::of(&messages) else {
            self.leave_out(LeftOut::OtherMessages);
            return Ok(());
        };
        let image = match &words.user.images[..] {
            [] => None,
            [one] => match self.picture(&one.sha256)? {
                Some(picture) => Some(picture),
                None => {
                    self.leave_out(LeftOut::Picture);
                    return Ok(());
                }
            },
            _ => {
                self.leave_out(LeftOut::Picture);
                return Ok(());
            }
        };
        let part = item.asked.split.map_or(WHOLE, SplitPart::name);
        let id = id(item, run);
        if self.seen.insert(id.clone()) {
            let question = DataSetQuestion {
                image,
                ..question(id.clone(), item, scored, run, &words)
            };
            self.note(&question);
            self.facts.parts.entry(part).or_default().0 += 1;
            rows.push((part, DataSetRow::Question(Box::new(question))));
        }
        self.facts.places.insert(item.place);
        self.facts.ways.insert(scored.configuration.clone());
        if matches!(scored.status, AnswerStatus::Unasked(_)) {
            return Ok(());
        }
        let answer = answer(id, scored, run);
        self.facts.with_tools |= answer.with_tools;
        self.facts.runs.insert(run.id);
        self.facts.parts.entry(part).or_default().1 += 1;
        rows.push((part, DataSetRow::Answer(Box::new(answer))));
        Ok(())
    }

    fn note(&mut self, question: &DataSetQuestion) {
        let facts = &mut self.facts;
        facts.tasks.insert(question.task);
        facts.keys.extend(question.answer_key);
        facts.without_key += usize::from(question.answer_key.is_none());
        facts.with_pictures |= question.image.is_some();
        facts.with_system |= !question.system.is_empty();
    }

    /// A stored picture as a data URI; nothing of what is not there, or that models do not take.
    fn picture(&self, sha256: &str) -> Result<Option<String>, StoreError> {
        let found = self.store.image(sha256)?;
        let usual = ["image/png", "image/jpeg", "image/webp"];
        let found = found.filter(|image| usual.contains(&image.media_type.as_str()));
        Ok(found.map(|image| {
            let base64 = BASE64_STANDARD.encode(&image.bytes);
            format!("data:{};base64,{base64}", image.media_type)
        }))
    }
}

/// The messages of a question.
struct Words<'a> {
    /// The text of the system; empty without one.
    system: &'a str,
    user: &'a Message,
}

impl<'a> Words<'a> {
    /// Those of the system and of the user, where there is nothing else.
    fn of(messages: &'a [Message]) -> Option<Self> {
        let (system, user) = match messages {
            [user] => ("", user),
            [system, user] if system.role == Role::System && system.images.is_empty() => {
                (system.content.as_str(), user)
            }
            _ => return None,
        };
        (user.role == Role::User).then_some(Self { system, user })
    }
}

/// The same for the same question, whoever is asked, on every machine.
fn id(item: &Item, run: &Run) -> String {
    let asked = &item.asked;
    let told = json!([
        asked.scenario,
        asked.scenario_hash,
        asked.task,
        asked.frame,
        asked.techniques,
        asked.lead,
        asked.transform,
        run.question.window,
        run.question.messages,
    ]);
    let digest = Sha256::digest(told.to_string());
    digest[..8]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn question(
    id: String,
    item: &Item,
    scored: &Scored,
    run: &Run,
    words: &Words<'_>,
) -> DataSetQuestion {
    let asked = &item.asked;
    let facts = asked.facts.as_ref();
    let settings = scored.configuration.settings;
    let form = AxisValues {
        form: settings.form,
        stride: settings.stride,
        ..AxisValues::default()
    };
    DataSetQuestion {
        id,
        scenario: asked.scenario.clone(),
        scenario_hash: asked.scenario_hash.clone(),
        task: asked.task,
        frame: asked.frame.clone(),
        techniques: asked.techniques.clone(),
        form: form.to_stored(),
        template: run.question.template.clone(),
        template_hash: run.question.template_hash.clone(),
        lead: asked.lead.clone(),
        transform: asked.transform.clone(),
        window: run.question.window,
        obstacles: facts.map(|facts| facts.obstacles),
        speed: facts.map(|facts| facts.speed),
        nearest: facts.and_then(|facts| facts.nearest),
        ttc: facts.and_then(|facts| facts.ttc),
        answer_key: answer_key(asked.task, &[words.system, &words.user.content]),
        target: word(asked.collides == Some(true)),
        critical_obstacles: scored.critical.clone(),
        system: words.system.into(),
        user: words.user.content.clone(),
        image: None,
    }
}

/// The key that the messages ask yes or no in: that of nearmiss, or that of the paper.
fn answer_key(task: Task, messages: &[&str]) -> Option<&'static str> {
    let paper = (task == Task::Collision).then_some("IsCollisionScenario");
    let mut known = std::iter::once(task.key()).chain(paper);
    known.find(|key| {
        let key = format!("\"{key}\"");
        messages.iter().any(|text| text.contains(&key))
    })
}

/// Yes or no, as JSON has it.
fn word(yes: bool) -> &'static str {
    if yes { "true" } else { "false" }
}

fn answer(question: String, scored: &Scored, run: &Run) -> DataSetAnswer {
    let verdict = scored.status.verdict();
    let sent = serde_json::from_str::<Parameters>(&run.question.parameters);
    DataSetAnswer {
        question,
        model: run.question.model.clone(),
        model_returned: run.ending.model_returned.clone(),
        settings: scored.configuration.settings.to_stored(),
        with_tools: sent.is_ok_and(|sent| sent.tools.is_some()),
        sample: scored.sample,
        state: match scored.status {
            AnswerStatus::Verdict(_) => AnswerState::Answered,
            AnswerStatus::Unparsed(_) => AnswerState::Unparsed,
            AnswerStatus::Failed(_) | AnswerStatus::Unasked(_) => {
                let state = AnswerState::from_run(run);
                match state.counted_as() {
                    CountedAs::Failed => state,
                    _ => AnswerState::Failed,
                }
            }
        },
        verdict: verdict.map(|verdict| word(verdict.dangerous)),
        right: scored.is_right() == Some(true),
        named_obstacles: verdict.map_or_else(Vec::new, |verdict| verdict.danger()),
        probability: verdict.and_then(|verdict| verdict.probability),
        claims: scored.claims,
        consumed: scored.consumed,
        answer: run.answer.clone(),
    }
}
