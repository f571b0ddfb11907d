//! Severity: contact before courses, courses before passes, and nothing for what is only near.

use std::f64::consts::FRAC_PI_2;

use nearmiss::formats::bundled;
use nearmiss::geometry::{Footprint, Shape};
use nearmiss::metrics::{CriticalMoment, Grade, Hazard, Headline, Thresholds};
use nearmiss::scenario::*;

use super::definitions::{car, moving, scene};

fn moments(obstacles: Vec<Obstacle>) -> Vec<CriticalMoment> {
    Headline::compute(&scene(obstacles), Thresholds::shipped()).moments
}

#[track_caller]
fn worst(obstacles: Vec<Obstacle>) -> CriticalMoment {
    moments(obstacles)[0]
}

/// A static obstacle: a parked car of 4 m × 2 m.
fn parked(id: i64, place: (f64, f64)) -> Obstacle {
    parked_turned(id, place, 0.0)
}

fn parked_turned(id: i64, (x, y): (f64, f64), heading: f64) -> Obstacle {
    let state = State {
        position: Some(Position::Point(nearmiss::geometry::Point::new(x, y))),
        orientation: Some(Quantity::Exact(heading)),
        ..State::at(Steps::exact(0))
    };
    let parts = ObstacleParts {
        id,
        role: ObstacleRole::Static,
        kind: ObstacleType::ParkedVehicle,
        footprint: Some(Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap()),
        initial: Some(state),
        prediction: Prediction::None,
        signals: Vec::new(),
    };
    Obstacle::new(parts, 0.1)
}

#[test]
fn contact_comes_first_and_the_harder_one_before_the_earlier() {
    let ego = || car(1, (0.0, 0.0), 0.0, 10.0, 0.0);
    // 2 is touched after 2 s with 2 m/s, 3 after 4 s with 6 m/s; 4 needs hard braking and is passed.
    let soft = car(2, (8.0, 0.0), 0.0, 8.0, 0.0);
    let hard = car(3, (28.0, 1.5), 0.0, 4.0, 0.0);
    let found = moments(vec![ego(), soft, hard]);
    assert_eq!((found[0].obstacle, found[1].obstacle), (3, 2));
    assert_eq!(found[0].grade, Grade::Contact);
    let Hazard::Contact { closing_speed, .. } = found[0].hazard else {
        panic!("{:?}", found[0]);
    };
    assert!((closing_speed - 6.0).abs() < 1e-9, "{closing_speed}");
    assert_eq!(found[0].step, 40);
}

#[test]
fn a_course_is_graded_by_its_time_and_the_braking_that_it_needs() {
    // The ego comes from 20 m/s with -4 m/s² behind one of 5 m/s: it closes to the least gap after 3.75 s.
    let found = worst(vec![
        car(1, (0.0, 0.0), 0.0, 20.0, -4.0),
        car(2, (35.0, 0.0), 0.0, 5.0, 0.0),
    ]);
    assert_eq!(
        (found.obstacle, found.grade),
        (2, Grade::Conflict),
        "{found:?}"
    );
    let Hazard::Course {
        seconds,
        braking,
        along_paths,
    } = found.hazard
    else {
        panic!("{found:?}");
    };
    assert!(!along_paths, "straight on both are one");
    // Gap 31 − 15t + 2t², closing 15 − 4t: needed is closing² over twice the gap, less what a reaction takes.
    let t = found.step as f64 * 0.1;
    let (gap, closing) = (31.0 - 15.0 * t + 2.0 * t * t, 15.0 - 4.0 * t);
    assert!((seconds - gap / closing).abs() < 1e-6, "{seconds}");
    let reaction = f64::min(1.0, gap / closing / 2.0);
    let left = gap / closing - reaction;
    assert!((braking - closing / (2.0 * left)).abs() < 1e-6, "{braking}");
    // The same more slowly is a course, no conflict, and far away something for later.
    let grade = |x: f64, v: f64| {
        worst(vec![
            car(1, (0.0, 0.0), 0.0, v, 0.0),
            car(2, (x + 4.0, 0.0), 0.0, v - 2.0, 0.0),
        ])
        .grade
    };
    assert_eq!(grade(25.0, 10.0), Grade::Course);
    assert_eq!(grade(27.0, 10.0), Grade::Ahead);
    assert_eq!(grade(33.0, 10.0), Grade::LaterCourse);
}

