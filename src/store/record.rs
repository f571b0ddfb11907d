//! Runs as JSON, one object each, complete and identical when read back; takes in the lines of an export or a bundle.

use std::collections::BTreeMap;

use nearmiss_base::system::did_you_mean;
use nearmiss_scene::verdict::Task;
use serde::Deserialize;
use serde_json::{Map, Value};

use super::{BatchId, Intake, Item, Origin, Record, Run, RunState, Store, StoreError};

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
    /// It was written by a newer program.
    #[error("the line has format {0}, and this version reads up to {1}; update nearmiss")]
    Newer(u32, u32),
    /// A word that is not known.
    #[error("unknown {field} `{word}`")]
    Word {
        /// Which field.
        field: &'static str,
        /// The word.
        word: String,
    },
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

/// The form of the records.
const FORM: u32 = 4;

/// The fields of a record behind `nearmiss_run`, in the order of the columns of `runs`.
const FIELDS: &str = "id key sample batch origin source created_ms updated_ms scenario scenario_hash ego task frame \
    techniques window model model_returned provider dialect endpoint address template template_version template_hash \
    messages parameters answer_schema state answer reasoning finish verdict reading error input_tokens output_tokens \
    reasoning_tokens cached_tokens cost_usd most_usd price_source first_chunk_ms duration_ms claims_right claims_wrong \
    claims_open claims_check notes pinned deleted_ms";

/// Those that are JSON inside JSON, and text in the store.
const DOCUMENTS: [&str; 5] = [
    "messages",
    "parameters",
    "answer_schema",
    "verdict",
    TOOL_ROUNDS,
];

/// A field of runs whose model called tools alone, so that other records stay as earlier versions read them.
const TOOL_ROUNDS: &str = "tool_rounds";

impl Run {
    /// The run as one JSON object; `nearmiss_run` says that this is one, and in which form.
    #[must_use]
    pub fn to_record(&self) -> Value {
        let mut fields = serde_json::to_value(self).unwrap_or_default();
        for name in DOCUMENTS {
            // Text that is no JSON stays text, and so comes back as it was.
            let document = fields[name].as_str().map(serde_json::from_str);
            if let Some(Ok(document)) = document {
                fields[name] = document;
            }
        }
        let seconds = fields["duration_ms"].as_f64().map(|ms| ms / 1e3);
        let mut record = Map::from_iter([
            ("nearmiss_run".to_string(), FORM.into()),
            ("run".to_string(), fields["id"].clone()),
            ("seconds".to_string(), seconds.into()),
        ]);
        record.extend(
            FIELDS
                .split(' ')
                .map(|name| (name.to_string(), fields[name].take())),
        );
        if fields[TOOL_ROUNDS].is_array() {
            record.insert(TOOL_ROUNDS.to_string(), fields[TOOL_ROUNDS].take());
        }
        Value::Object(record)
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
        for name in ["schema_version", "nearmiss_run", "seconds", "answer_state"] {
            record.remove(name);
        }
        // What a later version may have as the only name of the number.
        if let Some(run) = record.remove("run") {
            record.entry("id").or_insert(run);
        }
        let known = |name: &str| {
            let mut fields = FIELDS.split_whitespace().chain([TOOL_ROUNDS]);
            fields.any(|field| field == name)
        };
        if let Some(name) = record.keys().find(|name| !known(name)) {
            return Err(RecordError::Field {
                meant: did_you_mean(name, FIELDS.split_whitespace()),
                name: name.clone(),
                known: FIELDS.split_whitespace().collect::<Vec<_>>().join(", "),
            });
        }
        check_word(&record, "origin", |word| Origin::parse(word).is_some())?;
        check_word(&record, "state", |word| RunState::parse(word).is_some())?;
        check_word(&record, "task", |word| Task::parse(word).is_some())?;
        let has_key = record.get("key").is_some_and(Value::is_string);
        for name in DOCUMENTS {
            match record.get_mut(name) {
                None | Some(Value::Null) => {}
                Some(Value::String(_)) if name != "verdict" => {}
                Some(document) => *document = document.to_string().into(),
            }
        }
        let mut run = Self::deserialize(Value::Object(record))?.with_verdict();
        if run.origin == Origin::Asked {
            run.origin = Origin::Replayed;
        }
        if run.ending.state == RunState::Running {
            return Err(RecordError::Running);
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

fn check_word(
    record: &Map<String, Value>,
    field: &'static str,
    is_known: impl FnOnce(&str) -> bool,
) -> Result<(), RecordError> {
    match record.get(field).and_then(Value::as_str) {
        Some(word) if !is_known(word) => Err(RecordError::Word {
            field,
            word: word.to_string(),
        }),
        _ => Ok(()),
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
