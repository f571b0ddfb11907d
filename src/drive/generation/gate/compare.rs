//! Compares a variant from another source with its original.

use std::collections::HashMap;

use super::run::same;
use super::{Gate, GateEvidence};
use crate::generation::{Change, JointChange, Reason, Refusal};
use nearmiss_scene::scenario::{Lanelet, LaneletNetwork, Motion, Obstacle, Prediction, Scenario};

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
