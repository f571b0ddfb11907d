//! The map's tools: signs and lights, layers, tape, paths into the future, details, dragging.

use ratatui::layout::Position;

use super::bench::Bench;
use crate::action::Action;
use crate::features::details::DetailsScreen;
use crate::message::{Effect, Mouse, Msg};
use crate::model::{Foreseen, Measurement, On, Pane, Tape};
use crate::theme::{ColorDepth, Theme};

/// A bundled scenario with the map alone, at a step.
fn at(name: &str, step: i64) -> Bench {
    let mut bench = Bench::bundled();
    bench.press("/");
    bench.type_text(name);
    bench.press("enter");
    bench.model.focus = Pane::Map;
    bench.model.zoomed = true;
    bench.model.clock.go(step);
    bench.model.toasts.clear();
    bench
}

/// The tape and what it measures.
fn taped(bench: &Bench) -> (Tape, Measurement) {
    let tape = bench.model.map.tape.unwrap();
    (tape, bench.model.moment().unwrap().measured(&tape))
}

fn does(bench: &mut Bench, action: Action) {
    let key = crate::action::ACTIONS
        .iter()
        .find(|e| e.action == action)
        .and_then(|e| e.keys.first())
        .unwrap();
    bench.press(key);
}

/// Letters of lights stand alone between blanks or dots.
fn has_word(frame: &str, word: &str) -> bool {
    frame
        .split(|c: char| !c.is_ascii_alphanumeric())
        .any(|w| w == word)
}

#[test]
fn lights_change_with_the_step() {
    // By hand: of the ego's light the first phase begins at step 320 of a cycle of 360: 10 red and yellow, 150 green,
    // 30 yellow, 170 red. At step 0 it is 40 steps into the cycle before: green; it stays so until step 119.
    let mut bench = at("redlight", 0);
    let network = bench
        .model
        .opened
        .as_ref()
        .unwrap()
        .scenario
        .network
        .clone();
    let light = network.lights.iter().find(|l| l.id == 211).unwrap();
    assert_eq!((light.offset, light.cycle.len()), (320, 4));
    assert_eq!(
        light.color_at(0),
        nearmiss_scene::scenario::SignalColor::Green
    );
    assert_eq!(
        light.color_at(120),
        nearmiss_scene::scenario::SignalColor::Yellow
    );
    bench.model.clock.go(45);
    insta::assert_snapshot!(bench.frame(120, 40));
    let frame = bench.frame(120, 40);
    assert!(has_word(&frame, "G") && has_word(&frame, "R"), "{frame}");
    assert!(frame.contains("R A G lights"));
    bench.model.map.layers.lights = false;
    let frame = bench.frame(120, 40);
    assert!(!has_word(&frame, "G"), "{frame}");
}

#[test]
fn signs_are_read_where_there_is_room() {
    let mut bench = at("overtaking", 20);
    let sign = bench.model.opened.as_ref().unwrap().scenario.network.signs[0].clone();
    bench.model.camera.follow = false;
    bench.model.camera.center = sign.position.unwrap();
    insta::assert_snapshot!(bench.frame(100, 30));
    assert!(bench.frame(100, 30).contains("100 km/h"));
    bench.model.camera.cell = 1.5;
    let frame = bench.frame(100, 30);
    assert!(
        !frame.contains("km/h") && frame.contains("▫ sign"),
        "{frame}"
    );
    bench.model.map.layers.signs = false;
    assert!(!bench.frame(100, 30).contains('▫'));
}

#[test]
fn far_away_vehicles_are_arrows() {
    let mut bench = at("hardbraking", 10);
    bench.model.camera.cell = 3.0;
    bench.model.camera.auto = false;
    insta::assert_snapshot!(bench.frame(100, 30));
}

