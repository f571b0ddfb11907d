//! A share of some answers, with the interval that a small number of them leaves it.

use super::statistics::wilson;

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// Those that are meant.
    pub hits: u32,
    /// All.
    pub of: u32,
}

impl Share {
    /// Counts one more.
    pub fn count(&mut self, hit: bool) {
        self.hits += u32::from(hit);
        self.of += 1;
    }

    /// From 0 to 1; nothing of nothing.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| f64::from(self.hits) / f64::from(self.of))
    }

    /// The interval of 95 %: see [`wilson`].
    #[must_use]
    pub fn interval(&self) -> Option<(f64, f64)> {
        wilson(self.hits, self.of).map(|interval| (interval.low, interval.high))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn intervals_are_those_worked_out_elsewhere() {
        // The formula in Python, to seven digits.
        let cases = [
            ((8, 10), (0.490_162_5, 0.943_317_8)),
            ((1, 20), (0.008_881_4, 0.236_131_2)),
            ((0, 10), (0.0, 0.277_532_8)),
            ((5, 5), (0.565_517_5, 1.0)),
        ];
        for ((hits, of), (low, high)) in cases {
            let (a, b) = Share { hits, of }.interval().unwrap();
            assert!(
                (a - low).abs() < 1e-6 && (b - high).abs() < 1e-6,
                "{hits}/{of}: {a} {b}"
            );
        }
        assert_eq!(Share::default().interval(), None);
    }
}
