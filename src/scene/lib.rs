//! Driving scenarios and what is true about them: measures, verdicts, the built-in judge, scenes in words.

pub mod corpus;
/// Scenes in words.
pub mod description;
/// The built-in reference judge.
pub mod judge;
/// Safety measures, their registry, series and the risk score.
pub mod metrics;
/// Scenarios and scenes.
pub mod scenario;
/// What happened, in sentences.
pub mod story;
pub mod traffic_rules;
/// What judges say, as structured data.
pub mod verdict;
