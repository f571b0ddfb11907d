//! Moments: two on the map, the certificate, and the timeline.

use std::time::Duration;

use nearmiss_formats::bundled;
use nearmiss_study::evaluation::Answer;
use ratatui::layout::Position;

use crate::action::ACTIONS;
use crate::clock::PlayRange;
use crate::features::answers::LoadStored;
use crate::features::scenarios::request::{Find, Found, Survey};
use crate::message::{Mouse, Msg};
use crate::model::{Heat, Moment, On, Pane, ShownAnswer};
use crate::session::{Session, restore};
use crate::tests::answers::stored_of;
use crate::tests::bench::{self, Bench, answer};
use crate::tests::listing::surveyed;
use crate::tests::making::{self, arrive, asked, dangerous, made, open};
use crate::update::update;

const SIZE: (u16, u16) = (200, 60);

/// A bundled scenario with two maps.
fn split(name: &str) -> Bench {
    let mut bench = making::open(name);
    bench.frame(SIZE.0, SIZE.1);
    bench.press("home space m s");
    bench
}

fn then(bench: &Bench) -> Moment<'_> {
    bench.model.second_moment().expect("there are two maps")
}

fn said(bench: &Bench) -> String {
    let toasts = bench.model.toasts.iter();
    toasts
        .map(|t| t.text.clone())
        .collect::<Vec<_>>()
        .join("\n")
}

/// The title line of the map's pane.
fn titles(bench: &Bench) -> String {
    let frame = bench.frame(SIZE.0, SIZE.1);
    let lines = frame.lines().filter(|line| line.contains("· step "));
    lines.collect::<Vec<_>>().join("\n")
}

/// The title of the map where there is one of them.
fn title(bench: &Bench) -> String {
    let frame = bench.frame(SIZE.0, SIZE.1);
    let mut lines = frame.lines();
    lines.find(|line| line.contains(" map · ")).unwrap().into()
}

#[test]
fn a_goal_around_the_ego_is_named_beside_it() {
    let mut bench = making::open("cutin");
    bench.model.zoomed = true;
    bench.model.focus = Pane::Map;
    bench.model.clock.go(44);
    bench.model.toasts.clear();
    bench.model.map.layers.labels = false;
    let ego = bench.model.moment().unwrap().ego().unwrap();
    let opened = bench.model.opened.as_mut().unwrap();
    let scenario = std::sync::Arc::make_mut(&mut opened.scenario);
    let region = nearmiss_base::geometry::Shape::Rectangle {
        length: 8.0,
        width: 3.0,
        center: ego.position,
        orientation: ego.heading,
        origin_x_shift: 0.0,
    };
    scenario.planning_problems[0].goals[0].positions =
        vec![nearmiss_scene::scenario::Position::Region(region)];
    let frame = bench.frame(80, 24);
    assert!(frame.contains("goal"), "{frame}");
}

#[test]
fn a_scenario_opens_at_the_moment_that_matters_and_its_map_says_why() {
    for entry in bundled() {
        let mut bench = making::open(&entry.name.to_lowercase());
        let opened = bench.model.opened.clone().unwrap();
        let moment = *opened.headline.as_ref().unwrap().worst().unwrap();
        assert_eq!(bench.model.clock.step(), moment.step, "{}", entry.name);
        assert_eq!(bench.model.picked, Some(moment.obstacle));
        let hazard = moment.hazard.to_string();
        let why = hazard.split(';').next().unwrap();
        let collides = opened.headline.as_ref().unwrap().collides();
        let sign = if collides { 'X' } else { '▼' };
        let here = format!(" · {sign} {}: {why}", moment.obstacle);
        assert!(title(&bench).contains(&here), "{}", title(&bench));
        // Elsewhere it says when that is.
        bench.press("home");
        assert_eq!(bench.model.clock.step(), opened.steps().start);
        let time = moment.step as f64 * opened.scenario.dt();
        let when = format!(" · {sign} {time:.1} s {}: {why}", moment.obstacle);
        assert!(title(&bench).contains(&when), "{}", title(&bench));
    }
}

