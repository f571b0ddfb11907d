//! Batches, ratings and scenes as JSON lines of an export or a bundle.

use std::collections::BTreeMap;

use nearmiss_scene::verdict::Verdict;
use rusqlite::params;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::record::RecordError;
use super::{
    Batch, BatchId, Choice, Intake, Item, NewRating, RatedAnswer, Rating, Run, Store, StoreError,
    StoredImage, images,
};
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
            nearmiss_rating: FORM,
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
        if form.nearmiss_rating > FORM {
            return Err(RecordError::Newer(form.nearmiss_rating, FORM));
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
