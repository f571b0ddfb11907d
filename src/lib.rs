//! A workbench for safety-critical driving scenarios: reading, measuring, describing, asking, comparing.

pub mod geometry;
pub mod scenario;
pub mod cli;
pub mod metrics;
pub mod text;
pub mod verdict;
