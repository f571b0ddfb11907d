//! Prompt optimisation: better templates from wrong answers of a dev split, within a budget.
//!
//! [`tune_request`] takes the dev scenarios of an experiment and one way of asking; those of the test split are
//! never opened. [`TunePlan`] divides the dev scenarios once more: wrong answers are shown of the feedback part, and
//! templates are compared on the selection part. [`tune`] asks a model for better templates, round by round, and keeps
//! those that prove better: reflective evolution of prompts with a Pareto front, as in L. A. Agrawal et al., "GEPA:
//! Reflective Prompt Evolution Can Outperform Reinforcement Learning", arXiv:2507.19457 (2025); the front here is over
//! F1 and cost.
//!
//! Everything is decided by the seed and by answers, and every answer is in the store before it is used: the same tune
//! after a kill takes the same way without paying for it again.

mod ask;
mod candidate;
mod outcome;
mod prepare;
mod reflect;
mod rounds;

pub use candidate::{Candidate, CostMeasure, Refusal, RefusedBecause, Score, template_diff};
pub use nearmiss_study::evaluation::batch::TuneSettings;
pub use outcome::{
    Measure, TuneError, TuneEstimate, TuneEvent, TuneModels, TuneOutcome, Usage, can_tune, estimate,
};
pub use prepare::{DevPart, Division, TunePlan, TuneQuestion, TuneRequest, tune_request};
pub use rounds::tune;

#[cfg(test)]
mod tests;
