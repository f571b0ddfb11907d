//! Batches as JSON lines of an export: one object a batch, and one for each of its questions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::record::RecordError;
use super::{Batch, BatchId, Item, Run, StoredImage, images};
use nearmiss_record::Record as Noun;

/// The form of these lines.
const FORM: u32 = 1;

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
    /// Reads a line of an export, of this version or an older one.
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
        if form > FORM {
            return Err(RecordError::Newer(form, FORM));
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
            nearmiss_batch: FORM,
            batch: self,
        }
    }
}

impl Item {
    /// The question of a batch as it is exported.
    #[must_use]
    pub fn to_record(&self, batch: BatchId) -> QuestionRecord<'_> {
        QuestionRecord {
            nearmiss_question: FORM,
            batch,
            item: self,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::items::tests::item;
    use super::super::{Intake, ItemState, Store};
    use super::*;

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
}
