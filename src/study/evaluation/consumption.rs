//! What an answer consumed, in words: time, tokens, and why its cost is unknown.

use nearmiss_store::Consumed;

/// The tokens, where the server stated any.
#[must_use]
pub fn tokens(consumed: &Consumed) -> Option<String> {
    let (input, output) = (consumed.input_tokens, consumed.output_tokens);
    let count = |tokens: Option<u64>| tokens.map_or("unknown".into(), thousands);
    input.or(output)?;
    let mut words = format!("{} in, {} out", count(input), count(output));
    if let Some(reasoning) = consumed.reasoning_tokens {
        words += &format!(", {} of them reasoning", thousands(reasoning));
    }
    Some(words)
}

/// How long an answer took, where that is known.
#[must_use]
pub fn took(consumed: &Consumed) -> Option<String> {
    let whole = consumed.duration_ms.map(duration)?;
    Some(match consumed.first_chunk_ms {
        Some(first) => format!("{whole}, {} to first token", duration(first)),
        None => whole,
    })
}

/// Why the cost of an answer is unknown. `asked` is `provider/model`, `returned` the model as the server named it.
#[must_use]
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

/// A whole number with spaces between thousands.
#[must_use]
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Milliseconds in the unit that people would use.
#[must_use]
pub fn duration(ms: u64) -> String {
    match ms {
        0 => "<1 ms".into(),
        1..=999 => format!("{ms} ms"),
        1_000..=99_999 => format!("{:.1} s", ms as f64 / 1e3),
        _ => format!("{:.1} min", ms as f64 / 6e4),
    }
}

/// A moment, milliseconds since 1970, in the clock of this place.
#[must_use]
pub fn local_time(ms: i64) -> String {
    jiff::Timestamp::from_millisecond(ms).map_or(format!("{ms} ms"), |moment| {
        moment
            .to_zoned(jiff::tz::TimeZone::system())
            .strftime("%Y-%m-%d %H:%M")
            .to_string()
    })
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
