//! Tests of the whole workbench without a terminal: messages in, model and frames out.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod answers;
mod bench;
mod comparing;
mod frames;
mod looking;
mod opening;
mod pictures;
mod plotting;
mod prompt;
mod stored;
mod values;
