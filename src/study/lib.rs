//! Evaluation of models, claims, statistics, and the tools that models call.

/// One case from end to end.
pub mod evaluation;
/// What is held against the paper "From Words to Collisions".
pub mod paper;
pub mod tools;
