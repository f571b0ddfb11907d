//! The map and its tools, and the filter of the list.

use std::time::Duration;

use nearmiss_scene::verdict::Task;
use ratatui::layout::Position;

use crate::action::{ACTIONS, Action};
use crate::features::details::DetailsScreen;
use crate::features::scenarios::request::{Find, Found};
use crate::message::{Effect, Mouse, Msg};
use crate::model::{Foreseen, Measurement, On, Pane, Tape};
use crate::tests::bench::Bench;
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
    bench.model.camera.cell = 0.5;
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
    let (from, to) = (Position::new(8, 3), Position::new(28, 3));
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

#[test]
fn arrows_step_and_stop_at_the_ends() {
    let mut bench = Bench::bundled();
    bench.press("home right right left");
    assert_eq!(bench.model.clock.step(), 1);
    bench.press("left left left");
    assert_eq!(bench.model.clock.step(), 0);
    bench.press("end right shift-right");
    assert_eq!(bench.model.clock.step(), bench.model.clock.range().1);
}

#[test]
fn space_plays_in_real_time() {
    let mut bench = Bench::bundled();
    bench.press("home p");
    assert!(bench.model.moves());
    bench.send(Msg::Passed(Duration::from_millis(320)));
    assert_eq!(bench.model.clock.step(), 3);
    bench.press("p");
    bench.send(Msg::Passed(Duration::from_secs(9)));
    assert_eq!(bench.model.clock.step(), 3, "paused");
}

#[test]
fn x_goes_to_the_contact_and_picks_who_it_is() {
    let mut bench = Bench::bundled();
    bench.press("x");
    let decisive = bench
        .model
        .answers
        .reference
        .as_ref()
        .unwrap()
        .decisive_step;
    assert_eq!(Some(bench.model.clock.step()), decisive);
    assert_eq!(bench.model.picked, Some(301));
}

#[test]
fn the_filter_narrows_as_one_types_and_opens_the_best_match() {
    let mut bench = Bench::bundled();
    bench.press("/");
    bench.type_text("merge");
    assert_eq!(bench.model.list.visible.len(), 1);
    bench.send(Msg::Passed(Duration::from_secs(1)));
    assert_eq!(
        bench.model.opened.as_ref().unwrap().name,
        "ZAM_Merge-1_1_T-1"
    );
    bench.press("enter");
    bench.press("home right");
    assert_eq!(bench.model.clock.step(), 1, "keys act again");
    bench.press("esc");
    assert_eq!(bench.model.list.visible.len(), 8);
    assert_eq!(
        bench.model.opened.as_ref().unwrap().name,
        "ZAM_Merge-1_1_T-1",
        "what is open stays"
    );
}

#[test]
fn the_safety_task_follows_the_step() {
    let mut bench = Bench::bundled();
    bench.press("space a t home");
    assert_eq!(bench.model.task, Task::Safety);
    assert!(
        !bench
            .model
            .answers
            .reference
            .as_ref()
            .unwrap()
            .verdict
            .dangerous
    );
    bench.press("x left left");
    assert!(
        bench
            .model
            .answers
            .reference
            .as_ref()
            .unwrap()
            .verdict
            .dangerous
    );
    let last = bench
        .model
        .prompt
        .question
        .as_ref()
        .unwrap()
        .case
        .window
        .last();
    assert_eq!(last, bench.model.clock.step());
}

#[test]
fn the_map_zooms_pans_follows_and_fits() {
    let mut bench = Bench::bundled();
    bench.frame(120, 40);
    bench.send(Msg::Resize(120, 40));
    let before = bench.model.camera.clone();
    bench.press("+");
    assert!(bench.model.camera.cell < before.cell);
    bench.model.focus = Pane::Map;
    bench.press("l k");
    assert!(!bench.model.camera.follow);
    bench.press("space m f");
    assert!(bench.model.camera.follow);
    bench.press("space m a");
    assert!(bench.model.camera.cell > before.cell && !bench.model.camera.follow);
}

#[test]
fn until_the_user_zooms_the_map_shows_the_ego_and_the_picked_one() {
    let mut shown = 0;
    for (columns, rows) in [(41_u16, 13_u16), (78, 32), (198, 48)] {
        let mut bench = Bench::bundled();
        let opened = bench.model.opened.clone().unwrap();
        for (&id, step) in opened
            .ranking
            .iter()
            .zip([0, 10, 20, 30].into_iter().cycle())
        {
            bench.model.picked = Some(id);
            bench.model.clock.go(step);
            let moment = bench.model.moment().unwrap();
            let camera = bench.model.camera_of((columns, rows), &moment);
            let ego = moment.ego().unwrap();
            let inside = |point| {
                let at = camera.frame(Some(ego)).to_local(&point);
                at.x.abs() * 2.0 < camera.row() * f64::from(rows)
                    && at.y.abs() * 2.0 < camera.cell * f64::from(columns)
            };
            let road = ego.position + ego.forward() * 9.0;
            assert!(inside(ego.position) && inside(road), "{id} at {step}");
            let Some(motion) = moment.opened.motion_of(On::Obstacle(id), step) else {
                continue;
            };
            let away = (motion.pose.position - ego.position).norm();
            // Bodies would be single arrows otherwise.
            if away < 4.0 * f64::from(columns.min(2 * rows)) - 15.0 {
                shown += 1;
                assert!(inside(motion.pose.position), "{id} at {step}: {away} m");
            }
        }
    }
    assert!(shown > 3, "{shown}");
    let mut bench = Bench::bundled();
    assert!(bench.model.camera.auto);
    for (action, auto) in [("zoom-in", false), ("follow", false), ("follow", true)] {
        bench.perform(action);
        assert_eq!(bench.model.camera.auto, auto, "{action}");
    }
}

