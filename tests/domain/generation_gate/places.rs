//! Who may be changed, where a change begins, and where the body may be.

use nearmiss::formats::bundled;
use nearmiss::generation::{Change, ChangeError, Gate, Reason, Refusal};
use nearmiss::geometry::{Shape, Vector};
use nearmiss::scenario::{
    Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Occupancy, Prediction, Scenario, Steps,
};

use super::built::{alone, assert_near, driven, first, names, scenario, untouched};

const CAR: i64 = 304;

fn refused(scenario: &Scenario, change: &Change) -> Vec<Refusal> {
    Gate::new(scenario)
        .check(change, None)
        .expect_err("refused")
}

fn reason(scenario: &Scenario, change: &Change) -> Reason {
    let refusals = refused(scenario, change);
    assert_eq!(refusals.len(), 1, "{refusals:?}");
    refusals[0].reason.clone()
}

#[test]
fn it_starts_exactly_at_the_recorded_state() {
    let scenario = alone("Merge", CAR);
    let change = driven(&scenario, CAR, 70, 0.0, &[(0.0, 0.0); 4]);
    let start = |edit: &dyn Fn(&mut Change)| {
        let mut change = change.clone();
        edit(&mut change);
        let refusals = refused(&scenario, &change);
        let starts = refusals.into_iter().filter(|r| r.reason.name() == "start");
        let starts: Vec<_> = starts.collect();
        assert_eq!(starts.len(), 1, "{starts:?}");
        assert_eq!(starts[0].step, Some(70));
        (starts[0].reason.clone(), starts[0].value.unwrap())
    };
    let (what, value) = start(&|c| {
        for (_, m) in &mut c.motions {
            m.pose.position += Vector::new(0.3, 0.4);
        }
    });
    assert_eq!(what, Reason::Start("position"));
    assert_near(value, 0.5, 1e-9);
    let (what, value) = start(&|c| c.motions[0].1.pose.heading += 0.01);
    assert_eq!(what, Reason::Start("heading"));
    assert_near(value, 0.01, 1e-9);
    let (what, value) = start(&|c| c.motions[0].1.velocity += 1e-6);
    assert_eq!(what, Reason::Start("velocity"));
    assert_near(value, 1e-6, 1e-9);
}

#[test]
fn only_who_moves_and_is_there_can_be_changed() {
    let hard = scenario("HardBraking");
    let change = untouched(&hard, 301, 50);
    let of = |obstacle| Change {
        obstacle,
        ..change.clone()
    };
    let no = |why| Reason::Obstacle(why);
    assert_eq!(reason(&hard, &of(7)), no(ChangeError::NoSuchObstacle(7)));
    assert_eq!(reason(&hard, &of(309)), no(ChangeError::DoesNotMove(309)));
    let mut later = change.clone();
    for (step, _) in &mut later.motions {
        *step += 1000;
    }
    assert_eq!(reason(&hard, &later), no(ChangeError::NotThere(301)));
    let empty = Change {
        obstacle: 301,
        motions: Vec::new(),
    };
    assert_eq!(reason(&hard, &empty), Reason::Gap);
    let mut building = (*hard).clone();
    building.obstacles[1].kind = ObstacleType::Building;
    let id = building.obstacles[1].id;
    assert_eq!(reason(&building, &of(id)), Reason::Unable(id));
}

#[test]
fn gaps_and_what_is_no_number() {
    let scenario = alone("Merge", CAR);
    let change = driven(&scenario, CAR, 70, 0.0, &[(0.0, 0.0); 6]);
    let mut gap = change.clone();
    gap.motions.remove(3);
    let found = refused(&scenario, &gap);
    assert_eq!(names(&found), ["gap"].into());
    assert_eq!(first(&found, "gap"), (72, 2.0, 1.0));
    let mut back = change.clone();
    back.motions.swap(3, 4);
    assert!(names(&refused(&scenario, &back)).contains("gap"));
    let mut short = change.clone();
    short.motions.truncate(1);
    assert_eq!(reason(&scenario, &short), Reason::Gap);
    for nonsense in [f64::NAN, f64::INFINITY] {
        let mut nowhere = change.clone();
        nowhere.motions[2].1.pose.position.x = nonsense;
        nowhere.motions[5].1.acceleration = nonsense;
        let found = refused(&scenario, &nowhere);
        let steps: Vec<_> = found.iter().map(|r| r.step).collect();
        assert_eq!(names(&found), ["not a number"].into());
        assert_eq!(steps, [Some(72), Some(75)]);
    }
}

