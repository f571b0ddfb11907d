//! Token prices, what costs nothing, and the most that a request can cost.

use jiff::Timestamp;
use jiff::civil::{Date, Time, Weekday};
use jiff::tz::{Offset, TimeZone};
use serde::{Deserialize, Serialize, Serializer};

use super::chunk::Usage;
use super::provider;

/// Prices in US dollars per million tokens, at the cheaper hours where hours differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Price {
    /// Tokens of the question.
    pub input: f64,
    /// Tokens of the answer, reasoning included.
    pub output: f64,
    /// Tokens of the question that came from the server's cache; where none is stated, they cost what others do.
    pub cached: Option<f64>,
    /// Tokens of the question that were written to the server's cache; the same.
    pub cache_write: Option<f64>,
}

/// Prices of a provider's models.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prices {
    /// Prices by model and time; the first that fits holds.
    pub entries: Vec<PriceEntry>,
    /// The dearer hours, if there are any.
    pub peak: Option<Peak>,
    /// Price factor of batches.
    pub batch_factor: Option<f64>,
}

/// A price, of which models and when.
#[derive(Clone, Debug, PartialEq)]
pub struct PriceEntry {
    /// A model's name, or the beginning of some and `*`.
    pub model: String,
    /// The first day.
    pub from: Option<Date>,
    /// The last day.
    pub to: Option<Date>,
    /// The longest question it holds for, tokens; an entry that follows may have the price of longer ones.
    pub up_to: Option<u64>,
    /// The price.
    pub price: Price,
    /// The day on which its source had it so.
    pub as_of: Option<Date>,
    /// Where it is stated: an address.
    pub source: Option<String>,
}

impl Prices {
    /// Price of a model on a day, if known.
    #[must_use]
    pub fn pricing_for(&self, model: &str, day: Date) -> Option<Pricing> {
        let mut fitting = self.entries.iter().filter(|entry| {
            fits(&entry.model, model)
                && entry.from.is_none_or(|from| from <= day)
                && entry.to.is_none_or(|to| day <= to)
        });
        self.gather(&mut fitting)
    }

    /// The next price, and those of longer questions behind it.
    fn gather<'a>(&self, entries: &mut impl Iterator<Item = &'a PriceEntry>) -> Option<Pricing> {
        let entry = entries.next()?;
        let longer = entry.up_to.and_then(|_| self.gather(entries));
        Some(Pricing {
            price: entry.price,
            up_to: entry.up_to,
            longer: longer.map(Box::new),
            as_of: entry.as_of,
            source: entry.source.clone(),
            peak: self.peak.clone(),
            batch_factor: self.batch_factor,
        })
    }

    /// The same of the model that answered, which need not be the one asked for: providers route what they retire to
    /// other models, and bill those. The price of the one asked for holds only where the other is a version of it.
    #[must_use]
    pub fn of_answer(&self, asked: &str, returned: Option<&str>, day: Date) -> Option<Pricing> {
        let Some(returned) = returned else {
            return self.pricing_for(asked, day);
        };
        let name = |id: &str| id.rsplit('/').next().unwrap_or(id).to_ascii_lowercase();
        let version = name(returned).starts_with(&name(asked));
        self.pricing_for(returned, day)
            .or_else(|| self.pricing_for(asked, day).filter(|_| version))
    }
}

/// Whether a name, or a prefix and `*`, matches a model.
pub(super) fn fits(pattern: &str, model: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(beginning) => model.starts_with(beginning),
        None => pattern == model,
    }
}

/// Price of a model over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pricing {
    /// The price.
    #[serde(flatten)]
    pub price: Price,
    /// The longest question it holds for, tokens.
    #[serde(rename = "up_to_input_tokens")]
    pub up_to: Option<u64>,
    /// Price of longer questions, if known.
    pub longer: Option<Box<Pricing>>,
    /// The day on which its source had it so.
    #[serde(serialize_with = "as_text")]
    pub as_of: Option<Date>,
    /// Where it is stated; `None` if the user's configuration has it from nowhere.
    pub source: Option<String>,
    /// The dearer hours, if there are any.
    #[serde(rename = "peak_factor", serialize_with = "factor")]
    pub peak: Option<Peak>,
    /// Price factor of batches; see [`Pricing::batch_cost`].
    pub batch_factor: Option<f64>,
}

/// A day as text.
pub(super) fn as_text<S: Serializer>(day: &Option<Date>, to: S) -> Result<S::Ok, S::Error> {
    day.map(|day| day.to_string()).serialize(to)
}

