//! The way of one obstacle by distance: its recorded poses, and the lane beyond their end.

use nearmiss_base::geometry::Pose;
use nearmiss_scene::scenario::Track;
use nearmiss_scene::scenario::prediction::Path;

/// A way, by the distance driven on it since the first recorded state.
#[derive(Debug, Clone)]
pub struct Course {
    /// Distances in metres, each larger than the one before, and the poses there.
    places: Vec<(f64, Pose)>,
    /// Time steps and the distance at them, in order.
    steps: Vec<(i64, f64)>,
    /// The way on, from the last pose.
    beyond: Path,
    /// Metres of it.
    more: f64,
}

/// Longer ways are jumps of a damaged recording, metres: such an obstacle follows it.
pub(super) const LONGEST: f64 = 100_000.0;

/// Displacements below this are no way, metres.
const STANDSTILL: f64 = 1e-3;

/// Recorded speeds below this are driving backwards, m/s.
const BACKWARDS: f64 = -0.3;

impl Course {
    /// The recorded way, continued straight; nothing where nothing is recorded, or it is driven backwards.
    #[must_use]
    pub fn recorded(track: &Track) -> Option<Self> {
        if track.iter().any(|(_, motion)| motion.velocity < BACKWARDS) {
            return None;
        }
        let (mut places, mut steps): (Vec<(f64, Pose)>, Vec<_>) = (Vec::new(), Vec::new());
        for (step, motion) in track.iter() {
            match places.last() {
                None => places.push((0.0, motion.pose)),
                Some((s, last)) => {
                    let moved = (motion.pose.position - last.position).norm();
                    if moved > STANDSTILL {
                        places.push((s + moved, motion.pose));
                    }
                }
            }
            steps.push((step, places.last()?.0));
        }
        let (length, last) = *places.last()?;
        if length > LONGEST {
            return None;
        }
        Some(Self {
            places,
            steps,
            beyond: Path::Straight(last),
            more: 0.0,
        })
    }

    /// The same, with `path` from its last pose for `length` metres.
    #[must_use]
    pub fn continued(self, path: Path, length: f64) -> Self {
        Self {
            beyond: path,
            more: length.max(0.0),
            ..self
        }
    }

    /// Metres of it that were recorded.
    #[must_use]
    pub fn recorded_length(&self) -> f64 {
        self.places.last().map_or(0.0, |(s, _)| *s)
    }

    /// Metres of it.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.recorded_length() + self.more
    }

    /// The last recorded pose.
    #[must_use]
    pub fn last(&self) -> Option<&Pose> {
        self.places.last().map(|(_, pose)| pose)
    }

    /// The distance at a recorded step.
    #[must_use]
    pub fn at_step(&self, step: i64) -> Option<f64> {
        let found = self.steps.binary_search_by_key(&step, |(at, _)| *at).ok()?;
        Some(self.steps[found].1)
    }

    /// The recorded steps and the distances at them.
    #[must_use]
    pub fn steps(&self) -> &[(i64, f64)] {
        &self.steps
    }

    /// The pose at distance `s` (m); before the beginning the first one.
    #[must_use]
    pub fn pose_at(&self, s: f64) -> Pose {
        let next = self.places.partition_point(|(at, _)| *at < s);
        match (
            next.checked_sub(1).map(|i| self.places[i]),
            self.places.get(next),
        ) {
            (Some((from, a)), Some((to, b))) => a.towards(b, (s - from) / (to - from)),
            (Some((end, _)), None) => self.beyond.pose_at(s - end),
            (None, _) => self.places[0].1,
        }
    }
}
