//! Batch items: the state of each question, its newest complete answers, and the ground truth that is stored for it.

use nearmiss_scene::verdict::Task;
use rusqlite::{Connection, Row, params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use strum::{IntoStaticStr, VariantArray};

use super::list::MOST_SHOWN;
use super::rows::{self, from_row};
use super::{
    BatchId, Consumed, Key, RunId, SceneRecord, SplitPart, Store, StoreError, StoredTemplate, claim,
};

/// What is known of the window of a question.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct WindowFacts {
    /// First and last time step.
    pub steps: (i64, i64),
    /// Obstacles that the ego touches in the window or within the horizon after it, the first one first.
    pub critical: Vec<i64>,
    /// Obstacles near the ego at one of its steps.
    pub obstacles: u64,
    /// The ego's speed at its end, m/s.
    pub speed: f64,
    /// Least distance of an obstacle in the window, metres, and least time to collision at its end, seconds; of
    /// questions of earlier versions neither is known.
    #[serde(default)]
    pub nearest: Option<f64>,
    /// See `nearest`.
    #[serde(default)]
    pub ttc: Option<f64>,
    /// Tokens of the question, estimated.
    pub tokens: u64,
    /// SHA-256 of the template and its fragments.
    pub template_hash: String,
}

/// A question to ask.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NewItem {
    /// File of the scenario, or the name of a bundled one.
    pub path: String,
    /// Name of the scenario: its file name without the ending.
    pub scenario: String,
    /// SHA-256 of its file; null if it could not be read.
    pub scenario_hash: Option<String>,
    /// The ego; null if it could not be read.
    pub ego: Option<String>,
    /// The question: collision, safety, recording, attacker or trajectory.
    #[schemars(with = "String")]
    pub task: Task,
    /// Frame of the description; null for a judge without a prompt.
    pub frame: Option<String>,
    /// Prompting techniques; null for a judge without a prompt.
    pub techniques: Option<String>,
    /// Model asked, as provider/model.
    pub model: String,
    /// Number of the sample among answers to the same request, from 0.
    pub sample: u32,
    /// End of the window: seconds before the collision, or paper; null for that of the batch.
    pub lead: Option<String>,
    /// Change of the scene, such as mirror; null if it is as it is.
    pub transform: Option<String>,
    /// First and last step of the window, where it was drawn; null for the one that task and lead give.
    #[serde(default)]
    pub window: Option<(i64, i64)>,
    /// What is known of the window; null if it cannot be asked, or was asked by an earlier version.
    #[serde(default, deserialize_with = "rows::json")]
    pub facts: Option<WindowFacts>,
    /// What a bundle says about the scene; missing for a question that was asked here.
    #[schemars(with = "Value")]
    #[serde(
        default,
        deserialize_with = "rows::json",
        skip_serializing_if = "Option::is_none"
    )]
    pub scene: Option<SceneRecord>,
    /// Key of the request; null if none is sent.
    #[serde(deserialize_with = "claim::deserialize_key")]
    pub key: Option<Key>,
    /// Ground truth: whether the ego collides; null if unknown.
    #[serde(deserialize_with = "rows::truth")]
    pub collides: Option<bool>,
    /// Ground truth: the obstacle that the ego collides with.
    pub obstacle: Option<i64>,
    /// Why it cannot be asked; `None` if it can.
    #[serde(skip)]
    pub unaskable: Option<String>,
    /// Values of the axes of the batch, such as effort low; missing without axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<String>,
    /// dev or test; missing if the batch has no split.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub split: Option<SplitPart>,
}

/// State of a batch question.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum ItemState {
    /// Not asked yet.
    Waiting,
    /// It has a complete answer.
    Answered,
    /// The server cut the answer off; asked again, it would likely do so again.
    Truncated,
    /// No complete answer came.
    Failed,
    /// No question can be made of the scenario.
    Unaskable,
}

nearmiss_record::named!(ItemState, "state");

/// A question of a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Item {
    /// Place in the batch, from 0.
    pub place: u64,
    /// The question.
    #[serde(flatten)]
    pub asked: NewItem,
    /// State: waiting, answered, truncated, failed or unaskable.
    #[serde(rename(serialize = "state", deserialize = "now"))]
    pub state: ItemState,
    /// The last run that was made for it.
    pub run: Option<RunId>,
    /// Why there is no whole answer, or why it was not asked.
    pub error: Option<String>,
    /// Whether the newest whole answer to it has no verdict that could be read; known only from [`Store::items`].
    #[serde(default, deserialize_with = "truth_or_false", skip_serializing)]
    pub unparsed: bool,
}

fn truth_or_false<'de, D: serde::Deserializer<'de>>(from: D) -> Result<bool, D::Error> {
    rows::truth(from).map(|truth| truth.unwrap_or(false))
}

