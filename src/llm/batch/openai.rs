//! OpenAI's batches: a file of lines, a batch over it, and files of results.

use serde_json::{Value, json};

use super::super::dialect::Dialect;
use super::super::error::Error;
use super::call::{Again, Calls};
use super::pages::Pages;
use super::{Found, Mark, Outcome, SLACK, State, Status, read};

/// What the address of questions ends in.
const METHODS: [&str; 2] = ["/chat/completions", "/responses"];

/// The name under which a batch carries its tag.
const TAG: &str = "nearmiss";

/// Uploads the questions.
pub async fn prepare<'a>(
    calls: &Calls,
    tag: &str,
    bodies: impl Iterator<Item = (&'a str, Value)>,
) -> Result<Value, Error> {
    let method = match calls.endpoint().dialect {
        Dialect::OpenAiResponses => "/v1/responses",
        _ => "/v1/chat/completions",
    };
    let line = |(id, body): (&str, Value)| {
        json!({"custom_id": id, "method": "POST", "url": method, "body": body}).to_string() + "\n"
    };
    let lines: String = bodies.map(line).collect();
    // Nothing in JSON on one line begins a line with two dashes.
    let form = format!(
        "--{tag}\r\nContent-Disposition: form-data; name=\"purpose\"\r\n\r\nbatch\r\n\
         --{tag}\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{tag}.jsonl\"\r\n\
         Content-Type: application/jsonl\r\n\r\n{lines}\r\n--{tag}--\r\n"
    );
    let kind = format!("multipart/form-data; boundary={tag}");
    let url = calls.url(&METHODS, &["files"])?;
    let file = calls.upload(url, kind, form.into_bytes()).await?;
    let file = calls.id(&file, "id")?;
    Ok(json!({
        "input_file_id": file, "endpoint": method, "completion_window": "24h", "metadata": {TAG: tag},
    }))
}

pub async fn create(calls: &Calls, prepared: &Value) -> Result<Value, Error> {
    let url = calls.url(&METHODS, &["batches"])?;
    calls.post(url, prepared, Again::Refused).await
}

pub async fn look_up(calls: &Calls, mark: Mark<'_>) -> Result<Found, Error> {
    let mut after: Option<String> = None;
    let mut pages = Pages::new();
    loop {
        let mut url = calls.url(&METHODS, &["batches"])?;
        url.query_pairs_mut().append_pair("limit", "100");
        if let Some(after) = &after {
            url.query_pairs_mut().append_pair("after", after);
        }
        let page = calls.page(url).await?;
        let Some(batches) = page.get("data").and_then(Value::as_array) else {
            return Err(calls.malformed(&format!("no list of batches: {page}")));
        };
        for batch in batches {
            let tag = batch.pointer("/metadata/nearmiss").and_then(Value::as_str);
            if tag == Some(mark.tag) {
                return calls.id(batch, "id").map(Found::Batch);
            }
            // The newest come first.
            let created = batch.get("created_at").and_then(Value::as_i64);
            if created.is_some_and(|at| at.saturating_add(SLACK) < mark.since.as_second()) {
                return Ok(Found::Nothing);
            }
        }
        let more = page.get("has_more").and_then(Value::as_bool) == Some(true);
        after = match batches.last() {
            Some(last) if more => Some(calls.id(last, "id")?),
            _ => None,
        };
        pages.turn(calls, batches.len(), after.as_deref())?;
        if after.is_none() {
            return Ok(Found::Nothing);
        }
    }
}

pub async fn status(calls: &Calls, id: &str) -> Result<Status, Error> {
    let document = calls.get(calls.url(&METHODS, &["batches", id])?).await?;
    let state = match document.get("status").and_then(Value::as_str) {
        Some("validating" | "in_progress" | "finalizing") => State::Working,
        Some("cancelling") => State::Cancelling,
        Some("completed") => State::Ended,
        Some("cancelled") => State::Cancelled,
        Some("expired") => State::Expired,
        Some("failed") => State::Failed,
        _ => return Err(calls.malformed(&format!("no known status of a batch: {document}"))),
    };
    let count = |name: &str| {
        let count = document.pointer(&format!("/request_counts/{name}"));
        count.and_then(Value::as_u64).unwrap_or(0)
    };
    let errors = document.pointer("/errors/data").and_then(Value::as_array);
    let errors = errors.into_iter().flatten().take(3);
    let words: Vec<_> = errors.filter_map(|e| e.get("message")?.as_str()).collect();
    let problem = (!words.is_empty()).then(|| read::line(calls, &words.join("; ")));
    Ok(Status {
        state,
        answered: count("completed"),
        failed: count("failed"),
        problem,
        document,
    })
}

pub async fn results<E: From<Error>>(
    calls: &Calls,
    batch: &Value,
    each: &mut impl FnMut(&str, Outcome) -> Result<(), E>,
) -> Result<bool, E> {
    let mut certain = true;
    for field in ["output_file_id", "error_file_id"] {
        if batch.get(field).is_none_or(Value::is_null) {
            continue;
        }
        let file = calls.id(batch, field)?;
        let url = calls.url(&METHODS, &["files", &file, "content"])?;
        certain &= calls
            .lines(url, |line| {
                let Some(id) = line.get("custom_id").and_then(Value::as_str) else {
                    return Err(calls.malformed(&format!("no custom_id: {line}")).into());
                };
                each(id, outcome(calls, &line))
            })
            .await?;
    }
    Ok(certain)
}

fn outcome(calls: &Calls, line: &Value) -> Outcome {
    let code = line.pointer("/error/code").and_then(Value::as_str);
    match (code, line.pointer("/response/body")) {
        (Some("batch_expired"), _) => Outcome::Expired,
        (Some("batch_cancelled"), _) => Outcome::Cancelled,
        (None, Some(body)) if !body.is_null() => {
            let status = line
                .pointer("/response/status_code")
                .and_then(Value::as_u64);
            match status {
                Some(200..=299) | None => read::answer(calls, body),
                Some(_) => read::failed(calls, body, status),
            }
        }
        _ => read::failed(calls, line, None),
    }
}

pub async fn cancel(calls: &Calls, id: &str) -> Result<(), Error> {
    let url = calls.url(&METHODS, &["batches", id, "cancel"])?;
    let asked = calls.post(url, &json!({}), Again::Harmless).await;
    asked.map(drop)
}
