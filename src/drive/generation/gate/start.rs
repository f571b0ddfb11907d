//! Checks which obstacles may be changed, and how a changed motion must begin.

use super::run::{Findings, Flow, MOST_DIFFERENT, Run};
use crate::generation::{AttackStyle, Capability, Change, ChangeError, Reason, Refusal};
use nearmiss_base::geometry::{Footprint, angle_between};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Scenario};

/// The obstacle whose motion is changed, its body and its limits.
pub(super) fn who<'a>(
    scenario: &'a Scenario,
    style: AttackStyle,
    change: &Change,
) -> Result<(&'a Obstacle, &'a Footprint, Capability), Refusal> {
    let id = change.obstacle;
    let no = |why| Refusal::whole_motion(Reason::Obstacle(why));
    let obstacle = scenario
        .obstacle(id)
        .ok_or_else(|| no(ChangeError::NoSuchObstacle(id)))?;
    if obstacle.role != ObstacleRole::Dynamic || obstacle.initial.is_none() {
        return Err(no(ChangeError::DoesNotMove(id)));
    }
    let unable = || Refusal::whole_motion(Reason::Unable(id));
    let footprint = obstacle.footprint.as_ref().ok_or_else(unable)?;
    let can = Capability::for_obstacle(obstacle, style).ok_or_else(unable)?;
    let from = change
        .from()
        .ok_or_else(|| Refusal::whole_motion(Reason::Gap))?;
    if obstacle.track().at(from).is_none() {
        return Err(Refusal {
            step: Some(from),
            ..no(ChangeError::NotThere(id))
        });
    }
    Ok((obstacle, footprint, can))
}

/// Refuses what is no motion at all: of no length, or with what is no number. Nothing else can be asked of that.
pub(super) fn is_no_motion(motions: &[(i64, Motion)], found: &mut Findings) -> Flow {
    if let [(step, _)] = motions {
        found.say(false, Refusal::at(*step, Reason::Gap).with(0.0, 1.0))?;
    }
    for (step, motion) in motions {
        let numbers = [
            motion.pose.position.x,
            motion.pose.position.y,
            motion.pose.heading,
            motion.velocity,
            motion.acceleration,
        ];
        if !numbers.iter().all(|n| n.is_finite()) {
            found.say(false, Refusal::at(*step, Reason::NotANumber))?;
        }
    }
    Flow::Continue(())
}

/// How far two motions are apart in place (m), heading (rad) and speed (m/s).
pub(super) fn differences(a: &Motion, b: &Motion) -> impl Iterator<Item = (&'static str, f64)> {
    let turned = angle_between(a.pose.heading, b.pose.heading).abs();
    [
        ("position", (a.pose.position - b.pose.position).norm()),
        ("heading", turned),
        ("velocity", (a.velocity - b.velocity).abs()),
    ]
    .into_iter()
}

impl Run<'_> {
    /// It begins at the recorded state.
    pub fn start(&self, found: &mut Findings) -> Flow {
        let (step, first) = &self.motions[0];
        let Some(recorded) = self.obstacle.track().at(*step) else {
            return Flow::Continue(());
        };
        for (what, value) in differences(recorded, first) {
            if value > MOST_DIFFERENT {
                let refusal = Refusal::at(*step, Reason::Start(what));
                found.say(false, refusal.with(value, MOST_DIFFERENT))?;
            }
        }
        Flow::Continue(())
    }

    /// Checks that each step has a state.
    pub fn gaps(&self, found: &mut Findings) -> Flow {
        for pair in self.motions.windows(2) {
            let (step, next) = (pair[0].0, pair[1].0);
            let steps = next.saturating_sub(step);
            if steps != 1 {
                let refusal = Refusal::at(step, Reason::Gap);
                found.say(false, refusal.with(steps as f64, 1.0))?;
            }
        }
        Flow::Continue(())
    }
}
