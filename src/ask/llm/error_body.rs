//! Extracts the server's message from the many shapes of error bodies.

use std::time::Duration;

use serde_json::Value;

/// A server's own description of an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ErrorBody {
    /// Its words.
    pub message: String,
    /// `error.code`, which may be a string or a number.
    pub code: Option<String>,
    /// `error.type` or `error.status`.
    pub kind: Option<String>,
    /// The wait it asks for in the body (Google's `RetryInfo`).
    pub retry_delay: Option<Duration>,
    /// The quota of a whole day is used up (Google's `QuotaFailure`), whatever wait is named.
    pub day_is_spent: bool,
}

impl ErrorBody {
    /// The error inside a JSON document, if there is one: `{error:{…}}`, `{error:"…"}`, the same in a list or in the
    /// first choice, or a flat object that calls itself an error.
    pub fn in_value(value: &Value) -> Option<Self> {
        let value = value
            .as_array()
            .and_then(|list| list.first())
            .unwrap_or(value);
        let found = value
            .get("error")
            .filter(|e| is_meant(e))
            .or_else(|| value.pointer("/choices/0/error").filter(|e| is_meant(e)));
        match found {
            Some(Value::Object(_)) => found.map(Self::of_object),
            Some(other) => Some(Self {
                message: text(other),
                ..Self::default()
            }),
            None => {
                let says_so = |key| value.get(key).and_then(Value::as_str) == Some("error");
                (says_so("object") || says_so("type")).then(|| Self::of_object(value))
            }
        }
    }

    /// The error in the body of a failed answer; a body of no known shape is its own message, cut at 300 characters.
    pub fn in_body(body: &str) -> Self {
        let Ok(value) = serde_json::from_str::<Value>(body) else {
            return Self {
                message: plain_body(body),
                ..Self::default()
            };
        };
        if let Some(body) = Self::in_value(&value) {
            return body;
        }
        let flat = ["message", "detail"]
            .iter()
            .any(|key| value.get(key).is_some_and(is_meant));
        if flat {
            Self::of_object(&value)
        } else {
            Self {
                message: plain_body(body),
                ..Self::default()
            }
        }
    }

    /// Whether the account is used up, so that asking again cannot help.
    pub fn is_exhausted(&self) -> bool {
        let words = [&self.code, &self.kind].into_iter().flatten();
        let spent = |word: &str| {
            matches!(
                word,
                "insufficient_quota"
                    | "credit_balance_exhausted"
                    | "billing_hard_limit_reached"
                    | "insufficient_balance"
                    | "enforced_spend_limit_reached"
            )
        };
        self.day_is_spent || words.into_iter().any(|word| spent(word))
    }

    fn of_object(object: &Value) -> Self {
        let field = |key: &str| object.get(key).filter(|v| is_meant(v));
        let mut message = field("message")
            .or_else(|| field("detail"))
            .map_or_else(|| text(object), text);
        // OpenRouter's own message is only "Provider returned error"; the cause is here.
        if let Some(raw) = object.pointer("/metadata/raw").filter(|v| is_meant(v)) {
            message = format!("{message}: {}", text(raw));
        }
        // Anthropic's spend limits have an ordinary type and are told apart here.
        let inner = object
            .pointer("/details/error_code")
            .filter(|v| is_meant(v));
        let details = object.get("details").and_then(Value::as_array);
        let details = || details.into_iter().flatten();
        let violations = details().filter_map(|d| d.get("violations")?.as_array());
        let day_is_spent = violations.flatten().any(|violation| {
            let id = violation.get("quotaId").and_then(Value::as_str);
            id.is_some_and(|id| id.contains("PerDay"))
        });
        let delay = details().find_map(|d| {
            d.get("retryDelay")?
                .as_str()?
                .strip_suffix('s')?
                .parse()
                .ok()
        });
        Self {
            message,
            code: inner.or_else(|| field("code")).map(text),
            kind: field("type").or_else(|| field("status")).map(text),
            retry_delay: delay.and_then(|seconds: f64| Duration::try_from_secs_f64(seconds).ok()),
            day_is_spent,
        }
    }
}

