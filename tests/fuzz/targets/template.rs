//! Any text is a template that can be filled, or an error with a file and words; in bounded time and memory.
#![no_main]

use std::collections::BTreeMap;

use libfuzzer_sys::fuzz_target;
use nearmiss::prompts::{Template, render};

fuzz_target!(|text: &str| {
    let _ = Template::read(text);
    let values = serde_json::json!({
        "cp": true, "cot": true, "icl": false, "task": "safety", "frame": "ego", "history": 10, "dt": 0.1,
        "description": "Obstacle 20 is 9.5 m ahead.", "obstacles": [20, 21],
    });
    if let Err(error) = render("fuzz.md", text, &BTreeMap::new(), values) {
        assert!(!error.message.is_empty());
    }
});
