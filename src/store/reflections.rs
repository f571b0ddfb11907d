//! Requests for better templates and their answers: stored before they are used, found again by the same request.

use rusqlite::{OptionalExtension, params};

use super::database::now_ms;
use super::{Consumed, Key, Store, StoreError};

/// The number of a stored reflection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReflectionId(pub i64);

/// A request that is about to be sent.
#[derive(Debug, Clone, PartialEq)]
pub struct NewReflection {
    /// Identifies the request.
    pub key: Key,
    /// Which of several answers to it, from 0.
    pub sample: u32,
    /// `provider/model`.
    pub model: String,
    /// Messages and parameters, as JSON.
    pub request: String,
    /// What it can cost at most, US dollars, where that is known.
    pub most_usd: Option<f64>,
}

/// An answer to such a request.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reflection {
    /// Its text.
    pub answer: String,
    /// Why the server ended it.
    pub finish: String,
    /// Its consumption.
    pub consumed: Consumed,
}

impl Store {
    /// The answer to a request, the newest of several.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn reflection(&self, key: &Key, sample: u32) -> Result<Option<Reflection>, StoreError> {
        let connection = self.lock();
        let sql = "SELECT answer, coalesce(finish, ''), input_tokens, output_tokens, cost_usd FROM reflections
            WHERE key = ?1 AND sample = ?2 AND answer IS NOT NULL ORDER BY id DESC LIMIT 1";
        let found = connection
            .prepare_cached(sql)?
            .query_row(params![key.as_str(), sample], |row| {
                Ok(Reflection {
                    answer: row.get(0)?,
                    finish: row.get(1)?,
                    consumed: Consumed {
                        input_tokens: row.get::<_, Option<i64>>(2)?.map(i64::unsigned_abs),
                        output_tokens: row.get::<_, Option<i64>>(3)?.map(i64::unsigned_abs),
                        cost_usd: row.get(4)?,
                        ..Consumed::default()
                    },
                })
            })
            .optional()?;
        Ok(found)
    }

    /// Keeps a request before it is sent; afterwards it is on the disk.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn begin_reflection(&self, new: &NewReflection) -> Result<ReflectionId, StoreError> {
        self.durably(|transaction| {
            let sql = "INSERT INTO reflections (key, sample, created_ms, model, request, most_usd)
                VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
            let values = params![
                new.key.as_str(),
                new.sample,
                now_ms(),
                new.model,
                new.request,
                new.most_usd
            ];
            transaction.prepare_cached(sql)?.execute(values)?;
            Ok(ReflectionId(transaction.last_insert_rowid()))
        })
    }

    /// Keeps the answer to it; afterwards it is on the disk.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn finish_reflection(
        &self,
        id: ReflectionId,
        reflection: &Reflection,
    ) -> Result<(), StoreError> {
        let Reflection {
            answer,
            finish,
            consumed,
        } = reflection;
        let tokens =
            |count: Option<u64>| count.map(|count| i64::try_from(count).unwrap_or(i64::MAX));
        self.durably(|transaction| {
            let sql = "UPDATE reflections SET answer = ?2, finish = ?3, input_tokens = ?4, output_tokens = ?5,
                cost_usd = ?6 WHERE id = ?1";
            let values = params![
                id.0,
                answer,
                finish,
                tokens(consumed.input_tokens),
                tokens(consumed.output_tokens),
                consumed.cost_usd
            ];
            transaction.prepare_cached(sql)?.execute(values)?;
            Ok(())
        })
    }

    /// Writes down why a request has no answer, and what it can have cost.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn fail_reflection(
        &self,
        id: ReflectionId,
        error: &str,
        was_sent: bool,
    ) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let sql = "UPDATE reflections SET error = ?2, most_usd = CASE WHEN ?3 THEN most_usd ELSE 0 END WHERE id = ?1";
            transaction
                .prepare_cached(sql)?
                .execute(params![id.0, error, was_sent])?;
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_answer_is_found_by_request_and_sample() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(&folder.path().join("runs.sqlite")).unwrap();
        let key = Key::digest(&serde_json::json!({ "a": 1 }));
        let new = NewReflection {
            key: key.clone(),
            sample: 1,
            model: "lab/tiny".into(),
            request: "{}".into(),
            most_usd: Some(0.5),
        };
        let (first, second) = (
            store.begin_reflection(&new).unwrap(),
            store.begin_reflection(&new).unwrap(),
        );
        assert_eq!(store.reflection(&key, 1).unwrap(), None);
        store.fail_reflection(first, "gone", true).unwrap();
        let answer = Reflection {
            answer: "text".into(),
            finish: "stop".into(),
            consumed: Consumed {
                input_tokens: Some(10),
                output_tokens: Some(3),
                cost_usd: Some(0.25),
                ..Consumed::default()
            },
        };
        store.finish_reflection(second, &answer).unwrap();
        assert_eq!(store.reflection(&key, 1).unwrap(), Some(answer));
        assert_eq!(store.reflection(&key, 0).unwrap(), None);
    }
}
