//! Tokens of an answer with their log probabilities, as servers report them.

use serde_json::Value;

/// Alternatives that are asked for at each token: a yes, a no, and how either may be spelt.
pub(super) const ALTERNATIVES: u32 = 5;

/// Most alternatives of a token that are kept, and most bytes of each.
const MOST_ALTERNATIVES: usize = 20;
const LONGEST: usize = 200;

/// A token of an answer, with what the model might have written in its place. It is the server's text, from which
/// secrets are not taken out: to be computed with, neither shown nor stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// Its text.
    pub text: String,
    /// The natural logarithm of its probability.
    pub log_probability: f64,
    /// The likeliest tokens at its place, perhaps itself among them, each with the same.
    pub alternatives: Vec<(String, f64)>,
}

impl Token {
    /// A token; `None` if it has no logarithm of a probability. What is wrong with an alternative leaves that one out.
    pub(super) fn new(
        chosen: (Option<&str>, Option<f64>),
        alternatives: impl Iterator<Item = (Option<String>, Option<f64>)>,
    ) -> Option<Self> {
        let valid = |log: &f64| *log <= 0.001 && !log.is_nan();
        let kept = alternatives.filter_map(|(text, log)| Some((cut(&text?), log.filter(valid)?)));
        Some(Self {
            text: chosen.0?.to_owned(),
            log_probability: chosen.1.filter(valid)?,
            alternatives: kept.take(MOST_ALTERNATIVES).collect(),
        })
    }
}

fn cut(text: &str) -> String {
    text[..text.floor_char_boundary(LONGEST)].to_owned()
}

/// The tokens of a list as OpenAI has it: `token`, `logprob`, `top_logprobs`. Others speak it too.
pub(super) fn tokens(list: Option<&Value>) -> Vec<Token> {
    let pair = |entry: &Value| {
        let text = entry.get("token").and_then(Value::as_str);
        let log = entry.get("logprob").and_then(Value::as_f64);
        (text.map(str::to_owned), log)
    };
    let token = |entry: &Value| {
        let top = entry.get("top_logprobs").and_then(Value::as_array);
        let (text, log) = pair(entry);
        Token::new((text.as_deref(), log), top.into_iter().flatten().map(pair))
    };
    let entries = list.and_then(Value::as_array);
    entries.into_iter().flatten().filter_map(token).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_no_log_probability_is_left_out() {
        let list = json!([
            {"token": "true", "logprob": -0.1, "top_logprobs": [
                {"token": "true", "logprob": -0.1}, {"token": "false", "logprob": 3.0}, {"logprob": -1.0}]},
            {"token": "}", "logprob": null},
            {"token": "}", "logprob": -9999.0},
        ]);
        let found = tokens(Some(&list));
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!(found[0].alternatives, [("true".to_string(), -0.1)]);
        assert_eq!(found[1].log_probability, -9999.0);
        assert_eq!(tokens(None), []);
        assert_eq!(tokens(Some(&json!("no list"))), []);
    }
}
