//! The risk score 0 to 5 of one obstacle at one step and of a whole scene, by levels of gaps and times to close them.
//!
//! As in "From Words to Collisions": the longitudinal and lateral scores are weighted by the
//! direction, for distance and for time, and the mean of the two is rounded (halves up). Gaps are
//! those of the real bodies, so score 0 means contact, at the step or on the way to it from the step before, and nothing else does, and the distance is graded
//! no worse than the exact distance of the bodies. Between turned bodies that do not touch, both gaps can be 0:
//! then there is nothing to weigh, and the exact distance and the planar time to collision are graded instead.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use super::measure::RISK;
use super::paper::{self, TooLarge};
use super::{Danger, Direction, Encounter, Measure, Reading, Thresholds, measure, plane};
use crate::scenario::Scene;

impl RiskTable {
    fn of_encounter(&self, encounter: &Encounter<'_>) -> u8 {
        let mean = self.mean(encounter, |value, bound| {
            f64::from(self.score(value, bound))
        });
        // Without contact the score is never that of a collision.
        mean.map_or(0, |mean| (mean.round() as u8).max(1))
    }

    /// The score of one aspect of an encounter, 0 to 5: 0 at contact.
    #[must_use]
    pub fn aspect(&self, encounter: &Encounter<'_>, aspect: RiskAspect) -> u8 {
        let grade = |value, bound| f64::from(self.score(value, bound));
        let relation = encounter.relation();
        let long_or_lat = |long: bool| {
            if long {
                (relation.gap_long.abs(), relation.time_long())
            } else {
                (relation.gap_lat.abs(), relation.time_lat())
            }
        };
        let of_time = |time: Option<f64>| grade(time.unwrap_or(NO_CLOSING_TIME), |l| l.time);
        let score = match (aspect, self.parts(encounter, grade)) {
            (RiskAspect::Overall, _) => return self.of_encounter(encounter),
            (_, None) => 0.0,
            (RiskAspect::Distance(None), Some((distance, _))) => distance,
            (RiskAspect::Time(None), Some((_, time))) => time,
            (RiskAspect::Distance(Some(long)), Some(_)) => {
                grade(long_or_lat(long).0, |l| l.distance)
            }
            (RiskAspect::Time(Some(long)), Some(_)) => of_time(long_or_lat(long).1),
        };
        score.round() as u8
    }

    /// The mean of the grades of distance and time, each weighted by the direction; nothing at contact.
    fn mean(&self, encounter: &Encounter<'_>, grade: impl Fn(f64, Bound) -> f64) -> Option<f64> {
        let (distance, time) = self.parts(encounter, grade)?;
        Some(f64::midpoint(distance, time))
    }

    /// These grades.
    fn parts(
        &self,
        encounter: &Encounter<'_>,
        grade: impl Fn(f64, Bound) -> f64,
    ) -> Option<(f64, f64)> {
        let relation = encounter.relation();
        if relation.direction == Direction::Contact || encounter.contact().is_some() {
            return None;
        }
        let of_distance = |gap: f64| grade(gap, |level| level.distance);
        let of_time =
            |time: Option<f64>| grade(time.unwrap_or(NO_CLOSING_TIME), |level| level.time);
        let exact = of_distance(encounter.distance());
        let (distance, time) = if relation.gap_long == 0.0 && relation.gap_lat == 0.0 {
            let time = plane::TIME_TO_COLLISION.compute(encounter).value();
            (exact, of_time(time))
        } else {
            let weight = relation.direction.longitudinal_weight();
            let mix = |long: f64, lat: f64| weight * long + (1.0 - weight) * lat;
            let (long, lat) = (relation.gap_long.abs(), relation.gap_lat.abs());
            // A gap along one axis says nothing where the bodies are far apart along the other, so the
            // weighted grade is never more dangerous than that of the exact distance.
            (
                mix(of_distance(long), of_distance(lat)).max(exact),
                mix(of_time(relation.time_long()), of_time(relation.time_lat())),
            )
        };
        Some((distance, time))
    }

    /// Like [`Self::score`], but it grows evenly between the bounds, where it is between two levels. Less than 1 it
    /// never is: a gap that all but closed does not make up for one that closes slowly.
    fn even(&self, value: f64, bound: Bound) -> f64 {
        let mut from = (0.0, 0.0);
        for level in &self.levels {
            let Some(end) = bound(level) else { break };
            let to = (end, f64::from(level.score) + 0.5);
            if value <= end {
                let part = (value - from.0) / (to.0 - from.0).max(f64::MIN_POSITIVE);
                return (from.1 + part * (to.1 - from.1)).max(1.0);
            }
            from = to;
        }
        5.0
    }
}

/// What a risk score is of; an axis is that along (true) or across the ego's heading alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RiskAspect {
    /// Distance and time.
    Overall,
    /// The distance, or the gap along an axis.
    Distance(Option<bool>),
    /// The times to close the gaps, or that along an axis.
    Time(Option<bool>),
}

