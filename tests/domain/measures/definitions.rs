//! Definitions on made-up roads, where the values can be worked out by hand.

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss::geometry::{Footprint, Point, Shape};
use nearmiss::judge::judge;
use nearmiss::metrics::{Context, Headline, NoValue, Reading, Thresholds, measure};
use nearmiss::scenario::*;
use nearmiss::verdict::Task;

/// A straight road along x with two lanes: lanelet 1 at −1.75 < y < 1.75, lanelet 2 on its left.
fn network() -> LaneletNetwork {
    let lanelet = |id: i64, right: f64| {
        let bound = |y: f64| Bound {
            points: (0..=50)
                .map(|i| Point::new(f64::from(i) * 10.0 - 100.0, y))
                .collect(),
            heights: Vec::new(),
            marking: LineMarking::Dashed,
        };
        let neighbour = |id| Adjacent {
            id,
            same_direction: true,
        };
        Lanelet {
            id,
            left: bound(right + 3.5),
            right: bound(right),
            predecessors: Vec::new(),
            successors: Vec::new(),
            adjacent_left: (id == 1).then(|| neighbour(2)),
            adjacent_right: (id == 2).then(|| neighbour(1)),
            stop_line: None,
            types: Vec::new(),
            users_one_way: Vec::new(),
            users_bidirectional: Vec::new(),
            signs: Vec::new(),
            lights: Vec::new(),
        }
    };
    LaneletNetwork::new(
        vec![lanelet(1, -1.75), lanelet(2, 1.75)],
        vec![],
        vec![],
        vec![],
    )
}

/// A car of 4 m × 2 m from (x, y) at a heading, with constant velocity and acceleration, for 10 s.
pub fn car(id: i64, at: (f64, f64), heading: f64, v: f64, a: f64) -> Obstacle {
    car_every(0.1, id, at, heading, v, a)
}

/// The same with a state every `dt` seconds.
fn car_every(dt: f64, id: i64, (x, y): (f64, f64), heading: f64, v: f64, a: f64) -> Obstacle {
    moving_every(dt, 0, id, |t| {
        let way = v * t + a * t * t / 2.0;
        let (sin, cos) = heading.sin_cos();
        [x + way * cos, y + way * sin, heading, v + a * t, a]
    })
}

/// A car of 4 m × 2 m for 10 s; `at` gives place, heading, velocity and acceleration after so many seconds.
pub fn moving(id: i64, at: impl Fn(f64) -> [f64; 5]) -> Obstacle {
    moving_every(0.1, 0, id, at)
}

/// The same with a state every `dt` seconds, from step `first` on.
pub fn moving_every(dt: f64, first: i64, id: i64, at: impl Fn(f64) -> [f64; 5]) -> Obstacle {
    let state = |step: i64| {
        let [x, y, heading, velocity, acceleration] = at(step as f64 * dt);
        State {
            position: Some(Position::Point(Point::new(x, y))),
            orientation: Some(Quantity::Exact(heading)),
            velocity: Some(Quantity::Exact(velocity)),
            acceleration: Some(Quantity::Exact(acceleration)),
            ..State::at(Steps::exact(step))
        }
    };
    let last = (10.0 / dt) as i64;
    let parts = ObstacleParts {
        id,
        role: ObstacleRole::Dynamic,
        kind: ObstacleType::Car,
        footprint: Some(Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap()),
        initial: Some(state(first)),
        prediction: Prediction::Trajectory((first + 1..=last).map(state).collect()),
        signals: Vec::new(),
    };
    Obstacle::new(parts, dt)
}

/// The ego is obstacle 1.
pub fn scene(obstacles: Vec<Obstacle>) -> Scene {
    scene_every(0.1, obstacles)
}

/// The same with steps of `dt` seconds.
fn scene_every(dt: f64, obstacles: Vec<Obstacle>) -> Scene {
    let scenario = Scenario {
        header: Header {
            other_format: None,
            benchmark_id: "ZAM_Test-1_1_T-1".into(),
            version: "2020a".into(),
            time_step_size: dt,
            attributes: BTreeMap::new(),
        },
        location: None,
        tags: Vec::new(),
        network: network(),
        obstacles,
        planning_problems: Vec::new(),
        diagnostics: Vec::new(),
        recorded_ego: None,
        hash: ContentHash::digest(b""),
    };
    Scene::with_obstacle_as_ego(Arc::new(scenario), 1).unwrap()
}

fn reading(scene: &Scene, id: &str, obstacle: i64, step: i64) -> Reading {
    let context = Context::new(scene);
    let place = context
        .participants()
        .iter()
        .position(|p| p.obstacle.id == obstacle);
    measure(id)
        .unwrap()
        .compute(&context.encounter(place.unwrap(), step).unwrap())
}