#[test]
fn the_mouse_focuses_selects_zooms_and_seeks() {
    let mut bench = Bench::bundled();
    let frame = bench.frame(120, 40);
    let row = frame
        .lines()
        .position(|l| l.contains("ZAM_RedLight"))
        .unwrap();
    let at = Position::new(5, u16::try_from(row).unwrap());
    bench.send(Msg::Mouse(Mouse::Press(at)));
    assert_eq!(
        bench.model.opened.as_ref().unwrap().name,
        "ZAM_RedLight-1_1_T-1"
    );
    let map = Position::new(50, 10);
    let before = bench.model.camera.cell;
    bench.send(Msg::Mouse(Mouse::WheelUp(map)));
    assert!(bench.model.camera.cell < before);
    bench.send(Msg::Mouse(Mouse::Press(map)));
    assert_eq!(bench.model.focus, Pane::Map);
    let row = bench
        .frame(120, 40)
        .lines()
        .position(|l| l.contains("│all   "))
        .unwrap();
    bench.send(Msg::Mouse(Mouse::Press(Position::new(
        73,
        u16::try_from(row).unwrap(),
    ))));
    let (_, last) = bench.model.clock.range();
    assert_eq!(
        bench.model.clock.step(),
        last,
        "the strip's last column is the last step"
    );
}

#[test]
fn help_has_every_key_and_the_palette_every_action() {
    let mut bench = Bench::bundled();
    bench.press("?");
    let mut seen = String::new();
    for _ in 0..40 {
        seen.push_str(&bench.frame(120, 40));
        bench.press("pagedown");
    }
    for entry in ACTIONS.iter().filter(|e| !e.keys.is_empty()) {
        let words: String = entry.doc.chars().take(40).collect();
        assert!(seen.contains(&words), "{}", entry.id);
    }
    bench.press("esc");
    // What several places have is in the palette once.
    let mut listed = std::collections::HashSet::new();
    for entry in ACTIONS.iter().filter(|e| listed.insert(e.action)) {
        bench.press(":");
        bench.type_text(entry.id);
        let words: String = entry.doc.chars().take(30).collect();
        let frame = bench.frame(120, 40);
        assert!(frame.contains(&words), "{}\n{frame}", entry.id);
        bench.press("esc");
    }
    assert!(bench.model.screens.is_empty());
}

#[test]
fn tab_goes_round_and_z_shows_one_pane() {
    let mut bench = Bench::bundled();
    for _ in 0..Pane::ALL.len() {
        bench.press("tab");
    }
    assert_eq!(bench.model.focus, Pane::Scenarios);
    bench.press("tab z");
    assert!(!bench.frame(120, 40).contains("reasoning"));
    bench.press("esc");
    assert!(bench.frame(120, 40).contains("reasoning"));
}

#[test]
fn it_can_be_left() {
    for keys in ["q", "ctrl-c ctrl-c", "ctrl-q"] {
        let mut bench = Bench::bundled();
        bench.press(keys);
        assert!(matches!(bench.effects.last(), Some(Effect::Quit)), "{keys}");
    }
    for (between, seconds) in [("j", 0.1), ("", 2.1)] {
        let mut bench = Bench::bundled();
        bench.press("ctrl-c");
        bench.press(between);
        bench.send(Msg::Passed(std::time::Duration::from_secs_f64(seconds)));
        bench.press("ctrl-c");
        let quits = bench.effects.iter().any(|e| matches!(e, Effect::Quit));
        assert!(!quits, "after {between:?} and {seconds} s it asks again");
    }
    let mut bench = Bench::bundled();
    bench.send(Msg::Terminate);
    assert!(matches!(bench.effects.last(), Some(Effect::Quit)));
}

