//! The levels of the risk score: gaps and times, as data.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// One level of the table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct RiskLevel {
    /// 0 (collision) to 5 (negligible).
    pub score: u8,
    /// Its name, one word.
    pub name: String,
    /// Its meaning.
    pub meaning: String,
    /// Largest gap with this score, metres; the last level has none.
    pub distance: Option<f64>,
    /// Longest time with this score, seconds; the last level has none.
    pub time: Option<f64>,
}

/// The thresholds, as data.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RiskTable {
    /// The source of the thresholds.
    pub source: String,
    /// From the most to the least dangerous.
    #[serde(rename = "level")]
    pub levels: Vec<RiskLevel>,
}

/// The table that comes with the program.
pub static RISK_LEVELS: LazyLock<RiskTable> = LazyLock::new(|| {
    // A program without its own table could only give wrong scores; a test reads the file.
    toml::from_str(include_str!("thresholds/risk.toml"))
        .expect("the program's own risk table is right")
});

impl RiskTable {
    /// The score of a gap, metres.
    #[must_use]
    pub fn of_distance(&self, gap: f64) -> u8 {
        self.score(gap, |level| level.distance)
    }

    /// The score of a time to close a gap, seconds; without one the least dangerous.
    #[must_use]
    pub fn of_time(&self, time: Option<f64>) -> u8 {
        time.map_or(5, |time| self.score(time, |level| level.time))
    }

    /// The score of a gap or a time; beyond all bounds the least dangerous.
    pub(super) fn score(&self, value: f64, bound: Bound) -> u8 {
        let found = self
            .levels
            .iter()
            .find(|l| bound(l).is_none_or(|b| value <= b));
        found.map_or(5, |l| l.score)
    }

    /// The level with this score.
    #[must_use]
    pub fn level(&self, score: u8) -> Option<&RiskLevel> {
        self.levels.iter().find(|l| l.score == score)
    }
}

/// Which bound of a level.
pub(super) type Bound = fn(&RiskLevel) -> Option<f64>;