#[test]
fn what_is_near_and_on_its_own_way_is_not_severe() {
    // Beside a parked car at 0.6 m and beside a car in the next lane at 0.8 m, one far ahead is approached.
    let found = moments(vec![
        car(1, (0.0, 0.0), 0.0, 10.0, 0.0),
        parked(2, (50.0, -2.6)),
        car(3, (1.0, 2.8), 0.0, 10.0, 0.0),
        car(4, (70.0, 0.0), 0.0, 5.0, 0.55),
    ]);
    assert_eq!(found[0].obstacle, 4, "{found:?}");
    let of = |id: i64| found.iter().find(|m| m.obstacle == id).unwrap().grade;
    assert_eq!((of(2), of(3)), (Grade::Standing, Grade::Near));
    assert_eq!(
        found.last().unwrap().obstacle,
        2,
        "the parked one is the last"
    );
}

#[test]
fn who_crosses_closely_counts_by_time_and_distance() {
    // 2 crosses from the right: its front is at the ego's way when the ego's rear is 4 m beyond, 0.4 s later.
    let ego = || car(1, (0.0, 0.0), 0.0, 10.0, 0.0);
    let crossing = |x: f64| car(2, (60.0, x), FRAC_PI_2, 10.0, 0.0);
    let found = worst(vec![ego(), crossing(-70.0)]);
    assert_eq!(
        (found.obstacle, found.grade),
        (2, Grade::NearMiss),
        "{found:?}"
    );
    let Hazard::Crossing {
        seconds: Some(seconds),
        ..
    } = found.hazard
    else {
        panic!("{found:?}");
    };
    assert!((seconds - 0.4).abs() < 0.11, "{seconds}");
    assert_eq!(worst(vec![ego(), crossing(-80.0)]).grade, Grade::Pass);
    assert_eq!(worst(vec![ego(), crossing(-95.0)]).grade, Grade::Near);
}

#[test]
fn who_cuts_in_counts_by_the_gap_in_time() {
    // From the left lane, 12 m ahead at the same speed, with 0.1 rad to the right.
    let found = worst(vec![
        car(1, (0.0, 0.0), 0.0, 20.0, 0.0),
        car(2, (16.0, 3.5), -0.05, 20.03, 0.0),
    ]);
    assert_eq!(
        (found.obstacle, found.grade),
        (2, Grade::NearMiss),
        "{found:?}"
    );
    let Hazard::CutIn { seconds, metres } = found.hazard else {
        panic!("{found:?}");
    };
    assert!((metres / 20.0 - seconds).abs() < 1e-3 && (11.5..12.5).contains(&metres));
}

#[test]
fn the_story_of_each_bundled_scenario_is_its_moment() {
    let stories: [(&str, &[i64], Grade); 8] = [
        ("ZAM_CutIn-1_1_T-1", &[301], Grade::Conflict),
        ("ZAM_HardBraking-1_1_T-1", &[301], Grade::Contact),
        ("ZAM_JamTail-1_1_T-1", &[304], Grade::Ahead),
        ("ZAM_Merge-1_1_T-1", &[301, 302], Grade::Pass),
        ("ZAM_Overtaking-1_1_T-1", &[305], Grade::Conflict),
        ("ZAM_Pedestrian-1_1_T-1", &[302], Grade::Course),
        ("ZAM_RedLight-1_1_T-1", &[301], Grade::Contact),
        ("ZAM_RightTurn-1_1_T-1", &[301], Grade::NearMiss),
    ];
    for (name, obstacles, grade) in stories {
        let entry = bundled()
            .into_iter()
            .find(|entry| entry.name == name)
            .unwrap();
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        let headline = Headline::compute(&Scene::new(scenario, ego), Thresholds::shipped());
        let found = headline.worst().unwrap();
        assert!(
            obstacles.contains(&found.obstacle) && found.grade == grade,
            "{name}: {found:?}"
        );
    }
}