#[track_caller]
fn is(scene: &Scene, id: &str, expected: f64) {
    let found = reading(scene, id, 2, 0);
    let value = found.value().unwrap_or_else(|| panic!("{id}: {found:?}"));
    assert!(
        (value - expected).abs() < 1e-5,
        "{id}: {value} instead of {expected}"
    );
}

#[track_caller]
fn is_none(scene: &Scene, id: &str, expected: NoValue) {
    assert_eq!(reading(scene, id, 2, 0), Reading::None(expected), "{id}");
}

#[test]
fn following_a_slower_car() {
    // Gap 36 m, closing with 5 m/s, the one ahead braking with 1 m/s².
    let scene = scene(vec![
        car(1, (0.0, 0.0), 0.0, 15.0, 0.0),
        car(2, (40.0, 0.5), 0.0, 10.0, -1.0),
    ]);
    is(&scene, "headway", 36.0);
    is(&scene, "time_gap", 36.0 / 15.0);
    is(&scene, "thw", 2.4);
    let time = (25.0_f64 + 72.0).sqrt() - 5.0;
    is(&scene, "ttc_lane", time);
    is(&scene, "a_long_req", -1.0 - 25.0 / 72.0);
    is(&scene, "btn", (1.0 + 25.0 / 72.0) / 11.5);
    is(&scene, "drac", 25.0 / 72.0);
    // To the right 1.5 m are missing: half of both widths less the offset.
    is(&scene, "a_lat_req", 2.0 * 1.5 / (time * time));
    is(&scene, "stn", 2.0 * 1.5 / (time * time) / 8.0);
    is(
        &scene,
        "rss_long",
        15.0 + 1.75 + 18.5 * 18.5 / 8.0 - 100.0 / 16.0,
    );
    is(&scene, "rss_lat", 0.1 + 2.0 * 0.125);
    is(&scene, "rss_lat_margin", -0.35);
    // Both are violated, the lateral one less: 36 m are 17.28 m less than is safe along the road.
    is(&scene, "rss_margin", -0.35);
}

#[test]
fn rss_is_violated_only_along_and_across() {
    let margin = |place| {
        let scene = scene(vec![
            car(1, (0.0, 0.0), 0.0, 15.0, 0.0),
            car(2, place, 0.0, 10.0, 0.0),
        ]);
        reading(&scene, "rss_margin", 2, 0).value().unwrap()
    };
    // Asked for: 15 + 1.75 + 18.5²/8 − 100/16 = 53.28125 m along and 0.35 m across.
    assert!((margin((24.0, 0.0)) - -0.35).abs() < 1e-9, "both too short");
    assert!((margin((24.0, 3.0)) - 0.65).abs() < 1e-9, "beside");
    assert!(
        (margin((64.0, 0.0)) - (60.0 - 53.28125)).abs() < 1e-9,
        "far ahead"
    );
}

#[test]
fn the_recorded_collision() {
    let scene = scene(vec![
        car(1, (0.0, 0.0), 0.0, 10.0, 0.0),
        car(2, (44.5, 0.0), 0.0, 0.0, 0.0),
    ]);
    // The front is at the rear after 4.05 s, between two steps.
    is(&scene, "ttc_star", 4.05);
    is(&scene, "dce", 0.0);
    is(&scene, "ttce", 4.05);
    is(&scene, "contact_speed", 10.0);
    is(&scene, "ttc_lane", 4.05);
    // Braking takes 100/16 = 6.25 m, which are left until 3.4 s.
    is(&scene, "ttb", 3.4);
    is_none(&scene, "ttk", NoValue::NeverAvoided);
    is(&scene, "tet", 2.0);
    let steps = (21..=40).map(|i| 2.0 - (4.05 - 0.1 * f64::from(i)));
    is(&scene, "tit", 0.1 * steps.sum::<f64>());
    is_none(&scene, "pet", NoValue::NoConflictArea);
    assert_eq!(
        reading(&scene, "ttb", 2, 35),
        Reading::None(NoValue::TooLate)
    );
    assert_eq!(
        reading(&scene, "headway", 2, 45),
        Reading::None(NoValue::Contact)
    );
    assert_eq!(reading(&scene, "ttc_lane", 2, 45), Reading::Value(0.0));
    let context = Context::new(&scene);
    let contact = context.contacts(0)[0];
    assert!((contact.time - 4.05).abs() < 1e-6 && contact.step == 41 && contact.overlaps);
    assert!((contact.ego.position.x - 40.5).abs() < 1e-5);
}

