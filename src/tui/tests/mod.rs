//! Tests of the whole workbench without a terminal: messages in, model and frames out.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod answers;
mod asking;
mod bench;
mod comparing;
mod defaults;
mod editing;
mod frames;
mod history;
mod jobs;
mod keeping;
mod kept;
mod listing;
mod look;
mod looking;
mod map;
mod opening;
mod pictures;
mod plotting;
mod prompt;
mod reasoning;
mod side_by_side;
mod stored;
mod thousands;
mod timeline;
mod values;
