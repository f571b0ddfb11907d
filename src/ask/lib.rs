//! Prompt templates and language models.

/// Asking language models: requests, streams of chunks, errors.
pub mod llm;
/// Prompt templates and how they are filled.
pub mod prompts;