/// Whether the newest whole answer to a row of `items` has no verdict.
const UNPARSED: &str = "coalesce(CASE WHEN items.key IS NULL
             THEN (SELECT verdict IS NULL FROM runs WHERE id = items.run AND state = 'answered' AND deleted_ms IS NULL)
             ELSE (SELECT verdict IS NULL FROM runs WHERE runs.key = items.key AND runs.sample = items.sample
                       AND runs.state = 'answered' AND runs.deleted_ms IS NULL ORDER BY runs.id DESC LIMIT 1)
             END, 0)";

/// Current state of a row of `items`. A deleted answer does not count: its question is to be asked again.
pub(super) const STATE: &str = "CASE WHEN items.state = 'answered' AND items.key IS NOT NULL AND NOT EXISTS (
             SELECT 1 FROM runs AS kept WHERE kept.key = items.key AND kept.sample = items.sample
                 AND kept.state = 'answered' AND kept.deleted_ms IS NULL) THEN 'waiting'
         WHEN (items.state = 'truncated' OR (items.state = 'answered' AND items.key IS NULL)) AND items.run IS NOT NULL AND NOT EXISTS (
             SELECT 1 FROM runs AS kept WHERE kept.id = items.run AND kept.deleted_ms IS NULL) THEN 'waiting'
         ELSE items.state END";

/// The newest whole answer to a question.
#[derive(Debug, Clone, PartialEq)]
pub struct NewestAnswer {
    /// The run.
    pub run: RunId,
    /// The answer's text; the reasoning where that is all that was said.
    pub text: String,
    /// The verdict as it is kept, as JSON: it may say what the text does not, such as log probabilities.
    pub verdict: Option<String>,
    /// How the verdict was read; of an answer without one, why.
    pub reading: Option<String>,
    /// The template it was asked with.
    pub template: StoredTemplate,
    /// Time, tokens and cost.
    pub consumed: Consumed,
}

/// Writes questions behind those that the batch has.
pub(super) fn insert(
    connection: &Connection,
    batch: BatchId,
    items: &[NewItem],
) -> Result<(), StoreError> {
    let first: i64 = connection.query_row(
        "SELECT coalesce(max(place) + 1, 0) FROM items WHERE batch = ?1",
        [batch.0],
        |row| row.get(0),
    )?;
    let mut statement = connection.prepare_cached(
        "INSERT INTO items (batch, place, path, scenario, scenario_hash, ego, task, frame, techniques, model, sample,
             key, collides, obstacle, state, error, lead, transform, window_first, window_last, facts, settings, split)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22,
             ?23)",
    )?;
    for (place, item) in (first..).zip(items) {
        let state = match item.unaskable {
            Some(_) => ItemState::Unaskable,
            None => ItemState::Waiting,
        };
        statement.execute(params![
            batch.0,
            place,
            item.path,
            item.scenario,
            item.scenario_hash,
            item.ego,
            item.task.name(),
            item.frame,
            item.techniques,
            item.model,
            item.sample,
            item.key.as_ref().map(Key::as_str),
            item.collides,
            item.obstacle,
            state.name(),
            item.unaskable,
            item.lead,
            item.transform,
            item.window.map(|(first, _)| first),
            item.window.map(|(_, last)| last),
            known(item)?,
            item.settings,
            item.split.map(SplitPart::name),
        ])?;
    }
    Ok(())
}

/// The column `facts`: what is known of the window, with the record of the scene as its field `scene`.
fn known(item: &NewItem) -> Result<Option<String>, StoreError> {
    let mut known = serde_json::to_value(&item.facts)?;
    if let Some(scene) = &item.scene {
        known["scene"] = serde_json::to_value(scene)?;
    }
    Ok((!known.is_null()).then(|| known.to_string()))
}

/// The record of the scene of a row of `items`.
const SCENE: &str = "json_extract(items.facts, '$.scene') AS scene";

fn item(row: &Row<'_>) -> Result<Item, rusqlite::Error> {
    rows::from_row(row).map(Item::with_reason)
}

impl Item {
    /// The same with the reason why it cannot be asked, where that is its state.
    pub(super) fn with_reason(mut self) -> Self {
        let unaskable = self.state == ItemState::Unaskable;
        self.asked.unaskable = self.error.clone().filter(|_| unaskable);
        self
    }
}

