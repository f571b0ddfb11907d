//! Obstacles, plans and the ego after a change of the plane.

use super::plane::Plane;
use crate::scenario::{
    Ego, Goal, Motion, Obstacle, ObstacleParts, Occupancy, PlanningProblem, Prediction, Quantity,
    Sample, Signal, SignalState, State, Track,
};

impl Plane {
    pub(super) fn obstacle(&self, obstacle: &Obstacle, dt: f64) -> Obstacle {
        let prediction = match &obstacle.prediction {
            Prediction::None => Prediction::None,
            Prediction::Trajectory(states) => {
                Prediction::Trajectory(states.iter().map(|s| self.state(s)).collect())
            }
            Prediction::Occupancies(all) => {
                let placed = |one: &Occupancy| Occupancy {
                    time: one.time,
                    region: self.region(&one.region),
                };
                Prediction::Occupancies(all.iter().map(placed).collect())
            }
        };
        let mut initial = obstacle.initial.as_ref().map(|s| self.state(s));
        if let Some(state) = &mut initial
            && self.angle != 0.0
            && points_nowhere(obstacle)
        {
            // It was drawn along the x axis for want of a heading, and turns with the rest.
            state.orientation = Some(Quantity::Exact(self.heading(0.0)));
        }
        let footprint = obstacle.footprint.as_ref();
        let parts = ObstacleParts {
            id: obstacle.id,
            role: obstacle.role,
            kind: obstacle.kind,
            // Without a state the shape says where in the world it is.
            footprint: match obstacle.initial {
                Some(_) => footprint.map(|f| self.footprint(f)),
                None => footprint.map(|f| self.standing(f)),
            },
            initial,
            prediction,
            signals: obstacle.signals.iter().map(|s| self.signals(s)).collect(),
        };
        Obstacle::new(parts, dt)
    }

    fn signals(&self, state: &SignalState) -> SignalState {
        let mut placed = state.clone();
        if self.mirrored {
            for (signal, _) in &mut placed.signals {
                *signal = match *signal {
                    Signal::IndicatorLeft => Signal::IndicatorRight,
                    Signal::IndicatorRight => Signal::IndicatorLeft,
                    other => other,
                };
            }
        }
        placed
    }

    pub(super) fn problem(&self, problem: &PlanningProblem) -> PlanningProblem {
        let goal = |goal: &Goal| Goal {
            time: goal.time,
            positions: goal.positions.iter().map(|p| self.position(p)).collect(),
            orientation: goal.orientation.map(|q| self.heading_of(q)),
            velocity: goal.velocity,
        };
        PlanningProblem {
            id: problem.id,
            initial: self.state(&problem.initial),
            goals: problem.goals.iter().map(goal).collect(),
        }
    }

    pub(super) fn ego(&self, ego: &Ego, dt: f64) -> Ego {
        let moved = |(step, motion): (i64, &Motion)| Sample {
            step,
            position: self.point(&motion.pose.position),
            heading: Some(self.heading(motion.pose.heading)),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        };
        let mut track = Track::new(ego.track.iter().map(moved).collect(), dt, None);
        // What was filled was filled before.
        track.derived = ego.track.derived;
        let recorded = |sample: &Sample| Sample {
            position: self.point(&sample.position),
            heading: sample.heading.map(|h| self.heading(h)),
            ..*sample
        };
        Ego {
            footprint: self.footprint(&ego.footprint),
            track,
            recorded: ego.recorded.iter().map(recorded).collect(),
            ..ego.clone()
        }
    }
}

/// Whether nothing says which way an obstacle points, not even its motion.
fn points_nowhere(obstacle: &Obstacle) -> bool {
    let says = |s: &State| s.orientation.is_some() || s.point_mass_velocity().is_some();
    !obstacle.states().any(says) && obstacle.track().iter().all(|(_, m)| m.pose.heading == 0.0)
}
