//! Generates dangerous variants of a safe scenario by giving one obstacle, the attacker, another motion, or several.
//!
//! A changed motion is exported only if it passed the gate, whether it comes from a search, a model or a file. The ego
//! then plans anew against it, since a collision with a recorded ego proves nothing.

mod attack;
pub mod attacker;
mod certificate;
mod change;
mod closed_loop_screening;
mod effect;
mod evasive_search;
mod family;
mod gate;
mod manifest;
pub mod manoeuvre;
pub mod motion;
mod plausibility;
mod preventable;
mod refusal;
mod repair;
mod screening;
mod search;
mod staging;
#[cfg(test)]
mod tests;
mod tracking;
mod variant;
mod variant_generator;
mod wish;

pub use attack::{Attack, AttackContext, AttackSetup, SAME_PLACE, SAME_SPEED};
pub use attacker::Capability;
pub use certificate::{
    Avoidability, Certificate, DELAYS, EvasiveReview, EvasiveTrajectory, Finder, NotFound,
    SearchEffort, Unavoidable,
};
pub use change::{Change, ChangeError, JointChange, MOST_ATTACKERS};
pub use closed_loop_screening::{Baseline, ClosedLoop, NEAR_MISS, StagedDrive};
pub use effect::{AttackerEffect, Consequence, Effect, RiskCurve, SelectedAttack, choose};
pub use evasive_search::EvasiveManoeuvre;
pub use family::{EncounterFamily, Values, Varied};
pub use gate::{Comparison, Gate, GateEvidence, GateResult, Joint};
pub use manifest::{
    AttackerRecord, CertificateRecord, ContactRecord, DriveEnd, EvasionRecord, LogLikelihoods,
    Manifest, OriginalRecord, OutcomeName, PlannerIdentity, RefusalRecord, RequestedMotion,
};
pub use nearmiss_scene::scenario::HumanLimits;
pub use plausibility::{MotionQuantity, MotionSamples, Plausibility, RecordedMotions};
pub use refusal::{Reason, Refusal, RefusalSummary, summarize};
pub use repair::{AdmittedAttack, MAX_DISPLACEMENT, Repair, admit};
pub use screening::OpenLoopScreening;
pub use search::search_until;
pub use tracking::{TrackingTarget, track};
pub use variant::{MARK, Variant, VariantError, VariantFiles, attacked_planner};
pub use variant_generator::{
    Effort, GeneratorError, Progress, SearchEvent, SearchResult, Selection, VariantGenerator,
};
pub use wish::{AllowedAttacks, AttackPlace, AttackStyle, Wish};