/// Servers send `error: null`, `false`, `""` and `{}` along with good answers.
fn is_meant(value: &Value) -> bool {
    match value {
        Value::Null | Value::Bool(false) => false,
        Value::String(text) => !text.trim().is_empty(),
        Value::Object(fields) => !fields.is_empty(),
        _ => true,
    }
}

fn text(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

fn plain_body(body: &str) -> String {
    let short = tidy(body, 300);
    if short.is_empty() {
        "without explanation".to_owned()
    } else {
        short
    }
}

/// How much of a server's words an error quotes, characters: what to do stands behind them, and must be seen.
pub(super) const MAX_QUOTE_LENGTH: usize = 400;

/// One line of at most `longest` characters: control characters and runs of white space become one space.
pub(super) fn tidy(text: &str, longest: usize) -> String {
    let mut line = String::new();
    for word in text
        .split(|c: char| c.is_whitespace() || c.is_control())
        .filter(|w| !w.is_empty())
    {
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    match line.char_indices().nth(longest) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::json;

    #[test]
    fn the_message_is_found_in_every_shape() {
        for (body, expected) in [
            (
                r#"{"error":{"message":"bad","type":"x","code":null}}"#,
                "bad",
            ),
            (r#"{"error":"model not pulled"}"#, "model not pulled"),
            (r#"{"object":"error","message":"flat","code":400}"#, "flat"),
            (r#"{"message":"flat"}"#, "flat"),
            (r#"{"detail":"Not Found"}"#, "Not Found"),
            (
                r#"[{"error":{"code":400,"message":"in a list","status":"INVALID_ARGUMENT"}}]"#,
                "in a list",
            ),
            (
                r#"{"error":{"message":"Provider returned error","metadata":{"raw":"too long"}}}"#,
                "Provider returned error: too long",
            ),
            (r#"{"error":{"reason":"odd"}}"#, r#"{"reason":"odd"}"#),
            ("<html>\n  oops</html>", "<html> oops</html>"),
            ("", "without explanation"),
            ("{}", "{}"),
        ] {
            assert_eq!(ErrorBody::in_body(body).message, expected, "{body}");
        }
        assert_eq!(
            ErrorBody::in_body(&"é".repeat(400)).message.chars().count(),
            301
        );
    }

    #[test]
    fn codes_may_be_numbers_words_or_absent() {
        let code = |c: Value| {
            ErrorBody::in_value(&json!({"error": {"message": "m", "code": c}}))
                .unwrap()
                .code
        };
        assert_eq!(code(json!(502)).as_deref(), Some("502"));
        assert_eq!(code(json!("overloaded")).as_deref(), Some("overloaded"));
        assert_eq!(code(Value::Null), None);
    }

    #[test]
    fn an_empty_error_field_is_no_error() {
        for error in [Value::Null, json!(false), json!(""), json!({})] {
            assert_eq!(
                ErrorBody::in_value(&json!({"error": error, "choices": []})),
                None
            );
        }
    }

    #[test]
    fn exhausted_is_not_busy() {
        let body = |code: &str| {
            ErrorBody::in_body(&json!({"error": {"message": "m", "code": code}}).to_string())
        };
        assert!(body("insufficient_quota").is_exhausted());
        assert!(!body("rate_limit_exceeded").is_exhausted());
        let spend = r#"{"type":"error","error":{"type":"rate_limit_error","message":"m","details":{"error_code":"enforced_spend_limit_reached"}}}"#;
        assert!(ErrorBody::in_body(spend).is_exhausted());
        let quota = |id: &str| {
            let details = json!([{"violations": [{"quotaId": id}]}, {"retryDelay": "17s"}]);
            ErrorBody::in_value(&json!({"error": {"message": "m", "details": details}})).unwrap()
        };
        assert!(quota("GenerateRequestsPerDayPerProjectPerModel-FreeTier").is_exhausted());
        assert!(!quota("GenerateRequestsPerMinutePerProjectPerModel").is_exhausted());
    }

    #[test]
    fn google_puts_the_wait_into_the_body() {
        let body = json!([{"error": {"code": 429, "message": "m", "details": [{"@type": "x"}, {"retryDelay": "17.5s"}]}}]);
        assert_eq!(
            ErrorBody::in_value(&body).unwrap().retry_delay,
            Some(Duration::from_millis(17_500))
        );
    }
}
