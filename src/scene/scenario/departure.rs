//! An obstacle whose motion departs from its recording.

use super::{
    Motion, Obstacle, ObstacleParts, ObstacleRole, Position, Prediction, Quantity, State, Steps,
};

impl Obstacle {
    /// The same obstacle with another motion from the first of `motions` on, time steps in order: that one is the
    /// recorded state it departs from, what was recorded before stays, what was recorded after is gone. Nothing for
    /// obstacles that do not move, or are absent at that step.
    ///
    /// Changed states say position, orientation, velocity and acceleration; what else the recorded ones said (yaw
    /// rates, steering angles, signals) would not be true of them and is left out.
    #[must_use]
    pub fn departing(&self, motions: &[(i64, Motion)], dt: f64) -> Option<Self> {
        let (from, _) = *motions.first()?;
        let initial = self.initial.clone()?;
        if self.role != ObstacleRole::Dynamic || self.track().at(from).is_none() {
            return None;
        }
        let kept = self.states().skip(1).filter(|s| s.time.from <= from);
        let signals = self.signals.iter().filter(|s| s.time.to <= from);
        let new = motions.iter().skip(1).map(|(step, m)| state(*step, m));
        Some(Self::new(
            ObstacleParts {
                id: self.id,
                role: self.role,
                kind: self.kind,
                footprint: self.footprint.clone(),
                initial: Some(initial),
                prediction: Prediction::Trajectory(kept.cloned().chain(new).collect()),
                signals: signals.cloned().collect(),
            },
            dt,
        ))
    }
}

fn state(step: i64, motion: &Motion) -> State {
    State {
        position: Some(Position::Point(motion.pose.position)),
        orientation: Some(Quantity::Exact(motion.pose.heading)),
        velocity: Some(Quantity::Exact(motion.velocity)),
        acceleration: Some(Quantity::Exact(motion.acceleration)),
        ..State::at(Steps::exact(step))
    }
}
