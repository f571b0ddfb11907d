//! Anthropic's batches of messages: questions in the request itself, results as lines. A batch carries no word of ours,
//! so that one is recognised by the ids of its questions, which show only when it has ended.

use jiff::Timestamp;
use serde_json::{Value, json};

use super::super::error::Error;
use super::call::{Again, Calls};
use super::pages::Pages;
use super::{Found, Mark, Outcome, SLACK, State, Status, read};

pub fn prepared<'a>(bodies: impl Iterator<Item = (&'a str, Value)>) -> Value {
    let requests = bodies.map(|(id, body)| json!({"custom_id": id, "params": body}));
    json!({"requests": requests.collect::<Vec<_>>()})
}

pub async fn create(calls: &Calls, prepared: &Value) -> Result<Value, Error> {
    let url = calls.url(&[], &["batches"])?;
    calls.post(url, prepared, Again::Refused).await
}

pub async fn look_up(calls: &Calls, mark: Mark<'_>) -> Result<Found, Error> {
    let mut after: Option<String> = None;
    let mut perhaps = Vec::new();
    let mut pages = Pages::new();
    'pages: loop {
        let mut url = calls.url(&[], &["batches"])?;
        url.query_pairs_mut().append_pair("limit", "100");
        if let Some(after) = &after {
            url.query_pairs_mut().append_pair("after_id", after);
        }
        let page = calls.page(url).await?;
        let Some(batches) = page.get("data").and_then(Value::as_array) else {
            return Err(calls.malformed(&format!("no list of batches: {page}")));
        };
        for batch in batches {
            let created = batch.get("created_at").and_then(Value::as_str);
            let created = created.and_then(|at| at.parse::<Timestamp>().ok());
            // The newest come first.
            if created
                .is_some_and(|at| at.as_second().saturating_add(SLACK) < mark.since.as_second())
            {
                break 'pages;
            }
            let id = calls.id(batch, "id")?;
            if mark.others.contains(&id) || sum(&counts(batch)) != mark.ids.len() as u64 {
                continue;
            }
            if !status_of(calls, batch.clone())?.state.is_over() {
                perhaps.push(id);
            } else if is_ours(calls, &id, mark.ids).await? {
                return Ok(Found::Batch(id));
            }
        }
        let more = page.get("has_more").and_then(Value::as_bool) == Some(true);
        after = match batches.last() {
            Some(last) if more => Some(calls.id(last, "id")?),
            _ => None,
        };
        pages.turn(calls, batches.len(), after.as_deref())?;
        if after.is_none() {
            break;
        }
    }
    Ok(match perhaps.is_empty() {
        true => Found::Nothing,
        false => Found::Perhaps(perhaps),
    })
}

/// Whether the results of a batch are those of these questions; ids are never used twice, so that one tells.
async fn is_ours(calls: &Calls, id: &str, ids: &[String]) -> Result<bool, Error> {
    let mut ours = false;
    results(calls, id, &mut |of: &str, _| {
        ours |= ids.iter().any(|id| id == of);
        Ok::<_, Error>(())
    })
    .await?;
    Ok(ours)
}

/// The sum of counts, however large a server says they are.
fn sum(counts: &[u64]) -> u64 {
    counts.iter().fold(0, |sum, n| sum.saturating_add(*n))
}

/// Questions in work, answered, failed, cancelled and expired.
fn counts(batch: &Value) -> [u64; 5] {
    ["processing", "succeeded", "errored", "canceled", "expired"].map(|name| {
        let count = batch.pointer(&format!("/request_counts/{name}"));
        count.and_then(Value::as_u64).unwrap_or(0)
    })
}

pub async fn status(calls: &Calls, id: &str) -> Result<Status, Error> {
    let document = calls.get(calls.url(&[], &["batches", id])?).await?;
    status_of(calls, document)
}

fn status_of(calls: &Calls, document: Value) -> Result<Status, Error> {
    let state = match document.get("processing_status").and_then(Value::as_str) {
        Some("in_progress") => State::Working,
        Some("canceling") => State::Cancelling,
        Some("ended") => State::Ended,
        _ => return Err(calls.malformed(&format!("no known status of a batch: {document}"))),
    };
    let [_, answered, errored, cancelled, expired] = counts(&document);
    Ok(Status {
        state,
        answered,
        failed: sum(&[errored, cancelled, expired]),
        problem: None,
        document,
    })
}

pub async fn results<E: From<Error>>(
    calls: &Calls,
    id: &str,
    each: &mut impl FnMut(&str, Outcome) -> Result<(), E>,
) -> Result<bool, E> {
    // Not the address that the batch names: the key would go wherever that leads.
    let url = calls.url(&[], &["batches", id, "results"])?;
    calls
        .lines(url, |line| {
            let Some(id) = line.get("custom_id").and_then(Value::as_str) else {
                return Err(calls.malformed(&format!("no custom_id: {line}")).into());
            };
            let outcome = match line.pointer("/result/type").and_then(Value::as_str) {
                Some("succeeded") => {
                    let message = line.pointer("/result/message");
                    read::answer(calls, message.unwrap_or(&Value::Null))
                }
                Some("canceled") => Outcome::Cancelled,
                Some("expired") => Outcome::Expired,
                _ => {
                    let error = line.pointer("/result/error").unwrap_or(&line);
                    read::failed(calls, error, None)
                }
            };
            each(id, outcome)
        })
        .await
}

pub async fn cancel(calls: &Calls, id: &str) -> Result<(), Error> {
    let url = calls.url(&[], &["batches", id, "cancel"])?;
    let asked = calls.post(url, &json!({}), Again::Harmless).await;
    asked.map(drop)
}
