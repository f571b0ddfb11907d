//! OpenRouter's `reasoning_details`: read in fragments, sent again with the calls that they led to.

use serde_json::Value;

use super::string;

/// Most details of a turn that are kept.
const MOST: usize = 256;

/// The details of a turn so far.
#[derive(Debug, Default)]
pub(super) struct Details(Vec<Value>);

impl Details {
    /// Adds those of a fragment: texts grow, everything else is what was said last.
    pub fn add(&mut self, delta: &Value) {
        let list = delta.get("reasoning_details").and_then(Value::as_array);
        for detail in list.into_iter().flatten().filter(|d| d.is_object()) {
            let same = |known: &&mut Value| {
                known.get("index") == detail.get("index") && known.get("type") == detail.get("type")
            };
            let room = self.0.len() < MOST;
            match self.0.last_mut().filter(same) {
                Some(known) => grow(known, detail),
                None if room => self.0.push(detail.clone()),
                None => {}
            }
        }
    }

    /// All of them; none are left.
    pub fn take(&mut self) -> Vec<Value> {
        std::mem::take(&mut self.0)
    }
}

fn grow(known: &mut Value, more: &Value) {
    for (key, value) in more.as_object().into_iter().flatten() {
        match (key.as_str(), string(known, key), value) {
            ("text" | "summary" | "data", Some(before), Value::String(after)) => {
                let grown = format!("{before}{after}");
                known[key] = grown.into();
            }
            (_, _, Value::Null) => {}
            _ => known[key] = value.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn fragments_grow_together_and_keep_their_signature() {
        let mut details = Details::default();
        let fragments = [
            json!([{"type": "reasoning.text", "index": 0, "text": "The gap", "format": "f"}]),
            json!([{"type": "reasoning.text", "index": 0, "text": " shrinks."}]),
            json!([{"type": "reasoning.text", "index": 0, "signature": "s", "text": null}]),
            json!([{"type": "reasoning.encrypted", "index": 1, "data": "x"}, 7]),
        ];
        for fragment in fragments {
            details.add(&json!({"reasoning_details": fragment}));
        }
        details.add(&json!({"reasoning_details": "none"}));
        assert_eq!(
            details.take(),
            [
                json!({
                    "type": "reasoning.text", "index": 0, "text": "The gap shrinks.", "format": "f", "signature": "s",
                }),
                json!({"type": "reasoning.encrypted", "index": 1, "data": "x"}),
            ]
        );
        assert!(details.take().is_empty());
    }
}
