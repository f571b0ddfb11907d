//! Filtering, stepping, the map, the mouse.

use std::time::Duration;

use ratatui::layout::Position;

use super::bench::Bench;
use crate::action::ACTIONS;
use crate::features::scenarios::request::{Find, Found};
use crate::message::{Effect, Mouse, Msg};
use crate::model::{On, Pane};
use nearmiss_scene::verdict::Task;

#[test]
fn arrows_step_and_stop_at_the_ends() {
    let mut bench = Bench::bundled();
    bench.press("right right left");
    assert_eq!(bench.model.clock.step(), 1);
    bench.press("left left left");
    assert_eq!(bench.model.clock.step(), 0);
    bench.press("end right shift-right");
    assert_eq!(bench.model.clock.step(), bench.model.clock.range().1);
}

#[test]
fn space_plays_in_real_time() {
    let mut bench = Bench::bundled();
    bench.press("p");
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
    bench.press("right");
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
            assert!(inside(ego.position), "{id} at {step}");
            let Some(motion) = moment.opened.motion_of(On::Obstacle(id), step) else {
                continue;
            };
            let away = (motion.pose.position - ego.position).norm();
            // Bodies would be single arrows otherwise.
            if away < 4.0 * f64::from(columns.min(2 * rows)) - 10.0 {
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
fn an_error_covers_neither_plot_nor_timeline() {
    let mut bench = Bench::bundled();
    let plain = bench.frame(80, 24);
    bench.model.complain("words ".repeat(60));
    let frame = bench.frame(80, 24);
    assert!(frame.contains("┌ error "));
    let parts = |frame: &str| {
        let lines: Vec<String> = frame.lines().map(String::from).collect();
        let timeline = lines.iter().position(|l| l.starts_with("┌ 0.0 s")).unwrap();
        lines[timeline..].join("\n")
    };
    assert_eq!(parts(&frame), parts(&plain));
}

#[test]
fn the_position_hides_no_number_of_the_timeline() {
    let mut bench = Bench::bundled();
    for _ in 0..8 {
        let frame = bench.frame(120, 40);
        let ruler = frame.lines().find(|l| l.contains('▲')).unwrap();
        assert!(ruler.contains("0s") && ruler.contains("2s"), "{ruler}");
        bench.press("right");
    }
    assert!(
        bench
            .frame(200, 60)
            .contains("bars grow with danger: full = risk 0")
    );
}
