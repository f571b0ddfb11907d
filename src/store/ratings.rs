//! Ratings: people's judgements of answers side by side.

use std::collections::{BTreeMap, BTreeSet};

use rusqlite::params;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use super::database::{all_rows, now_ms};
use super::rows::from_row;
use super::{RunId, Store, StoreError, StoredTemplate};
use nearmiss_scene::verdict::Task;

/// A person's choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Choice {
    /// The answer at this place, from 0, is the best.
    Best(usize),
    /// They are equally good.
    Tie,
    /// All of them are wrong.
    #[strum(to_string = "none")]
    AllWrong,
}

impl Choice {
    /// The word for it, in the store and in exports.
    #[must_use]
    pub fn word(self) -> &'static str {
        self.into()
    }
}

/// An answer as it was shown in a rating.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RatedAnswer {
    /// Its run; `None` if it is in none.
    pub run: Option<RunId>,
    /// The model asked, `provider/model`.
    pub model: String,
    /// How it was asked: frame and techniques.
    pub prompt: String,
    /// Whether it was marked as wrong.
    pub wrong: bool,
    /// Why.
    pub reason: Option<String>,
    /// The template that its run was asked with, as the store has it; `None` if it is in none.
    #[serde(flatten)]
    pub template: Option<StoredTemplate>,
}

fn choice_word<S: serde::Serializer>(choice: &Choice, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(choice.word())
}

/// Which one is best stands with the answers.
fn choice<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Choice, D::Error> {
    match String::deserialize(from)?.as_str() {
        "tie" => Ok(Choice::Tie),
        "none" => Ok(Choice::AllWrong),
        "best" => Ok(Choice::Best(0)),
        word => Err(serde::de::Error::custom(format!(
            "choice `{word}` is not known to this version"
        ))),
    }
}

/// A rating before it is stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewRating {
    /// The rater.
    pub person: String,
    /// Name of the scenario.
    pub scenario: String,
    /// The task.
    pub task: Task,
    /// Whether the models were hidden and the order shuffled.
    pub blind: bool,
    /// Seed of the shuffled order.
    pub seed: i64,
    /// What was chosen.
    pub choice: Choice,
    /// What the person wrote.
    pub notes: String,
    /// The answers, in the order in which they were shown.
    pub answers: Vec<RatedAnswer>,
}

/// A rating as it is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Rating {
    /// Number of the rating.
    #[serde(rename = "rating", alias = "id")]
    pub id: i64,
    /// Time of creation, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// Who rated.
    pub person: String,
    /// Name of the scenario.
    pub scenario: String,
    /// The question: collision, safety, recording, attacker or trajectory.
    #[schemars(with = "String")]
    pub task: Task,
    /// Whether the models were hidden and the order shuffled.
    pub blind: bool,
    /// Seed of the shuffled order.
    pub seed: i64,
    /// The choice: best, tie or none.
    #[serde(serialize_with = "choice_word", deserialize_with = "choice")]
    #[schemars(with = "String")]
    pub choice: Choice,
    /// What the person wrote.
    pub notes: String,
    /// The answers, in the order in which they were shown.
    #[serde(default)]
    pub answers: Vec<RatedAnswer>,
}

impl Store {
    /// Keeps a rating; afterwards it is on the disk.
    ///
    /// # Errors
    /// A run does not exist; SQLite refused.
    pub fn rate(&self, rating: &NewRating) -> Result<i64, StoreError> {
        self.rate_at(rating, now_ms())
    }

    /// Keeps a rating that was made at this time, milliseconds since 1970, UTC.
    pub(super) fn rate_at(&self, rating: &NewRating, created_ms: i64) -> Result<i64, StoreError> {
        self.durably(|transaction| {
            transaction.execute(
                "INSERT INTO ratings (created_ms, person, scenario, task, blind, seed, choice, notes)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
                params![
                    created_ms,
                    rating.person,
                    rating.scenario,
                    rating.task.name(),
                    rating.blind,
                    rating.seed,
                    rating.choice.word(),
                    rating.notes,
                ],
            )?;
            let id = transaction.last_insert_rowid();
            answers(transaction, id, rating)?;
            Ok(id)
        })
    }

    /// Keeps a rating in the place of one that the same person made of the same answers; afterwards it is on the disk.
    ///
    /// # Errors
    /// The rating or a run does not exist; SQLite refused. The old rating then stays.
    pub fn rate_anew(&self, id: i64, rating: &NewRating) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let changed = transaction.execute(
                "UPDATE ratings SET created_ms = ?2, choice = ?3, notes = ?4
                 WHERE id = ?1 AND person = ?5 AND scenario = ?6",
                params![
                    id,
                    now_ms(),
                    rating.choice.word(),
                    rating.notes,
                    rating.person,
                    rating.scenario,
                ],
            )?;
            if changed == 0 {
                return Err(StoreError::NoRating(id));
            }
            transaction.execute("DELETE FROM rated WHERE rating = ?1", [id])?;
            answers(transaction, id, rating)
        })
    }

    /// Every rating, the oldest first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn ratings(&self) -> Result<Vec<Rating>, StoreError> {
        let connection = self.lock();
        let sql = "SELECT * FROM ratings ORDER BY created_ms, id";
        let mut ratings: Vec<Rating> = all_rows(&connection, sql, [], from_row)?;
        let mut statement = connection.prepare_cached(
            "SELECT rated.*, template, template_version, template_hash
             FROM rated LEFT JOIN runs ON runs.id = rated.run WHERE rating = ?1 ORDER BY place",
        )?;
        for rating in &mut ratings {
            let answers = statement.query_map([rating.id], |row| {
                Ok((from_row(row)?, row.get::<_, bool>("best")?))
            })?;
            for (place, found) in answers.enumerate() {
                let (answer, best) = found?;
                if best {
                    rating.choice = Choice::Best(place);
                }
                rating.answers.push(answer);
            }
        }
        Ok(ratings)
    }
}

