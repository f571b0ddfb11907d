//! One case from end to end: a scene is described, put into a prompt, judged, parsed and stored; and the accuracy of
//! the built-in judge.

pub(crate) mod annotations;
mod answer;
mod answer_outcome;
/// Questions in bulk, resumable, in the store.
pub mod batch;
mod bradley_terry;
/// Claims about obstacles in the text of an answer.
pub mod claims;
mod confusion;
mod defaults;
mod dry_render;
/// Attacks that a model writes.
pub mod generating;
mod invariance;
mod judges;
mod labels;
mod lead;
mod lead_curve;
mod planning;
mod predictors;
mod price_words;
mod prompt_summary;
mod question;
/// Questions that are handed to a provider as a batch.
pub mod remote;
/// Tables of how often answers are right.
pub mod report;
mod request;
mod results;
mod run_case;
mod scored;
mod settings;
mod share;
mod standings;
/// Statistics of yes-or-no answers.
pub mod statistics;
mod stream_recorder;
#[cfg(test)]
pub(crate) mod tests_scored;
mod validate;
mod values;

pub use annotations::{Loss, Problem, annotations};
pub(crate) use answer::reading;
pub use answer::{Answer, JudgeOutcome, MissingVerdict, StoredOrigin};
pub use bradley_terry::{Comparisons, NoStrengths, Strength};
pub use confusion::Confusion;
pub use defaults::default_frame;
pub use dry_render::dry_render;
pub use invariance::{Invariance, Pair, invariance, pairs};
pub use judges::{Judge, Judges, ModelJudge};
pub use labels::{Label, LabelError, Labels};
pub use lead::{Labelled, Lead};
pub use lead_curve::{LeadCurve, LeadPoint, Timed, lead_curves};
pub use planning::default_planning;
pub use predictors::{Alarms, Candidate, Predictions, Setting};
pub use prompt_summary::{TemplateVersion, how};
pub use question::{Case, CaseError, Question, prepare, template};
pub use results::{AnswerOutcome, Outcome, Results, results, with_intervals};
pub use run_case::{AskError, Event, RunOptions, can_ask, run};
pub use scored::{AnswerStatus, PromptConfig, Scored, named_obstacles, names_obstacle};
pub use settings::{EffectiveSettings, Settings};
pub use share::Share;
pub use standings::{Standing, Standings, StandingsBy};
pub use validate::validate;
