//! Open-loop screening: how near a changed motion comes to an ego that keeps to its path and brakes when it must.
//!
//! Screening only selects attacks for the closed loop; no reported figure comes from it.

use super::{AttackContext, Change};
use nearmiss_base::geometry::{Footprint, Placed, Pose};
use nearmiss_scene::scenario::{Motion, Obstacle};

/// How a change looks beside an ego that only brakes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenLoopScreening {
    /// The smallest distance between the bodies while both are there, metres.
    pub distance: f64,
    /// The step of it: of contact, the first.
    pub step: i64,
    /// Seconds from the first changed state to that step.
    pub lead: f64,
    /// The ego's speed there, m/s.
    pub speed: f64,
    /// Whether the attacker is behind the ego there.
    pub behind: bool,
}

/// The ego looks ahead so far, seconds, in this many looks.
const AHEAD: f64 = 2.4;
const LOOKS: usize = 8;

/// It brakes when the two would come nearer than this, metres.
const NEAR: f64 = 0.3;

/// How hard it brakes, and how it gets up to its old speed again, m/s².
const BRAKING: f64 = 9.0;
const RESUMING: f64 = 2.5;

/// A good driver needs so long to get away, seconds.
const CHANCE: f64 = 1.3;

/// An attack that takes longer than this is seen through, seconds.
const SEEN_THROUGH: f64 = 3.0;

/// Below this speed a contact is harmless, m/s.
const CRAWLING: f64 = 2.0;

/// The ego on its way.
struct Braking<'s> {
    stage: &'s AttackContext<'s>,
    s: f64,
    speed: f64,
}

impl OpenLoopScreening {
    /// Looks at a change; nothing where the two are never there together.
    #[must_use]
    pub fn evaluate(
        stage: &AttackContext<'_>,
        obstacle: &Obstacle,
        change: &Change,
    ) -> Option<Self> {
        let body = obstacle.footprint.as_ref()?;
        let from = change.from()?.max(*stage.steps.start());
        let first = stage.ego.at(from)?;
        let mut ego = Braking {
            stage,
            s: stage.line.project(&first.pose.position).s,
            speed: first.velocity,
        };
        let mut nearest: Option<Self> = None;
        for (step, motion) in change.motions.iter().filter(|(step, _)| *step > from) {
            if *step > *stage.steps.end() {
                break;
            }
            ego.go(*step, motion, body);
            let own = stage.footprint.at(ego.pose());
            let other = body.at(motion.pose);
            let least = nearest.map_or(f64::INFINITY, |n| n.distance);
            let Some(distance) = nearer(&own, &other, least) else {
                continue;
            };
            let ahead = own.pose.to_local(&other.pose.position).x;
            nearest = Some(Self {
                distance,
                step: *step,
                lead: (*step - from) as f64 * stage.dt(),
                speed: ego.speed,
                behind: ahead < -stage.footprint.shape().size().0 / 2.0,
            });
            if distance == 0.0 {
                break;
            }
        }
        nearest
    }

    /// How promising it is: the less, the better. Contact that a good driver could have avoided is best, from behind
    /// worst.
    #[must_use]
    pub fn cost(&self) -> f64 {
        let hasty = (CHANCE - self.lead).max(0.0);
        let slow = 0.2 * (self.lead - SEEN_THROUGH).max(0.0);
        let near = if self.distance > 0.0 {
            1.0 + self.distance.min(20.0)
        } else {
            0.0
        };
        let crawling = (CRAWLING - self.speed).max(0.0);
        near + hasty + slow.min(1.0) + crawling + if self.behind { 3.0 } else { 0.0 }
    }
}

/// The distance of two bodies where it is less than `least`, metres.
fn nearer(a: &Placed<'_>, b: &Placed<'_>, least: f64) -> Option<f64> {
    let reach = a.footprint.reach() + b.footprint.reach();
    if (a.pose.position - b.pose.position).norm() - reach >= least {
        return None;
    }
    Some(a.distance(b)).filter(|distance| *distance < least)
}

impl Braking<'_> {
    fn pose(&self) -> Pose {
        self.stage.line.pose_at(self.s)
    }

    /// To a step, at which the attacker moves like this.
    fn go(&mut self, step: i64, attacker: &Motion, body: &Footprint) {
        let dt = self.stage.dt();
        let usual = self.stage.ego_at(step).map_or(0.0, |m| m.velocity);
        let before = self.speed;
        self.speed = if self.has_to_brake(attacker, body) {
            (self.speed - BRAKING * dt).max(0.0)
        } else if self.speed > usual {
            (self.speed - RESUMING * dt).max(usual)
        } else {
            (self.speed + RESUMING * dt).min(usual)
        };
        self.s += f64::midpoint(before, self.speed) * dt;
    }

    /// Whether the two would meet if both went on as they do.
    fn has_to_brake(&self, attacker: &Motion, body: &Footprint) -> bool {
        (1..=LOOKS).any(|look| {
            let t = AHEAD * look as f64 / LOOKS as f64;
            let own = self.stage.line.pose_at(self.s + self.speed * t);
            let there = Pose {
                position: attacker.pose.position + attacker.velocity_vector() * t,
                ..attacker.pose
            };
            nearer(&self.stage.footprint.at(own), &body.at(there), NEAR).is_some()
        })
    }
}
