//! What reports, tables over axes and lists need of many runs, without their texts; the rule for what counts, and as what.

use nearmiss_scene::verdict::Task;
use rusqlite::{params, params_from_iter};
use serde::Deserialize;
use strum::{IntoStaticStr, VariantArray};

use super::database::all_rows;
use super::rows::from_row;
use super::{
    ClaimCounts, Consumed, Filter, Key, Origin, Run, RunId, RunState, SUPERSEDED, Store,
    StoreError, StoredTemplate, claim,
};

/// Outcome of one run.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Outcome {
    /// Its number.
    pub run: RunId,
    /// The key of the request; `None` if none was sent.
    #[serde(deserialize_with = "claim::deserialize_key")]
    pub key: Option<Key>,
    /// Name of the scenario.
    pub scenario: String,
    /// SHA-256 of its file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// Where the answer comes from.
    pub origin: Origin,
    /// The file that a recorded answer was read from.
    pub source: Option<String>,
    /// The task.
    pub task: Task,
    /// From where the scene was described.
    pub frame: String,
    /// Prompting techniques in use.
    pub techniques: String,
    /// The template.
    #[serde(flatten)]
    pub template: StoredTemplate,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
    /// `provider/model`, as asked for.
    pub model: String,
    /// Which of several answers to the same request.
    pub sample: u32,
    /// Whether the model could call tools.
    pub with_tools: bool,
    /// Where it stands.
    pub state: RunState,
    /// Why the model stopped, where it said so.
    pub finish: Option<String>,
    /// The verdict as JSON, where there is one.
    pub verdict: Option<String>,
    /// How the verdict was read, or why there is none.
    pub reading: Option<String>,
    /// Why there is no answer.
    pub error: Option<String>,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    pub most_usd: Option<f64>,
    /// What it consumed.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Its claims about obstacles, where they were checked.
    #[serde(flatten)]
    pub claims: ClaimCounts,
}

impl Store {
    /// Outcomes of all matching runs, oldest first. Their texts are not read.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn outcomes(&self, filter: &Filter) -> Result<Vec<Outcome>, StoreError> {
        let connection = self.lock();
        let found = filter.condition(|word| self.models_with(&connection, word))?;
        let (condition, values) = (found.sql, found.values);
        let sql = format!(
            "SELECT runs.id AS run, runs.scenario AS scenario, scenario_hash, ego, origin, source, task, frame, techniques,
                 template, template_version, template_hash, window_first, window_last, model, sample,
                 json_valid(parameters) AND json_extract(parameters, '$.tools') IS NOT NULL AS with_tools, state, finish, verdict, reading, error, most_usd, input_tokens, output_tokens,
                 reasoning_tokens, cached_tokens, cost_usd, first_chunk_ms, duration_ms, key,
                 claims_right, claims_wrong, claims_open, claims_check, claims_invented,
                 sentences, sentences_not_understood, sentences_contradictory
             FROM {condition} ORDER BY created_ms, runs.id"
        );
        all_rows(&connection, &sql, params_from_iter(values), from_row)
    }
}

/// When and of what a run was asked.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct RunOrigin {
    /// Its number.
    pub run: RunId,
    /// When it was asked, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// `provider/model`, as asked for.
    pub model: String,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// File name of the template.
    pub template: String,
    /// SHA-256 of its text.
    pub template_hash: String,
    /// SHA-256 of the scenario file.
    pub scenario_hash: Option<String>,
    /// The parameters that were sent, as JSON.
    pub parameters: String,
}

impl Store {
    /// The origins of all runs that are not deleted, oldest number first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn origins(&self) -> Result<Vec<RunOrigin>, StoreError> {
        let sql = "SELECT id AS run, created_ms, model, model_returned, template, template_hash, scenario_hash,
                 parameters
             FROM runs WHERE deleted_ms IS NULL ORDER BY id";
        self.rows(sql, [], from_row)
    }
}

/// Verdict of a stored answer.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct StoredVerdict {
    /// SHA-256 of the scenario's file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// Name of the scenario.
    pub scenario: String,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// Where the answer comes from.
    pub origin: Origin,
    /// The task.
    pub task: Task,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
    /// Yes or no.
    pub dangerous: bool,
}

impl Store {
    /// The verdicts in all whole answers, whatever template they were asked with, without those in whose place another
    /// answer to the same request counts ([`SUPERSEDED`]) and those of the model `but`; all of them, or those about one
    /// scenario, by hash and name as in [`Store::of_scenario`].
    ///
    /// # Errors
    /// SQLite refused.
    pub fn verdicts(
        &self,
        but: &str,
        of: Option<(&str, &str)>,
    ) -> Result<Vec<StoredVerdict>, StoreError> {
        let which = match of {
            None => "?2 IS NULL AND ?3 IS NULL",
            Some(_) => "(scenario_hash = ?2 OR (scenario_hash IS NULL AND scenario = ?3))",
        };
        let sql = format!(
            "SELECT scenario_hash, scenario, ego, origin, task, window_first, window_last, dangerous
             FROM runs
             WHERE deleted_ms IS NULL AND state = 'answered' AND dangerous IS NOT NULL AND model <> ?1 AND {which}
                 AND NOT {SUPERSEDED}"
        );
        let (hash, name) = of.unzip();
        self.rows(&sql, params![but, hash, name], from_row)
    }
}

/// How the end of an answer is called that this program cut off because of its size.
pub const TOO_LONG: &str = "too_long";

