//! Versions of prompt templates that questions were asked with, and the newest answers to them.

use rusqlite::{OptionalExtension, params};
use serde::Deserialize;

use super::list::MOST_SHOWN;
use super::{Run, Store, StoreError, rows};
use nearmiss_scene::verdict::Task;

/// A version of a template that whole answers were given to.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct AskedTemplate {
    /// The template's file.
    pub template: String,
    /// SHA-256 of its text and of the fragments that it includes.
    pub hash: String,
    /// How many whole answers there are.
    pub answers: u64,
}

/// A question as far as it is the same whatever the template.
#[derive(Debug, Clone, Copy)]
pub struct SameQuestion<'a> {
    /// SHA-256 of the scenario's file.
    pub scenario_hash: &'a str,
    /// The ego, and where its motion comes from.
    pub ego: &'a str,
    /// The task.
    pub task: Task,
    /// The frame of the description.
    pub frame: &'a str,
    /// The techniques.
    pub techniques: &'a str,
    /// `provider/model`.
    pub model: &'a str,
    /// First and last time step of the window.
    pub window: (i64, i64),
}

impl Store {
    /// The versions of templates that a model answered a task in a frame with, the last one used first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn asked_templates(
        &self,
        task: Task,
        frame: &str,
        model: &str,
    ) -> Result<Vec<AskedTemplate>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT template, template_hash AS hash, count(*) AS answers FROM runs
             WHERE task = ?1 AND frame = ?2 AND model = ?3 AND state = 'answered' AND deleted_ms IS NULL
                 AND template != '' AND template_hash != ''
             GROUP BY template_hash ORDER BY max(created_ms) DESC",
        )?;
        let found = statement.query_map(params![task.name(), frame, model], rows::from_row)?;
        Ok(found.collect::<Result<_, _>>()?)
    }

    /// The newest whole answer to a question that was asked with this version of a template, whatever else was set.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn answer_with_template(
        &self,
        question: &SameQuestion<'_>,
        hash: &str,
    ) -> Result<Option<Run>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT * FROM runs WHERE scenario_hash = ?1 AND task = ?2 AND ego = ?3 AND frame = ?4 AND techniques = ?5
                 AND model = ?6 AND window_first = ?7 AND window_last = ?8 AND template_hash = ?9
                 AND state = 'answered' AND deleted_ms IS NULL
             ORDER BY created_ms DESC, id DESC LIMIT 1",
        )?;
        let values = params![
            question.scenario_hash,
            question.task.name(),
            question.ego,
            question.frame,
            question.techniques,
            question.model,
            question.window.0,
            question.window.1,
            hash
        ];
        Ok(statement
            .query_row(values, |row| rows::shown(row, MOST_SHOWN))
            .optional()?)
    }
}
