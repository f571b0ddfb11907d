//! Scenes in words and the prompts around them: whole descriptions, traced numbers, and every template filled.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod close;
mod contact;
mod future;
mod options;
mod pack;
mod parsed;
mod random;
mod reach;
mod recomputed;
mod templates;
mod whole;

use std::collections::HashSet;
use std::sync::Arc;

use nearmiss::description::{Description, Value};
use nearmiss::formats::bundled;
use nearmiss::scenario::Scene;

/// The bundled scenario with this name and its recorded ego.
fn scene(name: &str) -> Scene {
    let entry = bundled().into_iter().find(|e| e.name == name).unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    Scene::new(Arc::clone(&scenario), ego)
}

/// Every number of a description is traced, and every trace is that number.
fn check_spans(described: &Description) {
    let text = &described.text;
    let mut covered = HashSet::new();
    let mut end = 0;
    for span in &described.spans {
        assert!(span.start >= end, "spans are in order: {span:?}");
        end = span.end;
        covered.extend(span.range());
        let written = &text[span.range()];
        match span.value {
            Value::Whole(value) => assert_eq!(written.parse(), Ok(value), "{span:?}"),
            Value::Real(value) => {
                let read: f64 = written.parse().unwrap();
                let decimals = written.split_once('.').map_or(0, |(_, d)| d.len());
                let half = 0.5 * 10_f64.powi(-(decimals as i32));
                let off = (read - value).abs();
                assert!(
                    off <= half + 1e-9 * value.abs().max(1.0),
                    "{written} is not {value}: {span:?}"
                );
            }
        }
    }
    for (place, byte) in text.bytes().enumerate() {
        assert!(
            !byte.is_ascii_digit() || covered.contains(&place),
            "untraced number at byte {place}: …{}",
            &text[place..text.len().min(place + 30)]
        );
    }
}