#[test]
fn crossing_one_after_the_other() {
    // The area is 49 < x < 51 (the other is 2 m wide) by −1 < y < 1. The ego's front is at 49 after 4.7 s, its
    // rear leaves 51 after 5.3 s; the other's front is at −1 after 6.705 s, between two steps: 70.05 − 2 − 1 = 67.05 m.
    let up = std::f64::consts::FRAC_PI_2;
    let scene = scene(vec![
        car(1, (0.0, 0.0), 0.0, 10.0, 0.0),
        car(2, (50.0, -70.05), up, 10.0, 0.0),
    ]);
    is(&scene, "et", 5.3 - 4.7);
    is(&scene, "pet", 6.705 - 5.3);
    is_none(&scene, "ttc_star", NoValue::NoRecordedOverlap);
    is_none(&scene, "headway", NoValue::OtherLane);
}

#[test]
fn reasons_along_the_road() {
    let with = |place, heading, v| {
        scene(vec![
            car(1, (0.0, 0.0), 0.0, 10.0, 0.0),
            car(2, place, heading, v, 0.0),
        ])
    };
    is_none(&with((30.0, 3.5), 0.0, 5.0), "headway", NoValue::OtherLane);
    is(&with((30.0, 2.0), 0.0, 5.0), "headway", 26.0);
    is_none(&with((-30.0, 0.0), 0.0, 5.0), "ttc_lane", NoValue::Behind);
    is_none(&with((2.0, 2.5), 0.0, 5.0), "ttc_lane", NoValue::Beside);
    is_none(
        &with((30.0, 0.0), 0.0, 12.0),
        "ttc_lane",
        NoValue::NotApproaching,
    );
    is_none(
        &with((30.0, 0.0), 0.0, 12.0),
        "drac",
        NoValue::NotApproaching,
    );
    // Oncoming in the ego's lane.
    is(
        &with((30.0, 0.0), std::f64::consts::PI, 5.0),
        "ttc_lane",
        26.0 / 15.0,
    );
    let mut bare = with((30.0, 0.0), 0.0, 5.0);
    Arc::make_mut(&mut bare.scenario).network = LaneletNetwork::default();
    is_none(&bare, "ttc_lane", NoValue::NoRoute);
    is_none(&bare, "rss_long", NoValue::NoRoute);
    is(&bare, "ttc", 26.0 / 5.0);
}

/// Steps at which public recordings are: of most data sets, of slow ones, of SUMO where nothing else is asked for.
const STEPS: [f64; 4] = [0.1, 0.2, 0.5, 1.0];

const UP: f64 = std::f64::consts::FRAC_PI_2;

#[test]
fn times_of_the_conflict_area_do_not_depend_on_the_step() {
    // As in `crossing_one_after_the_other`, with 13 and 11 m/s: no edge is reached at a step.
    for dt in STEPS {
        let scene = scene_every(
            dt,
            vec![
                car_every(dt, 1, (0.0, 0.0), 0.0, 13.0, 0.0),
                car_every(dt, 2, (50.0, -70.05), UP, 11.0, 0.0),
            ],
        );
        is(&scene, "et", 6.0 / 13.0);
        is(&scene, "pet", 67.05 / 11.0 - 53.0 / 13.0);
    }
}

#[test]
fn bodies_that_meet_between_two_steps_collide() {
    // Both centres are at (33, 0) after 3.3 s; the fronts touch the sides 0.3 s before, at a relative √200 m/s.
    for dt in STEPS {
        let scene = scene_every(
            dt,
            vec![
                car_every(dt, 1, (0.0, 0.0), 0.0, 10.0, 0.0),
                car_every(dt, 2, (33.0, -33.0), UP, 10.0, 0.0),
            ],
        );
        is(&scene, "ttc_star", 3.0);
        is(&scene, "contact_speed", 200.0_f64.sqrt());
        is(&scene, "dce", 0.0);
        let step = (3.0 / dt - 1e-6).ceil() as i64;
        assert_eq!(reading(&scene, "risk", 2, step), Reading::Value(0.0));
        let headline = Headline::compute(&scene, Thresholds::shipped());
        let contact = headline.contact.unwrap();
        assert!(headline.collides() && contact.step == step, "{contact:?}");
        assert_eq!(headline.worst().unwrap().step, step);
        let window = Window::full(&scene);
        for task in [Task::Collision, Task::Recording] {
            let judgement = judge(&scene, task, &window);
            assert!(judgement.verdict.dangerous, "{dt}: {}", judgement.reasoning);
            assert_eq!(judgement.decisive_step, Some(step));
        }
    }
    // 30 m a step: at the steps they are 24 and 36 m apart.
    let scene = scene_every(
        1.0,
        vec![
            car_every(1.0, 1, (0.0, 0.0), 0.0, 15.0, 0.0),
            car_every(1.0, 2, (75.0, 0.0), std::f64::consts::PI, 15.0, 0.0),
        ],
    );
    let verdict = judge(&scene, Task::Collision, &Window::full(&scene)).verdict;
    assert_eq!(
        verdict.justification,
        "The body of car 2 touches the ego's between steps 2 and 3, at 2.37 s."
    );
    is(&scene, "contact_speed", 30.0);
}

