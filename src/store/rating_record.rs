//! Ratings as JSON lines of a bundle: read back, and taken in once.

use rusqlite::params;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Choice, Intake, NewRating, RatedAnswer, Rating, RecordError, Store, StoreError};
use nearmiss_record::Record;

/// The form of these lines.
const FORM: u32 = 1;

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

impl Record for RatingRecord<'_> {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::ratings::tests::rating;
    use super::*;

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