#[test]
fn it_plays_from_3_s_before_the_moment_until_one_goes_elsewhere() {
    for entry in bundled() {
        let mut bench = making::open(&entry.name.to_lowercase());
        let opened = bench.model.opened.clone().unwrap();
        let moment = opened.headline.as_ref().unwrap().worst().unwrap().step;
        let ago = (3.0 / opened.scenario.dt()).round() as i64;
        let from = (moment - ago).max(opened.steps().start);
        bench.press("p");
        assert!(bench.model.clock.playing);
        assert_eq!(bench.model.clock.step(), from, "{}", entry.name);
        bench.send(Msg::Passed(Duration::from_millis(250)));
        bench.press("p");
        let stopped = bench.model.clock.step();
        assert!(stopped > from && !bench.model.clock.playing);
        bench.press("p");
        assert_eq!(bench.model.clock.step(), stopped, "it goes on");
        // The key that goes there makes it a run-up again.
        bench.press("x p");
        assert_eq!(bench.model.clock.step(), from);
        bench.press("home p");
        assert_eq!(bench.model.clock.step(), opened.steps().start);
    }
}

#[test]
fn a_question_about_a_window_opens_at_its_end_and_the_map_says_when_the_moment_is() {
    let mut bench = making::open("hardbraking");
    bench.press("space a t");
    bench.press("down up");
    let last = bench.model.scene().unwrap().last_step();
    assert_eq!(bench.model.clock.step(), last - 2);
    let title = title(&bench);
    assert!(title.contains(" · X 5.9 s 301: contact at "), "{title}");
}

#[test]
fn the_same_key_splits_the_map_and_makes_it_whole() {
    let mut bench = making::open("redlight");
    bench.press("home");
    let whole = bench.frame(SIZE.0, SIZE.1);
    bench.press("space m s");
    assert!(
        said(&bench).contains("second map: contact"),
        "{}",
        said(&bench)
    );
    let step = then(&bench).step;
    let titles = titles(&bench);
    assert!(titles.contains("map · 0.0 s · step 0"), "{titles}");
    assert!(titles.contains(&format!("step {step}")), "{titles}");
    bench.press("space m s");
    bench.model.toasts.clear();
    assert_eq!(bench.frame(SIZE.0, SIZE.1), whole);
    // Where the user zoomed, each map shows as much as the one before.
    bench.perform("zoom-in");
    let before = bench.model.camera.clone();
    bench.press("space m s");
    assert!((bench.model.camera.cell - 2.0 * before.cell).abs() < 1e-9);
    bench.press("space m s");
    assert_eq!(bench.model.camera, before);
}

#[test]
fn beside_the_contact_it_shows_a_second_before() {
    let mut bench = split("redlight");
    let contact = then(&bench).step;
    for step in [contact - 1, contact, contact + 1] {
        bench.model.clock.go(step);
        let expected = if step == contact {
            contact - 10
        } else {
            contact
        };
        assert_eq!(then(&bench).step, expected);
        assert!(titles(&bench).contains(if step == contact {
            "before · "
        } else {
            "contact · "
        }));
    }
}

#[test]
fn other_words_find_it() {
    for words in ["two moments", "side by side map", "compare map"] {
        let mut bench = making::open("redlight");
        bench.press(":");
        bench.type_text(words);
        let frame = bench.frame(120, 40);
        assert!(frame.contains("split-map"), "{words}: {frame}");
    }
    let entry = ACTIONS.iter().find(|e| e.id == "split-map").unwrap();
    assert_eq!(entry.keys, ["space m s"]);
}

