//! Round numbers for an axis: multiples of 1, 2 or 5 times a power of ten.

/// An axis that begins and ends on round numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Ticks {
    /// The first round number.
    first: f64,
    step: f64,
    /// How many there are, at least two.
    count: usize,
}

impl Ticks {
    /// Round numbers that `low` and `high` lie between, at most `most` of them but always two.
    #[must_use]
    pub fn around(low: f64, high: f64, most: usize) -> Self {
        Self::of(low, high, most, |from, to| (from.floor(), to.ceil()))
    }

    /// Round numbers between `low` and `high`, for an axis whose ends are given.
    #[must_use]
    pub fn within(low: f64, high: f64, most: usize) -> Self {
        Self::of(low, high, most, |from, to| (from.ceil(), to.floor()))
    }

    /// The two numbers, if nothing better is wanted.
    #[must_use]
    pub fn ends(low: f64, high: f64) -> Self {
        Self {
            first: low,
            step: high - low,
            count: 2,
        }
    }

    fn of(low: f64, high: f64, most: usize, round: fn(f64, f64) -> (f64, f64)) -> Self {
        let most = most.max(2) as f64;
        let span = (high - low).max(f64::MIN_POSITIVE);
        let rough = 10_f64.powf((span / most).log10().floor());
        // A span of nothing, or one that numbers cannot hold, has no round parts.
        if !rough.is_normal() {
            return Self::ends(low, high);
        }
        let steps = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0].map(|m| m * rough);
        let fitting = steps.into_iter().find_map(|step| {
            // What differs by rounding alone is the same number.
            let near = |v: f64| {
                if (v - v.round()).abs() < 1e-9 {
                    v.round()
                } else {
                    v
                }
            };
            let (from, to) = round(near(low / step), near(high / step));
            let count = to - from + 1.0;
            (count <= most).then_some((from, step, count))
        });
        match fitting {
            Some((from, step, count)) => Self {
                first: from * step,
                step,
                count: count.max(0.0) as usize,
            },
            None => Self::ends(low, high),
        }
    }

    /// The first and the last one.
    #[must_use]
    pub fn bounds(&self) -> (f64, f64) {
        (self.first, self.at(self.count.saturating_sub(1)))
    }

    fn at(&self, place: usize) -> f64 {
        self.first + place as f64 * self.step
    }

    /// The numbers, and how they are written.
    #[must_use]
    pub fn labels(&self) -> Vec<(f64, String)> {
        let values = (0..self.count).map(|i| self.at(i));
        values.map(|v| (v, self.written(v))).collect()
    }

    /// With as many decimals as the steps have.
    fn written(&self, value: f64) -> String {
        if value != 0.0 && (value.abs() >= 1e6 || self.step < 1e-3) {
            return format!("{value:.1e}");
        }
        let decimals = (-(self.step * 1.000_001).log10().floor()).clamp(0.0, 4.0) as usize;
        // No minus before a zero.
        let value = if value.abs() < self.step * 1e-6 {
            0.0
        } else {
            value
        };
        format!("{value:.decimals$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(ticks: &Ticks) -> String {
        let labels = ticks.labels().into_iter().map(|(_, words)| words);
        labels.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn round_numbers_around_a_range() {
        for (low, high, most, shown) in [
            (0.03, 9.71, 5, "0 5 10"),
            (0.0, 45.2, 5, "0 20 40 60"),
            (-83.3, -2.0, 4, "-100 -50 0"),
            (-0.13, 0.21, 5, "-0.2 0.0 0.2 0.4"),
            (1234.0, 1236.0, 4, "1234 1235 1236"),
            (0.0, 0.3, 5, "0.0 0.1 0.2 0.3"),
            (0.0, 4.0e6, 5, "0 1.0e6 2.0e6 3.0e6 4.0e6"),
        ] {
            let ticks = Ticks::around(low, high, most);
            assert_eq!(words(&ticks), shown, "{low} to {high}");
            let (from, to) = ticks.bounds();
            assert!(from <= low + 1e-12 && high <= to + 1e-12);
        }
    }

    #[test]
    fn round_numbers_within_a_range() {
        assert_eq!(words(&Ticks::within(0.0, 6.0, 7)), "0 1 2 3 4 5 6");
        assert_eq!(words(&Ticks::within(0.0, 14.9, 4)), "0 5 10");
        assert_eq!(words(&Ticks::within(3.1, 3.9, 5)), "3.2 3.4 3.6 3.8");
    }

    #[test]
    fn strange_ranges_end() {
        for (low, high) in [
            (0.0, 0.0),
            (5.0, 5.0),
            (-1e308, 1e308),
            (1e300, 1e300),
            (0.0, 1e-320),
        ] {
            let ticks = Ticks::around(low, high, 5);
            assert!(ticks.labels().len() <= 5, "{low} to {high}");
        }
    }
}
