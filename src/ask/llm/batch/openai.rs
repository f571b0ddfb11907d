//! OpenAI's batches: an input file of JSON lines, a batch over it, and result files.

use reqwest::Url;
use serde_json::{Value, json};

use super::super::error::Error;
use super::api::{BatchApi, Match, Results, Submission};
use super::call::Calls;
use super::{BatchState, CLOCK_SKEW, Outcome, Status, SubmissionMark};

/// Suffixes of the questions' address.
const METHODS: [&str; 2] = ["/chat/completions", "/responses"];

/// The name under which a batch carries its tag.
const TAG: &str = "nearmiss";

/// Batches of questions to one of OpenAI's two APIs.
#[derive(Debug)]
pub struct OpenAiBatches {
    /// The path of the API that answers the questions.
    pub endpoint: &'static str,
}

impl BatchApi for OpenAiBatches {
    fn submission(
        &self,
        calls: &Calls,
        tag: &str,
        questions: &mut dyn Iterator<Item = (&str, Value)>,
    ) -> Result<Submission, Error> {
        let endpoint = self.endpoint;
        let line = |(id, body): (&str, Value)| {
            json!({"custom_id": id, "method": "POST", "url": endpoint, "body": body}).to_string()
                + "\n"
        };
        let lines: String = questions.map(line).collect();
        // JSON on one line never begins a line with two dashes.
        let form = format!(
            "--{tag}\r\nContent-Disposition: form-data; name=\"purpose\"\r\n\r\nbatch\r\n\
             --{tag}\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{tag}.jsonl\"\r\n\
             Content-Type: application/jsonl\r\n\r\n{lines}\r\n--{tag}--\r\n"
        );
        Ok(Submission::File {
            url: calls.url(&METHODS, &["files"])?,
            content_type: format!("multipart/form-data; boundary={tag}"),
            body: form.into_bytes(),
            document: json!({
                "input_file_id": null, "endpoint": endpoint, "completion_window": "24h",
                "metadata": {TAG: tag},
            }),
            field: "input_file_id",
        })
    }

    fn create_url(&self, calls: &Calls, _model: &str) -> Result<Url, Error> {
        calls.url(&METHODS, &["batches"])
    }

    fn list_url(&self, calls: &Calls, after: Option<&str>) -> Result<Url, Error> {
        let mut url = calls.url(&METHODS, &["batches"])?;
        url.query_pairs_mut().append_pair("limit", "100");
        if let Some(after) = after {
            url.query_pairs_mut().append_pair("after", after);
        }
        Ok(url)
    }

    fn recognise(
        &self,
        calls: &Calls,
        batch: &Value,
        mark: &SubmissionMark<'_>,
    ) -> Result<Match, Error> {
        let tag = batch.pointer("/metadata/nearmiss").and_then(Value::as_str);
        if tag == Some(mark.tag) {
            return calls.id(batch, "id").map(Match::Yes);
        }
        let created = batch.get("created_at").and_then(Value::as_i64);
        let too_old =
            created.is_some_and(|at| at.saturating_add(CLOCK_SKEW) < mark.since.as_second());
        Ok(if too_old { Match::TooOld } else { Match::No })
    }

    fn status_url(&self, calls: &Calls, id: &str) -> Result<Url, Error> {
        calls.url(&METHODS, &["batches", id])
    }

    fn status(&self, calls: &Calls, document: Value) -> Result<Status, Error> {
        let state = match document.get("status").and_then(Value::as_str) {
            Some("validating" | "in_progress" | "finalizing") => BatchState::Working,
            Some("cancelling") => BatchState::Cancelling,
            Some("completed") => BatchState::Ended,
            Some("cancelled") => BatchState::Cancelled,
            Some("expired") => BatchState::Expired,
            Some("failed") => BatchState::Failed,
            _ => return Err(calls.malformed(&format!("unknown batch status: {document}"))),
        };
        let count = |name: &str| {
            let count = document.pointer(&format!("/request_counts/{name}"));
            count.and_then(Value::as_u64).unwrap_or(0)
        };
        let errors = document
            .pointer("/errors/data")
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
            .take(3);
        let words: Vec<_> = errors.filter_map(|e| e.get("message")?.as_str()).collect();
        let problem = (!words.is_empty()).then(|| super::line(calls, &words.join("; ")));
        Ok(Status {
            state,
            answered: count("completed"),
            failed: count("failed"),
            problem,
            document,
        })
    }

    fn results<'a>(
        &self,
        calls: &Calls,
        _id: &str,
        document: &'a Value,
    ) -> Vec<Result<Results<'a>, Error>> {
        let fields = ["output_file_id", "error_file_id"].into_iter();
        let there = fields.filter(|field| document.get(field).is_some_and(|id| !id.is_null()));
        let place = |field| {
            let file = calls.id(document, field)?;
            let url = calls.url(&METHODS, &["files", &file, "content"])?;
            Ok(Results::Lines(url))
        };
        there.map(place).collect()
    }

    fn result<'a>(&self, calls: &Calls, entry: &'a Value) -> Result<(&'a str, Outcome), Error> {
        Ok((super::custom_id(calls, entry)?, outcome(calls, entry)))
    }

    fn cancel_url(&self, calls: &Calls, id: &str) -> Result<Url, Error> {
        calls.url(&METHODS, &["batches", id, "cancel"])
    }
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
                Some(200..=299) | None => super::answer(calls, body),
                Some(_) => super::failed(calls, body, status),
            }
        }
        _ => super::failed(calls, line, None),
    }
}