#[test]
fn it_shows_the_contact_or_the_worst_of_the_picked_one() {
    let mut contacts = 0;
    for entry in bundled() {
        let mut bench = split(&entry.name.to_lowercase());
        let opened = bench.model.opened.clone().unwrap();
        let headline = opened.headline.as_ref().unwrap();
        if headline.collides() {
            contacts += 1;
            bench.press("n");
            assert_eq!(then(&bench).step, headline.contact.unwrap().step);
            continue;
        }
        for &id in opened.ranking.iter().take(3) {
            bench.model.picked = Some(id);
            let moment = headline.worst_with(id).unwrap();
            // Not beside itself.
            bench.model.clock.go(if moment.step == 0 { 1 } else { 0 });
            assert_eq!(then(&bench).step, moment.step, "{} {id}", entry.name);
            assert!(titles(&bench).contains(&format!("worst of {id}")));
        }
        bench.model.picked = None;
        bench.model.clock.go(1);
        let worst = headline.worst().unwrap();
        assert_eq!(then(&bench).step, worst.step);
        assert_eq!(worst.obstacle, opened.ranking[0]);
    }
    assert!(contacts > 0, "a scenario has a contact");
}

#[test]
fn it_is_pinned_moved_and_free_again_and_another_scenario_has_its_own() {
    let mut bench = making::open("redlight");
    bench.frame(SIZE.0, SIZE.1);
    bench.press("home right right right space m h");
    assert_eq!(then(&bench).step, 3, "pinning splits the map");
    bench.press("right right");
    assert_eq!((bench.model.clock.step(), then(&bench).step), (5, 3));
    assert!(titles(&bench).contains("pinned · 0.3 s · step 3"));
    bench.press("} } {");
    assert_eq!((bench.model.clock.step(), then(&bench).step), (5, 4));
    bench.press("1 0 space m .");
    assert_eq!(then(&bench).step, 14);
    bench.press("9 9 9 {");
    assert_eq!(then(&bench).step, bench.model.clock.range().0);
    bench.press("space m h");
    assert_eq!(then(&bench).step, 5);
    bench.press("space m h");
    assert!(said(&bench).contains("contact"), "{}", said(&bench));
    let contact = then(&bench).step;
    bench.press("{");
    assert_eq!(then(&bench).step, contact - 1);
    bench.press("esc down");
    assert_eq!(bench.model.map.second.pinned, None);
    bench.press("space m s }");
    assert!(said(&bench).contains("Space m s"), "{}", said(&bench));
}

#[test]
fn a_variant_and_its_original_are_stepped_together() {
    let mut bench = split("rightturn");
    bench.press("space g g");
    making::arrive(&mut bench);
    let at = bench.model.clock.step();
    let (now, other) = (bench.model.moment().unwrap(), then(&bench));
    assert_eq!((now.step, other.step), (at, at));
    assert_ne!(now.opened.scenario.hash, other.opened.scenario.hash);
    let attacker = making::made(&bench).effect.main().obstacle;
    let place = |m: &Moment<'_>| {
        m.opened
            .motion_of(On::Obstacle(attacker), m.step)
            .unwrap()
            .pose
    };
    assert_ne!(place(&now).position, place(&other).position);
    let line = titles(&bench);
    let order = (line.find("variant · "), line.find("original · "));
    assert!(order.0.is_some() && order.0 < order.1, "{line}");
    bench.press("left left");
    assert_eq!(then(&bench).step, at - 2);
    bench.press("space m h space g o");
    let line = titles(&bench);
    let order = (line.find("original · "), line.find("variant, pinned · "));
    assert!(order.0.is_some() && order.0 < order.1, "{line}");
    // Back to the scenario as it was recorded, there is one scene again.
    bench.press("space e r");
    assert!(then(&bench).variations.is_empty());
}

