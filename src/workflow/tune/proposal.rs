//! What the reflecting model answers: a diagnosis, a change, and the text of a template.

use serde::Deserialize;
use serde_json::{Value, json};

use nearmiss_scene::verdict::object_in;

/// A proposal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Proposal {
    /// What the template lets the model do wrong.
    #[serde(default)]
    pub diagnosis: String,
    /// What is changed, in a sentence.
    #[serde(default)]
    pub change: String,
    /// The text after the front matter.
    pub template: String,
}

/// The schema of the answer.
pub(super) fn schema() -> Value {
    let text = |about: &str| json!({ "type": "string", "description": about });
    json!({
        "type": "object",
        "properties": {
            "diagnosis": text("What the template lets the model do wrong, in general."),
            "change": text("What the new template changes, in one sentence."),
            "template": text("The whole new text of the template after its front matter."),
        },
        "required": ["diagnosis", "change", "template"],
        "additionalProperties": false,
    })
}

impl Proposal {
    /// Reads an answer: one JSON object, alone or within other text.
    ///
    /// # Errors
    /// There is none: in words.
    pub fn read(text: &str) -> Result<Self, String> {
        let part = match (text.find('{'), text.rfind('}')) {
            (Some(from), Some(to)) if from < to => &text[from..=to],
            _ => text,
        };
        // Long texts in JSON often have lines of their own, which JSON forbids.
        let lenient = || serde_json::from_value(object_in(text)?).ok();
        let found: Self = match serde_json::from_str(part) {
            Ok(found) => found,
            Err(error) => {
                lenient().ok_or_else(|| format!("the answer is not the JSON asked for: {error}"))?
            }
        };
        if found.template.trim().is_empty() {
            Err("the answer has no template".into())
        } else {
            Ok(found)
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_answer_is_read_alone_and_within_text() {
        let object = json!({ "diagnosis": "d", "change": "c", "template": "{% block user %}" });
        let alone = Proposal::read(&object.to_string()).unwrap();
        assert_eq!(
            (alone.change.as_str(), alone.template.as_str()),
            ("c", "{% block user %}")
        );
        let within = format!("Here it is:\n```json\n{object}\n```\n");
        assert_eq!(Proposal::read(&within).unwrap(), alone);
        let lines = "{\"diagnosis\": \"d\", \"change\": \"c\", \"template\": \"{% block user %}\n{{ description }}\n{% endblock %}\"}";
        let lines = Proposal::read(lines).unwrap();
        assert_eq!(
            lines.template,
            "{% block user %}\n{{ description }}\n{% endblock %}"
        );
        for (wrong, why) in [
            ("no", "not the JSON"),
            ("{\"change\": \"c\"}", "missing field `template`"),
            ("{\"template\": \" \"}", "no template"),
            ("} {", "not the JSON"),
        ] {
            assert!(Proposal::read(wrong).unwrap_err().contains(why), "{wrong}");
        }
    }
}
