//! The risk score 0 to 5 of one obstacle at one step, from gaps and times to close them.
//!
//! As in "From Words to Collisions": the longitudinal and lateral scores are weighted by the
//! direction, for distance and for time, and the mean of the two is rounded (halves up). Gaps are
//! those of the real bodies, so score 0 means contact and nothing else does, and the distance is graded
//! no worse than the exact distance of the bodies. Between turned bodies that do not touch, both gaps can be 0:
//! then there is nothing to weigh, and the exact distance and the planar time to collision are graded instead.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::{
    Danger, Direction, Encounter, Measure, Mirrored, Reading, Relation, time_to_collision,
};

/// One level of the table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct RiskLevel {
    /// 0 (collision) to 5 (negligible).
    pub score: u8,
    /// One word for it.
    pub name: String,
    /// What it means.
    pub meaning: String,
    /// Largest gap with this score, metres; the last level has none.
    pub distance: Option<f64>,
    /// Longest time with this score, seconds; the last level has none.
    pub time: Option<f64>,
}

/// The thresholds, as data.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RiskTable {
    /// Where the thresholds come from.
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

    fn score(&self, value: f64, bound: fn(&RiskLevel) -> Option<f64>) -> u8 {
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

    fn of(&self, encounter: &Encounter<'_>) -> u8 {
        let relation = encounter.relation();
        if relation.direction == Direction::Contact {
            return 0;
        }
        let exact = f64::from(self.of_distance(encounter.distance()));
        let (distance, time) = if relation.gap_long == 0.0 && relation.gap_lat == 0.0 {
            let time = (time_to_collision::MEASURE.compute)(encounter).value();
            (exact, f64::from(self.of_time(time)))
        } else {
            self.along_axes(&relation, exact)
        };
        // Without contact the score is never that of a collision.
        ((f64::midpoint(distance, time)).round() as u8).max(1)
    }

    /// The grades of distance and time, weighted by the direction.
    fn along_axes(&self, relation: &Relation, exact_distance: f64) -> (f64, f64) {
        let weight = relation.direction.longitudinal_weight();
        let mix = |long: u8, lat: u8| weight * f64::from(long) + (1.0 - weight) * f64::from(lat);
        // A gap along one axis says nothing where the bodies are far apart along the other, so the
        // weighted grade is never more dangerous than that of the exact distance.
        let distance = mix(
            self.of_distance(relation.gap_long.abs()),
            self.of_distance(relation.gap_lat.abs()),
        )
        .max(exact_distance);
        let time = mix(
            self.of_time(relation.time_long()),
            self.of_time(relation.time_lat()),
        );
        (distance, time)
    }
}

pub(super) const MEASURE: Measure = Measure {
    id: "risk",
    name: "risk score",
    unit: "",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    source: "From Words to Collisions, with real bodies",
    compute,
};

/// The risk score, 0 to 5.
fn compute(encounter: &Encounter<'_>) -> Reading {
    Reading::Value(f64::from(encounter.thresholds().risk.of(encounter)))
}

#[cfg(test)]
mod tests {
    use super::super::relation::tests::{motion, with};
    use super::*;

    #[test]
    fn the_table_is_whole() {
        let scores: Vec<u8> = RISK_LEVELS.levels.iter().map(|l| l.score).collect();
        assert_eq!(scores, [0, 1, 2, 3, 4, 5]);
        assert_eq!(RISK_LEVELS.of_distance(0.5), 1);
        assert_eq!(RISK_LEVELS.of_distance(0.51), 2);
        assert_eq!(RISK_LEVELS.of_time(None), 5);
    }

    #[test]
    fn from_contact_to_nothing() {
        let ego = motion(0., 0., 0., 10.);
        let score = |x, y, v| with(ego, motion(x, y, 0., v), compute).value();
        assert_eq!(score(3., 0., 10.), Some(0.0), "contact");
        // 0.4 m ahead and closing within 0.08 s.
        assert_eq!(score(4.4, 0., 5.), Some(1.0));
        // 0.4 m beside, not closing: distance 1, time 5.
        assert_eq!(score(0., 2.4, 10.), Some(3.0));
        assert_eq!(score(60., 0., 10.), Some(5.0));
    }

    #[test]
    fn turned_bodies_that_nearly_touch_are_graded_by_what_is_exact() {
        // The side of a car turned by 45° lies this far before the ego's front left corner, at (2, 1).
        let scores = |apart: f64, speed: f64| {
            let centre = (1.0 + apart) * std::f64::consts::FRAC_1_SQRT_2;
            let other = motion(2.0 + centre, 1.0 + centre, -std::f64::consts::FRAC_PI_4, 0.);
            with(motion(0., 0., 0., speed), other, |e| {
                let relation = e.relation();
                assert_eq!((relation.gap_long, relation.gap_lat), (0.0, 0.0));
                assert!((e.distance() - apart).abs() < 1e-6);
                compute(e).value()
            })
        };
        assert_eq!(scores(0.005, 1.0), Some(1.0), "5 mm in 7 ms");
        assert_eq!(scores(0.005, 0.0), Some(3.0), "5 mm, and it stays so");
        // 0.7 m: grade 2; 0.99 s at 0.707 m/s: grade 2.
        assert_eq!(scores(0.7, 1.0), Some(2.0));
    }
}
