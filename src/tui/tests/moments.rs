//! Two maps: which moments they show, how they are moved, and where there is no room for two.

use ratatui::layout::Position;

use super::bench::Bench;
use super::making;
use crate::action::ACTIONS;
use crate::features::scenarios::request::{Find, Found};
use crate::message::{Mouse, Msg};
use crate::model::{Moment, On, Pane};
use crate::session::{Session, restore};
use nearmiss_formats::bundled;

const SIZE: (u16, u16) = (200, 60);

/// A bundled scenario with two maps.
fn split(name: &str) -> Bench {
    let mut bench = making::open(name);
    bench.frame(SIZE.0, SIZE.1);
    bench.press("space m s");
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
    let line = frame.lines().find(|line| line.contains("· step "));
    line.expect("the maps have titles").to_string()
}

#[test]
fn the_same_key_splits_the_map_and_makes_it_whole() {
    let mut bench = making::open("redlight");
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
    bench.press("right right right space m h");
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
    let middle = Position::new(area.x + area.width * 3 / 4, area.y + area.height / 2);
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
    assert!(!frame.contains("contact · "), "{frame}");
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
    bench.press("right right space m h right");
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
