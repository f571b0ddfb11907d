//! Making a safe scenario dangerous: one obstacle, the attacker, gets another motion.
//!
//! A changed motion is exported only if it has passed the gate, whoever thought of it: a search, a model or a
//! file. The ego then plans anew against it, since a collision with a recorded ego proves nothing.

mod avoidable;
mod capability;
mod change;
mod closed_loop;
mod escape;
mod manoeuvre;
mod refusal;
#[cfg(test)]
mod tests;
mod variant;
mod variant_document;

pub use avoidable::{
    Avoidability, Avoidance, Certificate, DELAYS, Finder, NotFound, Searched, Why,
};
pub use capability::Capability;
pub use change::{Change, ChangeError};
pub use closed_loop::{Baseline, ClosedLoop, Consequence, Effect, RiskCurve};
pub use manoeuvre::Manoeuvre;
pub use refusal::{Reason, Refusal};
pub use variant::{Saved, Variant, VariantError};
