//! Runs, batches, ratings and scenes as lines of JSON in an export or a bundle, complete and identical when read back.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use nearmiss_base::system::did_you_mean;
use nearmiss_record::{Record as Noun, schema};
use nearmiss_scene::verdict::Verdict;
use rusqlite::params;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{
    AnswerState, Batch, BatchId, Choice, Intake, Item, NewRating, Origin, RatedAnswer, Rating, Run,
    RunState, Store, StoreError, StoredImage, images,
};

/// Why a line is not a valid run.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// It is not JSON of this form.
    #[error("not a run: {}", without_place(.0))]
    Form(#[from] serde_json::Error),
    /// It has a field that runs do not have.
    #[error("unknown field `{name}`{meant}; the fields are {known}")]
    Field {
        /// The field.
        name: String,
        /// What it probably means, as a question.
        meant: String,
        /// All fields.
        known: String,
    },
    /// A field has a value that no run has.
    #[error("`{0}` has a value that no run has: the line was changed")]
    Value(&'static str),
    /// It was written by a newer program.
    #[error("the line has format {0}, and this version reads up to {1}; update nearmiss")]
    Newer(u32, u32),
    /// The key is not the one of the request.
    #[error("the key does not match the request: the line was changed")]
    Key,
    /// The bytes of an image are not those that its hash names.
    #[error("the image does not match its hash: the line was changed")]
    Image,
    /// The answer is still arriving in another program.
    #[error("the answer was still streaming when it was exported")]
    Running,
}

impl RecordError {
    /// The column of the mistake in its line, from 1, where the text is not JSON of this form.
    #[must_use]
    pub fn column(&self) -> Option<usize> {
        match self {
            Self::Form(error) if error.line() > 0 => Some(error.column().max(1)),
            _ => None,
        }
    }
}

/// What is wrong, without the place: that counts lines from the beginning of the record, not of its file.
fn without_place(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rsplit_once(" at line ") {
        Some((what, _)) => what.into(),
        None => text,
    }
}

/// A record as a line of an export.
///
/// # Errors
/// It cannot be JSON.
pub fn record_line(record: &impl Noun) -> Result<String, StoreError> {
    Ok(nearmiss_record::json_line(record)?)
}

/// The form of the records.
const FORM: u32 = 5;

/// The fields of a record that are kept.
static FIELDS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let schema = schema::<Run>();
    let fields = schema.get("properties").and_then(Value::as_object);
    fields
        .into_iter()
        .flatten()
        .map(|(name, _)| name.clone())
        .collect()
});

/// A run as it is shown and exported.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RunRecord<'r> {
    /// Marks a run, with the version of its format.
    pub nearmiss_run: u32,
    /// The run.
    #[serde(flatten)]
    pub run: &'r Run,
    /// What the answer counts as: answered, unparsed, truncated, filtered, failed, cancelled, interrupted, waiting or
    /// superseded.
    pub answer_state: AnswerState,
    /// The decision of the verdict: true for a collision, a critical window or a recording of high risk; null without
    /// a yes or no.
    pub dangerous: Option<bool>,
    /// The justification of the verdict.
    pub justification: Option<&'r str>,
    /// The probability of yes that the answer states.
    pub probability: Option<f64>,
    /// The probability of yes by the log probabilities of the deciding token.
    pub token_probability: Option<f64>,
}

impl Noun for RunRecord<'_> {
    const NAME: &'static str = "run";
    const TITLE: &'static str = "`runs show --format json`, `runs export`: one run";
}

impl RunRecord<'_> {
    /// What records say of a run beside what is kept of it; and the length of the answer, which they did before.
    const DERIVED: [&'static str; 8] = [
        "schema_version",
        "nearmiss_run",
        "seconds",
        "answer_state",
        "dangerous",
        "probability",
        "token_probability",
        "justification",
    ];
}