#[test]
fn the_mouse_and_the_tools_hold_on_both_maps() {
    let mut bench = split("redlight");
    bench.press("end");
    bench.model.picked = None;
    bench.frame(SIZE.0, SIZE.1);
    // The contact is in the middle of the second map, where the ego is followed.
    let area = bench.model.drawn.area(Pane::Map).unwrap();
    let inside = area.inner(ratatui::layout::Margin::new(1, 1));
    let half = bench.model.halves(inside).unwrap().second;
    let middle = Position::new(half.x + half.width / 2, half.y + half.height / 2);
    let (point, _) = bench.model.drawn.point_at(middle).unwrap();
    let ego = then(&bench).ego().unwrap();
    assert!((point - ego.position).norm() < 3.0 * bench.model.camera.row());
    let moment = then(&bench);
    let (nearest, _) = moment
        .opened
        .nearest_body(&point, moment.step, false)
        .unwrap();
    let body = moment.opened.motion_of(nearest, moment.step).unwrap();
    let away = |at: &Position| {
        let seen = bench.model.drawn.point_at(*at);
        seen.map_or(f64::MAX, |(p, _)| (p - body.pose.position).norm())
    };
    let right = area.x + area.width / 2 + 2..area.right() - 1;
    let cells =
        right.flat_map(|x| (area.y + 1..area.bottom() - 2).map(move |y| Position::new(x, y)));
    let on_body = cells
        .min_by(|a, b| away(a).total_cmp(&away(b)))
        .expect("the map has cells");
    bench.send(Msg::Mouse(Mouse::Press(on_body)));
    bench.send(Msg::Mouse(Mouse::Release(on_body)));
    assert_eq!(bench.model.picked.map(On::Obstacle), Some(nearest));
    bench.press("home space m p");
    let tools = &bench.model.map;
    assert_eq!(tools.foresight.futures.len(), 1);
    assert_ne!(tools.foresight.futures, tools.second.foresight.futures);
    bench.press("space m t");
    let tape = bench.model.map.tape.unwrap();
    let now = bench.model.moment().unwrap();
    let (now, then) = (now.measured(&tape), then(&bench).measured(&tape));
    assert!(now.gap.metres > then.gap.metres + 1.0);
    bench.model.toasts.clear();
    let frame = bench.frame(SIZE.0, SIZE.1);
    for measured in [now, then] {
        let metres = crate::widgets::words::hundredths(measured.gap.metres);
        assert!(frame.contains(&format!("{metres} m")), "{frame}");
    }
    insta::assert_snapshot!("two_moments_at_200_by_60", frame);
}

#[test]
fn without_room_there_is_one_map_and_that_is_said_once() {
    let mut bench = making::open("redlight");
    let drawn = |bench: &mut Bench, (columns, rows): (u16, u16)| {
        bench.frame(columns, rows);
        bench.send(Msg::Drawn);
        bench.frame(columns, rows)
    };
    let words = "the pane is too small for two maps; z on the map";
    drawn(&mut bench, (80, 24));
    let cell = bench.model.camera.cell;
    bench.press("space m s");
    drawn(&mut bench, (80, 24));
    assert!(said(&bench).contains(words), "{}", said(&bench));
    assert_eq!(bench.model.camera.cell, cell);
    bench.press("right");
    let frame = drawn(&mut bench, (80, 24));
    assert_eq!(said(&bench), "", "once");
    assert!(
        !frame.contains("contact · ") && !frame.contains('◆'),
        "{frame}"
    );
    // Its pane alone has the room.
    bench.press("tab z");
    let frame = drawn(&mut bench, (80, 24));
    assert!(
        frame.contains("contact · ") && said(&bench).is_empty(),
        "{frame}"
    );
    bench.press("z space w w backtab backtab");
    bench.send(Msg::Resize(80, 24));
    drawn(&mut bench, (80, 24));
    assert!(said(&bench).contains(words), "{}", said(&bench));
}

#[test]
fn two_maps_come_back_with_the_session() {
    let mut bench = split("merge");
    bench.model.recall.on = true;
    bench.press("home right right space m h right");
    let left = restore::capture(&bench.model);
    let read = Session::parse(&left.text().unwrap(), &left.paths).unwrap();
    let mut again = Bench::empty();
    restore::restore(&mut again.model, read, false);
    again.send(Msg::reply::<Find>(Found::All(Ok(bundled().into()))));
    assert_eq!((then(&again).step, again.model.clock.step()), (2, 3));
    // A session of a version without two maps.
    bench.press("space m s");
    bench.model.map.second.pinned = None;
    let text = restore::capture(&bench.model).text().unwrap();
    assert!(!text.contains("split_map") && !text.contains("pinned"));
}

#[test]
fn nobody_without_an_ego_is_in_danger() {
    let mut bench = split("redlight");
    let opened = bench.model.opened.as_mut().unwrap();
    (opened.scene, opened.headline, opened.series) = (None, None, None);
    let last = then(&bench).opened.steps().end - 1;
    assert_eq!(then(&bench).step, last);
    assert!(titles(&bench).contains("end · "), "{}", titles(&bench));
}

