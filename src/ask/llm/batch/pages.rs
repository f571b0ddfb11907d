//! Paginated lists, bounded in length and free of duplicate pages.

use std::collections::HashSet;
use std::time::Instant;

use super::super::error::{Error, TimeoutKind};
use super::call::Calls;

/// Most pages of a list. With a hundred batches each this is more than any account has.
const MOST_PAGES: usize = 200;

/// Most entries of one page.
const MOST_ENTRIES: usize = 10_000;

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
        if entries > MOST_ENTRIES {
            let what = format!("a page of {entries} batches; at most {MOST_ENTRIES} are read");
            return Err(calls.malformed(&what));
        }
        let Some(next) = next else { return Ok(()) };
        if !self.seen.insert(next.to_owned()) {
            let what = format!("endless list of batches: the page after `{next}` repeats");
            return Err(calls.malformed(&what));
        }
        if self.seen.len() >= MOST_PAGES {
            let what = format!("endless list of batches: more than {MOST_PAGES} pages");
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
