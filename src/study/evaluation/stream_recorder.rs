//! Records a run in the store as it streams: chunks in small batches, the claim renewed, the end in any case.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::Instant;

use super::run_case::Event;
use nearmiss_ask::llm::Chunk;
use nearmiss_store::{AnswerPiece, Ending, RENEWAL, RunId, RunState, Store, StoreError};

/// The longest that a piece waits for others before all are written, and shown.
const INTERVAL: Duration = Duration::from_millis(50);

/// Bytes that are written at once, however short the wait.
const BATCH: usize = 4096;

/// Stores the chunks of one answer, and releases them for display once stored.
///
/// A lone chunk is written at once; of chunks in quick succession, those of [`INTERVAL`] are written in one
/// transaction. Dropped before its end, the run is recorded as cancelled.
///
/// If the store fails, the answer is already paid for: it is still received and shown, and its end is written with the
/// whole text if the store is writable again by then.
pub struct StreamRecorder {
    kept: Option<(Arc<Store>, RunId)>,
    waiting: Vec<Chunk>,
    bytes: usize,
    flushed: Option<Instant>,
    renewed: Instant,
    /// Why the store does not have all pieces so far.
    failed: Option<StoreError>,
}

impl StreamRecorder {
    /// For a run that was granted, or one that is not kept.
    pub fn new(kept: Option<(Arc<Store>, RunId)>) -> Self {
        Self {
            kept,
            waiting: Vec::new(),
            bytes: 0,
            flushed: None,
            renewed: Instant::now(),
            failed: None,
        }
    }

    /// Takes a piece, a [`Chunk::Reasoning`] or [`Chunk::Text`].
    pub fn take(&mut self, piece: Chunk) {
        if let Chunk::Reasoning(text) | Chunk::Text(text) = &piece {
            self.bytes += text.len();
        }
        self.waiting.push(piece);
    }

    /// When [`StreamRecorder::flush_due`] is due.
    pub fn due(&self) -> Instant {
        let renewal = self.renewed + RENEWAL;
        match self.flushed {
            _ if self.waiting.is_empty() => renewal,
            Some(flushed) if self.bytes < BATCH => renewal.min(flushed + INTERVAL),
            _ => Instant::now(),
        }
    }

    /// Writes the waiting pieces if they are due, then shows them; renews the claim if that is due.
    pub fn flush_due(&mut self, on_event: &mut impl FnMut(Event)) {
        if self.due() > Instant::now() {
            return;
        }
        let written = match (&self.kept, &self.failed) {
            (Some((store, run)), None) if self.waiting.is_empty() => store.renew(*run),
            (Some((store, run)), None) => store.append(*run, &pieces(&joined(&self.waiting))),
            // Each try may wait for a lock; the next one is the end.
            _ => Ok(()),
        };
        self.failed = self.failed.take().or(written.err());
        self.renewed = Instant::now();
        if !self.waiting.is_empty() {
            self.waiting
                .drain(..)
                .map(Event::Chunk)
                .for_each(&mut *on_event);
            self.bytes = 0;
            self.flushed = Some(Instant::now());
        }
    }

    /// Writes down the waiting pieces and how it ended, in one transaction, then shows the pieces. `whole` are
    /// reasoning and text, which are written anew where pieces of them are missing.
    pub fn finish(
        mut self,
        ending: &Ending,
        (reasoning, text): (&str, &str),
        on_event: &mut impl FnMut(Event),
    ) -> Result<(), StoreError> {
        let kept = match (self.kept.take(), self.failed.take()) {
            (None, _) => Ok(()),
            (Some((store, run)), None) => {
                store.conclude(run, &pieces(&joined(&self.waiting)), ending)
            }
            (Some((store, run)), Some(first)) => store
                .conclude_whole(run, reasoning, text, ending)
                .map_err(|_| first),
        };
        self.waiting.drain(..).map(Event::Chunk).for_each(on_event);
        kept
    }
}

fn pieces(joined: &[(bool, String)]) -> Vec<AnswerPiece<'_>> {
    joined
        .iter()
        .map(|(reasoning, text)| {
            if *reasoning {
                AnswerPiece::Reasoning(text)
            } else {
                AnswerPiece::Answer(text)
            }
        })
        .collect()
}

/// The texts, those that follow each other and are of one kind put together.
fn joined(chunks: &[Chunk]) -> Vec<(bool, String)> {
    let mut joined: Vec<(bool, String)> = Vec::new();
    for chunk in chunks {
        let (reasoning, text) = match chunk {
            Chunk::Reasoning(text) => (true, text),
            Chunk::Text(text) => (false, text),
            _ => continue,
        };
        match joined.last_mut() {
            Some((kind, all)) if *kind == reasoning => all.push_str(text),
            _ => joined.push((reasoning, text.clone())),
        }
    }
    joined
}

impl Drop for StreamRecorder {
    fn drop(&mut self) {
        if let Some((store, run)) = self.kept.take() {
            // An error has no receiver here.
            let joined = joined(&self.waiting);
            let _ = store.conclude(run, &pieces(&joined), &Ending::bare(RunState::Cancelled));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_scene::verdict::Task;
    use nearmiss_store::{Claim, NewRun};

    #[test]
    fn the_last_piece_is_shown_when_the_answer_is_kept_as_whole() {
        let store = Arc::new(Store::in_memory().unwrap());
        let text = |s: &str| s.to_string();
        let question = NewRun {
            sample: 0,
            batch: None,
            scenario: text("ZAM_A-1"),
            scenario_hash: None,
            ego: text("1"),
            task: Task::Collision,
            frame: text("ego"),
            techniques: text("base"),
            window: None,
            model: text("local/x"),
            provider: text("local"),
            dialect: None,
            endpoint: text("local"),
            address: None,
            template: text("t.md"),
            template_version: None,
            template_hash: text("th"),
            messages: text("[]"),
            parameters: text("{}"),
            answer_schema: None,
            images: Vec::new(),
        };
        let Claim::Granted(run) = store.claim(&question, true).unwrap() else {
            panic!("no other program asks");
        };
        let mut recorder = StreamRecorder::new(Some((store.clone(), run)));
        recorder.take(Chunk::Reasoning("because".into()));
        recorder.take(Chunk::Text("yes".into()));
        let mut shown = Vec::new();
        let ending = Ending::bare(RunState::Answered);
        recorder
            .finish(&ending, ("because", "yes"), &mut |event| {
                let kept = store.run(run).unwrap().unwrap();
                shown.push((event, kept.ending.state, kept.answer));
            })
            .unwrap();
        let whole = |event| (event, RunState::Answered, "yes".to_string());
        let pieces = [
            Event::Chunk(Chunk::Reasoning("because".into())),
            Event::Chunk(Chunk::Text("yes".into())),
        ];
        assert_eq!(shown, pieces.map(whole));
    }
}
