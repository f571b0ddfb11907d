//! Generates dangerous variants of a safe scenario by giving one obstacle, the attacker, another motion, or several.
//!
//! A changed motion is exported only if it passed the gate, whether it comes from a search, a model or a file. The ego
//! then plans anew against it, since a collision with a recorded ego proves nothing.

mod attack;
mod attack_context;
pub mod attacker;
mod capability;
mod certificate;
mod change;
mod closed_loop_screening;
mod effect;
mod effort;
mod evasive_manoeuvre;
mod evasive_review;
mod evasive_search;
mod gate;
mod joint_change;
mod manifest;
pub mod manoeuvre;
mod manoeuvre_space;
pub mod motion;
mod plausibility;
mod refusal;
mod refusal_summary;
mod repair;
mod screening;
mod search;
mod search_result;
mod select_attack;
mod staging;
mod style;
mod surrogate;
#[cfg(test)]
mod tests;
mod tracking;
mod variant;
mod variant_generator;
mod waypoints;
mod wish;

pub use attack::{Attack, AttackSetup, SAME_PLACE, SAME_SPEED};
pub use attack_context::AttackContext;
pub use capability::Capability;
pub use certificate::{
    Avoidability, Certificate, DELAYS, EvasiveTrajectory, Finder, NotFound, SearchEffort,
    Unavoidable,
};
pub use change::{Change, ChangeError};
pub use closed_loop_screening::{Baseline, ClosedLoop, NEAR_MISS, StagedDrive};
pub use effect::{AttackerEffect, Consequence, Effect, RiskCurve};
pub use effort::Effort;
pub use evasive_manoeuvre::EvasiveManoeuvre;
pub use evasive_review::EvasiveReview;
pub use gate::{Comparison, Gate, GateEvidence, GateResult, Joint};
pub use joint_change::{JointChange, MOST_ATTACKERS};
pub use manifest::{
    AttackerRecord, CertificateRecord, ContactRecord, DriveEnd, EvasionRecord, LogLikelihoods,
    Manifest, OriginalRecord, OutcomeName, PlannerIdentity, RefusalRecord, RequestedMotion,
};
pub use nearmiss_scene::scenario::HumanLimits;
pub use plausibility::{MotionQuantity, MotionSamples, Plausibility, RecordedMotions};
pub use refusal::{Reason, Refusal};
pub use refusal_summary::{RefusalSummary, summarize};
pub use repair::{AdmittedAttack, FARTHEST, Repair, admit};
pub use screening::OpenLoopScreening;
pub use search::search_until;
pub use search_result::{Progress, SearchResult};
pub use select_attack::{SelectedAttack, choose};
pub use style::AttackStyle;
pub use tracking::{TrackingTarget, track};
pub use variant::{MARK, Variant, VariantError, VariantFiles, attacked_planner};
pub use variant_generator::{GeneratorError, SearchEvent, Selection, VariantGenerator};
pub use wish::{AllowedAttacks, AttackPlace, Wish};