/// The line with the titles of both maps.
fn certificate_titles(bench: &mut Bench) -> String {
    let frame = bench.frame(260, 60);
    let lines = frame.lines().filter(|line| line.contains("· step "));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn the_ideal_driver_stands_beside_the_planner_with_verdict_and_gap() {
    let mut bench = dangerous();
    let survived = made(&bench)
        .avoidability
        .certificates
        .iter()
        .rev()
        .filter(|(_, c)| c.avoidance().is_some());
    let longest = survived.map(|(delay, _)| *delay).next();
    let Some(longest) = longest else {
        bench.press("space m g");
        assert!(
            super::making::said(&bench).contains("no ideal driver survives"),
            "{}",
            super::making::said(&bench)
        );
        return;
    };
    bench.press("space m g");
    assert!(bench.model.map.second.on);
    let then = bench.model.second_moment().expect("two maps");
    let now = bench.model.moment().expect("the clock's moment");
    assert_eq!(then.step, now.step);
    assert_eq!(then.opened.scenario.hash, now.opened.scenario.hash);
    let place = |ego: Option<nearmiss_base::geometry::Pose>| ego.unwrap().position;
    assert_ne!(place(then.ego()), place(now.ego()));
    let judged = |opened: &crate::loaded::Opened| {
        opened
            .collision
            .as_ref()
            .is_some_and(|j| j.verdict.dangerous)
    };
    assert!(!judged(then.opened), "the ideal driver touches nothing");
    let line = certificate_titles(&mut bench);
    let planner = line.find("attack: X collision · ");
    let driver = line.find("ideal driver");
    assert!(planner.is_some() && planner < driver, "{line}");
    assert!(line.contains(": no contact · "), "{line}");
    assert!(
        super::making::said(&bench)
            .contains(&format!("ideal driver {longest:.1} s: no contact · gap "))
    );
    // Both are stepped together.
    let at = bench.model.clock.step();
    bench.press("left left");
    let then = bench.model.second_moment().expect("two maps");
    assert_eq!(then.step, at - 2);
    // Again shows the original.
    bench.press("space m g");
    assert!(!certificate_titles(&mut bench).contains("ideal driver"));
    assert!(bench.model.map.second.on);
}

#[test]
fn the_chosen_planner_is_attacked() {
    let mut bench = open("rightturn");
    bench.model.driver.planners = vec!["lab".into()];
    bench.press("space g g");
    assert_eq!(asked(&bench)[0].1.planner, 0);
    arrive(&mut bench);
    bench.press("space e r");
    bench.press("space e n");
    assert_eq!(bench.model.driver.planner_name(), "lab");
    // The variant against the built-in planner is none against this one.
    bench.press("space g g");
    let all = asked(&bench);
    assert_eq!(all.len(), 2, "{}", super::making::said(&bench));
    assert_eq!(all[1].1.planner, 1);
    assert!(
        super::making::said(&bench).contains("against lab"),
        "{}",
        super::making::said(&bench)
    );
}

/// The rows inside the timeline's frame, its title first.
fn timeline(bench: &Bench, columns: u16, rows: u16) -> Vec<String> {
    let frame = bench.frame(columns, rows);
    let lines: Vec<&str> = frame.lines().collect();
    let from = lines.iter().position(|l| l.contains("· step ")).unwrap();
    let left = lines[from]
        .chars()
        .take_while(|c| *c != '·')
        .collect::<String>();
    let left = left.chars().count() - left.chars().rev().position(|c| c == '┌').unwrap() - 1;
    let cut = |l: &&str| l.chars().skip(left).collect::<String>();
    lines[from..].iter().take(8).map(cut).collect()
}

#[test]
fn strips_show_other_measures_and_none() {
    let mut bench = Bench::bundled();
    bench.press("x");
    let risk = timeline(&bench, 340, 60);
    assert!(
        risk[0].contains("bars grow with danger: full = risk 0"),
        "{risk:#?}"
    );
    let mut seen = vec![risk[1].clone()];
    for (heat, words) in [
        (Heat::Ttc, "full = ttc ≤ 1.50 s"),
        (Heat::Distance, "full = distance ≤ 0.50 m"),
    ] {
        bench.press("space p h");
        assert_eq!(bench.model.heat, heat);
        let now = timeline(&bench, 340, 60);
        assert!(now[0].contains(words), "{now:#?}");
        assert!(!seen.contains(&now[1]), "other bars: {now:#?}");
        seen.push(now[1].clone());
    }
    bench.press("space p m");
    bench.type_text("drac");
    bench.press("enter space p h");
    assert_eq!(bench.model.heat, Heat::Plotted);
    assert!(timeline(&bench, 340, 60)[0].contains("full = drac ≥"));
    bench.press("space p h");
    assert_eq!(bench.model.heat, Heat::Off);
    let off = timeline(&bench, 340, 60).join("\n");
    assert!(!off.contains('█') && off.contains("marks"), "{off}");
    bench.press("space p h");
    assert_eq!(bench.model.heat, Heat::Risk);
}

#[test]
fn the_minimum_of_the_plotted_measure_is_of_the_picked_obstacle_or_of_all() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("distance");
    bench.press("enter");
    let nearest = bench
        .model
        .opened
        .as_ref()
        .unwrap()
        .headline
        .clone()
        .unwrap()
        .distance
        .unwrap();
    bench.model.picked = None;
    bench.press("g m");
    assert_eq!(bench.model.clock.step(), nearest.step);
    assert_eq!(bench.model.picked, Some(nearest.obstacle));
    let series = bench.model.plot.series.as_ref().unwrap();
    let other = series
        .obstacles()
        .iter()
        .copied()
        .find(|id| *id != nearest.obstacle)
        .unwrap();
    let row: Vec<f64> = series
        .row("distance", other)
        .iter()
        .filter_map(|r| r.value())
        .collect();
    let least = row.iter().copied().fold(f64::MAX, f64::min);
    bench.model.picked = Some(other);
    bench.press("g m");
    let series = bench.model.plot.series.as_ref().unwrap();
    let here = series
        .at("distance", other, bench.model.clock.step())
        .value();
    assert_eq!(here, Some(least));
    assert_eq!(bench.model.picked, Some(other));
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("min distance")
    );
    bench.press("space p m");
    bench.type_text("drac");
    bench.press("enter");
    bench.model.picked = None;
    bench.press("g m");
    assert!(bench.model.toasts.last().unwrap().text.contains("max drac"));
}

