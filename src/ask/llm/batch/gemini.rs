//! Gemini's batches: questions inline in the request, and an operation that holds the results or names their file.

use reqwest::Url;
use serde_json::{Value, json};

use super::super::error::Error;
use super::api::{BatchApi, Match, Results, Submission};
use super::call::Calls;
use super::{BatchState, Outcome, Status, SubmissionMark};

/// Suffix of the questions' address, before the model.
const MODELS: [&str; 1] = ["/models"];

/// Gemini's batches.
#[derive(Debug)]
pub struct GeminiBatches;

impl BatchApi for GeminiBatches {
    fn submission(
        &self,
        _calls: &Calls,
        tag: &str,
        questions: &mut dyn Iterator<Item = (&str, Value)>,
    ) -> Result<Submission, Error> {
        let requests =
            questions.map(|(id, body)| json!({"request": body, "metadata": {"key": id}}));
        let requests: Vec<_> = requests.collect();
        Ok(Submission::Document(json!({"batch": {
            "displayName": name(tag),
            "inputConfig": {"requests": {"requests": requests}},
        }})))
    }

    fn create_url(&self, calls: &Calls, model: &str) -> Result<Url, Error> {
        let model = model.strip_prefix("models/").unwrap_or(model);
        calls.url(&[], &[&format!("{model}:batchGenerateContent")])
    }

    fn id_field(&self) -> &'static str {
        "name"
    }

    fn list_url(&self, calls: &Calls, after: Option<&str>) -> Result<Url, Error> {
        let mut url = calls.url(&MODELS, &["batches"])?;
        url.query_pairs_mut().append_pair("pageSize", "100");
        if let Some(token) = after {
            url.query_pairs_mut().append_pair("pageToken", token);
        }
        Ok(url)
    }

    fn batches<'a>(&self, _calls: &Calls, page: &'a Value) -> Result<&'a [Value], Error> {
        let operations = page.get("operations").and_then(Value::as_array);
        Ok(operations.map_or(&[], Vec::as_slice))
    }

    fn next_page(&self, _calls: &Calls, page: &Value) -> Result<Option<String>, Error> {
        let next = page.get("nextPageToken").and_then(Value::as_str);
        Ok(next.filter(|token| !token.is_empty()).map(str::to_owned))
    }

    fn recognise(
        &self,
        calls: &Calls,
        batch: &Value,
        mark: &SubmissionMark<'_>,
    ) -> Result<Match, Error> {
        let shown = batch
            .pointer("/metadata/displayName")
            .and_then(Value::as_str);
        if shown == Some(&name(mark.tag)) {
            calls.id(batch, self.id_field()).map(Match::Yes)
        } else {
            Ok(Match::No)
        }
    }

    fn status_url(&self, calls: &Calls, id: &str) -> Result<Url, Error> {
        operation(calls, id, "")
    }

    fn status(&self, calls: &Calls, document: Value) -> Result<Status, Error> {
        let state = document.pointer("/metadata/state").and_then(Value::as_str);
        // The documentation and the server disagree about the first word.
        let word = state.map(|s| {
            s.trim_start_matches("BATCH_STATE_")
                .trim_start_matches("JOB_STATE_")
        });
        let state = match word {
            Some("PENDING" | "QUEUED" | "RUNNING" | "UNSPECIFIED") => BatchState::Working,
            Some("CANCELLING") => BatchState::Cancelling,
            Some("SUCCEEDED" | "PARTIALLY_SUCCEEDED") => BatchState::Ended,
            Some("CANCELLED") => BatchState::Cancelled,
            Some("EXPIRED") => BatchState::Expired,
            Some("FAILED") => BatchState::Failed,
            _ => return Err(calls.malformed(&format!("unknown batch state: {document}"))),
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
            problem: problem.map(|words| super::line(calls, words)),
            document,
        })
    }

    fn results<'a>(
        &self,
        calls: &Calls,
        _id: &str,
        document: &'a Value,
    ) -> Vec<Result<Results<'a>, Error>> {
        let outputs = ["/response", "/metadata/output"].into_iter();
        let places = outputs.filter_map(|holder| {
            let output = document.pointer(holder)?;
            let inline = output.pointer("/inlinedResponses/inlinedResponses");
            if let Some(responses) = inline.and_then(Value::as_array) {
                return Some(Ok(Results::Inline(responses)));
            }
            output.get("responsesFile")?.as_str()?;
            let file = calls.id(output, "responsesFile");
            let url = file.and_then(|file| download(calls, &file));
            Some(url.map(Results::Lines))
        });
        // The one is a copy of the other.
        places.take(1).collect()
    }

    fn result<'a>(&self, calls: &Calls, entry: &'a Value) -> Result<(&'a str, Outcome), Error> {
        // A line of a file has the key itself, an entry of the document has it among what was sent along.
        let key = entry.get("key").or_else(|| entry.pointer("/metadata/key"));
        match key.and_then(Value::as_str) {
            Some(key) => Ok((key, outcome(calls, entry))),
            None => Err(calls.malformed(&format!("no key: {entry}"))),
        }
    }

    fn cancel_url(&self, calls: &Calls, id: &str) -> Result<Url, Error> {
        operation(calls, id, ":cancel")
    }
}

/// The name that people see in the provider's console.
fn name(tag: &str) -> String {
    format!("nearmiss-{tag}")
}

/// The address of an operation, `batches/…`, perhaps with a method.
fn operation(calls: &Calls, id: &str, method: &str) -> Result<Url, Error> {
    let id = format!("{id}{method}");
    calls.url(&MODELS, &id.split('/').collect::<Vec<_>>())
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
        Some(response) if !response.is_null() => super::answer(calls, response),
        _ => super::failed(calls, line, None),
    }
}