fn factor<S: Serializer>(peak: &Option<Peak>, to: S) -> Result<S::Ok, S::Error> {
    peak.as_ref().map(|peak| peak.factor).serialize(to)
}

/// Hours at which everything costs more.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Peak {
    /// How much more, as a factor.
    #[serde(deserialize_with = "provider::amount")]
    pub factor: f64,
    /// From and to, on the clock of the offset; the end does not belong to it.
    #[serde(deserialize_with = "provider::hours")]
    pub hours: Vec<(Time, Time)>,
    /// Whether Saturdays and Sundays are left out.
    #[serde(default)]
    pub weekdays_only: bool,
    /// The clock's offset from UTC, hours.
    #[serde(deserialize_with = "provider::offset")]
    pub utc_offset: i8,
}

impl Pricing {
    /// Cost of a question with this many tokens, if known.
    #[must_use]
    pub fn at(&self, input: u64) -> Option<&Self> {
        match self.up_to {
            Some(longest) if input > longest => self.longer.as_ref()?.at(input),
            _ => Some(self),
        }
    }

    /// Date and source of the price, for display; `None` if neither is stated.
    #[must_use]
    pub fn origin(&self) -> Option<String> {
        match (self.as_of, &self.source) {
            (Some(day), Some(source)) => Some(format!("as of {day}, {source}")),
            (Some(day), None) => Some(format!("as of {day}")),
            (None, source) => source.clone(),
        }
    }

    /// What an answer cost that was asked for at this time, US dollars; `None` if a count is missing, or the price of a
    /// question of this length.
    #[must_use]
    pub fn cost(&self, usage: &Usage, asked: Timestamp) -> Option<f64> {
        if self.is_free() {
            return Some(0.0);
        }
        let (input, output) = (usage.input_tokens?, usage.output_tokens?);
        let cached = usage.cached_tokens.unwrap_or(0);
        let written = usage.cache_write_tokens.unwrap_or(0);
        // Counts that contradict each other prove nothing.
        let plain = input.checked_sub(cached.checked_add(written)?)?;
        let price = &self.at(input)?.price;
        let millionths = plain as f64 * price.input
            + cached as f64 * price.cached.unwrap_or(price.input)
            + written as f64 * price.cache_write.unwrap_or(price.input)
            + output as f64 * price.output;
        let usd = millionths * self.factor(asked) / 1e6;
        usd.is_finite().then_some(usd)
    }

    /// The cost of an answer asked for in a batch, US dollars; `None` as for [`Pricing::cost`], or if the price of
    /// batches is unknown.
    #[must_use]
    pub fn batch_cost(&self, usage: &Usage, asked: Timestamp) -> Option<f64> {
        Some(self.cost(usage, asked)? * self.batch_factor?)
    }

    fn factor(&self, at: Timestamp) -> f64 {
        match &self.peak {
            Some(peak) if peak.holds(at) => peak.factor,
            _ => 1.0,
        }
    }
}

impl Peak {
    fn holds(&self, at: Timestamp) -> bool {
        let Ok(offset) = Offset::from_hours(self.utc_offset) else {
            return false;
        };
        let there = at.to_zoned(TimeZone::fixed(offset));
        let weekend = matches!(there.weekday(), Weekday::Saturday | Weekday::Sunday);
        let now = there.time();
        let within = self
            .hours
            .iter()
            .any(|(from, to)| *from <= now && now < *to);
        within && !(weekend && self.weekdays_only)
    }
}

impl Pricing {
    /// The most that a request can cost, US dollars, whenever it is sent and whatever of it goes through a cache;
    /// `None` if the price of a question of this length is not known.
    #[must_use]
    pub fn at_most(&self, input: u32, output: u32) -> Option<f64> {
        // Tokens are estimated before they are sent: a question a quarter longer may be a dearer one.
        let longest = u64::from(input) + u64::from(input) / 4;
        let prices = [&self.at(u64::from(input))?.price, &self.at(longest)?.price];
        let factor = self.peak.as_ref().map_or(1.0, |peak| peak.factor.max(1.0));
        let most = prices.map(|price| {
            let dearest = [price.cached, price.cache_write].into_iter().flatten();
            let input_price = dearest.fold(price.input, f64::max);
            f64::from(input) * input_price + f64::from(output) * price.output
        });
        Some(most[0].max(most[1]) * factor / 1e6)
    }

