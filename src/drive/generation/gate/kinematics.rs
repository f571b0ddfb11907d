//! The single-track check, and whether a violation is the recording's or the change's.

use super::run::{Findings, Flow, Run};
use crate::planner::{Bound, Feasibility, Tolerance};
use nearmiss_scene::scenario::{Sample, Track};

impl Run<'_> {
    /// A single-track vehicle of its kind can drive it.
    ///
    /// Steering angles are estimated from the changed motion alone: the steering rate of its first step is asked at
    /// the joint.
    pub fn kinematics(&self, found: &mut Findings) -> Flow {
        let dt = self.dt();
        let samples = self.motions.iter().map(|(step, motion)| Sample {
            step: *step,
            position: motion.pose.position,
            heading: Some(motion.pose.heading),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        });
        let track = Track::new(samples.collect(), dt, None);
        let tolerance = Tolerance {
            rounding: self.gate.rounding,
            ..Tolerance::default()
        };
        let check = Feasibility::new(self.can.limits, dt).within(tolerance);
        let Err(error) = check.track(&track) else {
            return Flow::Continue(());
        };
        for broken in error.0 {
            let place = self.motions.iter().position(|(s, _)| *s == broken.step);
            let exempt = place.is_some_and(|place| match broken.bound {
                Bound::Speed | Bound::Backwards => self.is_kept(place),
                // It says how the wheels were turned since the step before.
                Bound::SteeringRate => {
                    self.is_exempt(place) && (place == 0 || self.is_exempt(place - 1))
                }
                _ => self.is_exempt(place),
            });
            // Gaps have been reported.
            if broken.bound != Bound::Gap {
                found.say(exempt, broken.into())?;
            }
        }
        Flow::Continue(())
    }
}
