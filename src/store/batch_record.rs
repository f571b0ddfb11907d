//! Batches as JSON lines of an export: one object a batch, and one for each of its questions.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::record::RecordError;
use super::{Batch, BatchId, Item, Run, StoredImage, images};

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
        let mut record: Map<String, Value> = serde_json::from_str(line)?;
        let batch = record.remove("batch").unwrap_or_default();
        let id: BatchId = batch
            .as_str()
            .and_then(|name| name.parse().ok())
            .ok_or_else(|| RecordError::Word {
                field: "batch",
                word: batch.to_string(),
            })?;
        if kind.nearmiss_batch.is_some() {
            if let Some(spec) = record.get_mut("spec").filter(|spec| !spec.is_string()) {
                *spec = spec.to_string().into();
            }
            record.insert("id".into(), json!(id.0));
            let batch = Batch::deserialize(Value::Object(record))?;
            return Ok(Self::Batch(Box::new(batch)));
        }
        if let Some(state) = record.remove("state") {
            record.insert("now".into(), state);
        }
        let item = Item::deserialize(Value::Object(record))?;
        Ok(Self::Question(id, Box::new(item.with_reason())))
    }
}

impl Batch {
    /// The batch as one JSON object; `nearmiss_batch` says that this is one, and in which form.
    #[must_use]
    pub fn to_record(&self) -> Value {
        // What would not come back letter by letter stays text: stores find the same batch by it.
        let spec = serde_json::from_str::<Value>(&self.spec);
        let same = |spec: &Value| serde_json::to_string(spec).is_ok_and(|text| text == self.spec);
        let spec = spec.ok().filter(same);
        let mut record = json!({
            "nearmiss_batch": FORM,
            "batch": self.id.to_string(),
            "created_ms": self.created_ms,
            "updated_ms": self.updated_ms,
            "shard": self.shard,
            "spec": spec.unwrap_or_else(|| self.spec.clone().into()),
        });
        if !self.looks.is_empty() {
            record["looks"] = json!(self.looks);
        }
        record
    }
}

impl Item {
    /// The question of a batch as one JSON object; `nearmiss_question` says that this is one, and in which form.
    #[must_use]
    pub fn to_record(&self, batch: BatchId) -> Value {
        let mut record = Map::from_iter([
            ("nearmiss_question".to_string(), FORM.into()),
            ("batch".to_string(), batch.to_string().into()),
        ]);
        if let Ok(Value::Object(fields)) = serde_json::to_value(self) {
            let renamed = |name: String| match name.as_str() {
                "now" => "state".to_string(),
                _ => name,
            };
            record.extend(
                fields
                    .into_iter()
                    .map(|(name, value)| (renamed(name), value)),
            );
        }
        Value::Object(record)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::items::tests::item;
    use super::super::{Intake, ItemState, Store};
    use super::*;

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
        let Record::Batch(read) = Record::from_line(&batch.to_record().to_string()).unwrap() else {
            panic!("no batch");
        };
        assert_eq!(*read, batch);
        intake.batch(&read).unwrap();
        let mut read = Vec::new();
        for item in &items {
            let line = item.to_record(id).to_string();
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
