//! Opening, filtering, stepping, the map, the mouse.

use std::path::Path;
use std::time::Duration;

use ratatui::layout::Position;

use super::bench::Bench;
use crate::scenario::Entry;
use crate::tui::action::ACTIONS;
use crate::tui::message::{Effect, Mouse, Msg, OpenId};
use crate::tui::model::Pane;
use crate::verdict::Task;

#[test]
fn the_first_scenario_opens_with_the_built_in_verdict() {
    let bench = Bench::bundled();
    assert_eq!(
        bench.model.opened.as_ref().unwrap().name,
        "ZAM_HardBraking-1_1_T-1"
    );
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
    assert!(
        bench
            .effects
            .iter()
            .any(|e| matches!(e, Effect::Survey(list) if list.len() == 8))
    );
}

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
    bench.press("space");
    assert!(bench.model.moves());
    bench.send(Msg::Passed(Duration::from_millis(320)));
    assert_eq!(bench.model.clock.step(), 3);
    bench.press("space");
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
fn a_stale_opening_is_dropped() {
    let mut bench = Bench::bundled();
    bench.send(Msg::Opened(OpenId(0), Err("late".into())));
    assert!(bench.model.open_error.is_none() && bench.model.opened.is_some());
}

#[test]
fn a_file_that_cannot_be_read_says_why_and_the_rest_works() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.xml");
    std::fs::write(&path, "<commonRoad timeStepSize=\"x\">").unwrap();
    let mut entries = vec![Entry::of_file(&path)];
    entries.extend(crate::scenario::bundled());
    let mut bench = Bench::empty();
    bench.send(Msg::Found(Ok(entries.into())));
    let error = bench.model.open_error.clone().unwrap();
    assert!(
        error.contains("broken.xml:1:1") && error.contains("timeStepSize"),
        "{error}"
    );
    assert!(bench.frame(120, 40).contains("timeStepSize"));
    bench.press("down");
    assert!(bench.model.opened.is_some() && bench.model.open_error.is_none());
}

#[test]
fn what_the_search_passed_over_is_said_below_the_list_and_told_by_i() {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ZAM_Merge-1_1_T-1.xml");
    std::fs::copy(source, folder.path().join("good.xml")).unwrap();
    std::fs::write(folder.path().join("a.xml"), "").unwrap();
    std::fs::write(folder.path().join("b\u{1b}[31m.xml"), [0x1f, 0x8b, 8]).unwrap();
    let mut bench = Bench::bundled();
    assert!(!bench.frame(120, 40).contains("passed over"));
    let found = crate::scenario::find(&[folder.path().to_path_buf()]).unwrap();
    bench.send(Msg::Found(Ok(found)));
    let frame = bench.frame(120, 40);
    assert!(frame.contains("scenarios 1 "), "{frame}");
    assert!(frame.contains(" 2 passed over · i "), "{frame}");
    bench.press("i");
    let told = bench.frame(120, 60);
    for words in ["is not in the list", "a.xml (empty)", "gzip; unpack it"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    assert!(!told.contains('\u{1b}'));
}

#[test]
fn nothing_found_is_said() {
    let mut bench = Bench::empty();
    assert!(bench.frame(120, 40).contains("looking for scenarios"));
    bench.send(Msg::Found(Err("nothing in there".into())));
    assert!(bench.frame(120, 40).contains("nothing in there"));
}

#[test]
fn the_safety_task_follows_the_step() {
    let mut bench = Bench::bundled();
    bench.press("t");
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
fn an_obstacle_can_be_the_ego_and_the_recorded_one_comes_back() {
    let mut bench = Bench::bundled();
    let recorded = bench.model.scene().unwrap().ego.id;
    bench.press("o shift-e");
    let taken = bench.model.scene().unwrap().ego.id;
    assert_ne!(taken, recorded);
    assert!(bench.frame(120, 40).contains(&format!("{taken} as ego")));
    bench.press(":");
    bench.type_text("recorded-ego");
    bench.press("enter");
    assert_eq!(bench.model.scene().unwrap().ego.id, recorded);
}

#[test]
fn a_scenario_without_ego_is_shown_and_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alone.xml");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ZAM_Merge-1_1_T-1.xml");
    std::fs::copy(source, &path).unwrap();
    let mut bench = Bench::empty();
    bench.send(Msg::Found(Ok(vec![Entry::of_file(&path)].into())));
    assert!(bench.frame(120, 40).contains("no ego"));
    bench.press("r");
    assert!(bench.effects.iter().all(|e| !matches!(e, Effect::Ask(..))));
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("take it as ego")
    );
    bench.press("o shift-e");
    assert!(bench.model.scene().is_some());
}

