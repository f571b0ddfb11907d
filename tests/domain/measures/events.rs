//! Events of made-up scenes whose parameters are known, with and without lanes, moved and mirrored.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use nearmiss::corpus::{Event, EventKind, IndexOptions, Parameter, events, for_each_window};
use nearmiss::formats::{bundled, commonroad};
use nearmiss::metrics::Thresholds;
use nearmiss::scenario::{Scenario, Scene};

use super::scenes::opened;
use super::transform::Move;

/// Where a car is after some seconds: x, y and speed along x.
type Drive<'a> = (i64, &'a dyn Fn(f64) -> (f64, f64, f64));

/// Cars of 4 m × 2 m for 10 s, on two lanes along x, the right one with y from −1.75 to 1.75; or without lanes.
fn scenario(cars: &[Drive<'_>], has_lanes: bool) -> Arc<Scenario> {
    let border = |name: &str, y: f64| {
        let points = (-10..60).map(|i| format!("<point><x>{}</x><y>{y}</y></point>", 10 * i));
        format!("<{name}>{}</{name}>", points.collect::<String>())
    };
    let lanelet = |id: i64, right: f64, side: &str, other: i64| {
        format!(
            "<lanelet id=\"{id}\">{}{}<{side} ref=\"{other}\" drivingDir=\"same\"/></lanelet>",
            border("leftBound", right + 3.5),
            border("rightBound", right)
        )
    };
    let car = |(id, drive): &Drive<'_>| {
        let state = |step: i32| {
            let at = |seconds: f64| drive(seconds);
            let time = f64::from(step) / 10.0;
            let ((x, y, speed), (before, after)) = (at(time), (at(time - 0.05), at(time + 0.05)));
            let heading = (after.1 - before.1).atan2(after.0 - before.0);
            let tag = if step == 0 { "initialState" } else { "state" };
            format!(
                "<{tag}><position><point><x>{x}</x><y>{y}</y></point></position><orientation><exact>{heading}</exact>\
                 </orientation><time><exact>{step}</exact></time><velocity><exact>{speed}</exact></velocity></{tag}>"
            )
        };
        format!(
            "<dynamicObstacle id=\"{id}\"><type>car</type><shape><rectangle><length>4</length><width>2</width></rectangle>\
             </shape>{}<trajectory>{}</trajectory></dynamicObstacle>",
            state(0),
            (1..=100).map(state).collect::<String>()
        )
    };
    let lanes = lanelet(1, -1.75, "adjacentLeft", 2) + &lanelet(2, 1.75, "adjacentRight", 1);
    let xml = format!(
        "<commonRoad timeStepSize=\"0.1\" commonRoadVersion=\"2020a\" benchmarkID=\"ZAM_Events-1_1_T-1\" author=\"\" \
         affiliation=\"\" source=\"\" date=\"2024-01-01\">{}{}</commonRoad>",
        if has_lanes { &lanes } else { "" },
        cars.iter().map(car).collect::<String>()
    );
    Arc::new(commonroad::read(xml.as_bytes(), "made.xml").unwrap())
}

fn of(scenario: &Arc<Scenario>, ego: i64) -> Vec<Event> {
    let scene = Scene::with_obstacle_as_ego(Arc::clone(scenario), ego).unwrap();
    events(&scene, 100.0)
}

fn kinds(events: &[Event]) -> Vec<(EventKind, i64)> {
    events.iter().map(|e| (e.manoeuvre, e.obstacle)).collect()
}

/// From `from` to `to` with 1 m/s, from `start` seconds on.
fn across(from: f64, to: f64, start: f64) -> impl Fn(f64) -> f64 {
    move |t| from + (to - from).signum() * (t - start).clamp(0.0, (to - from).abs())
}

fn even(x: f64, y: f64, v: f64) -> impl Fn(f64) -> (f64, f64, f64) {
    move |t| (x + v * t, y, v)
}