impl Run {
    /// The run as it is exported; `superseded` if another run counts in its place.
    #[must_use]
    pub fn to_record(&self, superseded: bool) -> RunRecord<'_> {
        let said = self.ending.verdict.as_ref();
        let verdict = said.and_then(|said| said.verdict());
        RunRecord {
            nearmiss_run: FORM,
            run: self,
            answer_state: if superseded {
                AnswerState::Superseded
            } else {
                AnswerState::from_run(self)
            },
            dangerous: verdict.map(|verdict| verdict.dangerous),
            probability: verdict.and_then(|verdict| verdict.probability),
            token_probability: verdict.and_then(|verdict| verdict.token_probability),
            justification: said.map(|said| said.justification()),
        }
    }

    /// A run from a line that [`Run::to_record`] wrote, in this store or another. A run asked elsewhere counts as
    /// replayed here, and keeps the number of the other store.
    ///
    /// # Errors
    /// The line is not a run, or was altered.
    pub fn from_record(line: &str) -> Result<Self, RecordError> {
        #[derive(Deserialize)]
        #[serde(expecting = "a JSON object with nearmiss_run")]
        struct Form {
            nearmiss_run: u32,
        }
        let form: Form = serde_json::from_str(line)?;
        if form.nearmiss_run > FORM {
            return Err(RecordError::Newer(form.nearmiss_run, FORM));
        }
        let mut record: Map<String, Value> = serde_json::from_str(line)?;
        for name in RunRecord::DERIVED {
            record.remove(name);
        }
        // Form 4 has the number twice.
        if let Some(id) = record.remove("id") {
            record.entry("run").or_insert(id);
        }
        if let Some(name) = record.keys().find(|name| !FIELDS.contains(name)) {
            return Err(RecordError::Field {
                meant: did_you_mean(name, FIELDS.iter().map(String::as_str)),
                name: name.clone(),
                known: FIELDS.join(", "),
            });
        }
        let has_key = record.get("key").is_some_and(Value::is_string);
        let mut run = Self::deserialize(Value::Object(record))?.with_verdict();
        if run.origin == Origin::Asked {
            run.origin = Origin::Replayed;
        }
        if run.ending.state == RunState::Running {
            return Err(RecordError::Running);
        }
        let is_cost = |usd: f64| (0.0..=1e9).contains(&usd);
        // The year 9999 ends then.
        let is_time = |ms: i64| (0..=253_402_300_799_999).contains(&ms);
        let is_window = |(first, last): (i64, i64)| first <= last;
        let checks = [
            ("cost_usd", run.ending.consumed.cost_usd.is_none_or(is_cost)),
            ("created_ms", is_time(run.created_ms)),
            ("window", run.question.window.is_none_or(is_window)),
        ];
        if let Some((field, _)) = checks.iter().find(|(_, holds)| !holds) {
            return Err(RecordError::Value(field));
        }
        // The key of a recorded answer is made of more than the request, which is not known.
        let own = run.question.key();
        let fits = match run.origin {
            Origin::Recorded => own.is_none(),
            _ => own == run.key,
        };
        if fits && has_key == run.key.is_some() {
            Ok(run)
        } else {
            Err(RecordError::Key)
        }
    }
}

/// Runs, and bytes of lines, that are added in one transaction.
const TRANSACTION_SIZE: (usize, usize) = (200, 16 << 20);

/// What is being taken in; questions wait for the end, as they name runs.
pub struct RecordIntake<'a> {
    /// Where batches, runs and questions go.
    pub intake: Intake<'a>,
    runs: Vec<Run>,
    bytes: usize,
    questions: BTreeMap<BatchId, Vec<Item>>,
}

impl<'a> RecordIntake<'a> {
    /// Nothing so far.
    #[must_use]
    pub fn new(store: &'a Store) -> Self {
        Self {
            intake: Intake::new(store),
            runs: Vec::new(),
            bytes: 0,
            questions: BTreeMap::new(),
        }
    }

    /// Takes in the record of a line of so many bytes.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn take(&mut self, record: Record, bytes: usize) -> Result<(), StoreError> {
        match record {
            Record::Batch(batch) => self.intake.batch(&batch),
            Record::Question(batch, item) => {
                self.questions.entry(batch).or_default().push(*item);
                Ok(())
            }
            Record::Image(image) => self.intake.image(&image),
            Record::Run(run) => {
                self.runs.push(*run);
                self.bytes += bytes;
                if self.runs.len() >= TRANSACTION_SIZE.0 || self.bytes >= TRANSACTION_SIZE.1 {
                    self.add()
                } else {
                    Ok(())
                }
            }
        }
    }

    /// Takes in what is left, and the questions.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn finish(mut self) -> Result<Intake<'a>, StoreError> {
        self.add()?;
        for (batch, items) in &self.questions {
            self.intake.items(*batch, items)?;
        }
        Ok(self.intake)
    }

    fn add(&mut self) -> Result<(), StoreError> {
        self.bytes = 0;
        self.intake.runs(std::mem::take(&mut self.runs))
    }
}

/// The form of these lines.
const BATCH_FORM: u32 = 1;

/// A line of an export.
#[derive(Debug, Clone, PartialEq)]
pub enum Record {
    /// A run.
    Run(Box<Run>),
    /// A batch, without its questions.
    Batch(Box<Batch>),
    /// A question of a batch.
    Question(BatchId, Box<Item>),
    /// An image that questions show.
    Image(Box<StoredImage>),
}

/// A batch as it is exported.
#[derive(Debug, Serialize, JsonSchema)]
pub struct BatchRecord<'b> {
    /// Marks a batch, with the version of its format.
    nearmiss_batch: u32,
    /// The batch.
    #[serde(flatten)]
    batch: &'b Batch,
}