impl Store {
    /// The questions of a batch in their order; none where there is no such batch.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn items(&self, batch: BatchId) -> Result<Vec<Item>, StoreError> {
        let sql = format!(
            "SELECT items.*, {SCENE}, {STATE} AS now, {UNPARSED} AS unparsed FROM items WHERE batch = ?1 ORDER BY place"
        );
        self.rows(&sql, [batch.0], item)
    }

    /// Writes down where a question stands. `key` is that of the request as it was sent at last.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn set_item(
        &self,
        batch: BatchId,
        place: u64,
        key: Option<&Key>,
        state: ItemState,
        run: Option<RunId>,
        error: Option<&str>,
    ) -> Result<(), StoreError> {
        self.change(|transaction| {
            transaction
                .prepare_cached(
                    "UPDATE items SET key = ?3, state = ?4, run = coalesce(?5, run), error = ?6
                     WHERE batch = ?1 AND place = ?2",
                )?
                .execute(params![
                    batch.0,
                    place,
                    key.map(Key::as_str),
                    state.name(),
                    run.map(|run| run.0),
                    error
                ])?;
            Ok(())
        })
    }

    /// Whether a whole answer to this request and sample is there.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn has_answer(&self, key: &Key, sample: u32) -> Result<bool, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT EXISTS (SELECT 1 FROM runs WHERE key = ?1 AND sample = ?2 AND state = 'answered'
                 AND deleted_ms IS NULL)",
        )?;
        Ok(statement.query_row(params![key.as_str(), sample], |row| row.get(0))?)
    }

    /// The questions of a batch in their order, each with the newest whole answer to its request and sample.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn items_with_answers(
        &self,
        batch: BatchId,
    ) -> Result<Vec<(Item, Option<NewestAnswer>)>, StoreError> {
        self.some_items_with_answers(batch, 0, None)
    }

    /// At most so many of them, from this place on: the texts of all are much.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn some_items_with_answers(
        &self,
        batch: BatchId,
        from: u64,
        most: Option<u32>,
    ) -> Result<Vec<(Item, Option<NewestAnswer>)>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            &format!("SELECT items.*, {SCENE}, {STATE} AS now, found.id AS found,
                 CASE WHEN trim(found.answer) = '' THEN found.reasoning ELSE found.answer END AS text,
                 found.input_tokens, found.output_tokens, found.reasoning_tokens, found.cached_tokens, found.cost_usd,
                 found.first_chunk_ms, found.duration_ms, found.template, found.template_version, found.template_hash, found.verdict, found.reading
             FROM items LEFT JOIN runs AS found ON found.id = CASE
                 WHEN items.key IS NULL THEN
                     (SELECT id FROM runs WHERE id = items.run AND state = 'answered' AND deleted_ms IS NULL)
                 ELSE
                     (SELECT id FROM runs WHERE runs.key = items.key AND runs.sample = items.sample
                          AND runs.state = 'answered' AND runs.deleted_ms IS NULL
                      ORDER BY runs.id DESC LIMIT 1)
                 END
             WHERE items.batch = ?1 AND items.place >= ?2 ORDER BY items.place LIMIT ?3"),
        )?;
        let most = most.map_or(-1, i64::from); // a negative limit is none
        let rows = statement.query_map(params![batch.0, from, most], |row| {
            let found = match row.get::<_, Option<i64>>("found")? {
                None => None,
                Some(run) => Some(NewestAnswer {
                    run: RunId(run),
                    text: {
                        let text = row.get_ref("text")?.as_str()?;
                        text[..text.floor_char_boundary(MOST_SHOWN)].to_owned()
                    },
                    verdict: row.get("verdict")?,
                    reading: row.get("reading")?,
                    template: rows::from_row(row)?,
                    consumed: rows::from_row(row)?,
                }),
            };
            Ok((item(row)?, found))
        })?;
        Ok(rows.collect::<Result<_, _>>()?)
    }
}

/// What is true about a run, from its batch.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
pub struct RunLabel {
    /// The run.
    pub run: RunId,
    /// The batch.
    pub batch: BatchId,
    /// The task.
    pub task: Task,
    /// Whether the ego collides: in the scenario, or as the truth of its window says where that was drawn.
    pub collides: bool,
    /// The colliding obstacle, where known.
    pub obstacle: Option<i64>,
    /// Whether its window was drawn, so that the truth is that of the window.
    pub drawn: bool,
    /// What is known of its window.
    #[serde(deserialize_with = "rows::json")]
    pub facts: Option<WindowFacts>,
}

/// Another truth of a question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemTruth {
    /// The question's place in the batch.
    pub place: u64,
    /// What is true; `None` if it is unknown.
    pub collides: Option<bool>,
    /// The obstacle that the truth names, if it names one.
    pub obstacle: Option<i64>,
    /// The critical obstacles of its window, in place of those in [`WindowFacts`]; `None` leaves these.
    pub critical: Option<Vec<i64>>,
}

impl Item {
    /// Has this truth from now on.
    pub fn set_truth(&mut self, truth: &ItemTruth) {
        (self.asked.collides, self.asked.obstacle) = (truth.collides, truth.obstacle);
        if let (Some(facts), Some(critical)) = (&mut self.asked.facts, &truth.critical) {
            facts.critical.clone_from(critical);
        }
    }
}

