//! One case from end to end: a scene is described, put into a prompt, judged, parsed and stored; and the accuracy of
//! the built-in judge.

mod answer;
mod answer_page;
mod ask_model;
/// Questions in bulk, resumable, in the store.
pub mod batch;
mod bradley_terry;
/// Claims about obstacles in the text of an answer.
pub mod claims;
mod confusion;
/// What an answer consumed, in words.
pub mod consumption;
/// Attacks that a model writes.
pub mod generating;
mod invariance;
mod judges;
pub(crate) mod labels;
mod lead;
mod leaks;
mod naming;
mod predictors;
mod probability;
mod prompt_summary;
mod provenance;
mod question;
/// Questions that are handed to a provider as a batch.
pub mod remote;
/// Tables of how often answers are right.
pub mod report;
mod requirement;
mod results;
mod run_case;
mod score;
mod scored;
mod settings;
mod standings;
/// Statistics of yes-or-no answers.
pub mod statistics;
#[cfg(test)]
pub(crate) mod tests_scored;
/// Rounds of tool calls.
pub mod tool_rounds;
mod training;
mod validate;
mod values;
/// Windows that are asked about: dangerous ones, and safe ones like them.
pub mod windows;

pub(crate) use answer::reading;
pub use answer::{Answer, JudgeOutcome, MissingVerdict, StoredOrigin};
pub use answer_page::{AnswerDetail, AnswerPage, ShownClaim};
pub use bradley_terry::{Comparisons, NoStrengths, Strength};
pub use confusion::{Cluster, Confusion, Share};
pub use consumption::{Attempt, Spending, duration, local_time, thousands};
pub use invariance::{Invariance, Pair, invariance, pairs};
pub use judges::{Judge, Judges, ModelJudge, is_stored_alone};
pub use labels::{Label, LabelError, Labels, Loss, Problem, annotations};
pub use lead::{Labelled, Lead, LeadCurve, LeadPoint, PAPER_STEPS, Timed, lead_curves};
pub use leaks::{Leak, Rule, RuleScore, SURFACE, leaks, rules};
pub use naming::{Naming, NamingIntervals};
pub use nearmiss_store::{AnswerState, CountedAs};
pub use predictors::{Alarms, Candidate};
pub use probability::{ProbabilitySource, probability, token_probability, with_token_probability};
pub use prompt_summary::{TemplateVersion, motion_lines, prompt_label, run_summary, with_tools};
pub use provenance::Provenance;
pub use question::{
    AttackTerms, Case, CaseError, Question, ScenePicture, prepare, template, window_end,
};
pub use requirement::{Check, Regression, Requirement, regressions};
pub use results::{AnswerOutcome, Outcome, Results, ResultsRow, results, with_intervals};
pub use run_case::{AskError, Event, RunOptions, can_ask, run};
pub use score::{CriticalMoments, note_on_score, says_the_score};
pub use scored::{AnswerCase, AnswerStatus, PromptConfig, Scored};
pub use settings::{
    AxisValues, EffectiveSettings, Settings, default_frame, default_planning, tools_word,
};
pub use standings::{PersonPair, RaterAgreement, Standing, Standings, StandingsBy};
pub use training::{Example, ExampleRules, Examples, NoExample, Pictures, ReasoningForm};
pub use validate::{dry_render, validate};
pub use windows::Protocol;