#[test]
fn the_map_zooms_pans_follows_and_fits() {
    let mut bench = Bench::bundled();
    bench.frame(120, 40);
    let before = bench.model.camera.clone();
    bench.press("+");
    assert!(bench.model.camera.cell < before.cell);
    bench.model.focus = Pane::Map;
    bench.press("l k");
    assert!(!bench.model.camera.follow);
    bench.press("w");
    assert!(bench.model.camera.follow);
    bench.press("a");
    assert!(bench.model.camera.cell > before.cell && !bench.model.camera.follow);
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
        .position(|l| l.contains("lowest  "))
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
    for _ in 0..12 {
        seen.push_str(&bench.frame(120, 40));
        bench.press("pagedown");
    }
    for entry in ACTIONS.iter().filter(|e| !e.keys.is_empty()) {
        let words: String = entry.doc.chars().take(40).collect();
        assert!(seen.contains(&words), "{}", entry.id);
    }
    bench.press("esc");
    for entry in ACTIONS {
        bench.press(":");
        bench.type_text(entry.id);
        let words: String = entry.doc.chars().take(30).collect();
        let frame = bench.frame(120, 40);
        assert!(frame.contains(&words), "{}\n{frame}", entry.id);
        bench.press("esc");
    }
    assert!(bench.model.overlays.is_empty());
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
    for keys in ["q", "ctrl-c", "ctrl-q"] {
        let mut bench = Bench::bundled();
        bench.press(keys);
        assert!(matches!(bench.effects.last(), Some(Effect::Quit)), "{keys}");
    }
    let mut bench = Bench::bundled();
    bench.send(Msg::Terminate);
    assert!(matches!(bench.effects.last(), Some(Effect::Quit)));
}

#[test]
fn what_cannot_be_the_ego_changes_nothing_but_is_said() {
    let mut bench = Bench::bundled();
    bench.press("x");
    let (step, name) = (
        bench.model.clock.step(),
        bench.model.opened.as_ref().unwrap().name.clone(),
    );
    let parked = bench
        .model
        .opened
        .as_ref()
        .unwrap()
        .scenario
        .obstacles
        .iter();
    let parked = parked.map(|o| o.id).max().unwrap();
    bench.model.picked = Some(parked + 1_000);
    bench.press("shift-e");
    assert_eq!(bench.model.opened.as_ref().unwrap().name, name);
    assert_eq!(bench.model.clock.step(), step);
    assert!(bench.model.toasts.last().unwrap().bad);
    bench.model.picked = Some(302);
    bench.press("shift-e");
    assert_eq!(
        bench.model.clock.step(),
        step,
        "another ego, the same moment"
    );
}

#[test]
fn what_reading_assumed_is_shown_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.xml");
    let text = r#"<commonRoad timeStepSize="0.1" commonRoadVersion="2020a" benchmarkID="ZAM_Old-1_1_T-1" author="someone">
        <dynamicObstacle id="7"><type>spaceship</type></dynamicObstacle></commonRoad>"#;
    std::fs::write(&path, text).unwrap();
    let mut bench = Bench::empty();
    bench.send(Msg::Found(Ok(vec![Entry::of_file(&path)].into())));
    assert!(bench.frame(160, 45).contains("! 3 warnings (i)"));
    bench.press("i");
    let frame = bench.frame(160, 45);
    for words in [
        "someone",
        "1 dynamic unknown",
        "`spaceship` is not a known <type>",
        "line 2",
    ] {
        assert!(frame.contains(words), "{words}: {frame}");
    }
    bench.press("i");
    assert!(bench.model.overlays.is_empty());
}