/// The way after some seconds with a speed and an acceleration that end at another speed, then the speed and what changes it.
fn until(time: f64, from: f64, acceleration: f64, to: f64) -> [f64; 3] {
    let end = (to - from) / acceleration;
    let t = time.min(end);
    let way = from * t + acceleration * t * t / 2.0 + to * (time - t);
    let is_over = time >= end;
    let speed = if is_over { to } else { from + acceleration * t };
    [way, speed, if is_over { 0.0 } else { acceleration }]
}

/// 10 m ahead of the ego round a bend of 20 m drives one with half its speed; where they would touch their headings are
/// 11° apart, and it is no crossing all the same.
#[test]
fn a_leader_round_a_bend_is_on_the_course() {
    let bend = |[way, speed, acceleration]: [f64; 3]| {
        let angle = way / 20.0;
        let (sin, cos) = angle.sin_cos();
        [20.0 * sin, 20.0 - 20.0 * cos, angle, speed, acceleration]
    };
    let found = worst(vec![
        moving(1, |t| bend(until(t, 10.0, -3.0, 5.0))),
        moving(2, |t| bend([14.0 + 5.0 * t, 5.0, 0.0])),
    ]);
    assert_eq!(
        (found.obstacle, found.grade),
        (2, Grade::Course),
        "{found:?}"
    );
    assert!(found.step <= 3, "{found:?}");
    // Straight on they do not touch at that time, and the words say so.
    let words = found.hazard.to_string();
    assert!(
        words.contains("at constant speed on their paths"),
        "{words}"
    );
}

/// One comes from the side and stands 6 m before the ego's way, as it brakes from the beginning on.
#[test]
fn who_brakes_to_a_stand_before_the_way_is_on_no_course() {
    let found = worst(vec![
        car(1, (0.0, 0.0), 0.0, 10.0, 0.0),
        moving(2, |t| {
            let [way, speed, acceleration] = until(t, 6.0, -1.5, 0.0);
            [30.0, -20.0 + way, FRAC_PI_2, speed, acceleration]
        }),
    ]);
    assert!(
        !matches!(
            found.grade,
            Grade::Contact | Grade::Conflict | Grade::NearMiss | Grade::Course | Grade::Ahead
        ),
        "{found:?}"
    );
    // With the same speed at first and no braking until it is near, it is on one.
    let late = |t: f64| {
        if t < 0.5 {
            [6.0 * t, 6.0, 0.0]
        } else {
            let [way, speed, acceleration] = until(t - 0.5, 6.0, -3.0, 0.0);
            [3.0 + way, speed, acceleration]
        }
    };
    let found = worst(vec![
        car(1, (0.0, 0.0), 0.0, 10.0, 0.0),
        moving(2, |t| {
            let [way, speed, acceleration] = late(t);
            [30.0, -20.0 + way, FRAC_PI_2, speed, acceleration]
        }),
    ]);
    assert_eq!(
        (found.obstacle, found.grade),
        (2, Grade::Conflict),
        "{found:?}"
    );
}

/// The recording does not tell where the one in front came from.
#[test]
fn who_is_ahead_round_a_bend_from_the_begin_does_not_cut_in() {
    let at = |metres: f64| {
        let (before, beyond) = (metres.min(15.0), (metres - 15.0).max(0.0));
        let heading = if beyond > 0.0 { 0.4 } else { 0.0 };
        let place = [before + beyond * f64::cos(0.4), beyond * f64::sin(0.4)];
        [place[0], place[1], heading, 10.0, 0.0]
    };
    let found = worst(vec![
        moving(1, |t| at(10.0 * t)),
        moving(2, |t| at(18.0 + 10.0 * t)),
    ]);
    assert_eq!(
        (found.obstacle, found.grade),
        (2, Grade::Following),
        "{found:?}"
    );
}

#[test]
fn who_stands_across_the_way_is_on_a_course_too() {
    for heading in [0.5, -0.5, 2.5, FRAC_PI_2] {
        let found = worst(vec![
            car(1, (0.0, 0.0), 0.0, 8.0, -2.0),
            parked_turned(2, (24.0, 1.0), heading),
        ]);
        assert_eq!(found.obstacle, 2, "{found:?}");
        assert!(matches!(found.hazard, Hazard::Course { .. }), "{found:?}");
    }
}
