//! JSON in another form: in a string, with escaped quotes, with the signs of East Asian keyboards.

use serde_json::Value;

/// What an answer may be in another form: JSON in a JSON string, JSON whose quotes are escaped, JSON with the signs of East
/// Asian keyboards; with what was done.
pub(super) fn disguised(answer: &str) -> Vec<(String, &'static str)> {
    let mut found = Vec::new();
    if let Ok(Value::String(text)) = serde_json::from_str(answer.trim()) {
        found.push((text, "the JSON is written in a string"));
    }
    if answer.contains("\\\"") {
        found.push((
            answer.replace("\\\"", "\""),
            "the quotes of the JSON are escaped",
        ));
    }
    let narrow = |sign: char| match sign {
        '：' => ':',
        '，' => ',',
        '｛' => '{',
        '｝' => '}',
        '［' => '[',
        '］' => ']',
        '＂' => '"',
        other => other,
    };
    let narrowed: String = answer.chars().map(narrow).collect();
    if narrowed != answer {
        found.push((narrowed, "the JSON has full-width signs"));
    }
    found
}