#[test]
fn paths_of_the_picked_one_then_of_all_then_of_nobody() {
    let mut bench = at("redlight", 40);
    bench.model.picked = Some(301);
    does(&mut bench, Action::NextPaths);
    bench.model.toasts.clear();
    assert_eq!(bench.model.map.layers.paths, Foreseen::Picked);
    let futures = &bench.model.map.foresight.futures;
    assert_eq!(futures.len(), 1);
    assert_eq!(futures[0].who, On::Obstacle(301));
    let total: f64 = futures[0].courses.iter().map(|c| c.0).sum();
    assert!(total > 0.8 && total <= 1.0 + 1e-9, "{total}");
    // Straight on: the recorded speed for two seconds.
    let motion = *bench
        .model
        .opened
        .as_ref()
        .unwrap()
        .motion_of(On::Obstacle(301), 40)
        .unwrap();
    let straight = &futures[0].straight;
    let length = (straight[straight.len() - 1] - straight[0]).norm();
    assert!((length - 2.0 * motion.velocity.abs()).abs() < 1e-9);
    let frame = bench.frame(120, 40);
    assert!(frame.contains("predicted 2 s"), "{frame}");
    let told = |c: &str| c.ends_with(|c: char| c.is_ascii_digit());
    let parts: Vec<&str> = frame.split('%').collect();
    assert!(parts[..parts.len() - 1].iter().any(|c| told(c)), "{frame}");
    insta::assert_snapshot!(frame);
    let first = bench.model.map.foresight.futures.clone();
    bench.press("right");
    assert_ne!(
        bench.model.map.foresight.futures, first,
        "it follows the clock"
    );
    does(&mut bench, Action::NextPaths);
    let futures = &bench.model.map.foresight.futures;
    assert!(futures.len() > 2 && futures[0].who == On::Ego);
    bench.model.toasts.clear();
    assert!(bench.frame(120, 40).contains("near the ego"));
    does(&mut bench, Action::NextPaths);
    assert!(bench.model.map.foresight.futures.is_empty());
    bench.model.toasts.clear();
    assert!(!bench.frame(120, 40).contains("predicted"));
}

#[test]
fn the_tape_measures_bodies_exactly_and_points_by_keys() {
    let mut bench = at("redlight", 30);
    bench.model.picked = Some(301);
    does(&mut bench, Action::TakeTape);
    bench.model.toasts.clear();
    let (tape, measured) = taped(&bench);
    assert_eq!(
        (tape.from.on, tape.to.on),
        (Some(On::Ego), Some(On::Obstacle(301)))
    );
    let opened = bench.model.opened.as_ref().unwrap();
    let series = opened.series.as_ref().unwrap();
    let exact = series.at("distance", 301, 30).value().unwrap();
    assert!((measured.gap.metres - exact).abs() < 1e-9);
    let speed = opened.motion_of(On::Ego, 30).unwrap().velocity;
    assert!((measured.seconds.unwrap() - exact / speed).abs() < 1e-9);
    let frame = bench.frame(120, 40);
    assert!(frame.contains("ego to 301"), "{frame}");
    insta::assert_snapshot!(frame);
    // It stays on the bodies when time goes on.
    bench.press("right");
    let series = bench.model.opened.as_ref().unwrap().series.as_ref();
    let exact = series.unwrap().at("distance", 301, 31).value().unwrap();
    assert!((taped(&bench).1.gap.metres - exact).abs() < 1e-9);
    // Two cells a key: off the body it measures to the point.
    let before = bench.model.map.tape.unwrap().to.point;
    for _ in 0..8 {
        bench.press("k");
    }
    let to = bench.model.map.tape.unwrap().to;
    let moved = (to.point - before).norm();
    assert!(
        (moved - 8.0 * bench.model.camera.row()).abs() < 1e-9,
        "{moved}"
    );
    assert!(to.on != Some(On::Obstacle(301)));
    bench.press("enter");
    let swapped = bench.model.map.tape.unwrap();
    assert_eq!(swapped.to.on, Some(On::Ego));
    bench.press("esc");
    assert!(bench.model.map.tape.is_none() && bench.model.zoomed);
}

