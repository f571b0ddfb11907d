//! The outcome of a question: a verdict or the reason there is none, and the text in either case.

use super::answer_outcome::{is_cut, too_long};
use super::claims::{Subject, TimeOrigin, count};
use super::prompt_summary::{TemplateVersion, how, with_tools};
use super::tool_rounds;
use nearmiss_ask::llm::{Parameters, Secrets, ToolRound};
use nearmiss_scene::judge;
use nearmiss_scene::scenario::Scene;
use nearmiss_scene::verdict::{ParseQuality, Parsed, ParsedAnswer, Reading, Verdict};
use nearmiss_store::{ClaimCounts, Consumed, Ending, Origin, Run, RunId, RunState, TOO_LONG};

/// The end of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Its number in the store, if it is kept.
    pub run: Option<RunId>,
    /// Where it was in the store before it was asked for.
    pub past: Option<StoredOrigin>,
    /// The model asked, `provider/model`.
    pub model: String,
    /// First and last time step that were described; `None` if that is not known of a recorded answer.
    pub window: Option<(i64, i64)>,
    /// What the times in it count from.
    pub times: TimeOrigin,
    /// How it was asked: frame and techniques.
    pub how: String,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// The judgement.
    pub judged: JudgeOutcome,
    /// The answer's text.
    pub text: String,
    /// The reasoning's text, where it came apart from the answer.
    pub reasoning: String,
    /// Tools that the model called, and their results, in rounds.
    pub tool_rounds: Vec<ToolRound>,
    /// Its consumption.
    pub consumed: Consumed,
    /// Where the cost comes from.
    pub price_source: Option<String>,
    /// Why the model stopped, where it said so.
    pub finish: Option<String>,
}

/// Origin of an answer that was not asked for now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoredOrigin {
    /// When it was asked, or a recorded one read: milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// The program that asked.
    pub origin: Origin,
    /// Which of several answers to the same request.
    pub sample: u32,
}

/// A judge's statement.
#[derive(Debug, Clone, PartialEq)]
pub enum JudgeOutcome {
    /// This, yes or no.
    Verdict(Parsed),
    /// This, to a task that asks for more than yes or no.
    Other(Reading),
    /// No verdict, and why not.
    Missing(MissingVerdict),
}

impl From<Reading> for JudgeOutcome {
    fn from(reading: Reading) -> Self {
        match reading.said {
            ParsedAnswer::Verdict(verdict) => Self::Verdict(Parsed {
                verdict,
                how: reading.how,
            }),
            ParsedAnswer::Attacker(_) | ParsedAnswer::Trajectory(_) => Self::Other(reading),
        }
    }
}

impl JudgeOutcome {
    /// The same without secrets, should reading the answer have brought one to light.
    #[must_use]
    pub(super) fn without(mut self, secrets: &Secrets) -> Self {
        let clear = |text: &mut String| *text = secrets.redact(text);
        let how = match &mut self {
            Self::Verdict(parsed) => {
                parsed.verdict.texts_mut().for_each(clear);
                &mut parsed.how
            }
            Self::Other(reading) => {
                reading.said.texts_mut().for_each(clear);
                &mut reading.how
            }
            Self::Missing(
                MissingVerdict::NotInAnswer(why)
                | MissingVerdict::NoAnswer(why)
                | MissingVerdict::NotSent(why),
            ) => {
                clear(why);
                return self;
            }
            Self::Missing(MissingVerdict::Cancelled) => return self,
        };
        if let ParseQuality::Repaired(notes) = how {
            notes.iter_mut().for_each(clear);
        }
        self
    }
}

/// Why there is no verdict.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MissingVerdict {
    /// The answer is whole and holds none.
    NotInAnswer(String),
    /// The answer is missing or incomplete.
    NoAnswer(String),
    /// The question was not sent.
    NotSent(String),
    /// It was cancelled.
    Cancelled,
}

/// How the reason begins where nothing was sent, for people and in the store.
pub(super) const NOT_SENT: &str = "nothing was sent: ";