impl Noun for BatchRecord<'_> {
    const NAME: &'static str = "batch";
    const TITLE: &'static str = "`runs export`: one batch";
}

/// A question of a batch as it is exported.
#[derive(Debug, Serialize, JsonSchema)]
pub struct QuestionRecord<'q> {
    /// Marks a question of a batch, with the version of its format.
    nearmiss_question: u32,
    /// Name of the batch, such as b7.
    batch: BatchId,
    /// The question.
    #[serde(flatten)]
    item: &'q Item,
}

impl Noun for QuestionRecord<'_> {
    const NAME: &'static str = "question";
    const TITLE: &'static str = "`runs export`: one question of a batch";
}

impl Record {
    /// Reads a line of an export.
    ///
    /// # Errors
    /// The line is none, or was altered.
    pub fn from_line(line: &str) -> Result<Self, RecordError> {
        #[derive(Deserialize)]
        #[serde(expecting = "a JSON object with nearmiss_run, nearmiss_batch or nearmiss_question")]
        struct Kind {
            nearmiss_batch: Option<u32>,
            nearmiss_question: Option<u32>,
            nearmiss_image: Option<u32>,
        }
        let kind: Kind = serde_json::from_str(line)?;
        if let Some(form) = kind.nearmiss_image {
            return if form > images::FORM {
                Err(RecordError::Newer(form, images::FORM))
            } else {
                StoredImage::from_record(line).map(|one| Self::Image(Box::new(one)))
            };
        }
        let Some(form) = kind.nearmiss_batch.or(kind.nearmiss_question) else {
            return Run::from_record(line).map(|run| Self::Run(Box::new(run)));
        };
        if form > BATCH_FORM {
            return Err(RecordError::Newer(form, BATCH_FORM));
        }
        if kind.nearmiss_batch.is_some() {
            return Ok(Self::Batch(serde_json::from_str(line)?));
        }
        let mut record: Map<String, Value> = serde_json::from_str(line)?;
        let batch = BatchId::deserialize(record.remove("batch").unwrap_or_default())?;
        // The database has both: where the question stood last, and where it stands now.
        if let Some(state) = record.remove("state") {
            record.insert("now".into(), state);
        }
        let item = Item::deserialize(Value::Object(record))?;
        Ok(Self::Question(batch, Box::new(item.with_reason())))
    }
}

impl Batch {
    /// The batch as it is exported.
    #[must_use]
    pub fn to_record(&self) -> BatchRecord<'_> {
        BatchRecord {
            nearmiss_batch: BATCH_FORM,
            batch: self,
        }
    }
}

impl Item {
    /// The question of a batch as it is exported.
    #[must_use]
    pub fn to_record(&self, batch: BatchId) -> QuestionRecord<'_> {
        QuestionRecord {
            nearmiss_question: BATCH_FORM,
            batch,
            item: self,
        }
    }
}

/// A rating as it is exported.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RatingRecord<'r> {
    /// Marks a rating, with the version of its format.
    nearmiss_rating: u32,
    /// The rating.
    #[serde(flatten)]
    rating: &'r Rating,
    /// Position of the best answer, from 0; null if none is.
    best: Option<usize>,
}

impl Noun for RatingRecord<'_> {
    const NAME: &'static str = "rating";
    const TITLE: &'static str = "`runs ratings export`: one rating a line";
}

impl Rating {
    /// The rating as it is exported.
    #[must_use]
    pub fn to_record(&self) -> RatingRecord<'_> {
        RatingRecord {
            nearmiss_rating: BATCH_FORM,
            rating: self,
            best: match self.choice {
                Choice::Best(place) => Some(place),
                Choice::Tie | Choice::AllWrong => None,
            },
        }
    }

    /// A rating from a line that [`Rating::to_record`] wrote.
    ///
    /// # Errors
    /// The line is no rating, or one of a later version.
    pub fn from_record(line: &str) -> Result<Self, RecordError> {
        #[derive(Deserialize)]
        #[serde(expecting = "a JSON object with nearmiss_rating")]
        struct Form {
            nearmiss_rating: u32,
            best: Option<usize>,
        }
        let form: Form = serde_json::from_str(line)?;
        if form.nearmiss_rating > BATCH_FORM {
            return Err(RecordError::Newer(form.nearmiss_rating, BATCH_FORM));
        }
        let mut rating: Self = serde_json::from_str(line)?;
        if let (Choice::Best(_), Some(place)) = (rating.choice, form.best) {
            rating.choice = Choice::Best(place);
        }
        Ok(rating)
    }
}

