//! The convention of the paper's published tables and risk scores, defects and all; never the default.
//!
//! *From Words to Collisions* (Gao et al.) published its measures as `relative_metrics.csv`, those within 30 m as
//! `close_relative_metrics.csv`, and risk scores of one example as `risk_scores_*.csv`. This module computes the
//! same numbers from the same scenarios, so that results can be held against the published ones. It keeps what
//! the published tables do, which the measures of [`crate::metrics`] do not:
//!
//! - every participant, the ego too, is 4.508 m long and 1.610 m wide, and its box is never turned: centres that are
//!   less than one length apart along the ego's heading overlap along it, and the same across it with the width;
//! - the ego's heading, velocity and acceleration are those written in its recording, where the heading is 0 at
//!   standstill
//!   and velocity and acceleration are one step ahead of the position;
//! - accelerations are compared along the axes of the map, not of the ego;
//! - who overlaps along an axis has a time of 0 along it, whether it comes closer or not;
//! - the risk score takes its thresholds from the published code, which are not those of the published prompt, grades
//!   the
//!   rounded numbers, truncates instead of rounding, and gives `Behind` the weight of a diagonal.
//!
//! There is a row for every state of the trajectory of a dynamic obstacle at whose time step the ego has a row. The
//! initial states, which lie before the trajectories, have none, and static obstacles and those without a trajectory
//! have none.

mod relation;

pub use relation::{Across, Along, Direction, LENGTH, Relation, WIDTH};

use std::collections::{HashMap, HashSet};

use nearmiss_base::geometry::Pose;

use crate::scenario::{
    EgoSource, Motion, Obstacle, ObstacleRole, Prediction, Sample, Scene, State,
};

/// Obstacles whose centre is farther than this from the ego's, metres, are in no `close_relative_metrics.csv`.
pub const RADIUS: f64 = 30.0;

/// One obstacle at one time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time step.
    pub timestep: i64,
    /// Id of the obstacle.
    pub obstacle: i64,
    /// From centre to centre, metres; not rounded.
    pub distance: f64,
    /// Its position and motion, rounded to two decimals.
    pub relation: Relation,
    /// The score of the rounded numbers.
    pub risk: Risk,
}

/// States so far apart or so fast that their difference is beyond all numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "obstacle {obstacle} at step {timestep}: position, velocity or acceleration too large to compare with the ego's"
)]
pub struct TooLarge {
    /// Which obstacle.
    pub obstacle: i64,
    /// When.
    pub timestep: i64,
}

/// The rows of a scene in the published order: by time step, then by id.
///
/// The ego's row of a time step is taken as it was recorded ([`crate::scenario::Ego::recorded`]), and so are the
/// states of the obstacles. What a recording or a state does not say (the published ones say everything) is that of
/// the filled [`crate::scenario::Track`], and so is everything about an ego that is an obstacle of the scenario.
///
/// # Errors
/// [`TooLarge`], where a row would hold no finite number.
pub fn rows(scene: &Scene) -> Result<Vec<Row>, TooLarge> {
    let recorded: HashMap<i64, &Sample> = scene.ego.recorded.iter().map(|s| (s.step, s)).collect();
    let taken = match scene.ego.source {
        EgoSource::Obstacle(id) => Some(id),
        _ => None,
    };
    let mut rows = Vec::new();
    for obstacle in &scene.scenario.obstacles {
        let (ObstacleRole::Dynamic, Prediction::Trajectory(states)) =
            (obstacle.role, &obstacle.prediction)
        else {
            continue;
        };
        if Some(obstacle.id) == taken {
            continue;
        }
        let mut seen = HashSet::new();
        for state in states {
            let timestep = state.time.from;
            let filled = scene.ego.track.at(timestep);
            let ego = filled.map(|f| as_recorded(f, recorded.get(&timestep).copied()));
            let Some((ego, other)) = ego.zip(as_said(obstacle, state)) else {
                continue;
            };
            // A time step that is there twice counts once, as everywhere.
            if !seen.insert(timestep) {
                continue;
            }
            let unknown = TooLarge {
                obstacle: obstacle.id,
                timestep,
            };
            let relation = Relation::new(&ego, &other).ok_or(unknown)?.rounded();
            let apart = other.pose.position - ego.pose.position;
            let distance = apart.x.hypot(apart.y);
            if !distance.is_finite() {
                return Err(unknown);
            }
            rows.push(Row {
                timestep,
                obstacle: obstacle.id,
                distance,
                relation,
                risk: Risk::score(&relation),
            });
        }
    }
    rows.sort_by_key(|row| (row.timestep, row.obstacle));
    Ok(rows)
}

