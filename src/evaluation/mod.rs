//! One case from end to end: a scene is described, put into a prompt, judged, read and kept.

mod answer;
mod case;
mod judges;
mod question;

pub use answer::{Answer, Judged, Missing};
pub use case::{Event, run};
pub use judges::{Judge, ModelJudge};
pub use question::{Case, CaseError, Question, prepare};