impl Store {
    /// Takes in a rating of another store, whose runs were taken in before, unless it is here already; says whether it
    /// is new.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn take_rating(&self, rating: Rating, runs: &Intake<'_>) -> Result<bool, StoreError> {
        let new = NewRating {
            person: rating.person,
            scenario: rating.scenario,
            task: rating.task,
            blind: rating.blind,
            seed: rating.seed,
            choice: rating.choice,
            notes: rating.notes,
            answers: rating
                .answers
                .into_iter()
                .map(|answer| RatedAnswer {
                    run: answer.run.and_then(|run| runs.run(run)),
                    ..answer
                })
                .collect(),
        };
        let known: bool = self.lock().query_row(
            "SELECT EXISTS (SELECT 1 FROM ratings
                 WHERE created_ms = ?1 AND person = ?2 AND scenario = ?3 AND task = ?4 AND seed = ?5)",
            params![
                rating.created_ms,
                new.person,
                new.scenario,
                new.task.name(),
                new.seed
            ],
            |row| row.get(0),
        )?;
        if !known {
            self.rate_at(&new, rating.created_ms)?;
        }
        Ok(!known)
    }
}

/// What was read off the scenario of a question where its batch was packed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SceneRecord {
    /// The built-in judge's verdict; `None` if it was not needed or could not be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Verdict>,
    /// Why the built-in judge could not be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unjudged: Option<String>,
    /// From the ids of renumbered obstacles to those in the file; empty if nothing was renumbered.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ids: BTreeMap<i64, i64>,
}

impl SceneRecord {
    /// The verdict of the built-in judge, or why there is none; `None` if nothing is recorded of it.
    #[must_use]
    pub fn judgement(&self) -> Option<Result<Verdict, String>> {
        match (&self.reference, &self.unjudged) {
            (Some(verdict), _) => Some(Ok(verdict.clone())),
            (None, Some(why)) => Some(Err(why.clone())),
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::{Intake, ItemState, Store};
    use super::*;
    use crate::items::tests::item;
    use crate::ratings::tests::rating;

    fn line(record: &impl Serialize) -> String {
        nearmiss_record::json_line(record).unwrap()
    }

    #[test]
    fn a_batch_comes_back_from_its_lines() {
        let store = Store::in_memory().unwrap();
        let mut known = item("B", 1);
        (known.collides, known.obstacle) = (Some(true), Some(7));
        let mut unaskable = item("C", 0);
        unaskable.unaskable = Some("no ego".into());
        let asked = [item("A", 0), known, unaskable];
        let batch = store.begin_batch("{\"z\":1,\"a\":0.25}", Some("1/2"), &asked);
        let id = batch.unwrap();
        let failed = ItemState::Failed;
        store
            .set_item(id, 0, None, failed, None, Some("429"))
            .unwrap();
        store.record_look(id, Default::default()).unwrap();
        let (batch, items) = (store.batch(id).unwrap().unwrap(), store.items(id).unwrap());
        assert_eq!(batch.looks.len(), 1);
        let there = Store::in_memory().unwrap();
        let mut intake = Intake::new(&there);
        let Record::Batch(read) = Record::from_line(&line(&batch.to_record())).unwrap() else {
            panic!("no batch");
        };
        assert_eq!(*read, batch);
        intake.batch(&read).unwrap();
        let mut read = Vec::new();
        for item in &items {
            let line = line(&item.to_record(id));
            let Record::Question(of, item) = Record::from_line(&line).unwrap() else {
                panic!("no question");
            };
            assert_eq!(of, id);
            read.push(*item);
        }
        assert_eq!(read, items);
        intake.items(id, &read).unwrap();
        assert_eq!(there.items(id).unwrap(), items);
        assert_eq!(there.looks(id).unwrap(), batch.looks);
        let newer = "{\"nearmiss_batch\":9,\"batch\":\"b1\"}";
        let error = Record::from_line(newer).unwrap_err().to_string();
        assert!(error.contains("update nearmiss"), "{error}");
        assert!(Record::from_line("{\"nearmiss_question\":1}").is_err());
    }

    #[test]
    fn a_rating_comes_back_from_its_line_and_is_taken_in_once() {
        let (here, there) = (Store::in_memory().unwrap(), Store::in_memory().unwrap());
        there.rate(&rating(None, None)).unwrap();
        let first = there.ratings().unwrap().remove(0);
        let line = nearmiss_record::json_line(&first.to_record()).unwrap();
        let read = Rating::from_record(&line).unwrap();
        assert_eq!(read, first);
        let intake = Intake::new(&here);
        assert!(here.take_rating(read.clone(), &intake).unwrap());
        assert!(!here.take_rating(read, &intake).unwrap());
        let ours = here.ratings().unwrap();
        assert_eq!((ours.len(), ours[0].created_ms), (1, first.created_ms));
        assert_eq!(
            (ours[0].choice, &ours[0].answers),
            (first.choice, &first.answers)
        );
        let later = line.replace("\"nearmiss_rating\":1", "\"nearmiss_rating\":2");
        assert!(Rating::from_record(&later).is_err());
    }
}