#[test]
fn a_notice_goes_with_the_next_key_and_hides_no_pane() {
    let mut bench = Bench::empty();
    bench.press("space e t");
    assert!(bench.frame(80, 24).contains(" no scenario is open"));
    bench.press("r");
    assert_eq!(bench.model.toasts.len(), 1, "the newest alone");
    bench.send(Msg::reply::<Find>(Found::All(Ok(
        nearmiss_formats::bundled().into(),
    ))));
    assert!(bench.model.toasts.is_empty(), "it is not true any longer");
    bench.press("space a x");
    let frame = bench.frame(80, 24);
    let (above, last) = frame.rsplit_once('\n').unwrap();
    assert!(
        last.contains("the built-in judge cannot be closed"),
        "{frame}"
    );
    bench.press("right");
    assert!(bench.model.toasts.is_empty());
    bench.press("left");
    assert_eq!(bench.frame(80, 24).rsplit_once('\n').unwrap().0, above);
    // Unrequested notices stay for their time, whatever key is pressed.
    bench.model.tell("an answer elsewhere");
    bench.press("right");
    assert_eq!(bench.model.toasts.len(), 1);
    bench.send(Msg::Passed(Duration::from_secs(7)));
    assert!(bench.model.toasts.is_empty() && !bench.model.moves());
}

#[test]
fn a_long_message_takes_two_lines_at_the_bottom_and_can_be_read_again() {
    let mut bench = Bench::bundled();
    bench.send(Msg::Resize(80, 24));
    bench.model.say("words ".repeat(40) + "ended");
    let frame = bench.frame(80, 24);
    let border = frame.lines().nth(21).unwrap();
    assert!(border.starts_with('└') && border.ends_with('┘'), "{frame}");
    assert!(frame.ends_with("… Space o i all of it"), "{frame}");
    bench.press("space o i");
    let about = bench.frame(80, 24);
    assert!(
        about.contains("last message") && about.contains("words ended"),
        "{about}"
    );
    // One that was seen whole is not repeated.
    bench.model.say("short");
    assert!(!bench.frame(80, 24).contains("last message"));
}

#[test]
fn an_error_covers_neither_plot_nor_timeline() {
    let mut bench = Bench::bundled();
    let plain = bench.frame(80, 24);
    bench.model.complain("words ".repeat(60));
    let frame = bench.frame(80, 24);
    assert!(frame.contains("┌ error "));
    let parts = |frame: &str| {
        let lines: Vec<String> = frame.lines().map(String::from).collect();
        let timeline = lines.iter().position(|l| l.contains("· step ")).unwrap();
        lines[timeline..].join("\n")
    };
    assert_eq!(parts(&frame), parts(&plain));
}

#[test]
fn the_position_hides_no_number_of_the_timeline() {
    let mut bench = Bench::bundled();
    for _ in 0..8 {
        let frame = bench.frame(120, 40);
        let ruler = frame.lines().find(|l| l.contains(" 0s ")).unwrap();
        assert!(ruler.contains("2s") && !ruler.contains('▲'), "{ruler}");
        bench.press("right");
    }
    assert!(bench.frame(250, 60).contains("bars: danger by risk"));
}

#[test]
fn the_title_has_the_reason_before_anything_else() {
    for (name, reason) in [
        ("cutin", ": contact in"),
        ("overtaking", ": contact in"),
        ("pedestrian", ": c"),
    ] {
        let mut bench = Bench::bundled();
        bench.press("/");
        bench.type_text(name);
        bench.press("enter");
        let frame = bench.frame(80, 24);
        let title = frame.lines().find(|line| line.contains(" map · ")).unwrap();
        assert!(title.contains(reason), "{title}");
    }
}

#[test]
fn obstacles_are_picked_in_the_order_of_their_danger() {
    for name in ["rightturn", "cutin", "pedestrian"] {
        let bench = at(name, 0);
        let opened = bench.model.opened.as_ref().unwrap();
        let headline = opened.headline.as_ref().unwrap();
        let series = opened.series.as_ref().unwrap();
        let (first, rest) = opened.ranking.split_first().unwrap();
        assert_eq!(Some(*first), headline.worst().map(|worst| worst.obstacle));
        let danger = |id: &i64| {
            let grade = headline.worst_with(*id).unwrap().grade.number();
            let risks = series.row("risk", *id).iter().filter_map(|r| r.value());
            // Before those without a severe moment come those with one.
            let risk = if grade < 5 {
                0.0
            } else {
                risks.fold(f64::MAX, f64::min)
            };
            (grade, risk)
        };
        let all: Vec<_> = rest.iter().map(danger).collect();
        assert!(all.is_sorted(), "{name}: {:?} {all:?}", opened.ranking);
    }
}

#[test]
fn without_colours_small_bodies_are_boxes_with_their_heading() {
    let mut bench = at("overtaking", 48);
    bench.model.theme = Theme::default_theme().at_depth(ColorDepth::None);
    bench.model.camera.zoom(1.0, (40, 15));
    bench.model.camera.cell = 1.7;
    let frame = bench.frame(80, 24);
    assert!(frame.contains("[←]") && frame.contains(" → "), "{frame}");
}
