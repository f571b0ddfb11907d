//! Making a safe scenario dangerous: one obstacle, the attacker, gets another motion.
//!
//! A changed motion is exported only if it has passed the gate, whoever thought of it: a search, a model or a
//! file. The ego then plans anew against it, since a collision with a recorded ego proves nothing.

mod arms;
mod attack;
pub mod attacker;
mod avoidable;
mod capability;
mod change;
mod choice;
mod closed_loop;
mod escape;
mod evasion;
mod gate;
mod lesson;
mod made;
pub mod manoeuvre;
pub mod motion;
mod refusal;
mod rehearsal;
mod repair;
mod search;
mod stage;
mod summed;
#[cfg(test)]
mod tests;
mod tracking;
mod variant;
mod variant_document;
mod waypoints;

pub use attack::{Attack, Ground};
pub use avoidable::{
    Avoidability, Avoidance, Certificate, DELAYS, Finder, NotFound, Searched, Why,
};
pub use capability::Capability;
pub use change::{Change, ChangeError};
pub use choice::{Chosen, choose};
pub use closed_loop::{Baseline, ClosedLoop, Consequence, Effect, RiskCurve};
pub use evasion::Evasion;
pub use gate::{Comparison, Gate, Joint, Judged, Passed};
pub use made::{Made, Workshop, WorkshopError};
pub use refusal::{Reason, Refusal};
pub use rehearsal::Rehearsal;
pub use repair::{Admitted, FARTHEST, Repair, admit};
pub use search::{Effort, Found, Progress, search_until, search_watched};
pub use stage::Stage;
pub use summed::{Summed, summed};
pub use tracking::{Wanted, track};
pub use variant::{MARK, Saved, Variant, VariantError};
pub use variant_document::{asked, refusal};
