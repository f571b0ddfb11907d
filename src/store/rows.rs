//! Converts database rows to runs.

use rusqlite::types::Type;
use rusqlite::{Connection, Error, Row};

use super::{Consumed, Ending, Key, NewRun, Origin, Run, RunId, RunState, StoreError};
use crate::verdict::Task;

/// A run with at most so much of its texts as people look at, as [`run`].
pub fn shown(row: &Row<'_>, most: usize) -> Result<Run, Error> {
    let mut shown = of(row, |name| {
        let text = row.get_ref(name)?.as_str()?;
        Ok(text[..text.floor_char_boundary(most)].to_owned())
    })?;
    for (name, text) in [
        ("answer", &mut shown.answer),
        ("reasoning", &mut shown.reasoning),
    ] {
        let whole = row.get_ref(name)?.as_str()?.len();
        if whole > text.len() {
            text.push_str(&format!(
                "\n[nearmiss: shortened; {whole} bytes are in the store: nearmiss runs show {} --json]",
                shown.id
            ));
        }
    }
    Ok(shown)
}

/// A run, without the pieces that have not been put together.
pub fn run(row: &Row<'_>) -> Result<Run, Error> {
    of(row, |name| row.get(name))
}

/// A run whose answer and reasoning are read in some way.
fn of(row: &Row<'_>, long: impl Fn(&str) -> Result<String, Error>) -> Result<Run, Error> {
    let text = |name: &str| row.get::<_, String>(name);
    let verdict: Option<String> = row.get("verdict")?;
    let window = (row.get("window_first")?, row.get("window_last")?);
    Ok(Run {
        id: RunId(row.get("id")?),
        created_ms: row.get("created_ms")?,
        updated_ms: row.get("updated_ms")?,
        key: row
            .get::<_, Option<String>>("key")?
            .and_then(|key| Key::parse(&key)),
        origin: word(row, "origin", Origin::parse)?,
        source: row.get("source")?,
        question: NewRun {
            sample: row.get("sample")?,
            batch: row.get("batch")?,
            scenario: text("scenario")?,
            scenario_hash: row.get("scenario_hash")?,
            ego: text("ego")?,
            task: word(row, "task", Task::parse)?,
            frame: text("frame")?,
            techniques: text("techniques")?,
            window: match window {
                (Some(first), Some(last)) => Some((first, last)),
                _ => None,
            },
            model: text("model")?,
            provider: text("provider")?,
            dialect: row.get("dialect")?,
            endpoint: text("endpoint")?,
            address: row.get("address")?,
            template: text("template")?,
            template_version: row.get("template_version")?,
            template_hash: text("template_hash")?,
            messages: text("messages")?,
            parameters: text("parameters")?,
            answer_schema: row.get("answer_schema")?,
        },
        answer: long("answer")?,
        reasoning: long("reasoning")?,
        ending: Ending {
            state: word(row, "state", RunState::parse)?,
            model_returned: row.get("model_returned")?,
            finish: row.get("finish")?,
            verdict: verdict
                .as_deref()
                .and_then(|json| serde_json::from_str(json).ok()),
            reading: row.get("reading")?,
            error: row.get("error")?,
            consumed: consumed(row)?,
            price_source: row.get("price_source")?,
        },
        verdict_json: verdict,
        notes: text("notes")?,
        pinned: row.get("pinned")?,
        deleted_ms: row.get("deleted_ms")?,
    })
}

/// Time, tokens and cost of a run.
pub fn consumed(row: &Row<'_>) -> Result<Consumed, rusqlite::Error> {
    Ok(Consumed {
        input_tokens: row.get("input_tokens")?,
        output_tokens: row.get("output_tokens")?,
        reasoning_tokens: row.get("reasoning_tokens")?,
        cached_tokens: row.get("cached_tokens")?,
        cost_usd: row.get("cost_usd")?,
        first_chunk_ms: row.get("first_chunk_ms")?,
        duration_ms: row.get("duration_ms")?,
    })
}

/// A word of a fixed list; one that the program does not know is an error, not another word.
pub fn word<T>(
    row: &Row<'_>,
    column: &str,
    parse: impl FnOnce(&str) -> Option<T>,
) -> Result<T, Error> {
    let text: String = row.get(column)?;
    parse(&text).ok_or_else(|| {
        let place = row.as_ref().column_index(column).unwrap_or_default();
        let why = format!("{column} `{text}` is not known to this version");
        Error::FromSqlConversionFailure(place, Type::Text, why.into())
    })
}

/// The texts of the pieces that have not been put together: answer and reasoning.
pub fn pieces(connection: &Connection, run: RunId) -> Result<(String, String), Error> {
    let mut statement = connection
        .prepare_cached("SELECT reasoning, text FROM pieces WHERE run = ?1 ORDER BY id")?;
    let mut rows = statement.query([run.0])?;
    let (mut answer, mut reasoning) = (String::new(), String::new());
    while let Some(row) = rows.next()? {
        let text = row.get_ref(1)?.as_str()?;
        if row.get(0)? {
            &mut reasoning
        } else {
            &mut answer
        }
        .push_str(text);
    }
    Ok((answer, reasoning))
}

/// A run with the pieces that have arrived so far.
pub fn with_pieces(connection: &Connection, mut run: Run) -> Result<Run, StoreError> {
    let (answer, reasoning) = pieces(connection, run.id)?;
    run.answer.push_str(&answer);
    run.reasoning.push_str(&reasoning);
    Ok(run)
}
