//! Making a safe scenario dangerous: one obstacle, the attacker, gets another motion.
//!
//! A changed motion is exported only if it has passed the gate, whoever thought of it: a search, a model or a
//! file. The ego then plans anew against it, since a collision with a recorded ego proves nothing.

mod arms;
pub mod attacker;
mod capability;
mod change;
mod closed_loop;
mod gate;
pub mod manoeuvre;
pub mod motion;
mod refusal;
mod rehearsal;
mod search;
mod stage;
mod tracking;

pub use capability::Capability;
pub use change::{Change, ChangeError};
pub use closed_loop::{Baseline, ClosedLoop, Consequence, Effect, RiskCurve};
pub use gate::{Comparison, Gate, Joint, Judged, Passed};
pub use refusal::{Reason, Refusal};
pub use rehearsal::Rehearsal;
pub use search::{Attack, Effort, Found, Search};
pub use stage::Stage;
pub use tracking::{Wanted, track};