    /// What [`Pricing::at_most`] counts beyond the listed prices, in words; `None` where it counts nothing more.
    #[must_use]
    pub fn bound_note(&self) -> Option<String> {
        let price = &self.price;
        let written = price
            .cache_write
            .filter(|write| *write > price.input)
            .map(|write| {
                if price.input > 0.0 {
                    format!(
                        "the question at the cache-write rate, ${write} per 1M (×{:.2} of input)",
                        write / price.input
                    )
                } else {
                    format!("the question at the cache-write rate, ${write} per 1M")
                }
            });
        let peak = self
            .peak
            .as_ref()
            .filter(|peak| peak.factor > 1.0)
            .map(|peak| format!("peak hours (×{})", peak.factor));
        let words: Vec<String> = written.into_iter().chain(peak).collect();
        (!words.is_empty()).then(|| words.join(", "))
    }
}

/// Where the price of such a server is from, for display.
const LOCAL_SERVER: &str = "a server on this machine";

impl Prices {
    /// The prices of a server on this machine: nothing, whatever the model.
    #[must_use]
    pub fn free() -> Self {
        Self {
            entries: vec![PriceEntry {
                model: "*".into(),
                from: None,
                to: None,
                up_to: None,
                price: Price {
                    input: 0.0,
                    output: 0.0,
                    cached: None,
                    cache_write: None,
                },
                as_of: None,
                source: Some(LOCAL_SERVER.into()),
            }],
            peak: None,
            batch_factor: Some(1.0),
        }
    }

    /// Whether these are the prices of [`Prices::free`].
    #[must_use]
    pub fn are_free(&self) -> bool {
        *self == Self::free()
    }
}

impl Pricing {
    /// Whether it is a price of [`Prices::free`].
    #[must_use]
    pub fn is_free(&self) -> bool {
        let nothing = self.price.input == 0.0 && self.price.output == 0.0;
        nothing && self.source.as_deref() == Some(LOCAL_SERVER)
    }

    /// The same in words; `None` for all others.
    #[must_use]
    pub fn free_note(&self) -> Option<String> {
        self.is_free().then(|| format!("free: {LOCAL_SERVER}"))
    }
}

