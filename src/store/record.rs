//! Runs as JSON, one object each, complete and identical when read back; takes in the lines of an export or a bundle.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use nearmiss_base::system::did_you_mean;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{AnswerState, BatchId, Intake, Item, Origin, Record, Run, RunState, Store, StoreError};
use nearmiss_record::{Record as Noun, schema};

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
