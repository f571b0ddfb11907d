//! What is kept of a run.

use crate::verdict::{Said, Task};

/// Identifies a run in its store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RunId(pub i64);

impl std::fmt::Display for RunId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// What is known before a judge is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct NewRun {
    /// Name of the scenario.
    pub scenario: String,
    /// SHA-256 of its file.
    pub scenario_hash: String,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// What is asked.
    pub task: Task,
    /// From where the scene is described.
    pub frame: String,
    /// Prompting techniques in use.
    pub techniques: String,
    /// First and last time step of the window.
    pub window: (i64, i64),
    /// `provider/model`, as asked for.
    pub model: String,
    /// Address of the server, without any key.
    pub endpoint: String,
    /// File name of the template.
    pub template: String,
    /// SHA-256 of its text.
    pub template_hash: String,
    /// The messages as JSON.
    pub messages: String,
    /// The parameters as JSON.
    pub parameters: String,
}

/// A piece of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece<'a> {
    /// Of the reasoning.
    Reasoning(&'a str),
    /// Of the answer itself.
    Answer(&'a str),
}

/// Where a run stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RunState {
    /// The answer is arriving, or the program ended while it was.
    Running,
    /// The answer is whole; it may still hold no verdict.
    Answered,
    /// There is no whole answer.
    Failed,
    /// It was cancelled.
    Cancelled,
}

impl RunState {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Answered => "answered",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    pub(super) fn parse(name: &str) -> Option<Self> {
        [Self::Running, Self::Answered, Self::Failed, Self::Cancelled]
            .into_iter()
            .find(|s| s.name() == name)
    }
}

/// What an answer consumed, where it is known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Consumed {
    /// Tokens of the question.
    pub input_tokens: Option<u64>,
    /// Tokens of the answer, reasoning included.
    pub output_tokens: Option<u64>,
    /// Those that were reasoning.
    pub reasoning_tokens: Option<u64>,
    /// Those of the question that the server had in its cache.
    pub cached_tokens: Option<u64>,
    /// US dollars, as stated by the server.
    pub cost_usd: Option<f64>,
    /// Milliseconds to the first piece.
    pub first_chunk_ms: Option<u64>,
    /// Milliseconds to the end.
    pub duration_ms: Option<u64>,
}

/// What is known when a run ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Ending {
    /// Where it stands now.
    pub state: RunState,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// Why the model stopped.
    pub finish: Option<String>,
    /// What it says.
    pub verdict: Option<Said>,
    /// How the verdict was read, or why there is none.
    pub reading: Option<String>,
    /// Why there is no answer.
    pub error: Option<String>,
    /// What it consumed.
    pub consumed: Consumed,
}

impl Ending {
    /// An ending of which nothing more is known.
    #[must_use]
    pub fn bare(state: RunState) -> Self {
        Self {
            state,
            model_returned: None,
            finish: None,
            verdict: None,
            reading: None,
            error: None,
            consumed: Consumed::default(),
        }
    }
}

/// A run as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Its number.
    pub id: RunId,
    /// When it began, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// What was asked of whom.
    pub question: NewRun,
    /// The answer's text.
    pub answer: String,
    /// The reasoning's text.
    pub reasoning: String,
    /// How it ended, or where it stands.
    pub ending: Ending,
}
