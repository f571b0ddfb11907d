//! The gate: checks that every changed motion must pass before export, whatever its source.
//!
//! Every check reports the step, the value and the limit. Limits are those of
//! [`super::Capability`]; the single-track model is [`crate::planner::Feasibility`], and beside it the motion of the
//! body's centre is held against its heading and speed with other formulas.
//!
//! **What is left as recorded is exempt.** Recordings break limits themselves. A state is left as recorded where place,
//! heading, speed and acceleration are the recorded ones, a step where both of its ends are; what is broken there is
//! reported as the recording's. The first changed step is not exempt.
//!
//! **The joint.** What a motion did before it departs from the recording is known as well as recordings know it: many
//! round, or move the centre along the heading where a vehicle's rear axle would. See [`Joint`] for what is held
//! against it.
//!
//! **Several changes.** Of motions that are changed together each is checked beside the other changed ones, and in place
//! of those that these obstacles had.
//!
//! **Others.** Static and dynamic obstacles count with their bodies; one whose future is a set of regions counts with
//! the regions, though it is only somewhere in them. A trailer is straight on the changed steps.

mod compare;
mod motion_checks;
mod place_checks;
mod run;

pub use compare::{Comparison, GateResult};
pub use motion_checks::Joint;

use self::run::{Findings, Run};
use super::{AttackStyle, Change, JointChange, MOST_ATTACKERS, Refusal};
use nearmiss_scene::scenario::{DrivableArea, Ego, Scenario};
use run::Regions;

/// The gate of one scenario; built once, asked often.
#[derive(Debug, Clone)]
pub struct Gate<'a> {
    scenario: &'a Scenario,
    road: DrivableArea,
    regions: Regions,
    ego: Option<&'a Ego>,
    rounding: f64,
    style: AttackStyle,
    attackers: usize,
}

/// A changed motion that passed the gate.
#[derive(Debug, Clone, PartialEq)]
pub struct GateEvidence {
    /// Steps from one state to the next that were checked.
    pub steps: usize,
    /// Steps that are left exactly as recorded, and therefore exempt.
    pub exempt: usize,
    /// The largest share of the friction circle that a changed step uses, 0 to 1.
    pub friction: f64,
    /// Violations in the recording itself at exempt steps; [`Gate::passes`] does not look for them.
    pub recording: Vec<Refusal>,
    /// How many steps before the recorded motion the changed one ends; the obstacle is gone from then on.
    pub early: i64,
}

/// How exactly numbers are known that were not rounded, metres and radians.
const EXACT: f64 = 1e-6;

impl<'a> Gate<'a> {
    /// The gate for changes of `scenario` within what vehicles can do.
    #[must_use]
    pub fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            road: scenario.network.drivable_area(None),
            regions: Regions::new(scenario),
            ego: None,
            rounding: EXACT,
            style: AttackStyle::Limit,
            attackers: MOST_ATTACKERS,
        }
    }

    /// With an ego, whose body no obstacle may overlap before the change begins: that would not be the change's doing.
    #[must_use]
    pub fn with_ego(self, ego: &'a Ego) -> Self {
        Self {
            ego: Some(ego),
            ..self
        }
    }

    /// For motions of a style.
    #[must_use]
    pub fn of_style(self, style: AttackStyle) -> Self {
        Self { style, ..self }
    }

    /// For variants in which at most this many obstacles move otherwise, see [`Self::compare`].
    #[must_use]
    pub fn with_attackers(self, attackers: usize) -> Self {
        Self { attackers, ..self }
    }

    /// For motions whose places (m), headings (rad) and speeds (m/s) are only known this well: half of what a file
    /// rounds to.
    #[must_use]
    pub fn rounded_to(self, rounding: f64) -> Self {
        Self { rounding, ..self }
    }

    /// Everything that is wrong with a change, in the order of the checks.
    ///
    /// `contact` is the step at which the ego is touched, if it is: who is overlapped after it does not count.
    ///
    /// # Errors
    /// All refusals, never none.
    pub fn check(
        &self,
        change: &Change,
        contact: Option<i64>,
    ) -> Result<GateEvidence, Vec<Refusal>> {
        self.run(change, self.scenario, contact, false)
    }

    /// The same, but only the first refusal that is found; cheap checks come first.
    ///
    /// # Errors
    /// A refusal.
    pub fn passes(&self, change: &Change, contact: Option<i64>) -> Result<GateEvidence, Refusal> {
        self.run(change, self.scenario, contact, true)
            .map_err(|mut refusals| refusals.swap_remove(0))
    }

    /// Everything that is wrong with changes that are made together, each beside the others; see [`Self::check`]. The
    /// evidence is in the order of the changes.
    ///
    /// # Errors
    /// All refusals with whose motion it is, never none.
    pub fn check_joint(
        &self,
        change: &JointChange,
        contact: Option<i64>,
    ) -> Result<Vec<GateEvidence>, Vec<Refusal>> {
        let (mut passed, mut refused) = (Vec::new(), Vec::new());
        for (change, verdict) in self.verdicts(change, contact) {
            match verdict {
                Ok(evidence) => passed.push(evidence),
                Err(refusals) => {
                    let about = |refusal: Refusal| refusal.about(change.obstacle, None);
                    refused.extend(refusals.into_iter().map(about));
                }
            }
        }
        if refused.is_empty() {
            Ok(passed)
        } else {
            Err(refused)
        }
    }

    /// The verdict on each of several changes, beside the others.
    fn verdicts<'c>(
        &'c self,
        joint: &'c JointChange,
        contact: Option<i64>,
    ) -> impl Iterator<Item = (&'c Change, Result<GateEvidence, Vec<Refusal>>)> {
        joint.changes().iter().map(move |change| {
            let mut around = None;
            for other in joint
                .changes()
                .iter()
                .filter(|o| o.obstacle != change.obstacle)
            {
                // One that cannot be applied is refused itself.
                let scenario = around.get_or_insert_with(|| self.scenario.clone());
                let _ = other.apply_to(scenario);
            }
            let around = around.as_ref().unwrap_or(self.scenario);
            (change, self.run(change, around, contact, false))
        })
    }

    fn run(
        &self,
        change: &Change,
        around: &Scenario,
        contact: Option<i64>,
        stop: bool,
    ) -> Result<GateEvidence, Vec<Refusal>> {
        let mut found = Findings::new(stop);
        let mut passed = None;
        if let Some(run) = Run::begin(self, change, around, contact, &mut found) {
            let _ = run.all(&mut found);
            passed = Some((run.steps(), run.friction(), run.early()));
        }
        let Some((steps, friction, early)) = passed.filter(|_| found.refusals.is_empty()) else {
            return Err(found.refusals);
        };
        Ok(GateEvidence {
            steps: steps.0,
            exempt: steps.1,
            friction,
            recording: found.recording,
            early,
        })
    }
}
