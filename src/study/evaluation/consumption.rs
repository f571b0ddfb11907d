//! What answers consumed: time, tokens, and money that is known, bounded or unknown, each counted apart.

use jiff::Timestamp;
use jiff::tz::TimeZone;
use nearmiss_ask::llm::CostSource;
use nearmiss_store::Consumed;

use super::judges::ModelJudge;

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

/// One attempt at a question, as far as it was paid for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Attempt {
    /// Time, tokens and cost.
    pub consumed: Consumed,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    pub most_usd: Option<f64>,
}

/// A sum of costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spending {
    /// Attempts whose cost is known.
    pub known: u32,
    /// Their cost, US dollars.
    pub usd: f64,
    /// Attempts whose cost is not known, and what they can have cost at most is.
    pub bounded: u32,
    /// That, US dollars.
    pub most_usd: f64,
    /// Attempts of which neither is known.
    pub unknown: u32,
}

impl Spending {
    /// Adds an attempt: its cost, else the most that it can have cost. What can have cost nothing did.
    pub fn add(&mut self, cost_usd: Option<f64>, most_usd: Option<f64>) {
        match (cost_usd, most_usd) {
            (Some(usd), _) => {
                self.known += 1;
                self.usd += usd;
            }
            (None, Some(most)) if most <= 0.0 => self.known += 1,
            (None, Some(most)) => {
                self.bounded += 1;
                self.most_usd += most;
            }
            (None, None) => self.unknown += 1,
        }
    }

    /// Adds another sum.
    pub fn join(&mut self, other: &Self) {
        self.known += other.known;
        self.usd += other.usd;
        self.bounded += other.bounded;
        self.most_usd += other.most_usd;
        self.unknown += other.unknown;
    }

    /// Attempts whose cost is not known, bounded or not.
    #[must_use]
    pub fn unpriced(&self) -> u32 {
        self.bounded + self.unknown
    }

    /// The cost that is known, US dollars; `None` if none is.
    #[must_use]
    pub fn cost(&self) -> Option<f64> {
        (self.known > 0).then_some(self.usd)
    }

    /// The most that the bounded attempts cost, US dollars; `None` if there is none.
    #[must_use]
    pub fn most(&self) -> Option<f64> {
        (self.bounded > 0).then_some(self.most_usd)
    }
}

/// Describes the source of a cost.
pub(super) fn stated(source: CostSource, model: &ModelJudge, returned: Option<&str>) -> String {
    let table = "tokens times listed prices";
    match source {
        CostSource::Server => "stated by the server".into(),
        CostSource::Prices => {
            let today = Timestamp::now().to_zoned(TimeZone::UTC).date();
            let prices = &model.endpoint.prices;
            let pricing = prices.of_answer(&model.name, returned, today);
            if let Some(free) = pricing.as_ref().and_then(|pricing| pricing.free_note()) {
                return free;
            }
            match pricing.and_then(|pricing| pricing.origin()) {
                Some(origin) => format!("{table}, {origin}"),
                None => table.into(),
            }
        }
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

    #[test]
    fn known_bounded_and_unknown_costs_are_told_apart() {
        let mut sum = Spending::default();
        for (cost, most) in [
            (Some(0.25), Some(1.0)),
            (None, Some(0.5)),
            (None, None),
            (None, Some(0.0)),
        ] {
            sum.add(cost, most);
        }
        assert_eq!((sum.known, sum.cost()), (2, Some(0.25)));
        assert_eq!((sum.bounded, sum.most()), (1, Some(0.5)));
        assert_eq!((sum.unknown, sum.unpriced()), (1, 2));
        let mut twice = sum;
        twice.join(&sum);
        assert_eq!((twice.cost(), twice.unpriced()), (Some(0.5), 4));
        assert_eq!(Spending::default().cost(), None);
    }
}
