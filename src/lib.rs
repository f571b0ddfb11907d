//! A workbench for safety-critical driving scenarios: reading, measuring, describing, asking, comparing.

/// Asking language models: requests, streams of chunks, errors.
pub mod llm;