#[test]
fn loops_go_round_everything_then_the_window() {
    let mut bench = Bench::bundled();
    bench.press("space t l");
    assert_eq!(bench.model.clock.lap(), PlayRange::Whole);
    assert!(timeline(&bench, 120, 40)[0].contains("1× · loop"));
    bench.press("space t l");
    let window = bench.model.window().unwrap();
    assert_eq!(
        bench.model.clock.lap(),
        PlayRange::Part(window.first(), window.last())
    );
    assert!(timeline(&bench, 200, 60)[0].contains("loop 51–60"));
    bench.press("p");
    for _ in 0..40 {
        bench.send(Msg::Passed(Duration::from_millis(90)));
        let step = bench.model.clock.step();
        assert!((window.first()..=window.last()).contains(&step), "{step}");
    }
    assert!(bench.model.clock.playing);
    bench.press("space t l");
    assert_eq!(bench.model.clock.lap(), PlayRange::Once);
}

/// Three answers of the store about what is open, the second and third of which differ.
fn with_stored(bench: &mut Bench) {
    let of = stored_of(bench);
    let dangerous = bench
        .model
        .answers
        .reference
        .as_ref()
        .unwrap()
        .verdict
        .dangerous;
    let of_model = |model: &str, dangerous: bool, last: i64| Answer {
        window: Some((last - 9, last)),
        ..answer(model, dangerous, 301)
    };
    let answers = vec![
        of_model("lab/right", dangerous, 20),
        of_model("lab/wrong", !dangerous, 30),
        of_model("lab/wrong_too", !dangerous, 50),
    ];
    bench.send(Msg::reply::<LoadStored>((of, answers)));
}

