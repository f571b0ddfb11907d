//! Run filters and their query syntax.

use std::collections::BTreeSet;

use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;
use nearmiss_scene::verdict::Task;
use rusqlite::Connection;
use rusqlite::types::Value;

use super::database::all_rows;
use strum::{IntoStaticStr, VariantArray};

use super::{Origin, RunState, SUPERSEDED, Store, StoreError};

/// Filters on runs; unset ones do not restrict.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Filter {
    /// Words that all occur in scenario, answer, reasoning, justification or notes, each as a word or the beginning of
    /// one; or in the model's id, as any part of it.
    pub words: Option<String>,
    /// A part of the model's id, in any case.
    pub model: Option<String>,
    /// A part of the scenario's name, in any case.
    pub scenario: Option<String>,
    /// The task.
    pub task: Option<Task>,
    /// Where they stand.
    pub state: Option<StateFilter>,
    /// Where they come from.
    pub origin: Option<Origin>,
    /// The batch they belong to.
    pub batch: Option<String>,
    /// What the verdict says.
    pub verdict: Option<Decision>,
    /// Asked at this time or later, milliseconds since 1970.
    pub since_ms: Option<i64>,
    /// Asked before this time.
    pub before_ms: Option<i64>,
    /// Only those that are kept from deletion.
    pub pinned: bool,
    /// The deleted ones instead of the others.
    pub deleted: bool,
}

/// Which answers a filter asks for by their state: the states that runs are stored with, and those that reports tell
/// apart among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StateFilter {
    /// Runs stored with this state.
    Stored(RunState),
    /// Of the answered ones those without a verdict.
    Unparsed,
    /// Of the truncated ones those that a filter of the server stopped.
    Filtered,
    /// Those that are arriving, as reports call them.
    Waiting,
    /// Those in whose place another run counts.
    Superseded,
}

impl StateFilter {
    /// Every one.
    pub const ALL: [Self; 10] = [
        Self::Stored(RunState::Answered),
        Self::Unparsed,
        Self::Stored(RunState::Truncated),
        Self::Filtered,
        Self::Stored(RunState::Failed),
        Self::Stored(RunState::Cancelled),
        Self::Stored(RunState::Interrupted),
        Self::Stored(RunState::Running),
        Self::Waiting,
        Self::Superseded,
    ];

    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stored(state) => state.name(),
            Self::Unparsed => "unparsed",
            Self::Filtered => "filtered",
            Self::Waiting => "waiting",
            Self::Superseded => "superseded",
        }
    }

    /// The one with a name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }

    fn condition(self) -> String {
        match self {
            Self::Stored(state) => format!("state = '{}'", state.name()),
            Self::Unparsed => "state = 'answered' AND verdict IS NULL".into(),
            Self::Filtered => {
                "state = 'truncated' AND finish IN ('content_filter', 'blocked')".into()
            }
            Self::Waiting => "state = 'running'".into(),
            Self::Superseded => SUPERSEDED.into(),
        }
    }
}

/// Decision of a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Decision {
    /// Yes: a collision, or safety-critical.
    Dangerous,
    /// No.
    Safe,
    /// Nothing: there is no verdict.
    #[strum(to_string = "none")]
    Nothing,
}

nearmiss_record::named!(Decision);

/// A filter in SQL.
pub(super) struct Condition {
    /// What follows FROM.
    pub(super) sql: String,
    /// Its values in order.
    pub(super) values: Vec<Value>,
    /// Whether runs come from the index of words, which has them by number.
    pub(super) by_words: bool,
}

/// A part of a filter that means nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FilterError {
    /// An unknown word.
    #[error("unknown {field} `{word}`; available: {known}")]
    Word {
        /// Of what.
        field: &'static str,
        /// The word.
        word: String,
        /// Those that there are.
        known: String,
    },
    /// No day and no moment.
    #[error("{field}: {why}")]
    Moment {
        /// Of what.
        field: &'static str,
        /// What is wanted.
        why: String,
    },
    /// Nothing after the colon.
    #[error("`{0}:` needs a value after the colon")]
    Empty(&'static str),
    /// An unknown name before a colon.
    #[error("unknown filter `{0}:`; available: {names}", names = Filter::NAMES)]
    Name(String),
}

impl Filter {
    /// The names that [`Filter::read`] knows, for people: those of the command line's options.
    pub const NAMES: &str =
        "model: scenario: task: verdict: state: origin: batch: since: before: pinned deleted";