/// State of an answer, or of an attempt to get one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum AnswerState {
    /// The answer is whole, and a verdict was read in it.
    Answered,
    /// The answer is whole, and no verdict could be read in it.
    Unparsed,
    /// The answer was cut off: by the token limit, by the size that is read of one, or it is blank.
    Truncated,
    /// A filter of the server stopped the answer or blocked the question.
    Filtered,
    /// No whole answer came.
    Failed,
    /// It was cancelled.
    Cancelled,
    /// The program ended while the answer arrived.
    Interrupted,
    /// The answer is arriving, or is awaited.
    #[default]
    Waiting,
    /// Another attempt at the same question counts in its place; what it cost still counts.
    Superseded,
}

nearmiss_record::named!(AnswerState, "state");

/// What an answer is counted as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CountedAs {
    /// A yes or no, right or wrong.
    Verdict,
    /// An answer without a verdict.
    Unparsed,
    /// A question without a whole answer.
    Failed,
    /// A question that is still to be asked.
    Unasked,
    /// Nothing: another attempt is counted.
    Nothing,
}

impl AnswerState {
    /// The state of one run: where it stands, why its model stopped, and whether a verdict was read.
    #[must_use]
    pub fn of_run(state: RunState, finish: Option<&str>, has_verdict: bool) -> Self {
        match (state, finish) {
            (RunState::Answered, _) if has_verdict => Self::Answered,
            (RunState::Answered, _) => Self::Unparsed,
            (RunState::Truncated, Some("content_filter" | "blocked")) => Self::Filtered,
            (RunState::Truncated, _) => Self::Truncated,
            (RunState::Failed, _) => Self::Failed,
            (RunState::Cancelled, _) => Self::Cancelled,
            (RunState::Interrupted, _) => Self::Interrupted,
            (RunState::Running, _) => Self::Waiting,
        }
    }

    /// The state of a run as the store has it; whether another one counts in its place is not known of one alone.
    #[must_use]
    pub fn from_run(run: &Run) -> Self {
        let (finish, verdict) = (run.ending.finish.as_deref(), &run.ending.verdict);
        Self::of_run(run.ending.state, finish, verdict.is_some())
    }

    /// What it is counted as. A cut answer is a failed question, whatever can be read in what there is of it: the rest
    /// could have said something else, and how much arrives depends on the limit, not on the model.
    #[must_use]
    pub fn counted_as(self) -> CountedAs {
        match self {
            Self::Answered => CountedAs::Verdict,
            Self::Unparsed => CountedAs::Unparsed,
            Self::Truncated | Self::Filtered | Self::Failed => CountedAs::Failed,
            Self::Cancelled | Self::Interrupted | Self::Waiting => CountedAs::Unasked,
            Self::Superseded => CountedAs::Nothing,
        }
    }

    /// Why a run that ended like this has no verdict that counts, where it says nothing itself.
    #[must_use]
    pub fn reason(self, finish: Option<&str>) -> &'static str {
        match (self, finish) {
            (Self::Truncated, Some("length")) => "the answer ran into the token limit",
            (Self::Truncated, Some(TOO_LONG)) => "the answer was too long to be read whole",
            (Self::Truncated, Some("blank")) => "the answer is blank",
            (Self::Truncated, _) => "the server ended the answer before it was whole",
            (Self::Filtered, Some("blocked")) => "the server's filter blocked the question",
            (Self::Filtered, _) => "the server's content filter stopped the answer",
            (Self::Cancelled, _) => "it was cancelled",
            (Self::Interrupted, _) => "the program ended while the answer arrived",
            (Self::Waiting, _) => "the answer has not arrived yet",
            (Self::Unparsed, _) => "no verdict was found in the answer",
            (Self::Answered | Self::Failed | Self::Superseded, _) => "no whole answer came",
        }
    }
}

/// Which of several attempts at one question counts: a whole answer before one that was cut or failed, these before
/// what was cancelled or interrupted; of equals the one that entered the store last, see [`super::SUPERSEDED`].
#[must_use]
pub fn attempt_rank(state: RunState) -> u8 {
    match state {
        RunState::Answered => 2,
        RunState::Truncated | RunState::Failed => 1,
        RunState::Running | RunState::Interrupted | RunState::Cancelled => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_answer_is_a_failed_question_whatever_it_says() {
        for (state, finish, verdict, expected, counted) in [
            (
                RunState::Answered,
                Some("stop"),
                true,
                "answered",
                CountedAs::Verdict,
            ),
            (
                RunState::Answered,
                Some("refusal"),
                false,
                "unparsed",
                CountedAs::Unparsed,
            ),
            (
                RunState::Truncated,
                Some("length"),
                true,
                "truncated",
                CountedAs::Failed,
            ),
            (
                RunState::Truncated,
                Some("blank"),
                false,
                "truncated",
                CountedAs::Failed,
            ),
            (
                RunState::Truncated,
                Some("content_filter"),
                true,
                "filtered",
                CountedAs::Failed,
            ),
            (RunState::Failed, None, true, "failed", CountedAs::Failed),
            (
                RunState::Cancelled,
                None,
                false,
                "cancelled",
                CountedAs::Unasked,
            ),
            (
                RunState::Interrupted,
                None,
                true,
                "interrupted",
                CountedAs::Unasked,
            ),
            (
                RunState::Running,
                None,
                false,
                "waiting",
                CountedAs::Unasked,
            ),
        ] {
            let found = AnswerState::of_run(state, finish, verdict);
            assert_eq!((found.name(), found.counted_as()), (expected, counted));
        }
    }
}
