//! The batch API of a wire protocol: addresses, documents and their meaning, lists in pages. Implementations do no I/O.

use std::collections::HashSet;
use std::fmt::Debug;
use std::time::Instant;

use reqwest::Url;
use serde_json::Value;

use super::super::error::{Error, TimeoutKind};
use super::call::Calls;
use super::{Outcome, Status, SubmissionMark};

/// The batches of one wire protocol.
pub trait BatchApi: Debug + Sync {
    /// The requests that submit these questions, bodies by their ids.
    fn submission(
        &self,
        calls: &Calls,
        tag: &str,
        questions: &mut dyn Iterator<Item = (&str, Value)>,
    ) -> Result<Submission, Error>;

    /// Where a batch of a model is asked for.
    fn create_url(&self, calls: &Calls, model: &str) -> Result<Url, Error>;

    /// The field that holds the id of a batch.
    fn id_field(&self) -> &'static str {
        "id"
    }

    /// Where a page of the list of batches is, by what the page before says of it.
    fn list_url(&self, calls: &Calls, after: Option<&str>) -> Result<Url, Error>;

    /// The batches of a page, the newest first.
    fn batches<'a>(&self, calls: &Calls, page: &'a Value) -> Result<&'a [Value], Error> {
        let batches = page.get("data").and_then(Value::as_array);
        let no_list = || calls.malformed(&format!("no list of batches: {page}"));
        batches.map(Vec::as_slice).ok_or_else(no_list)
    }

    /// The cursor of the next page; `None` after the last.
    fn next_page(&self, calls: &Calls, page: &Value) -> Result<Option<String>, Error> {
        let more = page.get("has_more").and_then(Value::as_bool) == Some(true);
        let last = page
            .pointer("/data")
            .and_then(|data| data.as_array()?.last())
            .filter(|_| more);
        last.map(|last| calls.id(last, "id")).transpose()
    }

    /// Whether a listed batch is the one sought.
    fn recognise(
        &self,
        calls: &Calls,
        batch: &Value,
        mark: &SubmissionMark<'_>,
    ) -> Result<Match, Error>;

    /// Where the document about a batch is.
    fn status_url(&self, calls: &Calls, id: &str) -> Result<Url, Error>;

    /// Parses the document about a batch.
    fn status(&self, calls: &Calls, document: Value) -> Result<Status, Error>;

    /// Where the results of a batch are, in order; an error stands for a place that cannot be read.
    fn results<'a>(
        &self,
        calls: &Calls,
        id: &str,
        document: &'a Value,
    ) -> Vec<Result<Results<'a>, Error>>;

    /// The id of a question and what came of it.
    fn result<'a>(&self, calls: &Calls, entry: &'a Value) -> Result<(&'a str, Outcome), Error>;

    /// Where a batch is cancelled.
    fn cancel_url(&self, calls: &Calls, id: &str) -> Result<Url, Error>;
}

/// The requests needed to submit a batch.
pub enum Submission {
    /// A document with the questions in it.
    Document(Value),
    /// A file with the questions, and a document that names it.
    File {
        /// Where the file goes.
        url: Url,
        /// Its type on the wire.
        content_type: String,
        /// The body of the upload.
        body: Vec<u8>,
        /// The document, in which `field` becomes the id of the file.
        document: Value,
        /// Where in the document the id of the file belongs.
        field: &'static str,
    },
}

/// How a listed batch relates to the one looked up.
pub enum Match {
    /// It is the one.
    Yes(String),
    /// It is another.
    No,
    /// It and all that follow are too old to be the one.
    TooOld,
    /// It may be the one, which cannot be told before it has ended.
    Perhaps(String),
    /// It may be the one, which the ids of its results tell.
    ByResults(String),
}

/// A place where results are.
pub enum Results<'a> {
    /// In the document about the batch.
    Inline(&'a [Value]),
    /// At an address, a JSON document a line.
    Lines(Url),
}

/// Most pages of a list. With a hundred batches each this is more than any account has.
const MAX_PAGES: usize = 200;

/// Most entries of one page.
const MAX_ENTRIES: usize = 10_000;

/// The pages of one list so far.
#[derive(Debug)]
pub struct Pages {
    begun: Instant,
    /// Cursors of the pages requested so far.
    seen: HashSet<String>,
}

impl Pages {
    /// No page yet; the clock starts.
    pub fn new() -> Self {
        Self {
            begun: Instant::now(),
            seen: HashSet::new(),
        }
    }

    /// Accepts a page with this many entries, followed by the one that `next` requests.
    ///
    /// # Errors
    /// The list does not end: the server repeats itself, or sends more pages than any real list has.
    pub fn turn(&mut self, calls: &Calls, entries: usize, next: Option<&str>) -> Result<(), Error> {
        if entries > MAX_ENTRIES {
            let what = format!("a page of {entries} batches; at most {MAX_ENTRIES} are read");
            return Err(calls.malformed(&what));
        }
        let Some(next) = next else { return Ok(()) };
        if !self.seen.insert(next.to_owned()) {
            let what = format!("endless list of batches: the page after `{next}` repeats");
            return Err(calls.malformed(&what));
        }
        if self.seen.len() >= MAX_PAGES {
            let what = format!("endless list of batches: more than {MAX_PAGES} pages");
            return Err(calls.malformed(&what));
        }
        let after = calls.endpoint().timeouts.total;
        if self.begun.elapsed() > after {
            return Err(Error::Timeout {
                place: calls.endpoint().place(),
                which: TimeoutKind::Total,
                after,
            });
        }
        Ok(())
    }
}
