//! One case from end to end: a scene is described, put into a prompt, judged, read and kept; and how good the
//! built-in judge is.

mod answer;
mod bradley_terry;
mod case;
/// Claims about obstacles in the text of an answer.
pub mod claims;
mod confusion;
mod judges;
mod keeper;
mod labels;
mod lead;
mod plan;
/// Recorded answers as runs for the store.
pub mod published;
mod question;
/// Answers that were recorded by others.
pub mod recorded;
/// Tables of how often answers are right.
pub mod report;
mod request;
mod scored;
mod settings;
mod standings;
/// Statistics of yes-or-no answers.
pub mod statistics;
mod trial;
mod usable;
mod usual;
mod values;

pub use answer::{Answer, Judged, Missing, Past};
pub use bradley_terry::{Comparisons, NoStrengths, Strength};
pub use case::{AskError, Event, Wanted, can_ask, run, stored};
pub use confusion::Confusion;
pub use judges::{Judge, ModelJudge};
pub use labels::{Label, LabelError, Labels};
pub use lead::{Alarms, Answers, Candidate, Labelled, Lead, Setting, confusion};
pub use plan::{Plan, PlanError};
pub use question::{Case, CaseError, Question, prepare, template};
pub use scored::{Said, Scored, Way};
pub use settings::{Decided, Settings};
pub use standings::{By, Standing, Standings};
pub use trial::trial;
pub use usable::usable;
pub use usual::usual_frame;
