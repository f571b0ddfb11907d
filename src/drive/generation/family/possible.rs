//! Whether a case could be: its vehicle can drive so, and touches no one else before.

use nearmiss_scene::scenario::{Obstacle, Scenario, Track};

use super::EncounterFamily;
use crate::generation::gate::overlapped;
use crate::generation::{AttackStyle, Capability};
use crate::planner::{Bound, Broken, Feasibility};

/// What a vehicle cannot do; the others say how well a track fits the model of it, which recordings do not.
const PHYSICAL: [Bound; 7] = [
    Bound::Speed,
    Bound::Backwards,
    Bound::Acceleration,
    Bound::SteeringAngle,
    Bound::SteeringRate,
    Bound::YawRate,
    Bound::Friction,
];

/// What recordings themselves exceed, cases may by this share more.
const AS_RECORDED: f64 = 1.05;

impl EncounterFamily<'_> {
    /// # Errors
    /// The vehicle cannot drive like this, nor was recorded to: the bound that is exceeded most.
    pub(super) fn is_possible(&self, track: &Track) -> Result<(), String> {
        let Some(can) = Capability::for_obstacle(self.obstacle, AttackStyle::Limit) else {
            return Ok(());
        };
        let check = Feasibility::new(can.limits, self.dt());
        let broken = |track: &Track| -> Vec<Broken> {
            let broken = check.track(track).err().map(|error| error.0);
            let physical = |broken: &Broken| PHYSICAL.contains(&broken.bound);
            broken
                .unwrap_or_default()
                .into_iter()
                .filter(physical)
                .collect()
        };
        let recorded = broken(self.obstacle.track());
        let worse = broken(track).into_iter().filter(|one| {
            let same = recorded.iter().filter(|before| before.bound == one.bound);
            let most = same.map(|before| before.value).fold(one.most, f64::max);
            one.value > AS_RECORDED * most
        });
        // Who drives backwards breaks other bounds, too.
        let rank = |one: &Broken| (one.bound == Bound::Backwards, one.excess());
        let worst = worse.max_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        match worst {
            None => Ok(()),
            Some(one) if one.bound == Bound::Backwards => Err("it drives backwards".into()),
            Some(one) => Err(format!(
                "{} {:.2} {}, at most {:.2}",
                one.bound.name(),
                one.value,
                one.bound.unit(),
                one.most
            )),
        }
    }

    /// # Errors
    /// Until a step it touches another road user that it does not touch as recorded: which.
    pub(super) fn is_alone(
        &self,
        scenario: &Scenario,
        moved: &Obstacle,
        until: i64,
    ) -> Result<(), String> {
        let touched = |obstacle: &Obstacle, step: i64| -> Vec<i64> {
            let at = |step| obstacle.placed_at(step);
            let Some(body) = at(step) else {
                return Vec::new();
            };
            let (before, regions) = (at(step - 1), &self.regions);
            overlapped(scenario, regions, before, &body, obstacle.id, step).collect()
        };
        for step in moved.track().steps().take_while(|step| *step <= until) {
            for id in touched(moved, step) {
                let is_recorded = || {
                    let mut steps = self.obstacle.track().steps();
                    steps.any(|step| touched(self.obstacle, step).contains(&id))
                };
                if !is_recorded() {
                    return Err(format!("it touches {id}"));
                }
            }
        }
        Ok(())
    }
}
