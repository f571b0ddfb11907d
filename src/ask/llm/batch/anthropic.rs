//! Anthropic's message batches: questions inline in the request, results as JSON lines. A batch carries no metadata of
//! ours, so it is recognised by the ids of its questions, which are visible only once it has ended.

use jiff::Timestamp;
use reqwest::Url;
use serde_json::{Value, json};

use super::super::error::Error;
use super::api::{BatchApi, Match, Results, Submission};
use super::call::Calls;
use super::{BatchState, CLOCK_SKEW, Outcome, Status, SubmissionMark};

/// Anthropic's batches.
#[derive(Debug)]
pub struct AnthropicBatches;

impl BatchApi for AnthropicBatches {
    fn submission(
        &self,
        _calls: &Calls,
        _tag: &str,
        questions: &mut dyn Iterator<Item = (&str, Value)>,
    ) -> Result<Submission, Error> {
        let requests = questions.map(|(id, body)| json!({"custom_id": id, "params": body}));
        let requests: Vec<_> = requests.collect();
        Ok(Submission::Document(json!({"requests": requests})))
    }

    fn create_url(&self, calls: &Calls, _model: &str) -> Result<Url, Error> {
        calls.url(&[], &["batches"])
    }

    fn list_url(&self, calls: &Calls, after: Option<&str>) -> Result<Url, Error> {
        let mut url = calls.url(&[], &["batches"])?;
        url.query_pairs_mut().append_pair("limit", "100");
        if let Some(after) = after {
            url.query_pairs_mut().append_pair("after_id", after);
        }
        Ok(url)
    }

    fn recognise(
        &self,
        calls: &Calls,
        batch: &Value,
        mark: &SubmissionMark<'_>,
    ) -> Result<Match, Error> {
        let created = batch
            .get("created_at")
            .and_then(Value::as_str)
            .and_then(|at| at.parse::<Timestamp>().ok());
        if created
            .is_some_and(|at| at.as_second().saturating_add(CLOCK_SKEW) < mark.since.as_second())
        {
            return Ok(Match::TooOld);
        }
        let id = calls.id(batch, "id")?;
        if mark.others.contains(&id) || sum(&counts(batch)) != mark.ids.len() as u64 {
            return Ok(Match::No);
        }
        let is_over = self.status(calls, batch.clone())?.state.is_over();
        Ok(if is_over {
            Match::ByResults(id)
        } else {
            Match::Perhaps(id)
        })
    }

    fn status_url(&self, calls: &Calls, id: &str) -> Result<Url, Error> {
        calls.url(&[], &["batches", id])
    }

    fn status(&self, calls: &Calls, document: Value) -> Result<Status, Error> {
        let state = match document.get("processing_status").and_then(Value::as_str) {
            Some("in_progress") => BatchState::Working,
            Some("canceling") => BatchState::Cancelling,
            Some("ended") => BatchState::Ended,
            _ => return Err(calls.malformed(&format!("unknown batch status: {document}"))),
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

    fn results<'a>(
        &self,
        calls: &Calls,
        id: &str,
        _document: &'a Value,
    ) -> Vec<Result<Results<'a>, Error>> {
        // Not the address that the batch names: the key would go wherever that leads.
        let url = calls.url(&[], &["batches", id, "results"]);
        vec![url.map(Results::Lines)]
    }

    fn result<'a>(&self, calls: &Calls, entry: &'a Value) -> Result<(&'a str, Outcome), Error> {
        let id = super::custom_id(calls, entry)?;
        let outcome = match entry.pointer("/result/type").and_then(Value::as_str) {
            Some("succeeded") => {
                let message = entry.pointer("/result/message");
                super::answer(calls, message.unwrap_or(&Value::Null))
            }
            Some("canceled") => Outcome::Cancelled,
            Some("expired") => Outcome::Expired,
            _ => super::failed(calls, entry.pointer("/result/error").unwrap_or(entry), None),
        };
        Ok((id, outcome))
    }

    fn cancel_url(&self, calls: &Calls, id: &str) -> Result<Url, Error> {
        calls.url(&[], &["batches", id, "cancel"])
    }
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
