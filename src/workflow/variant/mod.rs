//! Variants of scenarios: what they are made with, what was made, and records of it for programs.

mod generated;
mod line;
mod settings;

pub use generated::{Generated, Gone};
pub use line::{ComparedSamples, ExternalPlannerRecord, GoodDriver, VariantLine};
pub use settings::{
    AttackRequest, GenerationSettings, PROMPTS, PlannerProcess, SearchSettings, WriterSettings,
    attacker_count, attackers_together, candidate_count, distinct_attackers, reaction_time,
};
