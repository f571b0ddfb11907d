//! Models as authors of attacks: what they get wrong goes back to them with the gate's words, and nothing invalid
//! gets through.
#![allow(clippy::unwrap_used)]

#[path = "generating/bench.rs"]
mod bench;
#[path = "generating/choosing.rs"]
mod choosing;
#[path = "generating/driving.rs"]
mod driving;
#[path = "generating/skill.rs"]
mod skill;
mod support;
#[path = "generating/writing.rs"]
mod writing;
