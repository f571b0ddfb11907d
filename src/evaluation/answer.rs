//! What comes of asking: a verdict, or the reason why there is none, with the text in any case.

use crate::scenario::Scenario;
use crate::store::{Consumed, Ending, Run, RunId, RunState};
use crate::verdict::{How, Parsed, Reading, Said, Verdict};

/// The end of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Its number in the store, if it is kept.
    pub run: Option<RunId>,
    /// The model asked, `provider/model`.
    pub model: String,
    /// First and last time step that were described.
    pub window: (i64, i64),
    /// How it was asked: frame and techniques.
    pub how: String,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// What was said.
    pub judged: Judged,
    /// The answer's text.
    pub text: String,
    /// The reasoning's text, where it came apart from the answer.
    pub reasoning: String,
    /// What it consumed.
    pub consumed: Consumed,
    /// Why the model stopped, where it said so.
    pub finish: Option<String>,
}

/// What was said.
#[derive(Debug, Clone, PartialEq)]
pub enum Judged {
    /// This, yes or no.
    Verdict(Parsed),
    /// This, to a task that asks for more than yes or no.
    Other(Reading),
    /// No verdict, and why not.
    Missing(Missing),
}

impl From<Reading> for Judged {
    fn from(reading: Reading) -> Self {
        match reading.said {
            Said::Verdict(verdict) => Self::Verdict(Parsed {
                verdict,
                how: reading.how,
            }),
            Said::Attacker(_) | Said::Trajectory(_) => Self::Other(reading),
        }
    }
}

/// Why there is no verdict.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Missing {
    /// The answer is whole and holds none.
    NotInAnswer(String),
    /// There is no whole answer.
    NoAnswer(String),
    /// It was cancelled.
    Cancelled,
}

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotInAnswer(why) => write!(f, "no verdict: {why}"),
            Self::NoAnswer(why) => write!(f, "no answer: {why}"),
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl Answer {
    /// The verdict, if there is one.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        match &self.judged {
            Judged::Verdict(parsed) => Some(&parsed.verdict),
            Judged::Other(_) | Judged::Missing(_) => None,
        }
    }

    /// What had to be put right to read it; nothing where it was as asked for, or was not read.
    #[must_use]
    pub fn repairs(&self) -> &[String] {
        let how = match &self.judged {
            Judged::Verdict(parsed) => &parsed.how,
            Judged::Other(reading) => &reading.how,
            Judged::Missing(_) => return &[],
        };
        match how {
            How::Strict => &[],
            How::Repaired(notes) => notes,
        }
    }

    /// What was said, in a word or two, and whether it had to be repaired.
    #[must_use]
    pub fn word(&self) -> String {
        let word = match &self.judged {
            Judged::Verdict(parsed) => parsed.verdict.word(),
            Judged::Other(reading) => reading.said.task().name(),
            Judged::Missing(_) => "no verdict",
        };
        let repaired = if self.repairs().is_empty() {
            ""
        } else {
            ", repaired"
        };
        format!("{word}{repaired}")
    }

    /// Whether the server named another model than the one asked for, in a way that is not just a date or a path.
    #[must_use]
    pub fn model_differs(&self) -> bool {
        let asked = self
            .model
            .split_once('/')
            .map_or(self.model.as_str(), |(_, name)| name);
        self.model_returned
            .as_deref()
            .is_some_and(|returned| returned != asked)
    }

    /// Ids in the verdict that no obstacle of the scenario has.
    #[must_use]
    pub fn unknown_obstacles(&self, scenario: &Scenario) -> Vec<i64> {
        let named = match &self.judged {
            Judged::Verdict(parsed) => parsed.verdict.obstacles.iter().map(|o| o.id).collect(),
            Judged::Other(reading) => reading.said.named(),
            Judged::Missing(_) => Vec::new(),
        };
        named
            .into_iter()
            .filter(|id| scenario.obstacle(*id).is_none())
            .collect()
    }

    /// How this is kept in the store.
    #[must_use]
    pub(super) fn ending(&self) -> Ending {
        let (state, verdict, reading, error) = match &self.judged {
            Judged::Verdict(parsed) => {
                let reading = reading(&parsed.how);
                (
                    RunState::Answered,
                    Some(Said::Verdict(parsed.verdict.clone())),
                    Some(reading),
                    None,
                )
            }
            Judged::Other(read) => {
                let reading = reading(&read.how);
                (
                    RunState::Answered,
                    Some(read.said.clone()),
                    Some(reading),
                    None,
                )
            }
            Judged::Missing(Missing::NotInAnswer(why)) => {
                (RunState::Answered, None, Some(why.clone()), None)
            }
            Judged::Missing(Missing::NoAnswer(why)) => {
                (RunState::Failed, None, None, Some(why.clone()))
            }
            Judged::Missing(Missing::Cancelled) => (RunState::Cancelled, None, None, None),
        };
        Ending {
            state,
            model_returned: self.model_returned.clone(),
            finish: self.finish.clone(),
            verdict,
            reading,
            error,
            consumed: self.consumed,
        }
    }
}

const STRICT: &str = "strict";
const REPAIRED: &str = "repaired: ";

fn reading(how: &How) -> String {
    match how {
        How::Strict => STRICT.into(),
        How::Repaired(notes) => format!("{REPAIRED}{}", notes.join("; ")),
    }
}

impl From<Run> for Answer {
    /// A run of the store, as it was when it ended.
    fn from(run: Run) -> Self {
        let ending = run.ending;
        let judged = match (ending.verdict, ending.state) {
            (Some(said), _) => {
                let how = match ending
                    .reading
                    .as_deref()
                    .and_then(|r| r.strip_prefix(REPAIRED))
                {
                    Some(notes) => How::Repaired(notes.split("; ").map(str::to_string).collect()),
                    None => How::Strict,
                };
                Judged::from(Reading { said, how })
            }
            (None, RunState::Answered) => Judged::Missing(Missing::NotInAnswer(
                ending.reading.unwrap_or_else(|| "none was found".into()),
            )),
            (None, RunState::Failed) => Judged::Missing(Missing::NoAnswer(
                ending.error.unwrap_or_else(|| "it failed".into()),
            )),
            (None, RunState::Running) => Judged::Missing(Missing::NoAnswer(
                "still running, or the program ended while it was".into(),
            )),
            (None, RunState::Cancelled) => Judged::Missing(Missing::Cancelled),
        };
        Self {
            run: Some(run.id),
            window: run.question.window,
            how: format!("{} · {}", run.question.frame, run.question.techniques),
            model: run.question.model,
            model_returned: ending.model_returned,
            judged,
            text: run.answer,
            reasoning: run.reasoning,
            consumed: ending.consumed,
            finish: ending.finish,
        }
    }
}