/// A filled motion with everything replaced that the recording says.
fn as_recorded(filled: &Motion, sample: Option<&Sample>) -> Motion {
    let Some(sample) = sample else {
        return *filled;
    };
    Motion {
        pose: Pose {
            position: sample.position,
            heading: sample.heading.unwrap_or(filled.pose.heading),
        },
        velocity: sample.velocity.unwrap_or(filled.velocity),
        acceleration: sample.acceleration.unwrap_or(filled.acceleration),
    }
}

/// The motion that a state says; `None` if it has no position.
fn as_said(obstacle: &Obstacle, state: &State) -> Option<Motion> {
    let filled = *obstacle.track().at(state.time.from)?;
    let position = state.point()?;
    // A point mass has its velocity in two parts, which the track has put together.
    if state.point_mass_velocity().is_some() {
        return Some(filled);
    }
    let sample = Sample {
        step: state.time.from,
        position,
        heading: state.orientation.map(|q| q.middle()),
        velocity: state.velocity.map(|q| q.middle()),
        acceleration: state.acceleration.map(|q| q.middle()),
    };
    Some(as_recorded(&filled, Some(&sample)))
}

/// Largest gaps below which the scores 0, 1, … are given, metres: those of the published code, not of its prompt.
const DISTANCES: [f64; 5] = [0.3, 0.8, 1.3, 3.0, 5.0];

/// The same for times, seconds; the first is excluded, the others are included.
const TIMES: [f64; 5] = [0.15, 0.65, 1.15, 3.0, 5.0];

/// The grades of one obstacle at one step, and what becomes of them. The fields are named like the published columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Risk {
    /// Weight of the longitudinal grades, 0 to 1; the lateral ones have the rest.
    pub wdominant: f64,
    /// Grade of the longitudinal gap.
    pub long_dsc: u8,
    /// Grade of the lateral gap.
    pub lat_dsc: u8,
    /// Weighted grade of the gaps.
    pub dsc: f64,
    /// Grade of the longitudinal time.
    pub long_tsc: u8,
    /// Grade of the lateral time.
    pub lat_tsc: u8,
    /// Weighted grade of the times.
    pub tsc: f64,
    /// Half the sum of both, without its fraction.
    pub risk_score: u8,
}

impl Risk {
    /// The score of a relation; the published ones are those of rounded relations.
    #[must_use]
    pub fn score(relation: &Relation) -> Self {
        let wdominant = relation.direction.longitudinal_weight();
        let weighted =
            |long: u8, lat: u8| wdominant * f64::from(long) + (1.0 - wdominant) * f64::from(lat);
        let long_dsc = of_distance(relation.adjusted_d_long);
        let lat_dsc = of_distance(relation.adjusted_d_lat);
        let long_tsc = of_time(relation.ttc_long);
        let lat_tsc = of_time(relation.ttc_lat);
        let dsc = weighted(long_dsc, lat_dsc);
        let tsc = weighted(long_tsc, lat_tsc);
        Self {
            wdominant,
            long_dsc,
            lat_dsc,
            dsc,
            long_tsc,
            lat_tsc,
            tsc,
            risk_score: f64::midpoint(dsc, tsc) as u8,
        }
    }
}

fn of_distance(gap: f64) -> u8 {
    DISTANCES.iter().filter(|d| gap.abs() >= **d).count() as u8
}