/// The time to close a gap that is not closing, seconds.
const NO_CLOSING_TIME: f64 = f64::INFINITY;

/// The risk score before it is rounded, with grades that grow evenly from level to level: of two
/// encounters with the same score it says which is nearer to the next. For searches; not among [`super::MEASURES`].
pub const UNROUNDED_RISK: Measure = Measure::new(
    "risk_unrounded",
    "unrounded risk score",
    "",
    Danger::Low,
    "own",
    |encounter| {
        let table = &encounter.thresholds().risk;
        let mean = table.mean(encounter, |value, bound| table.even(value, bound));
        Reading::Value(mean.unwrap_or(0.0))
    },
);

pub(super) const MEASURE: Measure = Measure::new(
    RISK,
    "risk score",
    "",
    Danger::Low,
    "From Words to Collisions, with real bodies",
    compute,
);

/// The risk score, 0 to 5.
fn compute(encounter: &Encounter<'_>) -> Reading {
    Reading::Value(f64::from(
        encounter.thresholds().risk.of_encounter(encounter),
    ))
}

/// By which numbers and thresholds a risk score is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum RiskConvention {
    /// Real bodies, and the table of the thresholds in use; see [`super::RISK_LEVELS`].
    #[default]
    Exact,
    /// That of the tables published with "From Words to Collisions", of obstacles within 30 m; see [`paper::Risk`].
    Paper,
}

nearmiss_record::named!(RiskConvention);

/// The score of an obstacle at a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ScoreAt {
    /// The time step.
    pub step: i64,
    /// 0 (collision) to 5 (negligible).
    pub score: u8,
    /// The obstacle.
    pub obstacle: i64,
}

impl RiskConvention {
    /// The scores of a scene that are at most `most`, by step, the worst of a step first.
    ///
    /// # Errors
    /// The scene cannot be scored by the paper's convention, whose tables hold no numbers as large as its own.
    pub fn scores_up_to(
        self,
        most: u8,
        scene: &Scene,
        thresholds: &Thresholds,
    ) -> Result<Vec<ScoreAt>, TooLarge> {
        match self {
            Self::Exact => Ok(Self::exact_up_to(most, scene, thresholds)),
            Self::Paper => Ok(up_to(most, of_paper(scene)?)),
        }
    }

    /// The same by [`Self::Exact`], which scores every scene.
    #[must_use]
    pub fn exact_up_to(most: u8, scene: &Scene, thresholds: &Thresholds) -> Vec<ScoreAt> {
        up_to(most, exact(scene, thresholds))
    }
}

fn up_to(most: u8, mut found: Vec<ScoreAt>) -> Vec<ScoreAt> {
    found.retain(|one| one.score <= most);
    found.sort_unstable();
    found
}

fn exact(scene: &Scene, thresholds: &Thresholds) -> Vec<ScoreAt> {
    let Some(risk) = measure(RISK) else {
        return Vec::new();
    };
    let everyone: Vec<_> = scene.participants().collect();
    let of_step = |step: i64| {
        let at = move |other: &_| {
            let encounter = Encounter::at(scene, other, step)?.under(thresholds);
            let score = risk.evaluate(&encounter).value()?;
            Some(ScoreAt {
                step,
                score: score as u8,
                obstacle: other.obstacle.id,
            })
        };
        everyone.iter().filter_map(at).collect::<Vec<_>>()
    };
    scene.steps().flat_map(of_step).collect()
}

fn of_paper(scene: &Scene) -> Result<Vec<ScoreAt>, TooLarge> {
    let rows = paper::rows(scene)?;
    let near = rows.iter().filter(|row| row.distance <= paper::RADIUS);
    let score = |row: &paper::Row| ScoreAt {
        step: row.timestep,
        score: row.risk.risk_score,
        obstacle: row.obstacle,
    };
    Ok(near.map(score).collect())
}

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

#[cfg(test)]
mod tests {
    use super::super::RISK_LEVELS;
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
    fn unrounded_it_grows_evenly_and_rounds_to_the_score() {
        let table = &*RISK_LEVELS;
        let even = |gap| table.even(gap, |level| level.distance);
        for (gap, grade) in [
            (0.0, 1.0),
            (0.25, 1.0),
            (0.375, 1.25),
            (0.5, 1.5),
            (0.75, 2.0),
            (4.0, 4.0),
            (6.0, 5.0),
        ] {
            assert!((even(gap) - grade).abs() < 1e-9, "{gap} m: {}", even(gap));
        }
        let ego = motion(0., 0., 0., 10.);
        let score = |x: f64, measure: &Measure| {
            with(ego, motion(x, 0., 0., 5.), |e| measure.compute(e)).value()
        };
        assert_eq!(score(3., &UNROUNDED_RISK), Some(0.0), "contact");
        let near = score(4.3, &UNROUNDED_RISK);
        assert!(near < score(4.4, &UNROUNDED_RISK), "0.3 m and 0.4 m ahead");
        assert_eq!(score(4.3, &MEASURE), score(4.4, &MEASURE));
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
