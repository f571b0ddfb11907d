//! Context of an attack: the ego's motion in the scenario, and the paths open to other participants.

use std::sync::Arc;

use super::{Attack, AttackStyle, RecordedMotions, StagedDrive};
use nearmiss_base::geometry::{Footprint, Point, Polyline, Pose};
use nearmiss_scene::scenario::prediction::{Model, ObservedHistory, Predictor};
use nearmiss_scene::scenario::{Motion, Obstacle, Scenario, Track};

/// The scenario with the ego's motion in it.
#[derive(Debug)]
pub struct AttackContext<'a> {
    /// The original scenario, or one with an attack by others in it.
    pub scenario: &'a Scenario,
    /// The ego's body.
    pub footprint: &'a Footprint,
    /// The ego's motion while no further obstacle attacks it.
    pub ego: &'a Track,
    /// The way of the ego's centre, straight on beyond its ends.
    pub line: Polyline,
    /// First and last step of the ego.
    pub steps: std::ops::RangeInclusive<i64>,
    /// The attack by others that goes on in the scenario, if there is one, and the ego's drive against it.
    pub others: Option<(&'a Attack, &'a StagedDrive)>,
    /// How attackers move.
    pub style: AttackStyle,
    /// Recorded motions that attacks are to be like; `None` where that does not matter.
    pub recorded: Option<Arc<RecordedMotions>>,
}

/// Points of a way are at least this far apart, metres: an obstacle that stands has no direction.
const SPACING: f64 = 0.3;

/// The ego's way goes on straight for so long, metres.
const BEYOND: f64 = 60.0;

/// How far ahead lanes are followed for ways, seconds at [`LEAST_SPEED`] or more.
const AHEAD: f64 = 12.0;

/// An obstacle that stands may take the ways of one that drives so fast, m/s.
const LEAST_SPEED: f64 = 8.0;

/// Ways are followed no farther than this, metres: no vehicle drives so far within a scenario's seconds.
pub(super) const FARTHEST: f64 = 5000.0;

/// Seconds that are looked at to tell which lane an obstacle follows.
const MEMORY: f64 = 1.0;

impl<'a> AttackContext<'a> {
    /// The stage with the ego's motion; `None` if the ego never moves. Attackers have all of their capability.
    #[must_use]
    pub fn new(scenario: &'a Scenario, footprint: &'a Footprint, ego: &'a Track) -> Option<Self> {
        let range = ego.steps();
        let places = ego.iter().map(|(_, m)| m.pose.position);
        let mut points = thinned(places);
        let (_, last) = ego.iter().last()?;
        points.push(last.pose.position + last.pose.forward() * BEYOND);
        Some(Self {
            scenario,
            footprint,
            ego,
            line: Polyline::new(points)?,
            steps: range.start..=range.end - 1,
            others: None,
            style: AttackStyle::Limit,
            recorded: None,
        })
    }

    /// The same for attackers of a style.
    #[must_use]
    pub fn of_style(self, style: AttackStyle) -> Self {
        Self { style, ..self }
    }

    /// Seconds between two steps.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.scenario.dt()
    }

    /// The step that is `seconds` after step 0, the nearest one.
    #[must_use]
    pub fn step_at(&self, seconds: f64) -> i64 {
        (seconds / self.dt()).round() as i64
    }

    /// The ego's motion at a step; beyond its ends as at the end.
    #[must_use]
    pub fn ego_at(&self, step: i64) -> Option<&Motion> {
        self.ego
            .at(step.clamp(*self.steps.start(), *self.steps.end()))
    }

    /// The ways that an obstacle may take from `step` on, the recorded one first: lines that begin where its centre is.
    ///
    /// The recorded way goes on along the lanes where the recording ends; the others follow the lanes.
    #[must_use]
    pub fn ways(&self, obstacle: &Obstacle, step: i64) -> Vec<Polyline> {
        let Some(end) = obstacle.track().steps().last() else {
            return Vec::new();
        };
        let driven = obstacle.track().iter().filter(|(s, _)| *s >= step);
        let mut recorded = thinned(driven.map(|(_, m)| m.pose.position));
        let on = self.lanes(obstacle, end);
        if let (Some(first), Some(from)) = (on.first(), recorded.last().copied()) {
            recorded.extend(thinned(first.iter().copied()).into_iter().filter(|p| {
                // The point beside the last one is not part of the remaining path.
                (p - from).norm() > SPACING
            }));
        }
        let mut ways: Vec<Polyline> = Polyline::new(recorded).into_iter().collect();
        let others = self.lanes(obstacle, step).into_iter();
        ways.extend(others.filter_map(|points| Polyline::new(thinned(points.into_iter()))));
        ways
    }

    /// The ways along lanes from where an obstacle is at a step, likeliest first.
    fn lanes(&self, obstacle: &Obstacle, step: i64) -> Vec<Vec<Point>> {
        let memory = (MEMORY / self.dt()).round() as i64;
        let past = ObservedHistory::of_traffic(self.scenario, step - memory..=step, None);
        let Some(seen) = past.others().iter().find(|o| o.who.id == obstacle.id) else {
            return Vec::new();
        };
        let mut courses = Predictor::new(&past, Model::AlongLanes)
            .predict(seen, AHEAD)
            .courses;
        courses.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let reach = (AHEAD * seen.motion.velocity).clamp(AHEAD * LEAST_SPEED, FARTHEST);
        let along = |pose: &dyn Fn(f64) -> Pose| -> Vec<Point> {
            let pieces = (reach / 1.0) as usize;
            (0..=pieces).map(|s| pose(s as f64).position).collect()
        };
        courses
            .iter()
            .map(|c| along(&|s| c.path.pose_at(s)))
            .collect()
    }
}

/// Points without those that are too near to the one before.
fn thinned(points: impl Iterator<Item = Point>) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for p in points {
        if kept.last().is_none_or(|last| (p - last).norm() >= SPACING) {
            kept.push(p);
        }
    }
    kept
}