fn of_time(time: Option<f64>) -> u8 {
    let Some(time) = time else { return 5 };
    let [first, others @ ..] = TIMES;
    u8::from(time >= first) + others.iter().filter(|t| time > **t).count() as u8
}

/// The relative motion along the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AlongMotion {
    /// It overlaps the ego along this axis; its motion is not looked at.
    Beside,
    /// From ahead, it comes closer.
    ClosingAhead,
    /// From behind, it comes closer.
    ClosingBehind,
    /// It falls back or drives off.
    Receding,
    /// The distance stays exactly the same.
    Steady,
}

/// The relative motion across the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AcrossMotion {
    /// It overlaps the ego across its heading; its motion is not looked at.
    Aligned,
    /// It comes closer from the left.
    ClosingLeft,
    /// It comes closer from the right.
    ClosingRight,
    /// It moves off to the left.
    RecedingLeft,
    /// It moves off to the right.
    RecedingRight,
    /// The distance stays exactly the same.
    Steady,
}

impl AlongMotion {
    fn classify(along: Along, v_rel: f64) -> Self {
        let closing = match along {
            Along::Beside => return Self::Beside,
            Along::Front => (v_rel < 0.0).then_some(Self::ClosingAhead),
            Along::Behind => (v_rel > 0.0).then_some(Self::ClosingBehind),
        };
        let otherwise = if v_rel == 0.0 {
            Self::Steady
        } else {
            Self::Receding
        };
        closing.unwrap_or(otherwise)
    }

    /// In a few words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Beside => "alongside",
            Self::ClosingAhead => "closing in ahead",
            Self::ClosingBehind => "closing in behind",
            Self::Receding => "getting farther",
            Self::Steady => "steady",
        }
    }
}

impl AcrossMotion {
    fn classify(across: Across, v_rel: f64) -> Self {
        let steady = v_rel == 0.0;
        match (across, v_rel < 0.0) {
            (Across::Aligned, _) => Self::Aligned,
            _ if steady => Self::Steady,
            (Across::Left, true) => Self::ClosingLeft,
            (Across::Left, false) => Self::RecedingLeft,
            (Across::Right, true) => Self::RecedingRight,
            (Across::Right, false) => Self::ClosingRight,
        }
    }

    /// In a few words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Aligned => "in line",
            Self::ClosingLeft => "closing in from the left",
            Self::ClosingRight => "closing in from the right",
            Self::RecedingLeft => "getting farther left",
            Self::RecedingRight => "getting farther right",
            Self::Steady => "steady",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{AcrossMotion, AlongMotion, Direction, *};

    #[test]
    fn a_gap_at_a_threshold_is_above_it() {
        let grades = |values: [f64; 6]| values.map(of_distance);
        assert_eq!(
            grades([0.0, 0.3, 0.8, 1.3, 3.0, 5.0]),
            [0, 1, 2, 3, 4, 5],
            "at the thresholds"
        );
        assert_eq!(
            grades([-0.29, -0.79, -1.29, -2.99, -4.99, -500.0]),
            [0, 1, 2, 3, 4, 5],
            "below them, on the other side"
        );
    }

    #[test]
    fn a_time_at_a_threshold_is_below_it_but_for_the_first() {
        let grades = |values: [f64; 6]| values.map(|t| of_time(Some(t)));
        assert_eq!(
            grades([0.14, 0.15, 1.15, 3.0, 5.0, 5.01]),
            [0, 1, 2, 3, 4, 5]
        );
        assert_eq!(of_time(Some(0.65)), 1);
        assert_eq!(of_time(Some(0.66)), 2);
        assert_eq!(of_time(None), 5);
    }

