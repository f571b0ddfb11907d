//! Variants made by others, held against their original.

use std::collections::BTreeSet;

use nearmiss::generation::{Change, Gate, JointChange, Reason, Refusal};
use nearmiss::scenario::Scenario;

use super::built::{driven, names, scenario, untouched};

fn reasons(original: &Scenario, variant: &Scenario) -> Vec<Reason> {
    let compared = Gate::new(original).compare(variant, None);
    compared.refusals.into_iter().map(|r| r.reason).collect()
}

#[test]
fn one_change_is_found_and_checked() {
    let original = scenario("Merge");
    let gate = Gate::new(&original);
    let change = driven(&original, 304, 70, 0.0, &[(-2.0, 0.0), (-4.0, 0.0)]);
    let compared = gate.compare(&change.apply(&original).unwrap(), None);
    assert!(compared.passed(), "{compared:?}");
    assert_eq!(compared.changed.len(), 1);
    let judged = &compared.changed[0];
    assert_eq!((judged.from, &judged.change), (71, &change));
    assert_eq!(judged.verdict, gate.check(&change, None));
    let fast = driven(&original, 304, 70, 0.0, &[(-9.0, 0.0), (-12.0, 0.0)]);
    let compared = gate.compare(&fast.apply(&original).unwrap(), None);
    assert!(!compared.passed() && compared.refusals.is_empty());
    let found = compared.changed[0].verdict.as_ref().unwrap_err();
    assert_eq!(
        names(found),
        ["acceleration", "friction circle", "jerk"].into()
    );
}

#[test]
fn no_more_changes_pass_than_there_may_be() {
    let original = scenario("Merge");
    assert_eq!(reasons(&original, &original), [Reason::Unchanged]);
    let one = driven(&original, 304, 70, 0.0, &[(-2.0, 0.0)]);
    let two = driven(&original, 302, 70, 0.0, &[(-12.0, 0.0)]);
    let both = JointChange::new(vec![one, two])
        .unwrap()
        .apply(&original)
        .unwrap();
    assert_eq!(reasons(&original, &both), []);
    let compared = Gate::new(&original).with_attackers(1).compare(&both, None);
    assert_eq!(compared.refusals.len(), 1);
    assert_eq!(
        compared.refusals[0].to_string(),
        "several changed obstacles: 2, at most 1"
    );
    let verdicts: Vec<_> = compared.changed.iter().map(|c| c.verdict.is_ok()).collect();
    assert_eq!(verdicts, [false, true]);
}

/// As the recording of another obstacle, or of the same, from a step on, moved by so many metres north.
fn moved(original: &Scenario, id: i64, like: i64, north: f64) -> Change {
    let mut change = untouched(original, id, 70);
    let track = original.obstacle(like).unwrap().track();
    for (step, motion) in change.motions.iter_mut().skip(1) {
        *motion = *track.at(*step).unwrap();
        motion.pose.position.y += north;
    }
    change
}

/// Which of the obstacles overlaps which other one.
fn overlaps(refusals: Vec<Refusal>) -> BTreeSet<(i64, i64)> {
    let all = refusals.into_iter();
    let overlaps = all.filter_map(|refusal| match refusal.reason {
        Reason::Overlap(other) => Some((refusal.attacker.unwrap(), other)),
        _ => None,
    });
    overlaps.collect()
}

