//! Numbers and files: scenarios, measures, words, drives, variants, reports.

mod answers;
mod bundled;
mod claims;
mod commonroad;
mod crop;
mod drivers;
mod egos;
mod encounter_families;
mod generating;
mod generation;
mod generation_gate;
mod implausible;
mod measures;
mod paper;
mod planner;
mod planner_check;
mod protobuf;
mod protobuf_messages;
mod published;
mod recorded;
mod report;
mod road;
mod safety;
mod search;
mod simulators;
mod solution;
mod stories;
#[path = "../support/mod.rs"]
mod support;
mod traffic_rules;
mod transform;
mod windows;
mod words;