    fn relation(d_long: f64, d_lat: f64, adjusted: [f64; 2], ttc: [Option<f64>; 2]) -> Relation {
        let direction = Direction::from_offsets(d_long, d_lat);
        Relation {
            direction,
            d_long,
            d_lat,
            adjusted_d_long: adjusted[0],
            adjusted_d_lat: adjusted[1],
            v_rel_long: 0.0,
            v_rel_lat: 0.0,
            a_rel_long: 0.0,
            a_rel_lat: 0.0,
            ttc_long: ttc[0],
            ttc_lat: ttc[1],
            motion_long: AlongMotion::classify(direction.along, 0.0),
            motion_lat: AcrossMotion::classify(direction.across, 0.0),
        }
    }

    #[test]
    fn the_weight_follows_the_direction_and_fractions_are_cut() {
        // Diagonal: (5 + 0) / 2 = 2.5 and (5 + 1) / 2 = 3, so 2.75.
        let risk = Risk::score(&relation(-12.11, 1.84, [-7.6, 0.23], [None, Some(0.18)]));
        assert_eq!((risk.wdominant, risk.dsc, risk.tsc), (0.5, 2.5, 3.0));
        assert_eq!(risk.risk_score, 2);
        let ahead = Risk::score(&relation(5.0, 0.0, [0.49, 0.0], [Some(0.5), Some(0.0)]));
        assert_eq!((ahead.wdominant, ahead.dsc, ahead.tsc), (1.0, 1.0, 1.0));
        assert_eq!(ahead.risk_score, 1);
        // The same behind is taken for a diagonal.
        let behind = Risk::score(&relation(-5.0, 0.0, [-0.49, 0.0], [Some(0.5), Some(0.0)]));
        assert_eq!((behind.wdominant, behind.dsc, behind.tsc), (0.5, 0.5, 0.5));
        assert_eq!(behind.risk_score, 0);
        let beside = Risk::score(&relation(1.0, 4.0, [0.0, 2.39], [Some(0.0), None]));
        assert_eq!((beside.wdominant, beside.dsc, beside.tsc), (0.0, 3.0, 5.0));
        assert_eq!(beside.risk_score, 4);
        let inside = Risk::score(&relation(1.0, 1.0, [0.0, 0.0], [Some(0.0), Some(0.0)]));
        assert_eq!((inside.wdominant, inside.risk_score), (0.5, 0));
    }

    #[test]
    fn closing_depends_on_the_side() {
        let along = |side, v| AlongMotion::classify(side, v);
        assert_eq!(along(Along::Front, -1.0), AlongMotion::ClosingAhead);
        assert_eq!(along(Along::Front, 1.0), AlongMotion::Receding);
        assert_eq!(along(Along::Behind, 1.0), AlongMotion::ClosingBehind);
        assert_eq!(along(Along::Behind, -1.0), AlongMotion::Receding);
        let across = |side, v| AcrossMotion::classify(side, v);
        assert_eq!(across(Across::Left, -1.0), AcrossMotion::ClosingLeft);
        assert_eq!(across(Across::Left, 1.0), AcrossMotion::RecedingLeft);
        assert_eq!(across(Across::Right, 1.0), AcrossMotion::ClosingRight);
        assert_eq!(across(Across::Right, -1.0), AcrossMotion::RecedingRight);
    }

    #[test]
    fn no_motion_is_steady_and_overlap_hides_it() {
        for zero in [0.0, -0.0] {
            assert_eq!(
                AlongMotion::classify(Along::Front, zero),
                AlongMotion::Steady
            );
            assert_eq!(
                AlongMotion::classify(Along::Behind, zero),
                AlongMotion::Steady
            );
            assert_eq!(
                AcrossMotion::classify(Across::Left, zero),
                AcrossMotion::Steady
            );
            assert_eq!(
                AcrossMotion::classify(Across::Right, zero),
                AcrossMotion::Steady
            );
        }
        for v in [-1.0, 0.0, 1.0] {
            assert_eq!(AlongMotion::classify(Along::Beside, v), AlongMotion::Beside);
            assert_eq!(
                AcrossMotion::classify(Across::Aligned, v),
                AcrossMotion::Aligned
            );
        }
    }
}