/// A car ahead changes into the lane of a faster one with 1 m/s, from 3.5 m on its left at 3 s. It heads 3.8° to the right, so that
/// its front is 1.131 m to the right of its centre: in the lane after 0.62 s, its centre after 1.75 s.
#[test]
fn a_cut_in_is_one_event_with_these_parameters() {
    let lateral = across(3.5, 0.0, 3.0);
    let cuts_in = |t: f64| (40.0 + 15.0 * t, lateral(t), 15.0);
    for has_lanes in [true, false] {
        let scenario = scenario(&[(10, &even(0.0, 0.0, 17.0)), (11, &cuts_in)], has_lanes);
        let found = of(&scenario, 10);
        assert_eq!(kinds(&found), [(EventKind::CutIn, 11)], "{found:?}");
        let event = &found[0];
        assert_eq!((event.first_step, event.last_step), (37, 48), "{has_lanes}");
        let is = |parameter: Parameter, wanted: f64, off: f64| {
            let value = parameter.of(event).unwrap();
            assert!((value - wanted).abs() < off, "{parameter:?}: {value}");
        };
        // 40 − 2·3.7 between centres, 2 m of the ego, 2.062 m of the turned other.
        is(Parameter::Gap, 28.538, 0.01);
        is(
            Parameter::Closing,
            17.0 - 15.0 * 15.0 / 226.0_f64.sqrt(),
            0.01,
        );
        is(Parameter::LateralSpeed, 1.0, 0.02);
        is(Parameter::EgoSpeed, 17.0, 1e-9);
        assert_eq!(event.deceleration, None);
        // Who is ahead sees nothing.
        assert_eq!(of(&scenario, 11), []);
    }
}

#[test]
fn who_changes_lanes_behind_another_or_is_reached_by_the_ego_cuts_nobody_in() {
    let lateral = across(3.5, 0.0, 3.0);
    let changes = |t: f64| (60.0 + 15.0 * t, lateral(t), 15.0);
    let mine = across(3.5, 0.0, 3.0);
    let ego = |t: f64| (15.0 * t, mine(t), 15.0);
    for has_lanes in [true, false] {
        let between = [
            (10, &even(0.0, 0.0, 15.0) as &dyn Fn(f64) -> _),
            (11, &changes),
            (12, &even(30.0, 0.0, 15.0)),
        ];
        let found = scenario(&between, has_lanes);
        assert_eq!(of(&found, 10), [], "12 is between them");
        assert_eq!(kinds(&of(&found, 12)), [(EventKind::CutIn, 11)]);
        let own = scenario(&[(10, &ego), (11, &even(30.0, 0.0, 15.0))], has_lanes);
        assert_eq!(of(&own, 10), [], "the ego changes lanes");
    }
}

/// Over the border and back, with the body in the lane all the time, is one cut-in.
#[test]
fn who_sways_on_the_border_cuts_in_once() {
    let comes = across(3.5, 1.7, 3.0);
    let lateral = |t: f64| comes(t) - 0.3 * (1.5 * (t - 4.8).max(0.0)).sin();
    let sways = |t: f64| (40.0 + 15.0 * t, lateral(t), 15.0);
    let scenario = scenario(&[(10, &even(0.0, 0.0, 15.0)), (11, &sways)], true);
    let found = kinds(&of(&scenario, 10));
    let cut_ins = found.iter().filter(|(kind, _)| *kind == EventKind::CutIn);
    assert_eq!(cut_ins.count(), 1, "{found:?}");
}

/// The one ahead leaves for the left with 1 m/s from 3 s on: its right side is out at 2.75 s after that. A slower one is beyond it.
#[test]
fn a_cut_out_has_the_gap_to_what_it_uncovers() {
    let lateral = across(0.0, 3.5, 3.0);
    let leaves = |t: f64| (30.0 + 15.0 * t, lateral(t), 15.0);
    for has_lanes in [true, false] {
        let cars = [
            (10, &even(0.0, 0.0, 15.0) as &dyn Fn(f64) -> _),
            (11, &leaves),
            (12, &even(100.0, 0.0, 5.0)),
        ];
        let found = of(&scenario(&cars, has_lanes), 10);
        assert_eq!(kinds(&found), [(EventKind::CutOut, 11)], "{has_lanes}");
        assert!((57..=59).contains(&found[0].first_step), "{found:?}");
        let seconds = found[0].first_step as f64 / 10.0;
        let gap = found[0].gap.unwrap();
        assert!((gap - (96.0 - 10.0 * seconds)).abs() < 1e-6, "{gap}");
        assert!((found[0].closing.unwrap() - 10.0).abs() < 1e-6);
        assert!((found[0].lateral_speed.unwrap() - 1.0).abs() < 0.02);
    }
}

