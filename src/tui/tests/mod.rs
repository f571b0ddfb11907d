//! Tests of the whole workbench without a terminal: messages in, model and frames out.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod answers;
mod bench;
mod comparing;
mod editing;
mod frames;
mod keeping;
mod looking;
mod opening;
mod plotting;
mod prompt;
mod stored;
mod values;
