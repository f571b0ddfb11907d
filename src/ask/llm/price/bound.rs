//! The most that a request can cost, and what that bound counts.

use super::Pricing;

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
    pub fn bound_words(&self) -> Option<String> {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::{QUIET, pricing, usage};

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
            priced.bound_words().unwrap(),
            "the question at the cache-write rate, $2.5 per 1M (×1.25 of input), peak hours (×2)"
        );
        priced.peak = None;
        priced.price.cache_write = Some(2.0);
        assert_eq!(priced.bound_words(), None, "no dearer than the list");
    }
}