#[test]
fn the_tape_is_pulled_with_the_mouse() {
    let mut bench = at("redlight", 30);
    does(&mut bench, Action::TakeTape);
    bench.frame(120, 40);
    let (from, to) = (Position::new(8, 4), Position::new(28, 4));
    bench.send(Msg::Mouse(Mouse::Press(from)));
    bench.send(Msg::Mouse(Mouse::Drag(to)));
    bench.send(Msg::Mouse(Mouse::Release(to)));
    let (tape, measured) = taped(&bench);
    // Twenty cells of the map in between, wherever they are in the world.
    assert_eq!((tape.from.on, tape.to.on), (None, None));
    let expected = 20.0 * bench.model.camera.cell;
    assert!(
        (measured.gap.metres - expected).abs() < 1e-9,
        "{measured:?}"
    );
}

#[test]
fn dragging_moves_the_map_and_a_click_picks() {
    let mut bench = at("redlight", 30);
    bench.frame(120, 40);
    bench.model.picked = Some(301);
    let (from, to) = (Position::new(8, 4), Position::new(18, 8));
    let (under, _) = bench.model.drawn.point_at(from).unwrap();
    bench.send(Msg::Mouse(Mouse::Press(from)));
    bench.send(Msg::Mouse(Mouse::Drag(Position::new(12, 6))));
    bench.send(Msg::Mouse(Mouse::Drag(to)));
    bench.send(Msg::Mouse(Mouse::Release(to)));
    bench.frame(120, 40);
    let (now, _) = bench.model.drawn.point_at(to).unwrap();
    assert!(
        (now - under).norm() < 1e-9,
        "what was taken is under the pointer"
    );
    assert_eq!(bench.model.picked, Some(301), "dragging picks no obstacle");
    bench.send(Msg::Mouse(Mouse::Press(from)));
    bench.send(Msg::Mouse(Mouse::Release(from)));
    assert_eq!(bench.model.picked, None, "there is no obstacle");
}

#[test]
fn the_wheel_zooms_about_the_pointer_while_the_ego_is_followed() {
    let mut bench = at("redlight", 30);
    bench.frame(120, 40);
    let at = Position::new(90, 10);
    let (before, _) = bench.model.drawn.point_at(at).unwrap();
    bench.send(Msg::Mouse(Mouse::WheelUp(at)));
    bench.frame(120, 40);
    let (after, _) = bench.model.drawn.point_at(at).unwrap();
    assert!(bench.model.camera.follow && (after - before).norm() < 1e-9);
}

#[test]
fn layers_are_switched_one_by_one() {
    let mut bench = at("redlight", 30);
    does(&mut bench, Action::Layers);
    insta::assert_snapshot!(bench.frame(80, 24));
    bench.press("down enter down enter");
    assert!(!bench.model.map.layers.signs && !bench.model.map.layers.lights);
    bench.press("enter down down enter");
    assert!(bench.model.map.layers.lights);
    assert_eq!(bench.model.map.layers.paths, Foreseen::Picked);
    bench.press("esc");
    assert!(bench.model.screens.is_empty());
}

#[test]
fn details_follow_the_clock_and_are_copied() {
    let mut bench = at("redlight", 30);
    bench.model.picked = Some(301);
    does(&mut bench, Action::Details);
    let frame = bench.frame(120, 40);
    insta::assert_snapshot!(frame);
    bench.press("right");
    let next = bench.frame(120, 40);
    assert!(next.contains("step 31") && frame.contains("step 30"));
    bench.press("y");
    let Some(Effect::Copy(text)) = bench.effects.last() else {
        panic!("nothing was copied");
    };
    assert!(text.contains("car 301") && text.contains("step 31") && text.contains("distance"));
    assert!(bench.model.screens.is_top::<DetailsScreen>());
    bench.press("esc");
    assert!(bench.model.screens.is_empty());
    bench.model.picked = None;
    does(&mut bench, Action::Details);
    assert!(bench.model.screens.is_empty());
}