/// What a person has rated and could rate, of one task.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Unrated {
    /// The runs that the person rated.
    pub rated: BTreeSet<RunId>,
    /// Scenarios with at least two complete answers of models that the person did not rate, and how many.
    pub scenarios: BTreeMap<String, u32>,
}

impl Store {
    /// What a person has rated of a task, and where there is something left to rate.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn unrated(&self, task: Task, person: &str, judge: &str) -> Result<Unrated, StoreError> {
        let connection = self.lock();
        let rated = "SELECT run FROM rated JOIN ratings ON ratings.id = rated.rating
             WHERE person = ?1 AND ratings.task = ?2 AND run IS NOT NULL";
        let mut statement = connection.prepare_cached(rated)?;
        let runs = statement.query_map([person, task.name()], |row| row.get(0).map(RunId))?;
        let done = runs.collect::<Result<_, _>>()?;
        let mut statement = connection.prepare_cached(&format!(
            "SELECT scenario, count(*) FROM runs
             WHERE task = ?2 AND state IN ('answered', 'truncated') AND deleted_ms IS NULL AND model <> ?3
                 AND id NOT IN ({rated})
             GROUP BY scenario HAVING count(*) >= 2"
        ))?;
        let left = statement.query_map([person, task.name(), judge], |row| {
            Ok((row.get(0)?, row.get(1)?))
        })?;
        Ok(Unrated {
            rated: done,
            scenarios: left.collect::<Result<_, _>>()?,
        })
    }
}

fn answers(
    transaction: &rusqlite::Transaction<'_>,
    id: i64,
    rating: &NewRating,
) -> Result<(), StoreError> {
    for (place, answer) in rating.answers.iter().enumerate() {
        transaction.execute(
            "INSERT INTO rated (rating, place, run, model, prompt, best, wrong, reason)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
            params![
                id,
                i64::try_from(place).unwrap_or(i64::MAX),
                answer.run.map(|r| r.0),
                answer.model,
                answer.prompt,
                rating.choice == Choice::Best(place),
                answer.wrong,
                answer.reason,
            ],
        )?;
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    pub fn rating(left: Option<RunId>, right: Option<RunId>) -> NewRating {
        let answer = |run, model: &str| RatedAnswer {
            run,
            model: model.into(),
            prompt: "ego · base".into(),
            wrong: false,
            reason: None,
            template: None,
        };
        let mut worse = answer(right, "lab/b");
        worse.wrong = true;
        worse.reason = Some("wrong obstacle: it is 301".into());
        NewRating {
            person: "ada".into(),
            scenario: "ZAM_A-1".into(),
            task: Task::Safety,
            blind: true,
            seed: -7,
            choice: Choice::Best(1),
            notes: "both are short".into(),
            answers: vec![answer(left, "lab/a"), worse],
        }
    }

    #[test]
    fn ratings_come_back_as_they_were() {
        let store = Store::in_memory().unwrap();
        let new = rating(None, None);
        let id = store.rate(&new).unwrap();
        for choice in [Choice::Tie, Choice::AllWrong, Choice::Best(0)] {
            store
                .rate(&NewRating {
                    choice,
                    ..new.clone()
                })
                .unwrap();
        }
        let all = store.ratings().unwrap();
        let choices: Vec<_> = all.iter().map(|r| r.choice).collect();
        assert_eq!(
            choices,
            [
                Choice::Best(1),
                Choice::Tie,
                Choice::AllWrong,
                Choice::Best(0)
            ]
        );
        let first = &all[0];
        assert_eq!(
            (first.id, first.answers.clone(), first.blind),
            (id, new.answers, true)
        );
        assert_eq!(
            (first.person.as_str(), first.seed, first.task),
            ("ada", -7, Task::Safety)
        );
        let record = serde_json::to_value(first.to_record()).unwrap();
        assert_eq!(record["answers"][1]["reason"], "wrong obstacle: it is 301");
        assert_eq!(
            (&record["choice"], &record["best"]),
            (&"best".into(), &1.into())
        );
    }

    #[test]
    fn a_second_rating_takes_the_place_of_the_first() {
        let store = Store::in_memory().unwrap();
        let new = rating(None, None);
        let id = store.rate(&new).unwrap();
        let mut other = new.clone();
        (other.choice, other.answers[0].wrong) = (Choice::Best(0), true);
        store.rate_anew(id, &other).unwrap();
        let all = store.ratings().unwrap();
        assert_eq!(all.len(), 1);
        assert_eq!((all[0].id, all[0].choice), (id, Choice::Best(0)));
        assert_eq!(all[0].answers, other.answers);
        // What cannot be kept leaves the old one whole.
        other.answers[1].run = Some(RunId(5));
        assert!(store.rate_anew(id, &other).is_err());
        other.person = "bob".into();
        other.answers[1].run = None;
        let error = store.rate_anew(id, &other).unwrap_err().to_string();
        assert!(error.contains("no rating 1"), "{error}");
        assert_eq!(store.ratings().unwrap(), all);
    }

    #[test]
    fn a_run_that_is_not_there_cannot_be_rated() {
        let store = Store::in_memory().unwrap();
        assert!(store.rate(&rating(Some(RunId(5)), None)).is_err());
        assert_eq!(store.ratings().unwrap(), [], "nor is half of it kept");
    }
}
