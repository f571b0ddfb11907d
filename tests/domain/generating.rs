//! Models as authors of attacks: what they get wrong goes back to them with the gate's words, and nothing invalid
//! gets through.
#![allow(clippy::unwrap_used)]

mod bench;
mod choosing;
mod driving;
mod skill;
use crate::support;
mod writing;
