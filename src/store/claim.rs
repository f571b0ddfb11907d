//! Claims: the first run to ask a question, known by the hash of its canonical JSON, asks it alone; others receive its answer.

use std::time::Duration;

use rusqlite::{Connection, OptionalExtension, Transaction, params};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::database::{all_rows, now_ms};
use super::list::MOST_SHOWN;
use super::{NewRun, Run, RunId, RunState, Store, StoreError, rows, run};

/// How long a claim holds unless it is renewed. A program that is killed leaves its claims to expire.
pub const LEASE: Duration = Duration::from_secs(6);

/// How often a claim is renewed while an answer arrives.
pub const RENEWAL: Duration = Duration::from_millis(1500);

/// Result of claiming a question.
#[derive(Debug, Clone, PartialEq)]
pub enum Claim {
    /// Ask it under this run id; no other run asks it meanwhile.
    Granted(RunId),
    /// It was answered before.
    Stored(Box<Run>),
    /// Another run is asking it.
    Taken(RunId),
}

impl Store {
    /// Looks up an answer to the same request; if there is none and no run is asking for one, records that it is about
    /// to be asked. With `fresh` it is asked in any case.
    ///
    /// Answers that were cut off, failed, cancelled, interrupted or deleted do not count. Of several, the last to enter
    /// the store counts, as clocks may have been set meanwhile.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn claim(&self, run: &NewRun, fresh: bool) -> Result<Claim, StoreError> {
        let key = run.key().filter(|_| !fresh);
        self.change(|transaction| {
            if let Some(key) = &key {
                interrupt_abandoned(transaction)?;
                if let Some(there) = there(transaction, key, run.sample)? {
                    return Ok(there);
                }
            }
            let id = run::insert_new(transaction, run, now_ms())?;
            hold(transaction, id)?;
            Ok(Claim::Granted(id))
        })
    }

    /// The whole answer to the same request that the store has, as [`Store::claim`] finds it; claims nothing.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn answer_to(&self, run: &NewRun) -> Result<Option<Run>, StoreError> {
        match run.key() {
            Some(key) => answered(&self.lock(), key.as_str(), run.sample),
            None => Ok(None),
        }
    }

    /// The newest answer to a request that ran into the limit of tokens, where there is no whole one: asked again, it would
    /// most likely do so again.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn answer_at_limit(&self, key: &Key, sample: u32) -> Result<Option<Run>, StoreError> {
        let connection = self.lock();
        if answered(&connection, key.as_str(), sample)?.is_some() {
            return Ok(None);
        }
        let mut statement = connection.prepare_cached(
            "SELECT * FROM runs WHERE key = ?1 AND sample = ?2 AND state = 'truncated' AND finish = 'length'
                 AND deleted_ms IS NULL ORDER BY id DESC LIMIT 1",
        )?;
        Ok(statement
            .query_row(params![key.as_str(), sample], |row| {
                rows::shown(row, MOST_SHOWN)
            })
            .optional()?)
    }

    /// The newest run with these texts, reasoning and answer, as its whole answer to the same question, asked the same way under the same
    /// parameters: for judges that are sent no request, which therefore has no key.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn same_answer(
        &self,
        run: &NewRun,
        (reasoning, answer): (&str, &str),
    ) -> Result<Option<Run>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT * FROM runs WHERE scenario_hash IS ?1 AND task = ?2 AND model = ?3 AND scenario = ?4 AND ego = ?5
                 AND frame = ?6 AND techniques = ?7 AND window_first IS ?8 AND window_last IS ?9 AND parameters = ?10
                 AND sample = ?11 AND reasoning = ?12 AND answer = ?13 AND state = 'answered' AND deleted_ms IS NULL
             ORDER BY id DESC LIMIT 1",
        )?;
        let (first, last) = run.window.unzip();
        let found = statement.query_row(
            params![
                run.scenario_hash,
                run.task.name(),
                run.model,
                run.scenario,
                run.ego,
                run.frame,
                run.techniques,
                first,
                last,
                run.parameters,
                run.sample,
                reasoning,
                answer
            ],
            |row| rows::shown(row, MOST_SHOWN),
        );
        Ok(found.optional()?)
    }

    /// The newest imported answer of a recorded model to the same question: about the same scenario and steps, to the
    /// same task, in the same frame, with the same techniques. Of imported answers whose scenario file was not there,
    /// its name decides; their steps are not known.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn recorded_answer(&self, run: &NewRun) -> Result<Option<Run>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT * FROM runs WHERE model = ?1 AND task = ?2 AND frame = ?3 AND techniques = ?4 AND sample = ?5
                 AND (scenario_hash = ?6 OR (scenario_hash IS NULL AND scenario = ?7))
                 AND (window_first IS NULL OR (window_first IS ?8 AND window_last IS ?9))
                 AND origin = 'recorded' AND state = 'answered' AND deleted_ms IS NULL
             ORDER BY scenario_hash IS NULL, id DESC LIMIT 1",
        )?;
        let (first, last) = run.window.unzip();
        let found = statement.query_row(
            params![
                run.model,
                run.task.name(),
                run.frame,
                run.techniques,
                run.sample,
                run.scenario_hash,
                run.scenario,
                first,
                last,
            ],
            |row| rows::shown(row, MOST_SHOWN),
        );
        Ok(found.optional()?)
    }

    /// Renews the claim on a run whose answer is arriving.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn renew(&self, run: RunId) -> Result<(), StoreError> {
        self.change(|transaction| renew(transaction, run))
    }

    /// Marks what was running in programs that have ended. Their pieces are kept as the answer so far.
    pub(super) fn interrupt_abandoned(&self) -> Result<(), StoreError> {
        // Reading needs no lock, and mostly there is nothing to do.
        let nothing = {
            let connection = self.lock();
            abandoned(&connection)?.is_empty() && !any_too_long(&connection)?
        };
        if nothing {
            return Ok(());
        }
        self.change(interrupt_abandoned)
    }
}