#[cfg(test)]
pub mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::llm::Usage;

    pub fn pricing() -> Pricing {
        Pricing {
            price: Price {
                input: 2.0,
                output: 10.0,
                cached: Some(0.5),
                cache_write: Some(2.5),
            },
            up_to: None,
            longer: None,
            as_of: None,
            source: None,
            peak: Some(Peak {
                factor: 2.0,
                hours: vec![("09:00".parse().unwrap(), "12:00".parse().unwrap())],
                weekdays_only: true,
                utc_offset: 8,
            }),
            batch_factor: None,
        }
    }

    pub fn usage(input: u64, output: u64, cached: Option<u64>, written: Option<u64>) -> Usage {
        Usage {
            input_tokens: Some(input),
            output_tokens: Some(output),
            cached_tokens: cached,
            cache_write_tokens: written,
            ..Usage::default()
        }
    }

    pub const QUIET: &str = "2026-11-20T12:00:00Z";

    #[test]
    fn every_kind_of_token_has_its_price() {
        let at = QUIET.parse().unwrap();
        let cost = |usage| pricing().cost(&usage, at);
        let close = |cost: Option<f64>, usd: f64| assert!((cost.unwrap() - usd).abs() < 1e-12);
        close(cost(usage(1_000_000, 100_000, None, None)), 3.0);
        close(
            cost(usage(1_000_000, 0, Some(400_000), Some(200_000))),
            0.8 + 0.2 + 0.5,
        );
        assert_eq!(cost(usage(10, 0, Some(11), None)), None);
        assert_eq!(cost(Usage::default()), None);
        let mut plain = pricing();
        plain.price.cached = None;
        close(
            plain.cost(&usage(1_000_000, 0, Some(1_000_000), None), at),
            2.0,
        );
    }

    #[test]
    fn the_model_that_answered_is_billed() {
        let entry = |model: &str, input: f64, to: Option<&str>| PriceEntry {
            model: model.into(),
            from: None,
            to: to.map(|day| day.parse().unwrap()),
            up_to: None,
            price: Price {
                input,
                ..pricing().price
            },
            as_of: None,
            source: None,
        };
        let prices = Prices {
            entries: vec![
                entry("old", 1.0, Some("2026-11-30")),
                entry("old", 2.0, None),
                entry("new-*", 3.0, None),
            ],
            ..Prices::default()
        };
        let day = |day: &str| day.parse::<Date>().unwrap();
        let input = |pricing: Option<Pricing>| pricing.map(|p| p.price.input);
        assert_eq!(
            input(prices.pricing_for("old", day("2026-11-30"))),
            Some(1.0)
        );
        assert_eq!(
            input(prices.pricing_for("old", day("2026-12-01"))),
            Some(2.0)
        );
        assert_eq!(input(prices.pricing_for("older", day("2026-12-01"))), None);
        let answer = |returned| input(prices.of_answer("old", returned, day("2026-12-01")));
        assert_eq!(answer(None), Some(2.0));
        assert_eq!(answer(Some("old-2026-01-01")), Some(2.0));
        assert_eq!(answer(Some("new-flash")), Some(3.0));
        assert_eq!(answer(Some("unheard-of")), None);
    }

    #[test]
    fn peak_hours_are_those_of_the_place() {
        let cost = |at: &str| {
            let usage = usage(1_000_000, 0, None, None);
            pricing().cost(&usage, at.parse().unwrap()).unwrap()
        };
        assert_eq!(
            cost("2026-11-20T01:00:00Z"),
            4.0,
            "nine in Beijing, a Friday"
        );
        assert_eq!(cost("2026-11-20T00:59:59Z"), 2.0);
        assert_eq!(cost("2026-11-20T04:00:00Z"), 2.0, "noon");
        assert_eq!(cost("2026-11-21T02:00:00Z"), 2.0, "a Saturday");
    }

    #[test]
    fn a_longer_question_has_another_price_or_none() {
        let entry = |up_to: Option<u64>, input: f64| PriceEntry {
            model: "a".into(),
            from: None,
            to: None,
            up_to,
            price: Price {
                input,
                output: 0.0,
                cached: None,
                cache_write: None,
            },
            as_of: None,
            source: None,
        };
        let priced = |entries: Vec<PriceEntry>| {
            let prices = Prices {
                entries,
                ..Prices::default()
            };
            prices
                .pricing_for("a", "2026-11-20".parse().unwrap())
                .unwrap()
        };
        let stepped = priced(vec![
            entry(Some(1000), 1.0),
            entry(None, 3.0),
            entry(None, 9.0),
        ]);
        let cost = |pricing: &Pricing, input| {
            let cost = pricing.cost(&usage(input, 0, None, None), QUIET.parse().unwrap());
            cost.map(|usd| (usd * 1e6).round())
        };
        assert_eq!(cost(&stepped, 1000), Some(1000.0));
        assert_eq!(
            cost(&stepped, 1001),
            Some(3003.0),
            "all of it, not the rest"
        );
        assert_eq!(stepped.at_most(700, 0), Some(700e-6));
        assert_eq!(
            stepped.at_most(900, 0),
            Some(2700e-6),
            "it may be longer than estimated"
        );
        let short = priced(vec![entry(Some(1000), 1.0)]);
        assert_eq!((cost(&short, 1001), short.at_most(900, 0)), (None, None));
    }

    #[test]
    fn the_most_is_no_less_than_any_cost() {
        let most = pricing().at_most(1000, 1000).unwrap();
        for (cached, written) in [(0, 0), (1000, 0), (0, 1000)] {
            let usage = usage(1000, 1000, Some(cached), Some(written));
            for at in [QUIET, "2026-11-20T01:00:00Z"] {
                assert!(pricing().cost(&usage, at.parse().unwrap()).unwrap() <= most);
            }
        }
    }

    #[test]
    fn the_words_name_what_is_counted_beyond_the_list() {
        let mut priced = pricing();
        assert_eq!(
            priced.bound_note().unwrap(),
            "the question at the cache-write rate, $2.5 per 1M (×1.25 of input), peak hours (×2)"
        );
        priced.peak = None;
        priced.price.cache_write = Some(2.0);
        assert_eq!(priced.bound_note(), None, "no dearer than the list");
    }

    #[test]
    fn what_runs_here_costs_nothing_even_where_no_tokens_are_counted() {
        let prices = Prices::free();
        let day = "2026-11-20".parse().unwrap();
        let pricing = prices.of_answer("any", Some("other"), day).unwrap();
        let asked = "2026-11-20T12:00:00Z".parse().unwrap();
        assert_eq!(pricing.cost(&Usage::default(), asked), Some(0.0));
        assert_eq!(pricing.batch_cost(&Usage::default(), asked), Some(0.0));
        assert_eq!(pricing.at_most(1000, 1000), Some(0.0));
        assert!(prices.are_free() && !Prices::default().are_free());
        assert_eq!(
            pricing.free_note().unwrap(),
            "free: a server on this machine"
        );
    }
}