#[test]
fn disagreements_are_marked_and_found_one_after_the_other() {
    let mut bench = surveyed();
    with_stored(&mut bench);
    let steps: Vec<i64> = bench.model.disagreements().iter().map(|d| d.step).collect();
    assert_eq!(steps, [30, 50]);
    let rows = timeline(&bench, 200, 60).join("\n");
    assert!(rows.matches('≠').count() >= 2, "{rows}");
    let model = |bench: &Bench| bench.model.answers.column().map(|c| c.model.clone());
    bench.press("home g shift-d");
    assert_eq!(
        (bench.model.clock.step(), model(&bench)),
        (30, Some("lab/wrong".into()))
    );
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .starts_with("difference 1 of 2: lab/wrong says no")
    );
    bench.press("g shift-d");
    assert_eq!(
        (bench.model.clock.step(), model(&bench)),
        (50, Some("lab/wrong_too".into()))
    );
    // No other scenario of the list has one: from the first again.
    bench.press("g shift-d");
    assert_eq!(bench.model.clock.step(), 30);
}

#[test]
fn the_next_disagreement_may_be_in_another_scenario() {
    let mut bench = surveyed();
    bench.press("g g down down down");
    assert_eq!(bench.model.list.opened, Some(3));
    bench.press("g shift-d");
    assert_eq!(bench.model.list.opened, Some(0), "the store has one there");
    assert_eq!(bench.model.list.current(), Some(0));
    assert!(bench.model.seek.is_some());
    with_stored(&mut bench);
    assert_eq!(bench.model.clock.step(), 30);
    assert_eq!(bench.model.answers.shown, ShownAnswer::Column(1));
    assert!(bench.model.seek.is_none());
}

#[test]
fn where_nothing_differs_it_is_said() {
    let mut bench = Bench::bundled();
    bench.press("g shift-d");
    let words = &bench.model.toasts.last().unwrap().text;
    assert!(
        words.contains("no answer") && words.contains("8 scenarios are not read"),
        "{words}"
    );
}

#[test]
fn an_answer_that_arrives_is_counted() {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    bench.press("r");
    let (id, _) = bench.asked();
    let effects = update(
        &mut bench.model,
        bench::answered(id, Ok(Box::new(answer("lab/small", false, 302)))),
    );
    let counted = effects
        .iter()
        .any(|e| matches!(e.request(), Some(Survey::Again(rows)) if rows.len() == 1));
    assert!(counted, "{effects:?}");
}

#[test]
fn the_picture_at_200_by_60() {
    let mut bench = surveyed();
    with_stored(&mut bench);
    bench.press("home g shift-d space p h");
    bench.model.toasts.clear();
    insta::assert_snapshot!(timeline(&bench, 200, 60).join("\n"));
}

#[test]
fn a_contact_is_shown_whole_and_large_with_any_obstacle_picked() {
    let mut bench = Bench::bundled();
    let opened = bench.model.opened.clone().unwrap();
    let contact = *opened.contact().expect("the first scenario collides");
    let other = { opened.ranking.iter() }.find(|id| **id != contact.obstacle);
    bench.model.picked = other.copied();
    bench.model.clock.go(contact.step);
    let moment = bench.model.moment().unwrap();
    for (columns, rows) in [(26_u16, 10_u16), (41, 8), (78, 32)] {
        let camera = bench.model.camera_of((columns, rows), &moment);
        assert!(camera.cell < 0.9, "{columns}×{rows}: {}", camera.cell);
        let frame = camera.frame(moment.ego());
        for on in [On::Ego, On::Obstacle(contact.obstacle)] {
            let body = moment.opened.body_of(on, contact.step).unwrap();
            for corner in body.outlines().concat() {
                let at = frame.to_local(&corner);
                assert!(at.x.abs() * 2.0 < camera.row() * f64::from(rows), "{on:?}");
                assert!(
                    at.y.abs() * 2.0 < camera.cell * f64::from(columns),
                    "{on:?}"
                );
            }
        }
    }
}