/// The answer to a request, or the run that is asking for one; `None` without either.
pub(super) fn there(
    transaction: &Transaction<'_>,
    key: &Key,
    sample: u32,
) -> Result<Option<Claim>, StoreError> {
    if let Some(found) = answered(transaction, key.as_str(), sample)? {
        return Ok(Some(Claim::Stored(Box::new(found))));
    }
    let asking = "SELECT id FROM runs WHERE key = ?1 AND sample = ?2 AND state = 'running'
        AND deleted_ms IS NULL ORDER BY id LIMIT 1";
    let found = transaction
        .query_row(asking, params![key.as_str(), sample], |row| row.get(0))
        .optional()?;
    Ok(found.map(|id| Claim::Taken(RunId(id))))
}

/// The newest whole answer to a request.
fn answered(connection: &Connection, key: &str, sample: u32) -> Result<Option<Run>, StoreError> {
    let mut statement = connection.prepare_cached(
        "SELECT * FROM runs WHERE key = ?1 AND sample = ?2 AND state = 'answered' AND deleted_ms IS NULL
         ORDER BY id DESC LIMIT 1",
    )?;
    Ok(statement
        .query_row(params![key, sample], |row| rows::shown(row, MOST_SHOWN))
        .optional()?)
}

fn hold(connection: &Connection, run: RunId) -> Result<(), StoreError> {
    hold_until(connection, run, lease_from_now())
}

/// When a claim that is made or renewed now ends.
fn lease_from_now() -> i64 {
    now_ms().saturating_add(LEASE.as_millis() as i64)
}

/// The end of a claim that no program has to renew.
pub(super) const FOR_EVER: i64 = i64::MAX;

/// Claims that end later than any that could have been made now: the clock was set back since.
const TOO_LONG: &str = "until_ms > ?1 AND until_ms < ?2";

fn any_too_long(connection: &Connection) -> Result<bool, StoreError> {
    let sql = format!("SELECT EXISTS (SELECT 1 FROM claims WHERE {TOO_LONG})");
    let mut statement = connection.prepare_cached(&sql)?;
    Ok(statement.query_row(params![lease_from_now(), FOR_EVER], |row| row.get(0))?)
}

/// Shortens claims that a clock set back made too long. A live program renews its own.
fn shorten(transaction: &Transaction<'_>) -> Result<(), StoreError> {
    let sql = format!("UPDATE claims SET until_ms = ?1 WHERE {TOO_LONG}");
    let mut statement = transaction.prepare_cached(&sql)?;
    statement.execute(params![lease_from_now(), FOR_EVER])?;
    Ok(())
}

/// Holds a run until a time, milliseconds since 1970.
pub(super) fn hold_until(
    connection: &Connection,
    run: RunId,
    until: i64,
) -> Result<(), StoreError> {
    connection
        .prepare_cached("INSERT OR REPLACE INTO claims (run, until_ms) VALUES (?1, ?2)")?
        .execute(params![run.0, until])?;
    Ok(())
}

