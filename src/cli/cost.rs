//! Formats what an answer consumed.

use nearmiss_store::Consumed;

/// The tokens, where the server stated any.
pub fn tokens(consumed: &Consumed) -> Option<String> {
    let (input, output) = (consumed.input_tokens, consumed.output_tokens);
    let count = |tokens: Option<u64>| tokens.map_or("unknown".into(), |t| t.to_string());
    (input.or(output).is_some()).then(|| format!("{} in, {} out", count(input), count(output)))
}

/// Why the cost of an answer is unknown. `asked` is `provider/model`, `returned` the model as the server named it.
pub fn unknown(consumed: &Consumed, asked: &str, returned: Option<&str>) -> String {
    match (consumed.input_tokens, consumed.output_tokens) {
        (Some(input), Some(_)) if consumed.cached_tokens.is_some_and(|cached| cached > input) => {
            "the server counts more cached tokens than tokens sent".into()
        }
        (Some(_), Some(_)) => {
            let name = asked.split_once('/').map_or(asked, |(_, name)| name);
            format!("no price for {}", returned.unwrap_or(name))
        }
        _ => "the server sent no token counts".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reason_is_the_first_that_holds() {
        let consumed = |input, output, cached| Consumed {
            input_tokens: input,
            output_tokens: output,
            cached_tokens: cached,
            ..Consumed::default()
        };
        let whole = consumed(Some(10), Some(2), None);
        assert_eq!(tokens(&whole).as_deref(), Some("10 in, 2 out"));
        assert_eq!(tokens(&Consumed::default()), None);
        assert_eq!(unknown(&whole, "lab/a/b", None), "no price for a/b");
        assert_eq!(unknown(&whole, "lab/a", Some("b")), "no price for b");
        let half = consumed(Some(10), None, None);
        assert_eq!(tokens(&half).as_deref(), Some("10 in, unknown out"));
        assert!(unknown(&half, "lab/a", None).contains("no token counts"));
        let odd = consumed(Some(10), Some(2), Some(11));
        assert!(unknown(&odd, "lab/a", None).contains("cached"));
    }
}