impl std::fmt::Display for MissingVerdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotInAnswer(why) => write!(f, "no verdict: {why}"),
            Self::NoAnswer(why) => write!(f, "no answer: {why}"),
            Self::NotSent(why) => write!(f, "{NOT_SENT}{why}"),
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl Answer {
    /// Whether all of it arrived, with a verdict or without.
    #[must_use]
    pub fn arrived(&self) -> bool {
        !matches!(
            self.judged,
            JudgeOutcome::Missing(
                MissingVerdict::NoAnswer(_)
                    | MissingVerdict::NotSent(_)
                    | MissingVerdict::Cancelled
            )
        )
    }

    /// The verdict, if there is one.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        match &self.judged {
            JudgeOutcome::Verdict(parsed) => Some(&parsed.verdict),
            JudgeOutcome::Other(_) | JudgeOutcome::Missing(_) => None,
        }
    }

    /// What had to be put right to read it; nothing where it was as asked for, or was not read.
    #[must_use]
    pub fn repairs(&self) -> &[String] {
        let how = match &self.judged {
            JudgeOutcome::Verdict(parsed) => &parsed.how,
            JudgeOutcome::Other(reading) => &reading.how,
            JudgeOutcome::Missing(_) => return &[],
        };
        match how {
            ParseQuality::Strict => &[],
            ParseQuality::Repaired(notes) => notes,
        }
    }

    /// The verdict in a word or two, and whether it had to be repaired.
    #[must_use]
    pub fn word(&self) -> String {
        let word = match &self.judged {
            JudgeOutcome::Verdict(parsed) => parsed.verdict.word(),
            JudgeOutcome::Other(reading) => reading.said.task().name(),
            JudgeOutcome::Missing(_) => "no verdict",
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

    /// What is to be said of an answer that this program cut off because of its size; nothing of others.
    #[must_use]
    pub fn cut_off(&self) -> Option<String> {
        (self.finish.as_deref() == Some(TOO_LONG)).then(too_long)
    }

    /// Its claims about the obstacles of the scene that it is about.
    #[must_use]
    pub fn claims(&self, scene: &Scene) -> ClaimCounts {
        let subject = Subject {
            scene,
            times: self.times,
            window: self.window,
        };
        count(&self.reasoning, &self.text, &subject)
    }

    /// How this is kept in the store.
    #[must_use]
    pub(super) fn ending(&self) -> Ending {
        let (state, verdict, reading, error) = match &self.judged {
            JudgeOutcome::Verdict(parsed) => {
                let reading = reading(&parsed.how);
                (
                    self.whole(),
                    Some(ParsedAnswer::Verdict(parsed.verdict.clone())),
                    Some(reading),
                    None,
                )
            }
            JudgeOutcome::Other(read) => {
                let reading = reading(&read.how);
                (self.whole(), Some(read.said.clone()), Some(reading), None)
            }
            JudgeOutcome::Missing(MissingVerdict::NotInAnswer(why)) => {
                (self.whole(), None, Some(why.clone()), None)
            }
            JudgeOutcome::Missing(MissingVerdict::NoAnswer(why)) => {
                (RunState::Failed, None, None, Some(why.clone()))
            }
            JudgeOutcome::Missing(missing @ MissingVerdict::NotSent(_)) => {
                (RunState::Failed, None, None, Some(missing.to_string()))
            }
            JudgeOutcome::Missing(MissingVerdict::Cancelled) => {
                (RunState::Cancelled, None, None, None)
            }
        };
        Ending {
            state,
            model_returned: self.model_returned.clone(),
            finish: self.finish.clone(),
            verdict,
            reading,
            error,
            consumed: self.consumed,
            price_source: self.price_source.clone(),
            claims: ClaimCounts::default(),
        }
    }

    /// An answer that the server ended is not whole, whatever can be read from it, and one that says nothing neither.
    fn whole(&self) -> RunState {
        if self.is_whole() {
            RunState::Answered
        } else {
            RunState::Truncated
        }
    }

    /// Whether the server let the model finish, and it said something.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let cut = self.finish.as_deref().is_some_and(is_cut);
        let silent = self.text.trim().is_empty() && self.reasoning.trim().is_empty();
        !(cut || silent)
    }
}

const STRICT: &str = "strict";
const REPAIRED: &str = "repaired: ";

/// How an answer was read, as the store keeps it.
pub(crate) fn reading(how: &ParseQuality) -> String {
    match how {
        ParseQuality::Strict => STRICT.into(),
        ParseQuality::Repaired(notes) => format!("{REPAIRED}{}", notes.join("; ")),
    }
}

/// What the times in a model's answer to these messages, or to this description, count from. The built-in judge does not
/// read them, and speaks of the recording.
pub(super) fn times(model: &str, messages: &str) -> TimeOrigin {
    if model == judge::MODEL {
        TimeOrigin::Recording
    } else {
        TimeOrigin::of(messages)
    }
}

/// Whether a model that was sent these parameters could call tools.
fn had_tools(parameters: &str) -> bool {
    serde_json::from_str(parameters).is_ok_and(|sent: Parameters| sent.tools.is_some())
}

impl From<Run> for Answer {
    /// A run of the store, as it is there.
    fn from(run: Run) -> Self {
        let ending = run.ending;
        let judged = match (ending.verdict, ending.state) {
            (Some(said), _) => {
                let how = match ending
                    .reading
                    .as_deref()
                    .and_then(|r| r.strip_prefix(REPAIRED))
                {
                    Some(notes) => {
                        ParseQuality::Repaired(notes.split("; ").map(str::to_string).collect())
                    }
                    None => ParseQuality::Strict,
                };
                JudgeOutcome::from(Reading { said, how })
            }
            (None, RunState::Answered | RunState::Truncated) => {
                JudgeOutcome::Missing(MissingVerdict::NotInAnswer(
                    ending.reading.unwrap_or_else(|| "none was found".into()),
                ))
            }
            (None, RunState::Failed) => {
                let error = ending.error.unwrap_or_else(|| "it failed".into());
                JudgeOutcome::Missing(match error.strip_prefix(NOT_SENT) {
                    Some(why) => MissingVerdict::NotSent(why.into()),
                    None => MissingVerdict::NoAnswer(error),
                })
            }
            (None, RunState::Running) => {
                JudgeOutcome::Missing(MissingVerdict::NoAnswer("it is still arriving".into()))
            }
            (None, RunState::Interrupted) => JudgeOutcome::Missing(MissingVerdict::NoAnswer(
                "interrupted: the program ended while it arrived".into(),
            )),
            (None, RunState::Cancelled) => JudgeOutcome::Missing(MissingVerdict::Cancelled),
        };
        Self {
            run: Some(run.id),
            past: Some(StoredOrigin {
                created_ms: run.created_ms,
                origin: run.origin,
                sample: run.question.sample,
            }),
            window: run.question.window,
            times: times(&run.question.model, &run.question.messages),
            how: how(
                &run.question.frame,
                &with_tools(
                    &run.question.techniques,
                    had_tools(&run.question.parameters),
                ),
                TemplateVersion::of(&run.question.template()).as_ref(),
            ),
            model: run.question.model,
            model_returned: ending.model_returned,
            judged,
            text: run.answer,
            reasoning: run.reasoning,
            tool_rounds: tool_rounds::stored(run.tool_rounds.as_deref()),
            consumed: ending.consumed,
            price_source: ending.price_source,
            finish: ending.finish,
        }
    }
}
