//! The outcome of a question: a verdict or the reason there is none, and the text in either case.

use nearmiss_ask::llm::{
    Finish, MAX_ANSWER_BYTES, Message, Parameters, Secrets, THINKING_TAGS, Token, ToolRound,
};
use nearmiss_scene::judge;
use nearmiss_scene::scenario::Scene;
use nearmiss_scene::verdict::{self, ParseQuality, Parsed, ParsedAnswer, Reading, Task, Verdict};
use nearmiss_store::{ClaimCounts, Consumed, Ending, Origin, Run, RunId, RunState, TOO_LONG};

use super::claims::{Subject, TimeOrigin, count};
use super::probability::token_probability;
use super::prompt_summary::{TemplateVersion, prompt_label, with_tools};
use super::tool_rounds;

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
    pub fn verdict_label(&self) -> String {
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

    /// Its claims about the scene that it is about, when these messages asked for it; none where they are not known.
    #[must_use]
    pub fn claims(&self, scene: &Scene, messages: &[Message]) -> ClaimCounts {
        // Numbers may be read from a picture.
        let is_text = !messages.is_empty() && messages.iter().all(|one| one.images.is_empty());
        let told = messages.iter().map(|message| message.content.clone());
        let found = self.tool_rounds.iter().flat_map(tool_rounds::lines);
        let shown = is_text.then(|| told.chain(found).collect::<Vec<_>>().join("\n"));
        let subject = Subject {
            prompt: shown.as_deref(),
            ..Subject::new(scene, self.times, self.window)
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
                    self.run_state(),
                    Some(ParsedAnswer::Verdict(parsed.verdict.clone())),
                    Some(reading),
                    None,
                )
            }
            JudgeOutcome::Other(read) => {
                let reading = reading(&read.how);
                (
                    self.run_state(),
                    Some(read.said.clone()),
                    Some(reading),
                    None,
                )
            }
            JudgeOutcome::Missing(MissingVerdict::NotInAnswer(why)) => {
                (self.run_state(), None, Some(why.clone()), None)
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
    fn run_state(&self) -> RunState {
        if self.is_complete() {
            RunState::Answered
        } else {
            RunState::Truncated
        }
    }

    /// Whether the server let the model finish, and it said something.
    #[must_use]
    pub fn is_complete(&self) -> bool {
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
        TimeOrigin::from_messages(messages)
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
            how: prompt_label(
                &run.question.frame,
                &with_tools(
                    &run.question.techniques,
                    had_tools(&run.question.parameters),
                ),
                TemplateVersion::from_stored(&run.question.template()).as_ref(),
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

/// Reads an answer whose text is complete, truncated or missing.
pub(super) fn read(task: Task, answer: &Answer, failure: Option<MissingVerdict>) -> JudgeOutcome {
    read_from(task, answer, [0, 0], failure)
}

/// The same of text and reasoning from these bytes on: what a model says before it calls tools is no answer.
pub(super) fn read_from(
    task: Task,
    answer: &Answer,
    from: [usize; 2],
    failure: Option<MissingVerdict>,
) -> JudgeOutcome {
    let last = answer.text.get(from[0]..).unwrap_or_default();
    // A model that puts everything into its reasoning has still answered.
    let whole = if last.trim().is_empty() {
        answer.reasoning.get(from[1]..).unwrap_or_default()
    } else {
        after_thinking(last)
    };
    let finish = answer.finish.as_deref();
    let is_cut = finish.is_some_and(|word| is_cut(word) || DECLINED.contains(&word));
    match failure {
        Some(missing @ (MissingVerdict::NoAnswer(_) | MissingVerdict::NotSent(_))) => {
            JudgeOutcome::Missing(missing)
        }
        Some(stopped) if is_cut => JudgeOutcome::Missing(stopped),
        _ if whole.trim().is_empty() && !last.trim().is_empty() => {
            JudgeOutcome::Missing(MissingVerdict::NotInAnswer(ONLY_THINKING.into()))
        }
        stopped => match (verdict::read(task, whole), stopped) {
            (Ok(reading), _) => JudgeOutcome::from(reading),
            (Err(_), Some(stopped)) => JudgeOutcome::Missing(stopped),
            (Err(why), None) => JudgeOutcome::Missing(MissingVerdict::NotInAnswer(why.to_string())),
        },
    }
}

/// A question is known to be cut where a server counts less than this share of its estimated tokens: the estimate is
/// within 5 % of o200k_base, and other tokenizers make more of scenes in words.
const CUT: f64 = 0.8;

/// No server's context is smaller, tokens: one that counts less does not count.
const LEAST_CONTEXT: u64 = 256;

/// What was read in an answer, unless the server read only a part of the question: by the tokens that it counted and the
/// estimate of those sent, where these were words alone.
pub(super) fn unless_cut(
    judged: JudgeOutcome,
    counted: Option<u64>,
    sent: Option<usize>,
) -> JudgeOutcome {
    match judged {
        JudgeOutcome::Verdict(_) | JudgeOutcome::Other(_) => sent
            .and_then(|sent| cut_question(counted, sent))
            .map_or(judged, JudgeOutcome::Missing),
        JudgeOutcome::Missing(_) => judged,
    }
}

fn cut_question(counted: Option<u64>, sent: usize) -> Option<MissingVerdict> {
    let counted = counted.filter(|counted| *counted >= LEAST_CONTEXT)?;
    let is_cut = (counted as f64) < CUT * sent as f64;
    is_cut.then(|| {
        MissingVerdict::NotInAnswer(format!(
            "the server counts {counted} of about {sent} tokens that were sent, so it read only a part of the question; raise \
             its context (num_ctx, --ctx-size), or shorten the question (stride, radius, history), and ask with --fresh"
        ))
    })
}

/// Whether an answer that ended with this word is not whole: the rest could have said something else.
pub(super) fn is_cut(word: &str) -> bool {
    matches!(word, "length" | TOO_LONG | "content_filter" | "blocked") || is_broken(word)
}

/// How whole answers end in which nothing counts: there is nothing but thinking, in which verdicts are drafts, or the
/// model declined.
const DECLINED: [&str; 2] = ["refusal", THINKING];

const THINKING: &str = "thinking";

/// Words of servers for an answer that they broke off, in lower case; unknown ones say that it is whole.
fn is_broken(word: &str) -> bool {
    const BEGINNINGS: [&str; 8] = [
        "abort",
        "cancel",
        "error",
        "fail",
        "incomplete",
        "interrupt",
        "malformed",
        "timeout",
    ];
    let word = word.to_ascii_lowercase();
    word == "other" || BEGINNINGS.iter().any(|begin| word.starts_with(begin))
}

const ONLY_THINKING: &str =
    "the answer is thinking and nothing else; raise max_tokens, or ask for less effort";

/// What a text says between the last end of thinking, which may have begun without a tag, and thinking that never ends;
/// all of it where it is one JSON value.
fn after_thinking(text: &str) -> &str {
    if serde_json::from_str::<serde_json::Value>(text).is_ok() {
        return text;
    }
    let plain = text.to_ascii_lowercase();
    let ends = THINKING_TAGS.iter().filter_map(|(_, close)| {
        let tag = close.to_ascii_lowercase();
        Some(plain.rfind(&tag)? + tag.len())
    });
    let said = ends.max().unwrap_or(0);
    let begins = THINKING_TAGS
        .iter()
        .filter_map(|(open, _)| plain[said..].find(&open.to_ascii_lowercase()));
    let end = begins.min().map_or(text.len(), |at| said + at);
    &text[said..end]
}

/// Adds to a verdict what the log probabilities of its tokens say. Whether they say it, or are about no verdict.
pub(super) fn weighed(task: Task, tokens: &[Token], judged: &mut JudgeOutcome) -> bool {
    let JudgeOutcome::Verdict(parsed) = judged else {
        return true;
    };
    let verdict = &mut parsed.verdict;
    verdict.token_probability = token_probability(tokens, task, verdict.dangerous);
    verdict.token_probability.is_some()
}

/// Why an answer that ended this way may hold no verdict.
pub(super) fn stopped_short(finish: &Finish) -> Option<MissingVerdict> {
    let why = match finish {
        Finish::Length => "the answer ran into the token limit; raise max_tokens".to_string(),
        Finish::TooLong => too_long(),
        Finish::ContentFilter => "the server's content filter stopped the answer".to_string(),
        Finish::Blocked(why) => format!("the server's filter blocked the question ({why})"),
        Finish::Blank => {
            "the answer is blank, as from some servers that fail to produce the requested JSON; ask again".into()
        }
        Finish::Thinking => ONLY_THINKING.to_string(),
        Finish::ToolCalls => "the model called tools that it was not offered".to_string(),
        Finish::Refusal(text) if text.is_empty() => "the model declined".into(),
        Finish::Refusal(text) => format!("the model declined: {text}"),
        Finish::Other(word) if is_broken(word) => {
            format!("the server broke the answer off ({word}); ask again")
        }
        Finish::Stop | Finish::Other(_) => return None,
    };
    Some(MissingVerdict::NotInAnswer(why))
}

/// The message for an answer cut off by this program.
pub(super) fn too_long() -> String {
    let limit = MAX_ANSWER_BYTES >> 20;
    format!("nearmiss cut the answer off at {limit} MiB; set max_tokens, or choose another model")
}

pub(super) fn finish_name(finish: &Finish) -> String {
    match finish {
        Finish::Stop => "stop".into(),
        Finish::ToolCalls => "tool_calls".into(),
        Finish::Length => "length".into(),
        Finish::TooLong => TOO_LONG.into(),
        Finish::ContentFilter => "content_filter".into(),
        Finish::Blocked(_) => "blocked".into(),
        Finish::Blank => "blank".into(),
        Finish::Thinking => THINKING.into(),
        Finish::Refusal(_) => "refusal".into(),
        Finish::Other(word) => word.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_lies_outside_of_thinking_in_any_case() {
        for (text, said) in [
            ("draft</Think> yes", " yes"),
            ("first <THINK>no, yes", "first "),
            ("<think>a</think>b <scratchpad>c", "b "),
            ("a <think>yes, <think>no", "a "),
            ("{\"a\": \"<think>\"}", "{\"a\": \"<think>\"}"),
            ("plain", "plain"),
        ] {
            assert_eq!(after_thinking(text), said, "{text}");
        }
    }

    #[test]
    fn words_of_servers_for_broken_answers() {
        for (word, cut) in [
            ("stop", false),
            ("eos_found", false),
            ("abort", true),
            ("OTHER", true),
            ("MALFORMED_RESPONSE", true),
            ("length", true),
            ("blank", false),
        ] {
            assert_eq!(is_cut(word), cut, "{word}");
            let finish = Finish::Other(word.into());
            let broken = cut && word != "length";
            assert_eq!(stopped_short(&finish).is_some(), broken, "{word}");
        }
    }

    #[test]
    fn only_what_a_context_can_have_kept_is_a_cut_question() {
        for (counted, sent, is_cut) in [
            (Some(2050), 2688, true),
            (Some(2048), 3526, true),
            (Some(512), 11_582, true),
            (Some(3400), 3526, false),
            // Servers that do not count write anything.
            (Some(10), 2688, false),
            (None, 2688, false),
        ] {
            let found = cut_question(counted, sent);
            assert_eq!(found.is_some(), is_cut, "{counted:?} of {sent}");
        }
    }

    #[test]
    fn thinking_without_its_first_tag_is_no_answer() {
        for (text, said) in [
            ("draft {\"collision\": false}\n</think>\n\nyes", "\n\nyes"),
            ("a [/THINK] b </think> c", " c"),
            ("draft </think>", ""),
            ("plain", "plain"),
            ("\"of </think>\"", "\"of </think>\""),
        ] {
            assert_eq!(after_thinking(text), said);
        }
    }
}
