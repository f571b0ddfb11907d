//! Everything that runs or waits, and what became of what ran before in this session.

use std::time::Duration;

use crate::model::JobId;
use nearmiss_store::Consumed;

/// Work outside the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Its number.
    pub id: JobId,
    /// Its kind.
    pub kind: JobKind,
    /// Its subject, in words.
    pub title: String,
    /// Where it stands.
    pub state: JobState,
    /// When it began, since the start of the program.
    pub begun: Duration,
    /// When it ended.
    pub ended: Option<Duration>,
    /// Parts that are done.
    pub done: usize,
    /// Parts in all.
    pub of: usize,
    /// Tokens, as the servers counted them; while an answer arrives, those of its text, estimated.
    pub tokens: u64,
    /// Its cost so far, US dollars, as far as known.
    pub cost: f64,
    /// Answers whose cost is not known.
    pub unpriced: usize,
    /// Answers like the built-in judge's, others, and questions without a verdict.
    pub tally: (usize, usize, usize),
    /// Parts that are done already, for work that may tell of one part twice.
    pub parts: Vec<bool>,
    /// The name that the store knows a batch by.
    pub batch: Option<String>,
    /// Whether models are asked.
    asks: bool,
    /// Why the first part that failed did.
    pub why: Option<String>,
}

/// The kind of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobKind {
    /// A question.
    Question,
    /// One question about many scenarios.
    Batch,
    /// Facts of all scenarios.
    Survey,
    /// What the list is sorted by, by the order's id.
    Ranking(&'static str),
    /// The ego of a scenario is planned.
    Plan,
    /// A scenario is made dangerous.
    Generate,
    /// An index is read.
    Index,
}

/// Where a job stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum JobState {
    /// No answer has arrived yet; perhaps why.
    Waiting(String),
    /// It goes on.
    Running,
    /// It begins nothing more, and what it began goes on.
    Stopping,
    /// It is done, with this outcome.
    Done(String),
    /// It failed; why.
    Failed(String),
    /// It was cancelled.
    Cancelled(String),
}

impl Job {
    /// Work that begins now.
    #[must_use]
    pub fn new(id: JobId, kind: JobKind, title: String, of: usize, now: Duration) -> Self {
        Self {
            id,
            kind,
            title,
            state: JobState::Running,
            begun: now,
            ended: None,
            done: 0,
            of,
            tokens: 0,
            cost: 0.0,
            unpriced: 0,
            tally: (0, 0, 0),
            parts: Vec::new(),
            batch: None,
            asks: matches!(kind, JobKind::Question | JobKind::Batch),
            why: None,
        }
    }

    /// Whether it is not over.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.ended.is_none()
    }

    /// Whether models are asked.
    #[must_use]
    pub fn asks(&self) -> bool {
        self.asks
    }

    /// The same, where models are asked.
    #[must_use]
    pub fn asking(mut self) -> Self {
        self.asks = true;
        self
    }

    /// How long it ran, or has been running.
    #[must_use]
    pub fn took(&self, now: Duration) -> Duration {
        self.ended.unwrap_or(now).saturating_sub(self.begun)
    }

    /// It is over.
    pub fn end(&mut self, state: JobState, now: Duration) {
        self.state = state;
        self.ended = Some(now);
    }

    /// An answer that was asked for now consumed this.
    pub fn consumed(&mut self, consumed: &Consumed) {
        let counted = [consumed.input_tokens, consumed.output_tokens];
        let known = counted.into_iter().flatten();
        self.tokens = known.fold(self.tokens, u64::saturating_add);
        match consumed.cost_usd {
            Some(usd) => self.cost += usd,
            None if counted.iter().any(Option::is_some) => self.unpriced += 1,
            None => {}
        }
    }

    /// The outcome of a batch, in words.
    #[must_use]
    pub fn outcome(&self) -> String {
        let (agree, differ, failed) = self.tally;
        let answered = agree + differ + failed;
        let mut parts = vec![format!("{agree} agree"), format!("{differ} differ")];
        // Tasks without a built-in verdict have nothing to agree with.
        let plain = self.done.saturating_sub(answered);
        if plain > 0 {
            parts.push(format!("{plain} answered"));
        }
        parts.push(format!("{failed} failed"));
        parts.join(", ")
    }
}

/// All jobs, the newest last.
#[derive(Debug, Default)]
pub struct Jobs {
    /// The jobs.
    pub all: Vec<Job>,
    /// The selected one in the list, counted from the newest.
    pub selected: usize,
}

/// Jobs that are over and kept; older ones go.
const MAX_ENDED: usize = 500;

impl Jobs {
    /// Adds one, unless there is nothing to do.
    pub fn add(&mut self, job: Job) {
        if job.of == 0 {
            return;
        }
        if self.all.len() >= MAX_ENDED
            && let Some(old) = self.all.iter().position(|job| !job.is_running())
        {
            self.all.remove(old);
        }
        self.all.push(job);
    }

    /// The one with this id, while it is not over.
    pub fn running_mut(&mut self, id: JobId) -> Option<&mut Job> {
        let mut all = self.all.iter_mut().rev();
        all.find(|job| job.id == id && job.is_running())
    }

    /// The newest of this kind that is not over.
    pub fn newest_mut(&mut self, kind: JobKind) -> Option<&mut Job> {
        let mut all = self.all.iter_mut().rev();
        all.find(|job| job.kind == kind && job.is_running())
    }

    /// Whether one of this kind shall end and has not yet.
    #[must_use]
    pub fn is_stopping(&self, kind: JobKind) -> bool {
        let stopping = |job: &Job| job.kind == kind && job.state == JobState::Stopping;
        self.all.iter().any(stopping)
    }

    /// The selected one.
    #[must_use]
    pub fn current(&self) -> Option<&Job> {
        self.all.iter().rev().nth(self.selected)
    }

    /// How many questions and batches are not over.
    #[must_use]
    pub fn asking(&self) -> usize {
        let asks = |job: &&Job| job.is_running() && job.asks();
        self.all.iter().filter(asks).count()
    }

    /// Whether a batch is not over.
    #[must_use]
    pub fn has_batch(&self) -> bool {
        let batch = |job: &Job| job.kind == JobKind::Batch && job.is_running();
        self.all.iter().any(batch)
    }

    /// The cost of this session, US dollars, and the number of answers of unknown cost.
    #[must_use]
    pub fn cost(&self) -> (f64, usize) {
        let add = |(usd, unknown), job: &Job| (usd + job.cost, unknown + job.unpriced);
        self.all.iter().fold((0.0, 0), add)
    }
}