/// A program that slept longer than its claim held takes its run up again: no other run can have asked under the
/// same number.
pub(super) fn renew(transaction: &Transaction<'_>, run: RunId) -> Result<(), StoreError> {
    hold(transaction, run)?;
    transaction
        .prepare_cached("UPDATE runs SET state = 'running', error = NULL WHERE id = ?1 AND state = 'interrupted'")?
        .execute([run.0])?;
    Ok(())
}

fn abandoned(connection: &Connection) -> Result<Vec<RunId>, StoreError> {
    let sql = "SELECT id FROM runs WHERE state = 'running'
         AND NOT EXISTS (SELECT 1 FROM claims WHERE run = runs.id AND until_ms > ?1)";
    all_rows(connection, sql, [now_ms()], |row| row.get(0).map(RunId))
}

pub(super) fn interrupt_abandoned(transaction: &Transaction<'_>) -> Result<(), StoreError> {
    shorten(transaction)?;
    for run in abandoned(transaction)? {
        run::join_pieces(transaction, run)?;
        transaction.execute(
            "UPDATE runs SET state = ?2, updated_ms = ?3, error = ?4 WHERE id = ?1",
            params![
                run.0,
                RunState::Interrupted.name(),
                now_ms(),
                "the program ended before the answer was complete"
            ],
        )?;
        transaction.execute("DELETE FROM claims WHERE run = ?1", [run.0])?;
    }
    Ok(())
}

/// Identifies a request by everything that is in it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
pub struct Key(String);

impl Key {
    /// The key of a document: the hexadecimal SHA-256 of its canonical form.
    ///
    /// That form has no white space, and the names of every object are sorted by their code points.
    #[must_use]
    pub fn digest(document: &Value) -> Self {
        let mut text = String::new();
        write(document, &mut text);
        let digest = Sha256::digest(text.as_bytes());
        Self(digest.iter().map(|byte| format!("{byte:02x}")).collect())
    }

    /// A key as it was kept; nothing if it cannot be one.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let fits = text.len() == 64 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        fits.then(|| Self(text.to_string()))
    }

    /// Sixty-four hexadecimal digits.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// A key as it was kept, if it can be one.
pub(super) fn deserialize_key<'de, D: serde::Deserializer<'de>>(
    from: D,
) -> Result<Option<Key>, D::Error> {
    let text = Option::<String>::deserialize(from)?;
    Ok(text.and_then(|text| Key::parse(&text)))
}

fn write(value: &Value, out: &mut String) {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_by_key(|(name, _)| name.as_str());
            out.push('{');
            for (place, (name, value)) in entries.into_iter().enumerate() {
                if place > 0 {
                    out.push(',');
                }
                out.push_str(&Value::from(name.as_str()).to_string());
                out.push(':');
                write(value, out);
            }
            out.push('}');
        }
        Value::Array(items) => {
            out.push('[');
            for (place, item) in items.iter().enumerate() {
                if place > 0 {
                    out.push(',');
                }
                write(item, out);
            }
            out.push(']');
        }
        plain => out.push_str(&plain.to_string()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use serde_json::json;

    #[test]
    fn the_order_of_names_does_not_count_and_everything_else_does() {
        let a: Value =
            serde_json::from_str(r#"{"b": [1, {"d": 2, "c": "x\n"}], "a": null}"#).unwrap();
        let b: Value = serde_json::from_str(r#"{"a":null,"b":[1,{"c":"x\n","d":2}]}"#).unwrap();
        assert_eq!(Key::digest(&a), Key::digest(&b));
        for other in [
            json!({"a": null, "b": [{"c": "x\n", "d": 2}, 1]}),
            json!({"a": null, "b": [1, {"c": "x", "d": 2}]}),
            json!({"a": false, "b": [1, {"c": "x\n", "d": 2}]}),
            json!({"b": [1, {"c": "x\n", "d": 2}]}),
        ] {
            assert_ne!(Key::digest(&a), Key::digest(&other), "{other}");
        }
    }

    #[test]
    fn a_key_is_the_digest_of_the_canonical_text() {
        // printf '{"a":[1,"b"]}' | sha256sum
        let known = "ee70aef572200b15408cec63724334e0ccd6c2b5d1cd7225a7f6a3f2a9aa80a9";
        let key = Key::digest(&json!({"a": [1, "b"]}));
        assert_eq!(key.as_str(), known);
        assert_eq!(Key::parse(known), Some(key));
        assert_eq!(Key::parse(&known[1..]), None);
        assert_eq!(Key::parse(&known.to_uppercase()), None);
    }
}
