//! The gate: checks that every changed motion must pass before export, whatever its source, also variants from elsewhere.
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

mod checks;
mod run;

pub use checks::Joint;

use std::collections::HashMap;

use nearmiss_scene::scenario::{
    DrivableArea, Ego, Lanelet, LaneletNetwork, Motion, Obstacle, Prediction, Scenario,
};

use self::run::{Findings, Run};
use super::{AttackStyle, Change, JointChange, MOST_ATTACKERS, Refusal};
use crate::generation::Reason;
use run::same;
pub(super) use run::{Regions, overlapped};

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

/// A variant's changes, and what is wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Refusals of the variant as a whole.
    pub refusals: Vec<Refusal>,
    /// The obstacles with a changed motion, in the original's order.
    pub changed: Vec<GateResult>,
}

/// One changed motion, and its result at the gate.
#[derive(Debug, Clone, PartialEq)]
pub struct GateResult {
    /// The first step at which it is not the recorded one.
    pub from: i64,
    /// The motion, from the last recorded state before that, if there is one.
    pub change: Change,
    /// The gate's verdict.
    pub verdict: Result<GateEvidence, Vec<Refusal>>,
}

impl Comparison {
    /// Whether the variant is a change that passes, or several.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.refusals.is_empty() && self.changed.iter().all(|one| one.verdict.is_ok())
    }
}

impl Gate<'_> {
    /// Holds a variant of the gate's scenario against it: some obstacles may move in another way
    /// ([`Gate::with_attackers`]), everything else has to be the same. Each changed motion is checked beside the others.
    /// Names, tags and what obstacles signal are not compared.
    ///
    /// A variant that was written with few digits is to be asked of a gate that knows ([`Gate::rounded_to`]).
    #[must_use]
    pub fn compare(&self, variant: &Scenario, contact: Option<i64>) -> Comparison {
        let original = self.scenario;
        let mut refusals = Vec::new();
        let mut differs = |is: bool, what| {
            if is {
                refusals.push(Refusal::whole_motion(Reason::Differs(what)));
            }
        };
        differs(original.dt() != variant.dt(), "the time step");
        let moved = has_another_shape(&original.network, &variant.network);
        differs(moved, "the shape of the road");
        // Types, users, neighbours, signs and lights.
        differs(
            !moved && original.network != variant.network,
            "the attributes of the road",
        );
        differs(
            original.planning_problems != variant.planning_problems,
            "the planning problem",
        );
        let mut theirs: HashMap<i64, &Obstacle> =
            variant.obstacles.iter().map(|o| (o.id, o)).collect();
        if theirs.len() < variant.obstacles.len() {
            let twice = variant
                .obstacles
                .iter()
                .filter(|o| !theirs.get(&o.id).is_some_and(|t| std::ptr::eq(*t, *o)));
            refusals.extend(twice.map(|o| Refusal::whole_motion(Reason::Reshaped(o.id))));
        }
        let (mut found, mut reshaped) = (Vec::new(), false);
        for ours in &original.obstacles {
            let Some(theirs) = theirs.remove(&ours.id) else {
                refusals.push(Refusal::whole_motion(Reason::Missing(ours.id)));
                continue;
            };
            if is_reshaped(ours, theirs) {
                reshaped = true;
                refusals.push(Refusal::whole_motion(Reason::Reshaped(ours.id)));
            } else {
                found.extend(change(ours, theirs));
            }
        }
        let added = variant
            .obstacles
            .iter()
            .filter(|o| theirs.contains_key(&o.id));
        refusals.extend(added.map(|o| Refusal::whole_motion(Reason::Added(o.id))));
        match found.len() {
            // The motion of another obstacle's body is compared with nothing.
            0 if reshaped => {}
            0 => refusals.push(Refusal::whole_motion(Reason::Unchanged)),
            n if n <= self.attackers => {}
            n => {
                let several = Refusal::whole_motion(Reason::Several);
                refusals.push(several.with(n as f64, self.attackers as f64));
            }
        }
        let (from, changes): (Vec<i64>, Vec<Change>) = found.into_iter().unzip();
        // There is no joint change of none; ids that are there twice were refused above.
        let joint = JointChange::new(changes).ok();
        let verdicts = joint.iter().flat_map(|joint| self.verdicts(joint, contact));
        let changed = from
            .into_iter()
            .zip(verdicts)
            .map(|(from, (change, verdict))| GateResult {
                from,
                change: change.clone(),
                verdict,
            });
        Comparison {
            changed: changed.collect(),
            refusals,
        }
    }
}

fn has_another_shape(ours: &LaneletNetwork, theirs: &LaneletNetwork) -> bool {
    let shapes = |network: &LaneletNetwork| {
        let lanelets = network.lanelets.iter();
        let shape = |l: &Lanelet| (l.id, l.left.points.clone(), l.right.points.clone());
        lanelets.map(shape).collect::<Vec<_>>()
    };
    shapes(ours) != shapes(theirs)
}

/// Whether more than the motion is another one.
fn is_reshaped(ours: &Obstacle, theirs: &Obstacle) -> bool {
    let regions = |o: &Obstacle| matches!(o.prediction, Prediction::Occupancies(_));
    (ours.role, ours.kind) != (theirs.role, theirs.kind)
        || ours.footprint != theirs.footprint
        || ((regions(ours) || regions(theirs)) && ours.prediction != theirs.prediction)
}

/// The first step at which two motions are not the same, and the second one from the state before.
fn change(ours: &Obstacle, theirs: &Obstacle) -> Option<(i64, Change)> {
    let motions: Vec<(i64, Motion)> = theirs.track().iter().map(|(s, m)| (s, *m)).collect();
    let alike = ours
        .track()
        .iter()
        .zip(&motions)
        .take_while(|((s, m), (t, n))| s == t && same(m, n))
        .count();
    let recorded = ours.track().iter().count();
    if alike == recorded && alike == motions.len() {
        return None;
    }
    let next = motions.get(alike).map(|(step, _)| *step);
    let from = next.or_else(|| ours.track().iter().nth(alike).map(|(step, _)| step));
    let change = Change {
        obstacle: ours.id,
        motions: motions
            .get(alike.saturating_sub(1)..)
            .unwrap_or_default()
            .to_vec(),
    };
    Some((from?, change))
}
