//! Lenient JSON: embedded in text, with mistakes of people and Python, possibly truncated.
//!
//! One pass from left to right with bounded look-ahead and depth, linear in any text. Valid JSON is read exactly; every
//! departure from it is reported as a [`Repair`].

mod opening;
mod reasons;
mod repair_kinds;
mod string;
mod text;
mod tolerant_reader;

use std::collections::BTreeSet;

use serde_json::Value;

use opening::Opening;
pub use reasons::{ReasonedAnswer, reasons_first};
pub(super) use repair_kinds::Repair;
use tolerant_reader::Reader;

/// Deeper values end the reading of the piece they are in.
const MOST_DEPTH: usize = 48;

/// An object or list found in a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct JsonPiece {
    /// What it holds; of a broken or cut one, what was complete.
    pub value: Value,
    /// What was put right.
    pub repairs: BTreeSet<Repair>,
    /// How it ends.
    pub end: End,
}

/// How a piece ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// With its own bracket.
    Whole,
    /// With the text.
    CutOff,
    /// With something that is no JSON by any reading.
    Broken,
}

/// All outermost objects and lists of objects in a text, in order; empty ones are left out.
pub(super) fn read(text: &str) -> Vec<JsonPiece> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(step) = text[at..].find(['{', '[']) {
        at += step;
        match opening::look(&text[at..]) {
            Opening::No(length) => at += length,
            Opening::Cut => {
                found.push(JsonPiece {
                    value: Value::Null,
                    repairs: BTreeSet::new(),
                    end: End::CutOff,
                });
                break;
            }
            Opening::Yes => {
                let mut reader = Reader::new(text, at);
                let value = reader.outermost();
                at = reader.at();
                let (repairs, end) = reader.finish();
                if !is_empty(&value) || end == End::CutOff {
                    found.push(JsonPiece {
                        value,
                        repairs,
                        end,
                    });
                }
            }
        }
    }
    found
}

/// The last whole object in a text, with mistakes of people and Python put right.
#[must_use]
pub fn object_in(text: &str) -> Option<Value> {
    let whole = |piece: &JsonPiece| piece.end == End::Whole && piece.value.is_object();
    let pieces = read(text).into_iter();
    pieces.rev().find(whole).map(|piece| piece.value)
}

fn is_empty(value: &Value) -> bool {
    match value {
        Value::Object(map) => map.is_empty(),
        Value::Array(items) => items.iter().all(is_empty),
        Value::Null => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests;