#[test]
fn without_colour_everything_can_be_told_apart() {
    let mut bench = at("redlight", 45);
    bench.model.theme = Theme::default_theme().at_depth(ColorDepth::None);
    bench.model.picked = Some(301);
    does(&mut bench, Action::NextPaths);
    does(&mut bench, Action::TakeTape);
    bench.model.toasts.clear();
    let frame = bench.frame(120, 40);
    insta::assert_snapshot!(frame);
    let frame = bench.frame(200, 60);
    for sign in [
        "ego to 301",
        "predicted 2 s",
        "constant velocity",
        "R A G lights",
    ] {
        assert!(frame.contains(sign), "{sign}: {frame}");
    }
    assert!(has_word(&frame, "R") && has_word(&frame, "G"));
}

#[test]
fn no_tool_minds_a_missing_scenario_or_an_absurd_size() {
    for mut bench in [Bench::empty(), at("pedestrian", 3)] {
        let tools = [
            Action::NextPaths,
            Action::TakeTape,
            Action::SwapTape,
            Action::PanUp,
            Action::NextPaths,
            Action::Layers,
            Action::Details,
        ];
        bench.model.focus = Pane::Map;
        for action in tools {
            does(&mut bench, action);
            for size in [(1, 1), (3, 9), (80, 24), (81, 30), (200, 60), (300, 90)] {
                bench.frame(size.0, size.1);
            }
        }
        bench.press("esc esc");
    }
}

#[test]
fn regions_that_somebody_may_cover_are_areas_at_their_steps() {
    use nearmiss_base::geometry::Shape;
    use nearmiss_scene::scenario::{
        Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Occupancy, Prediction, Steps,
    };
    let mut bench = at("overtaking", 10);
    let opened = bench.model.opened.as_mut().unwrap();
    let ego = opened.motion_of(On::Ego, 10).unwrap().pose;
    let region = Shape::Rectangle {
        length: 14.0,
        width: 10.0,
        center: ego.position + ego.left() * 12.0,
        orientation: ego.heading,
        origin_x_shift: 0.0,
    };
    let parts = ObstacleParts {
        id: 77,
        role: ObstacleRole::Phantom,
        kind: ObstacleType::Unknown,
        footprint: None,
        initial: None,
        prediction: Prediction::Occupancies(vec![Occupancy {
            time: Steps { from: 8, to: 12 },
            region,
        }]),
        signals: Vec::new(),
    };
    let mut scenario = (*opened.scenario).clone();
    scenario.obstacles.push(Obstacle::new(parts, 0.1));
    opened.scenario = std::sync::Arc::new(scenario);
    let there = bench.frame(100, 30);
    insta::assert_snapshot!(there);
    bench.model.map.layers.occupancy = false;
    let hidden = bench.frame(100, 30);
    assert_ne!(there, hidden);
    bench.model.map.layers.occupancy = true;
    bench.model.clock.go(13);
    bench.model.camera.follow = false;
    bench.model.camera.center = ego.position;
    let after = bench.frame(100, 30);
    bench.model.map.layers.occupancy = false;
    assert_eq!(after, bench.frame(100, 30), "it is over");
    bench.model.picked = Some(77);
    bench.model.clock.go(10);
    does(&mut bench, Action::Details);
    assert!(bench.frame(200, 60).contains("given as regions"));
}

#[test]
fn the_goal_is_named_where_it_is_seen() {
    let mut bench = at("redlight", 40);
    let opened = bench.model.opened.as_ref().unwrap();
    let goal = opened.scenario.planning_problems[0].goals[0].clone();
    let lanelets = goal.lanelets();
    let network = &opened.scenario.network;
    let center = match lanelets.first() {
        Some(id) => {
            let points = &network.lanelet(*id).unwrap().left.points;
            points[points.len() / 2]
        }
        None => match &goal.positions[0] {
            nearmiss_scene::scenario::Position::Region(region) => region.outlines()[0][0],
            other => panic!("{other:?}"),
        },
    };
    bench.model.camera.follow = false;
    bench.model.camera.center = center;
    let frame = bench.frame(120, 40);
    assert!(frame.contains("goal"), "{frame}");
    insta::assert_snapshot!(frame);
    bench.model.map.layers.goal = false;
    assert!(!bench.frame(120, 40).contains("goal"));
}
