//! One case from end to end: a scene is described, put into a prompt, judged, parsed and stored; and the accuracy of
//! the built-in judge.

pub(crate) mod annotations;
mod answer;
mod answer_case;
mod answer_flags;
mod answer_outcome;
mod answer_page;
mod ask_model;
mod attacker_values;
mod axes;
/// Questions in bulk, resumable, in the store.
pub mod batch;
mod bradley_terry;
/// Claims about obstacles in the text of an answer.
pub mod claims;
mod cluster;
mod confusion;
/// What an answer consumed, in words.
pub mod consumption;
mod defaults;
mod dry_render;
/// Attacks that a model writes.
pub mod generating;
mod invariance;
mod judges;
mod labels;
mod lead;
mod lead_curve;
mod leaks;
mod naming;
mod picture;
mod planning;
mod predictors;
mod price_words;
mod probability;
mod prompt_summary;
mod protocol;
mod provenance;
mod question;
mod rater_agreement;
mod recorded_answer;
mod regression;
/// Questions that are handed to a provider as a batch.
pub mod remote;
/// Tables of how often answers are right.
pub mod report;
mod request;
mod requirement;
mod results;
mod rules;
mod run_case;
mod run_words;
mod score;
mod scored;
mod settings;
mod share;
mod spending;
mod standings;
/// Statistics of yes-or-no answers.
pub mod statistics;
mod stream_recorder;
#[cfg(test)]
pub(crate) mod tests_scored;
mod token_probability;
/// Rounds of tool calls.
pub mod tool_rounds;
mod training;
mod validate;
mod values;
/// Windows that are asked about: dangerous ones, and safe ones like them.
pub mod windows;

pub use annotations::{Loss, Problem, annotations};
pub(crate) use answer::reading;
pub use answer::{Answer, JudgeOutcome, MissingVerdict, StoredOrigin};
pub use answer_case::AnswerCase;
pub use answer_page::{AnswerDetail, AnswerPage, ShownClaim};
pub use axes::{AxisValues, tools_word};
pub use bradley_terry::{Comparisons, NoStrengths, Strength};
pub use cluster::Cluster;
pub use confusion::Confusion;
pub use consumption::{duration, local_time, thousands};
pub use defaults::default_frame;
pub use dry_render::dry_render;
pub use invariance::{Invariance, Pair, invariance, pairs};
pub use judges::{Judge, Judges, ModelJudge, RECORDED};
pub use labels::{Label, LabelError, Labels};
pub use lead::{Labelled, Lead, PAPER_STEPS};
pub use lead_curve::{LeadCurve, LeadPoint, Timed, lead_curves};
pub use leaks::{Leak, SURFACE, leaks};
pub use naming::{Naming, NamingIntervals};
pub use nearmiss_store::{AnswerState, CountedAs};
pub use picture::ScenePicture;
pub use planning::default_planning;
pub use predictors::{Alarms, Candidate, Predictions, Setting};
pub use probability::{ProbabilitySource, probability};
pub use prompt_summary::{TemplateVersion, how, with_tools};
pub use protocol::Protocol;
pub use provenance::Provenance;
pub use question::{AttackTerms, Case, CaseError, Question, prepare, template, window_end};
pub use rater_agreement::{PersonPair, RaterAgreement};
pub use regression::{Regression, regressions};
pub use requirement::{Check, Requirement};
pub use results::{AnswerOutcome, Outcome, Results, ResultsRow, results, with_intervals};
pub use rules::{Rule, RuleScore, rules};
pub use run_case::{AskError, Event, RunOptions, can_ask, run};
pub use run_words::{motion_words, run_words};
pub use score::{CriticalMoments, note_on_score, says_the_score};
pub use scored::{AnswerStatus, PromptConfig, Scored};
pub use settings::{EffectiveSettings, Settings};
pub use share::Share;
pub use spending::{Attempt, Spending};
pub use standings::{Standing, Standings, StandingsBy};
pub use token_probability::{token_probability, with_token_probability};
pub use training::{Example, ExampleRules, Examples, NoExample, Pictures, ReasoningForm};
pub use validate::validate;
