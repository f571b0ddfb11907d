//! A first look at a changed motion: how near it comes to the ego that does not answer.

use super::{Change, Stage};
use crate::geometry::Footprint;
use crate::scenario::Obstacle;

/// How a change looks beside the ego's motion in the original scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenLoop {
    /// The smallest distance between the bodies while both are there, metres.
    pub distance: f64,
    /// The step of it: of contact, the first.
    pub step: i64,
    /// Seconds from where the motion can be told from the recorded one to that step.
    pub warning: f64,
    /// Whether the attacker is behind the ego there.
    pub behind: bool,
}

/// A motion can be told from the recorded one when it is this far from it, metres.
const TELLING: f64 = 0.5;

/// The warning that leaves a good driver a chance, and a careless one none, seconds.
const SURPRISE: f64 = 1.4;

impl OpenLoop {
    /// Looks at a change; nothing where the two are never there together.
    #[must_use]
    pub fn of(stage: &Stage<'_>, obstacle: &Obstacle, change: &Change) -> Option<Self> {
        let body: &Footprint = obstacle.footprint.as_ref()?;
        let mut told = None;
        let mut nearest: Option<Self> = None;
        for (step, motion) in change.motions.iter().skip(1) {
            let recorded = obstacle.track().at(*step);
            let off = recorded.map(|r| (r.pose.position - motion.pose.position).norm());
            if told.is_none() && off.is_none_or(|off| off > TELLING) {
                told = Some(*step);
            }
            let Some(ego) = stage.ego.at(*step) else {
                continue;
            };
            let own = stage.footprint.at(ego.pose);
            let other = body.at(motion.pose);
            let most = stage.footprint.reach() + body.reach();
            let apart = (own.pose.position - other.pose.position).norm() - most;
            if nearest.is_some_and(|n| n.distance <= apart) {
                continue;
            }
            let distance = own.distance(&other);
            if nearest.is_none_or(|n| distance < n.distance) {
                let ahead = own.pose.to_local(&other.pose.position).x;
                nearest = Some(Self {
                    distance,
                    step: *step,
                    warning: told.map_or(0.0, |t| (*step - t) as f64 * stage.dt()),
                    behind: ahead < -stage.footprint.shape().size().0 / 2.0,
                });
            }
            if distance == 0.0 {
                break;
            }
        }
        nearest
    }

    /// How promising it is: the less, the better. Contact with a short warning is best, from behind worst.
    #[must_use]
    pub fn cost(&self) -> f64 {
        let off = (self.warning - SURPRISE).abs().min(3.0);
        let near = if self.distance > 0.0 {
            1.0 + self.distance.min(20.0)
        } else {
            0.0
        };
        near + 0.5 * off + if self.behind { 3.0 } else { 0.0 }
    }
}
