//! Gemini's batches: questions in the request itself, and an operation that holds its results, or names their file.

use reqwest::Url;
use serde_json::{Value, json};

use super::super::error::Error;
use super::call::{Again, Calls};
use super::pages::Pages;
use super::{Found, Mark, Outcome, State, Status, read};

/// What the address of questions ends in, before the model.
const MODELS: [&str; 1] = ["/models"];

pub fn prepared<'a>(tag: &str, bodies: impl Iterator<Item = (&'a str, Value)>) -> Value {
    let requests = bodies.map(|(id, body)| json!({"request": body, "metadata": {"key": id}}));
    json!({"batch": {
        "displayName": name(tag),
        "inputConfig": {"requests": {"requests": requests.collect::<Vec<_>>()}},
    }})
}

/// The name that people see in the provider's console.
fn name(tag: &str) -> String {
    format!("nearmiss-{tag}")
}

pub async fn create(calls: &Calls, model: &str, prepared: &Value) -> Result<Value, Error> {
    let model = model.strip_prefix("models/").unwrap_or(model);
    let method = format!("{model}:batchGenerateContent");
    let url = calls.url(&[], &[&method])?;
    calls.post(url, prepared, Again::Refused).await
}

/// The address of an operation, `batches/…`, perhaps with a method.
fn operation(calls: &Calls, id: &str, method: &str) -> Result<Url, Error> {
    let id = format!("{id}{method}");
    calls.url(&MODELS, &id.split('/').collect::<Vec<_>>())
}

pub async fn look_up(calls: &Calls, mark: Mark<'_>) -> Result<Found, Error> {
    let mut token: Option<String> = None;
    let mut pages = Pages::new();
    loop {
        let mut url = calls.url(&MODELS, &["batches"])?;
        url.query_pairs_mut().append_pair("pageSize", "100");
        if let Some(token) = &token {
            url.query_pairs_mut().append_pair("pageToken", token);
        }
        let page = calls.page(url).await?;
        let operations = page.get("operations").and_then(Value::as_array);
        let entries = operations.map_or(0, Vec::len);
        for operation in operations.into_iter().flatten() {
            let shown = operation.pointer("/metadata/displayName");
            if shown.and_then(Value::as_str) == Some(&name(mark.tag)) {
                return calls.id(operation, "name").map(Found::Batch);
            }
        }
        let next = page.get("nextPageToken").and_then(Value::as_str);
        token = next.filter(|token| !token.is_empty()).map(str::to_owned);
        pages.turn(calls, entries, token.as_deref())?;
        if token.is_none() {
            return Ok(Found::Nothing);
        }
    }
}

pub async fn status(calls: &Calls, id: &str) -> Result<Status, Error> {
    let document = calls.get(operation(calls, id, "")?).await?;
    let state = document.pointer("/metadata/state").and_then(Value::as_str);
    // The documentation and the server disagree about the first word.
    let word = state.map(|s| {
        s.trim_start_matches("BATCH_STATE_")
            .trim_start_matches("JOB_STATE_")
    });
    let state = match word {
        Some("PENDING" | "QUEUED" | "RUNNING" | "UNSPECIFIED") => State::Working,
        Some("CANCELLING") => State::Cancelling,
        Some("SUCCEEDED" | "PARTIALLY_SUCCEEDED") => State::Ended,
        Some("CANCELLED") => State::Cancelled,
        Some("EXPIRED") => State::Expired,
        Some("FAILED") => State::Failed,
        _ => return Err(calls.malformed(&format!("no known state of a batch: {document}"))),
    };
    let count = |name: &str| {
        let count = document.pointer(&format!("/metadata/batchStats/{name}"));
        let words = |value: &Value| value.as_str().and_then(|text| text.parse().ok());
        count
            .and_then(|value| value.as_u64().or_else(|| words(value)))
            .unwrap_or(0)
    };
    let problem = document.pointer("/error/message").and_then(Value::as_str);
    Ok(Status {
        state,
        answered: count("successfulRequestCount"),
        failed: count("failedRequestCount"),
        problem: problem.map(|words| read::line(calls, words)),
        document,
    })
}

pub async fn results<E: From<Error>>(
    calls: &Calls,
    operation: &Value,
    each: &mut impl FnMut(&str, Outcome) -> Result<(), E>,
) -> Result<bool, E> {
    for holder in ["/response", "/metadata/output"] {
        let Some(output) = operation.pointer(holder) else {
            continue;
        };
        let inline = output.pointer("/inlinedResponses/inlinedResponses");
        if let Some(responses) = inline.and_then(Value::as_array) {
            for response in responses {
                let key = response.pointer("/metadata/key").and_then(Value::as_str);
                let Some(key) = key else {
                    return Err(calls.malformed(&format!("no key: {response}")).into());
                };
                each(key, outcome(calls, response))?;
            }
            return Ok(true);
        }
        if output.get("responsesFile").is_some_and(Value::is_string) {
            let file = calls.id(output, "responsesFile")?;
            let url = download(calls, &file)?;
            return calls
                .lines(url, |line| match line.get("key").and_then(Value::as_str) {
                    Some(key) => each(key, outcome(calls, &line)),
                    None => Err(calls.malformed(&format!("no key: {line}")).into()),
                })
                .await;
        }
    }
    Ok(true)
}

/// The address of a file's content: `/download` stands before the version.
fn download(calls: &Calls, file: &str) -> Result<Url, Error> {
    let mut url = operation(calls, file, ":download")?;
    let path = format!("/download{}", url.path());
    url.set_path(&path);
    url.query_pairs_mut().append_pair("alt", "media");
    Ok(url)
}

fn outcome(calls: &Calls, line: &Value) -> Outcome {
    match line.get("response") {
        Some(response) if !response.is_null() => read::answer(calls, response),
        _ => read::failed(calls, line, None),
    }
}

pub async fn cancel(calls: &Calls, id: &str) -> Result<(), Error> {
    let url = operation(calls, id, ":cancel")?;
    let asked = calls.post(url, &json!({}), Again::Harmless).await;
    asked.map(drop)
}