#[test]
fn changed_motions_are_checked_beside_each_other() {
    let original = scenario("Merge");
    let gate = Gate::new(&original);
    let found = |changes: &[&Change]| {
        let changes = changes.iter().map(|c| (*c).clone()).collect();
        let joint = JointChange::new(changes).unwrap();
        overlaps(gate.check_joint(&joint, None).unwrap_err())
    };
    // In a free place both, but in the same one.
    let (one, two) = (
        moved(&original, 304, 304, -999.0),
        moved(&original, 302, 304, -999.0),
    );
    assert_eq!(found(&[&one]), [].into());
    assert_eq!(found(&[&two]), [].into());
    assert_eq!(found(&[&one, &two]), [(304, 302), (302, 304)].into());
    // Where the other one was recorded, which is elsewhere now.
    let follows = moved(&original, 302, 304, 0.0);
    assert_eq!(found(&[&follows]), [(302, 304)].into());
    assert_eq!(found(&[&follows, &one]), [].into());
    // A variant from elsewhere is held against the same.
    let both = JointChange::new(vec![two, one]).unwrap();
    let compared = gate.compare(&both.apply(&original).unwrap(), None);
    assert!(compared.refusals.is_empty() && !compared.passed());
    let found = compared.changed.into_iter().flat_map(|one| {
        let refused = one.verdict.unwrap_err().into_iter();
        refused.map(move |refusal| refusal.about(one.change.obstacle, None))
    });
    assert_eq!(overlaps(found.collect()), [(304, 302), (302, 304)].into());
}

#[test]
fn everything_else_is_the_same() {
    let original = scenario("Merge");
    let change = driven(&original, 304, 70, 0.0, &[(-2.0, 0.0)]);
    let edited = |edit: &dyn Fn(&mut Scenario)| {
        let mut variant = change.apply(&original).unwrap();
        edit(&mut variant);
        reasons(&original, &variant)
    };
    assert_eq!(edited(&|_| ()), []);
    let gone = edited(&|v| v.obstacles.retain(|o| o.id != 302));
    assert_eq!(gone, [Reason::Missing(302)]);
    let new = edited(&|v| {
        let mut new = v.obstacles[0].clone();
        new.id = 77;
        v.obstacles.push(new);
    });
    assert_eq!(new, [Reason::Added(77)]);
    let twice = edited(&|v| v.obstacles.push(v.obstacles[0].clone()));
    assert_eq!(twice, [Reason::Reshaped(original.obstacles[0].id)]);
    let small = edited(&|v| v.obstacles[1].footprint = v.obstacles[0].footprint.clone());
    assert_eq!(small, [Reason::Reshaped(original.obstacles[1].id)]);
    let road = edited(&|v| {
        v.network.lanelets.pop();
    });
    assert_eq!(road, [Reason::Differs("the shape of the road")]);
    let types = edited(&|v| v.network.lanelets[0].types.clear());
    assert_eq!(types, [Reason::Differs("the attributes of the road")]);
    let goal = edited(&|v| v.planning_problems.clear());
    assert_eq!(goal, [Reason::Differs("the planning problem")]);
    let time = edited(&|v| v.header.time_step_size = 0.2);
    assert_eq!(time, [Reason::Differs("the time step")]);
    // Who stands cannot be moved, and who is gone early is no motion.
    let hard = scenario("HardBraking");
    let mut moved = (*hard).clone();
    let place = moved.obstacles.iter().position(|o| o.id == 309).unwrap();
    let mut initial = moved.obstacles[place].initial.clone().unwrap();
    initial.position = Some(nearmiss::scenario::Position::Point(
        nearmiss::geometry::Point::origin(),
    ));
    let old = &moved.obstacles[place];
    let parts = nearmiss::scenario::ObstacleParts {
        id: old.id,
        role: old.role,
        kind: old.kind,
        footprint: old.footprint.clone(),
        initial: Some(initial),
        prediction: old.prediction.clone(),
        signals: Vec::new(),
    };
    moved.obstacles[place] = nearmiss::scenario::Obstacle::new(parts, 0.1);
    let compared = Gate::new(&hard).compare(&moved, None);
    let found = compared.changed[0].verdict.as_ref().unwrap_err();
    assert_eq!(found[0].reason.name(), "obstacle");
    let mut early = untouched(&hard, 301, 0);
    early.motions.truncate(50);
    let compared = Gate::new(&hard).compare(&early.apply(&hard).unwrap(), None);
    assert_eq!(compared.changed[0].from, 50);
    let found = compared.changed[0].verdict.as_ref().unwrap_err();
    assert_eq!(names(found), ["gap"].into());
}