/// From 20 m/s with 4 m/s² for 2 s, and later with 2 m/s² for 2 s.
#[test]
fn each_braking_of_the_one_ahead_is_an_event() {
    let brakes = |t: f64| {
        let (a, b) = ((t - 2.0).clamp(0.0, 2.0), (t - 7.0).clamp(0.0, 2.0));
        let after = |start: f64, length: f64| (t - start - length).max(0.0);
        let lost = 4.0 * (a * a / 2.0 + 2.0 * after(2.0, 2.0))
            + 2.0 * (b * b / 2.0 + 2.0 * after(7.0, 2.0));
        (34.0 + 20.0 * t - lost, 0.0, 20.0 - 4.0 * a - 2.0 * b)
    };
    for has_lanes in [true, false] {
        let found = of(
            &scenario(&[(10, &even(0.0, 0.0, 12.0)), (11, &brakes)], has_lanes),
            10,
        );
        assert_eq!(kinds(&found), [(EventKind::Braking, 11); 2]);
        for (event, most, begins) in [(&found[0], 4.0, 20), (&found[1], 2.0, 70)] {
            assert!((event.first_step - begins).abs() <= 2, "{event:?}");
            let value = |parameter: Parameter| parameter.of(event).unwrap();
            assert!((value(Parameter::Deceleration) - most).abs() < 1e-6);
            assert!((value(Parameter::MeanDeceleration) - most).abs() < 0.1 * most);
            assert!((value(Parameter::EgoSpeed) - 12.0).abs() < 1e-9);
        }
        let value = |parameter: Parameter| parameter.of(&found[0]).unwrap();
        assert!((value(Parameter::Closing) + 8.0).abs() < 0.5);
        assert!((value(Parameter::Gap) - 46.0).abs() < 1.5);
    }
}

#[test]
fn egos_drive_so_long_and_so_far() {
    let drive = even(0.0, 0.0, 15.0);
    let scenario = scenario(
        &[
            (10, &drive),
            (11, &even(30.0, 3.5, 5.0)),
            (12, &even(60.0, 0.0, 0.0)),
        ],
        true,
    );
    let options = IndexOptions {
        length: 2.0,
        stride: 1.0,
        radius: 50.0,
        measures: Vec::new(),
    };
    let driven = for_each_window(&scenario, None, &options, Thresholds::shipped(), &mut drop);
    assert_eq!(
        (driven.recorded.egos, driven.obstacles.egos),
        (0, 2),
        "one stands"
    );
    assert!((driven.obstacles.seconds - 20.0).abs() < 1e-9);
    assert!((driven.obstacles.metres - 200.0).abs() < 2.0, "{driven:?}");
}

const MOVES: [Move; 5] = [
    Move {
        angle: 0.7,
        ..Move::NONE
    },
    Move {
        shift: (-100_000.0, 30_000.0),
        ..Move::NONE
    },
    Move {
        mirror: true,
        ..Move::NONE
    },
    Move {
        angle: PI,
        steps: -37,
        ..Move::NONE
    },
    Move {
        mirror: true,
        angle: -FRAC_PI_2,
        shift: (5_000.0, 1.0),
        steps: 12,
    },
];

#[test]
fn moved_and_mirrored_scenes_have_the_same_events() {
    let lateral = across(3.5, 0.0, 3.0);
    let cuts_in = |t: f64| (40.0 + 15.0 * t, lateral(t), 15.0);
    let made = [true, false].map(|has_lanes| {
        let scenario = scenario(&[(10, &even(0.0, 0.0, 17.0)), (11, &cuts_in)], has_lanes);
        Scene::with_obstacle_as_ego(scenario, 10).unwrap()
    });
    let scenes = bundled()
        .iter()
        .filter_map(opened)
        .chain(made)
        .collect::<Vec<_>>();
    let mut count = 0;
    for scene in &scenes {
        let before = events(scene, 50.0);
        count += before.len();
        for by in &MOVES {
            let after = events(&by.scene(scene), 50.0);
            assert_eq!(kinds(&after), kinds(&before), "{by:?}");
            for (a, b) in before.iter().zip(&after) {
                let ends = |of: &Event, more| [of.first_step + more, of.last_step + more];
                assert_eq!(ends(b, 0), ends(a, by.steps), "{by:?}");
                for parameter in Parameter::ALL {
                    let (a, b) = (parameter.of(a), parameter.of(b));
                    let same = match (a, b) {
                        (Some(a), Some(b)) => (a - b).abs() < 1e-6,
                        (a, b) => a == b,
                    };
                    assert!(same, "{a:?} became {b:?} by {by:?}");
                }
            }
        }
    }
    assert!(count >= 4, "{count}");
}