#[test]
fn off_the_road_after_having_been_on_it() {
    let scenario = alone("Merge", CAR);
    // Slowly to the left, over the edge of the motorway.
    let mut inputs = vec![(0.0, 0.1), (0.0, 0.1), (0.0, -0.1), (0.0, -0.1)];
    inputs.resize(40, (0.0, 0.0));
    let change = driven(&scenario, CAR, 60, 0.0, &inputs);
    let found = refused(&scenario, &change);
    assert_eq!(names(&found), ["off road"].into());
    let (step, value, limit) = first(&found, "off road");
    assert!(step > 65 && value > 0.0, "{step} {value}");
    assert_eq!(limit, 0.0);
    assert!(found[1].value > found[0].value);
}

#[test]
fn people_on_foot_may_leave_the_road() {
    let scenario = alone("RightTurn", 310);
    let change = driven(&scenario, 310, 20, 0.0, &[(0.0, 0.0); 80]);
    let moved: Vec<_> = {
        let mut scenario = scenario.clone();
        scenario.network = nearmiss::scenario::LaneletNetwork::default();
        vec![Gate::new(&scenario).check(&change, None)]
    };
    assert!(moved[0].is_ok(), "{moved:?}");
    assert!(Gate::new(&scenario).check(&change, None).is_ok());
}

/// A parked van across the way of the car, 30 m ahead.
fn blocked(role: ObstacleRole) -> Scenario {
    let mut scenario = alone("Merge", CAR);
    let car = scenario.obstacles[0].clone();
    let mut at = car.states().nth(70).unwrap().clone();
    let ahead = car.track().at(70).unwrap().pose;
    let place = ahead.position + ahead.forward() * 30.0;
    at.position = Some(nearmiss::scenario::Position::Point(place));
    at.time = Steps::exact(0);
    let region = Shape::Circle {
        radius: 1.0,
        center: place,
    };
    let prediction = if role == ObstacleRole::Static {
        Prediction::None
    } else {
        at.position = Some(nearmiss::scenario::Position::Point(
            place + Vector::new(0.0, 500.0),
        ));
        Prediction::Occupancies(vec![Occupancy {
            time: Steps { from: 1, to: 200 },
            region,
        }])
    };
    scenario.obstacles.push(Obstacle::new(
        ObstacleParts {
            id: 9,
            role,
            kind: ObstacleType::Car,
            footprint: car.footprint.clone(),
            initial: Some(at),
            prediction,
            signals: Vec::new(),
        },
        0.1,
    ));
    scenario
}

#[test]
fn nobody_else_is_driven_over() {
    for role in [ObstacleRole::Static, ObstacleRole::Dynamic] {
        let scenario = blocked(role);
        let change = driven(&scenario, CAR, 70, 0.0, &[(-1.0, 0.0); 14]);
        let gate = Gate::new(&scenario);
        let found = gate.check(&change, None).unwrap_err();
        assert_eq!(found[0].reason, Reason::Overlap(9));
        assert_eq!(names(&found), ["overlap"].into());
        // 30 m less 5.9 m, or half of it and 1 m, at 28 m/s.
        let step = found[0].step.unwrap();
        let expected = if role == ObstacleRole::Static { 79 } else { 80 };
        assert_eq!(step, expected);
        assert_eq!(gate.passes(&change, None), Err(found[0].clone()));
        // Who has touched the ego may slide into others.
        assert!(gate.check(&change, Some(step - 1)).is_ok());
        assert_eq!(gate.check(&change, Some(step)).unwrap_err().len(), 1);
    }
}

#[test]
fn the_ego_is_not_touched_by_the_recording() {
    let entries = bundled();
    let entry = entries
        .iter()
        .find(|e| e.name.contains("HardBraking"))
        .unwrap();
    let scenario = entry.read().unwrap();
    let mut ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    // The ego takes the place of the car itself until step 30.
    let track = scenario.obstacle(301).unwrap().track();
    let change = untouched(&scenario, 301, 20);
    assert!(
        Gate::new(&scenario)
            .with_ego(&ego)
            .check(&change, None)
            .is_ok()
    );
    let samples = track
        .iter()
        .take(31)
        .map(|(step, m)| nearmiss::scenario::Sample {
            step,
            position: m.pose.position,
            heading: Some(m.pose.heading),
            velocity: Some(m.velocity),
            acceleration: None,
        });
    ego.track = nearmiss::scenario::Track::new(samples.collect(), 0.1, None);
    let gate = Gate::new(&scenario).with_ego(&ego);
    let found = gate.check(&change, None).unwrap_err();
    assert_eq!(names(&found), ["overlap with the ego"].into());
    assert_eq!(found.len(), 21);
    // What the change does later is what it is for.
    let brakes = driven(&scenario, 301, 20, 0.0, &[(-2.0, 0.0); 5]);
    let found = gate.check(&brakes, None).unwrap_err();
    let touched = found.iter().filter(|r| r.reason == Reason::OverlapsEgo);
    assert_eq!(touched.count(), 21);
}
