//! A workbench for safety-critical driving scenarios: reading, measuring, describing, asking, comparing.

/// The command line: one file a subcommand.
pub mod cli;
/// The user's folders and configuration file.
pub mod config;
/// One case from end to end.
pub mod evaluation;
/// Making a safe scenario dangerous: attackers, the gate, avoidability.
pub mod generation;
/// Poses, footprints, polylines, polygons, with exact distances.
pub mod geometry;
/// The built-in reference judge.
pub mod judge;
/// Asking language models: requests, streams of chunks, errors.
pub mod llm;
/// Safety measures, their registry, series and the risk score.
pub mod metrics;
/// Figures of scenes, plots and screens: SVG, PNG, GIF.
pub mod picture;
/// A sampling-based motion planner.
pub mod planner;
/// Prompt templates and how they are filled.
pub mod prompts;
/// Scenarios and scenes, and the files they come from.
pub mod scenario;
/// The closed loop: the planner drives the ego through a scenario.
pub mod simulation;
/// Every run, in SQLite.
pub mod store;
/// The operating system: what it says, in plain words, and files that somebody names.
pub mod system;
/// Scenes in words.
pub mod text;
/// The workbench in the terminal.
pub mod tui;
/// What judges say, as structured data.
pub mod verdict;
