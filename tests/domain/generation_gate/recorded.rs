//! What is left as recorded is exempt, and reported.

use nearmiss::formats::bundled;
use nearmiss::generation::{AttackStyle, Capability, Gate, Joint};
use nearmiss::scenario::ObstacleRole;

use super::built::{alone, driven, names, untouched};

#[test]
fn everybody_passes_with_the_recorded_motion() {
    let mut seen = 0;
    for entry in bundled() {
        let scenario = entry.read().unwrap();
        let gate = Gate::new(&scenario);
        let all = scenario.obstacles.iter();
        for obstacle in all.filter(|o| o.role == ObstacleRole::Dynamic) {
            let steps = obstacle.track().steps();
            let change = untouched(&scenario, obstacle.id, steps.start);
            let passed = gate
                .check(&change, None)
                .unwrap_or_else(|refusals| panic!("{} {}: {refusals:?}", entry.name, obstacle.id));
            let ways = usize::try_from(steps.end - steps.start - 1).unwrap();
            assert_eq!((passed.steps, passed.exempt), (0, ways));
            assert_eq!((passed.friction, passed.early), (0.0, 0));
            seen += 1;
        }
    }
    assert!(seen > 60, "{seen}");
}

#[test]
fn what_the_recording_breaks_is_the_recordings() {
    let clean = alone("Merge", 304);
    let mut jumping = driven(&clean, 304, 0, 0.0, &[(0.0, 0.0); 40]);
    for (_, motion) in &mut jumping.motions[10..] {
        motion.pose.position += motion.pose.forward() * 10.0;
    }
    assert!(Gate::new(&clean).check(&jumping, None).is_err());
    // Now it is what was recorded.
    let scenario = jumping.apply(&clean).unwrap();
    let gate = Gate::new(&scenario);
    let change = untouched(&scenario, 304, 5);
    let passed = gate.check(&change, None).unwrap();
    assert_eq!((passed.steps, passed.exempt), (0, 35));
    assert!(
        names(&passed.recording).contains("displacement"),
        "{passed:?}"
    );
    assert!(passed.recording.iter().all(|r| r.step == Some(9)));
    // A change that begins before it and goes back to it does not get past the joint on the way back.
    let mut back = untouched(&scenario, 304, 5);
    back.motions[20].1.pose.position.x += 0.5;
    let found = gate.check(&back, None).unwrap_err();
    let steps: Vec<_> = found.iter().filter_map(|r| r.step).collect();
    assert!(steps.iter().all(|s| (24..=26).contains(s)), "{found:?}");
    assert!(steps.contains(&24) && steps.contains(&25));
}

#[test]
fn the_joint_knows_what_the_recording_knows() {
    let scenario = alone("Merge", 304);
    let car = scenario.obstacle(304).unwrap();
    let can = Capability::for_obstacle(car, AttackStyle::Limit).unwrap();
    let joint = Joint::at(car.track(), 70, &can, 0.1).unwrap();
    let steering = joint.steering.unwrap();
    assert!(steering.start().abs() < 1e-3 && steering.end().abs() < 1e-3);
    assert!(joint.acceleration.contains(&0.0));
    assert!(Joint::at(car.track(), 100_000, &can, 0.1).is_none());
    // In a bend of the road the wheels are turned.
    let bend = alone("CutIn", 307);
    let car = bend.obstacle(307).unwrap();
    let joint = Joint::at(
        car.track(),
        60,
        &Capability::for_obstacle(car, AttackStyle::Limit).unwrap(),
        0.1,
    )
    .unwrap();
    assert!(*joint.steering.unwrap().end() > 1e-3);
}