impl Store {
    /// Replaces the ground truth: by place, whether the ego collides, and with which obstacle.
    ///
    /// # Errors
    /// SQLite refused; no change is made.
    pub fn set_truth(
        &self,
        batch: BatchId,
        spec: &str,
        truth: &[ItemTruth],
    ) -> Result<(), StoreError> {
        self.durably(|transaction| {
            transaction.execute(
                "UPDATE batches SET spec = ?2 WHERE id = ?1",
                params![batch.0, spec],
            )?;
            let mut statement = transaction.prepare_cached(
                "UPDATE items SET collides = ?3, obstacle = ?4,
                     facts = CASE WHEN ?5 IS NOT NULL AND json_type(facts, '$.critical') IS NOT NULL
                         THEN json_set(facts, '$.critical', json(?5)) ELSE facts END
                 WHERE batch = ?1 AND place = ?2",
            )?;
            for one in truth {
                let critical = one
                    .critical
                    .as_ref()
                    .map(serde_json::to_string)
                    .transpose()?;
                let told = (one.place, one.collides, one.obstacle);
                statement.execute(params![batch.0, told.0, told.1, told.2, critical])?;
            }
            Ok(())
        })
    }

    /// The batch that each run was made for, in words; runs that were made for none are left out.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn run_batches(&self) -> Result<Vec<(RunId, String)>, StoreError> {
        let sql = "SELECT id, batch FROM runs WHERE batch IS NOT NULL";
        self.rows(sql, [], |row| Ok((RunId(row.get(0)?), row.get(1)?)))
    }

    /// Labels of runs from their batches, one a run. If several batches have one, the batch that the run was made for
    /// counts. Changed scenes are left out, as their obstacles can have other ids.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn truths(&self) -> Result<Vec<RunLabel>, StoreError> {
        let sql = "SELECT items.run, items.batch, items.task, collides, obstacle,
                 items.window_first IS NOT NULL AS drawn, items.facts
             FROM items JOIN runs ON runs.id = items.run
             WHERE collides IS NOT NULL AND transform IS NULL
             ORDER BY items.run, coalesce(runs.batch = 'b' || items.batch, 0) DESC, items.batch";
        let mut told: Vec<RunLabel> = self.rows(sql, [], from_row)?;
        told.dedup_by_key(|one| one.run);
        Ok(told)
    }
}

/// Counts of claims. All are `None` where the answer was not checked, as its scenario was not at hand.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
pub struct ClaimCounts {
    /// Claims about obstacles in the answer that hold; null if they were not checked.
    pub claims_right: Option<u32>,
    /// Claims that do not hold.
    pub claims_wrong: Option<u32>,
    /// Claims that cannot be decided.
    pub claims_open: Option<u32>,
    /// Wrong numbers that the question does not have; null also where a picture was shown, or the question is not known.
    pub claims_invented: Option<u32>,
    /// Sentences of the answer that say something of the scene; null if they were not checked.
    pub sentences: Option<u32>,
    /// Of them those that were not understood.
    pub sentences_not_understood: Option<u32>,
    /// Of them those that contradict another one.
    pub sentences_contradictory: Option<u32>,
    /// Version of the check that counted the claims.
    pub claims_check: Option<u32>,
}

impl ClaimCounts {
    /// Right, wrong and open; `None` if the answer was not checked.
    #[must_use]
    pub fn known(self) -> Option<[u32; 3]> {
        Some([self.claims_right?, self.claims_wrong?, self.claims_open?])
    }

    /// Sentences, those not understood and those that contradict another one; `None` if they were not checked.
    #[must_use]
    pub fn known_sentences(self) -> Option<[u32; 3]> {
        Some([
            self.sentences?,
            self.sentences_not_understood?,
            self.sentences_contradictory?,
        ])
    }
}

impl Store {
    /// Keeps counts of claims with their runs; runs that are gone are left out.
    ///
    /// # Errors
    /// SQLite refused; nothing is kept then.
    pub fn keep_claims(&self, counted: &[(RunId, ClaimCounts)]) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let mut statement = transaction.prepare_cached(
                "UPDATE runs SET claims_right = ?2, claims_wrong = ?3, claims_open = ?4, claims_check = ?5,
                     claims_invented = ?6, sentences = ?7, sentences_not_understood = ?8, sentences_contradictory = ?9
                 WHERE id = ?1",
            )?;
            for (run, counts) in counted {
                statement.execute(params![
                    run.0,
                    counts.claims_right,
                    counts.claims_wrong,
                    counts.claims_open,
                    counts.claims_check,
                    counts.claims_invented,
                    counts.sentences,
                    counts.sentences_not_understood,
                    counts.sentences_contradictory
                ])?;
            }
            Ok(())
        })
    }
}

#[cfg(test)]
#[path = "items_tests.rs"]
pub mod tests;