/// Braking makes uncertain where the body is between two steps, not whether it passes through who stands in its way.
#[test]
fn who_brakes_passes_through_nobody_unnoticed() {
    for (aside, collides) in [(0.0, true), (1.5, true), (2.5, false)] {
        let scene = scene_every(
            1.0,
            vec![
                // At 0, 26 and 44 m.
                car_every(1.0, 1, (0.0, 0.0), 0.0, 30.0, -8.0),
                car_every(1.0, 2, (35.0, aside), 0.0, 0.0, 0.0),
            ],
        );
        let headline = Headline::compute(&scene, Thresholds::shipped());
        assert_eq!(headline.collides(), collides, "{aside} m aside");
        let verdict = judge(&scene, Task::Collision, &Window::full(&scene)).verdict;
        assert_eq!(verdict.dangerous, collides, "{aside} m aside");
    }
}

/// A truck that turns in place by a quarter between two steps sweeps over who stands beside it, and over nobody further off.
#[test]
fn who_turns_passes_through_nobody_unnoticed() {
    let standing = |id: i64, at: (f64, f64), length: f64, turns: bool| {
        let state = |step: i64| State {
            position: Some(Position::Point(Point::new(at.0, at.1))),
            orientation: Some(Quantity::Exact(if turns && step >= 5 { UP } else { 0.0 })),
            velocity: Some(Quantity::Exact(0.0)),
            ..State::at(Steps::exact(step))
        };
        let parts = ObstacleParts {
            id,
            role: ObstacleRole::Dynamic,
            kind: ObstacleType::Unknown,
            footprint: Some(Footprint::new(Shape::rectangle(length, length.min(2.5))).unwrap()),
            initial: Some(state(0)),
            prediction: Prediction::Trajectory((1..=10).map(state).collect()),
            signals: Vec::new(),
        };
        Obstacle::new(parts, 1.0)
    };
    for (at, collides) in [(3.0, true), (4.5, false)] {
        let scene = scene_every(
            1.0,
            vec![
                standing(1, (0.0, 0.0), 12.0, true),
                standing(2, (at, at), 0.5, false),
            ],
        );
        let headline = Headline::compute(&scene, Thresholds::shipped());
        assert_eq!(headline.collides(), collides, "{at} m beside and before");
        assert!(
            headline
                .contact
                .is_none_or(|contact| contact.step == 5 && !contact.overlaps)
        );
    }
}

#[test]
fn the_time_to_collision_of_overlapping_bodies_is_zero() {
    for v in [0.0, 9.0, 10.0, 11.0] {
        let scene = scene(vec![
            car(1, (0.0, 0.0), 0.0, 10.0, 0.0),
            car(2, (3.0, 0.5), 0.0, v, 0.0),
        ]);
        is(&scene, "ttc", 0.0);
        is(&scene, "ttc_lane", 0.0);
        is(&scene, "ttc_star", 0.0);
        is(&scene, "ttce", 0.0);
        is(&scene, "contact_speed", (10.0_f64 - v).abs());
        is_none(&scene, "drac", NoValue::Contact);
    }
}

#[test]
fn a_jump_touches_nothing_on_its_way() {
    let mut jumps = car(2, (20.0, -80.0), UP, 0.0, 0.0);
    let Prediction::Trajectory(mut states) = jumps.prediction.clone() else {
        unreachable!("cars have trajectories")
    };
    for state in states.iter_mut().skip(19) {
        state.position = Some(Position::Point(Point::new(20.0, 80.0)));
    }
    let parts = ObstacleParts {
        id: 2,
        role: jumps.role,
        kind: jumps.kind,
        footprint: jumps.footprint.clone(),
        initial: jumps.initial.take(),
        prediction: Prediction::Trajectory(states),
        signals: Vec::new(),
    };
    let ego = car(1, (0.0, 0.0), 0.0, 10.0, 0.0);
    let scene = scene(vec![ego, Obstacle::new(parts, 0.1)]);
    is_none(&scene, "ttc_star", NoValue::NoRecordedOverlap);
    is_none(&scene, "contact_speed", NoValue::NeverTouched);
    is_none(&scene, "pet", NoValue::NoConflictArea);
}
