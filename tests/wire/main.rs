//! What goes over the wire: providers and their faults, batches, against servers of our own.

mod batches;
mod llm_wire;
mod misbehaviour;
#[path = "../support/mod.rs"]
mod support;
