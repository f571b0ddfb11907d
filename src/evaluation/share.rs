//! A share of some answers, with the interval that a small number of them leaves it.

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// Those that are meant.
    pub hits: u32,
    /// All.
    pub of: u32,
}

/// Standard errors to either side that hold 95 % of a normal distribution.
const Z: f64 = 1.959_963_984_540_054;

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

    /// The interval of 95 % by Wilson, *Probable inference, the law of succession, and statistical inference*, Journal of
    /// the American Statistical Association 22 (1927): (p + z²/2n ± z √(p(1 − p)/n + z²/4n²)) / (1 + z²/n).
    #[must_use]
    pub fn interval(&self) -> Option<(f64, f64)> {
        let (n, p) = (f64::from(self.of), self.value()?);
        let shrink = 1.0 + Z * Z / n;
        let centre = (p + Z * Z / (2.0 * n)) / shrink;
        let half = Z / shrink * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        // At its ends it ends there exactly; rounding would miss that by a hair.
        let low = if self.hits == 0 { 0.0 } else { centre - half };
        let high = if self.hits == self.of {
            1.0
        } else {
            centre + half
        };
        Some((low, high))
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