    /// A filter from one line: `model:gpt verdict:dangerous since:2026-01-31 pinned` and words to search for. The names
    /// are those of the command line's options.
    ///
    /// # Errors
    /// A name before a colon is not known, or what is behind it. Words with other signs in front of a colon, such as
    /// `"at:` or `:8080`, are words.
    pub fn read(line: &str) -> Result<Self, FilterError> {
        let mut filter = Self::default();
        let mut words = Vec::new();
        for part in line.split_whitespace() {
            match part {
                "pinned" => filter.pinned = true,
                "deleted" => filter.deleted = true,
                _ => match part.split_once(':') {
                    Some((name, value)) if is_name(name) => {
                        if !filter.set(name, value)? {
                            return Err(FilterError::Name(name.to_string()));
                        }
                    }
                    _ => words.push(part),
                },
            }
        }
        filter.words = Some(words.join(" ")).filter(|w| !w.is_empty());
        Ok(filter)
    }

    /// Sets the part with this name; says whether there is one.
    fn set(&mut self, name: &str, value: &str) -> Result<bool, FilterError> {
        let text = |field| match value {
            "" => Err(FilterError::Empty(field)),
            _ => Ok(Some(value.to_string())),
        };
        match name {
            "model" => self.model = text("model")?,
            "scenario" => self.scenario = text("scenario")?,
            "batch" => self.batch = text("batch")?,
            "task" => self.task = word("task", value, &Task::ALL, Task::name)?,
            "state" => self.state = word("state", value, &StateFilter::ALL, StateFilter::name)?,
            "origin" => self.origin = word("origin", value, &Origin::ALL, Origin::name)?,
            "verdict" => {
                // As answers are shown.
                let value = match value {
                    "yes" => Decision::Dangerous.name(),
                    "no" => Decision::Safe.name(),
                    other => other,
                };
                self.verdict = word("verdict", value, &Decision::ALL, Decision::name)?;
            }
            "since" => self.since_ms = day("since", value)?,
            "before" => self.before_ms = day("before", value)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// What follows FROM. `models` gives the models whose names contain a word: the word finds their runs, too.
    pub(super) fn condition(
        &self,
        models: impl Fn(&str) -> Result<Vec<String>, StoreError>,
    ) -> Result<Condition, StoreError> {
        let mut parts = vec![format!(
            "deleted_ms IS {}NULL",
            if self.deleted { "NOT " } else { "" }
        )];
        let mut values = Vec::new();
        let mut tables = "runs";
        let mut of_texts = Vec::new();
        for word in self.words.iter().flat_map(|words| words.split_whitespace()) {
            let found = models(word)?;
            if found.is_empty() {
                of_texts.push(word);
                continue;
            }
            let places = vec!["?"; found.len()].join(", ");
            parts.push(format!(
                "(model IN ({places}) OR runs.id IN (SELECT rowid FROM runs_text WHERE runs_text MATCH ?))"
            ));
            values.extend(found.into_iter().map(Value::from));
            values.push(Value::from(matching(&[word])));
        }
        if !of_texts.is_empty() {
            tables = "runs_text JOIN runs ON runs.id = runs_text.rowid";
            parts.push("runs_text MATCH ?".into());
            values.push(Value::from(matching(&of_texts)));
        }
        let mut part = |sql: &str, value: Option<Value>| {
            if let Some(value) = value {
                parts.push(sql.to_string());
                values.push(value);
            }
        };
        let text = |text: &Option<String>| text.clone().map(Value::from);
        let name = |name: Option<&'static str>| name.map(|n| Value::from(n.to_string()));
        part("instr(lower(model), lower(?)) > 0", text(&self.model));
        part(
            "instr(lower(runs.scenario), lower(?)) > 0",
            text(&self.scenario),
        );
        part("task = ?", name(self.task.map(Task::name)));
        part("origin = ?", name(self.origin.map(Origin::name)));
        part("batch = ?", text(&self.batch));
        part("created_ms >= ?", self.since_ms.map(Value::from));
        part("created_ms < ?", self.before_ms.map(Value::from));
        parts.extend(self.state.map(StateFilter::condition));
        match self.verdict {
            Some(Decision::Dangerous) => parts.push("dangerous = 1".into()),
            Some(Decision::Safe) => parts.push("dangerous = 0".into()),
            Some(Decision::Nothing) => parts.push("verdict IS NULL".into()),
            None => {}
        }
        if self.pinned {
            parts.push("pinned = 1".into());
        }
        Ok(Condition {
            sql: format!("{tables} WHERE {}", parts.join(" AND ")),
            values,
            by_words: !of_texts.is_empty(),
        })
    }
}

/// Whether this could be the name of a filter.
fn is_name(word: &str) -> bool {
    !word.is_empty() && word.chars().all(char::is_alphabetic)
}

/// Words as FTS5 wants them: all of them, each a word or the beginning of one, and none of them an operator.
fn matching(words: &[&str]) -> String {
    let quoted = words
        .iter()
        .map(|word| format!("\"{}\"*", word.replace('"', "\"\"")));
    quoted.collect::<Vec<_>>().join(" ")
}

/// One of a list by its name, or by a beginning that only one has.
fn word<T: Copy>(
    field: &'static str,
    value: &str,
    all: &[T],
    name: fn(T) -> &'static str,
) -> Result<Option<T>, FilterError> {
    let whole = all.iter().copied().find(|one| name(*one) == value);
    let mut begun = all
        .iter()
        .copied()
        .filter(|one| name(*one).starts_with(value));
    let only = begun.next().filter(|_| begun.next().is_none());
    match (value, whole.or(only)) {
        ("", _) => Err(FilterError::Empty(field)),
        (_, Some(found)) => Ok(Some(found)),
        (_, None) => Err(FilterError::Word {
            field,
            word: value.to_string(),
            known: all
                .iter()
                .map(|one| name(*one))
                .collect::<Vec<_>>()
                .join(", "),
        }),
    }
}

fn day(field: &'static str, value: &str) -> Result<Option<i64>, FilterError> {
    match value {
        "" => Err(FilterError::Empty(field)),
        _ => moment(value)
            .map(Some)
            .map_err(|why| FilterError::Moment { field, why }),
    }
}

/// A day of this place (its beginning), or a moment with its zone, as milliseconds since 1970.
///
/// # Errors
/// It is neither; says what is wanted.
pub fn moment(text: &str) -> Result<i64, String> {
    let day = text
        .parse::<Date>()
        .ok()
        .filter(|_| text.len() == 10)
        .and_then(|day| day.to_zoned(TimeZone::system()).ok());
    match day {
        Some(day) => Ok(day.timestamp().as_millisecond()),
        None => text
            .parse::<Timestamp>()
            .map(Timestamp::as_millisecond)
            .map_err(|_| "write 2026-01-31, or 2026-01-31T12:00:00Z".to_string()),
    }
}

/// The models that were asked, as far as the store was read.
#[derive(Debug, Default)]
pub(super) struct KnownModels {
    /// Their ids.
    ids: BTreeSet<String>,
    /// The run up to which they were read: a run keeps its model.
    read_to: i64,
}

impl Store {
    /// The models whose names contain a word, in any case. Only runs that came since the last search are read.
    pub(super) fn models_with(
        &self,
        connection: &Connection,
        word: &str,
    ) -> Result<Vec<String>, StoreError> {
        let mut known = self.known_models();
        let newest: Option<i64> =
            connection.query_row("SELECT max(id) FROM runs", [], |row| row.get(0))?;
        if let Some(newest) = newest.filter(|newest| *newest > known.read_to) {
            let sql = "SELECT DISTINCT model FROM runs WHERE id > ?1 AND id <= ?2";
            let values = (known.read_to, newest);
            let ids: Vec<String> = all_rows(connection, sql, values, |row| row.get(0))?;
            known.ids.extend(ids);
            known.read_to = newest;
        }
        let word = word.to_lowercase();
        let has = |id: &&String| id.to_lowercase().contains(&word);
        Ok(known.ids.iter().filter(has).cloned().collect())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn one_line_says_what_the_options_of_the_command_line_say() {
        let filter = Filter::read("model:GPT brakes verdict:dangerous task:coll hard state:answered pinned since:2026-01-31T00:00:00Z").unwrap();
        let expected = Filter {
            words: Some("brakes hard".into()),
            model: Some("GPT".into()),
            task: Some(Task::Collision),
            verdict: Some(Decision::Dangerous),
            state: Some(StateFilter::Stored(RunState::Answered)),
            since_ms: Some(1_769_817_600_000),
            pinned: true,
            ..Filter::default()
        };
        assert_eq!(filter, expected);
        assert_eq!(Filter::read("  ").unwrap(), Filter::default());
        for (shown, stored) in [("yes", Decision::Dangerous), ("no", Decision::Safe)] {
            let filter = Filter::read(&format!("verdict:{shown}")).unwrap();
            assert_eq!(filter.verdict, Some(stored));
        }
        for words in ["12:30 :8080", "\"at: (see:"] {
            assert_eq!(Filter::read(words).unwrap().words.as_deref(), Some(words));
        }
        for (wrong, said) in [
            ("bogus:thing", "unknown filter `bogus:`; available: model: "),
            ("brakes Model:", "unknown filter `Model:`"),
            ("verdict:maybe", "dangerous, safe, none"),
            ("state:", "`state:` needs a value"),
            ("task:x", "collision"),
            ("since:yesterday", "2026-01-31"),
        ] {
            let error = Filter::read(wrong).unwrap_err().to_string();
            assert!(error.contains(said), "{wrong}: {error}");
        }
    }
}
