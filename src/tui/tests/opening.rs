//! Finding and opening scenarios, with which ego, and what cannot be read.

use std::path::Path;

use super::bench::Bench;
use crate::features::answers::Ask;
use crate::features::scenarios::request::{Find, Found, Survey};
use crate::message::Msg;
use crate::model::OpenId;
use crate::model::{Notice, Pane};
use crate::update::Open;
use nearmiss_formats::{EgoSelection, Entry, write_recording};

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
            .any(|e| matches!(e.request(), Some(Survey::All(list)) if list.len() == 8))
    );
}

#[test]
fn a_stale_opening_is_dropped() {
    let mut bench = Bench::bundled();
    bench.send(Msg::reply::<Open>((OpenId(0), Err("late".into()))));
    assert!(bench.model.open_error.is_none() && bench.model.opened.is_some());
}

#[test]
fn a_file_that_cannot_be_read_says_why_and_the_rest_works() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.xml");
    std::fs::write(&path, "<commonRoad timeStepSize=\"x\">").unwrap();
    let mut entries = vec![Entry::of_file(&path)];
    entries.extend(nearmiss_formats::bundled());
    let mut bench = Bench::empty();
    bench.send(Msg::reply::<Find>(Found::All(Ok(entries.into()))));
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
    let source =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/ZAM_Merge-1_1_T-1.xml");
    std::fs::copy(source, folder.path().join("good.xml")).unwrap();
    std::fs::write(folder.path().join("a.xml"), "").unwrap();
    std::fs::write(folder.path().join("b\u{1b}[31m.xml"), [0x1f, 0x8b, 8]).unwrap();
    let mut bench = Bench::bundled();
    assert!(!bench.frame(120, 40).contains(" skipped"));
    let found = nearmiss_formats::find(&[folder.path().to_path_buf()]).unwrap();
    bench.send(Msg::reply::<Find>(Found::All(Ok(found))));
    let frame = bench.frame(120, 40);
    assert!(frame.contains("scenarios 1 "), "{frame}");
    assert!(frame.contains(" 2 skipped: Space o i "), "{frame}");
    bench.press("space o i");
    let told = bench.frame(120, 60);
    for words in ["skipped files", "a.xml (empty)", "gzip; unpack it"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    assert!(!told.contains('\u{1b}'));
}

#[test]
fn nothing_found_is_said() {
    let mut bench = Bench::empty();
    assert!(bench.frame(120, 40).contains("looking for scenarios"));
    bench.send(Msg::reply::<Find>(Found::All(Err(
        "nothing in there".into()
    ))));
    assert!(bench.frame(120, 40).contains("nothing in there"));
}

#[test]
fn an_obstacle_can_be_the_ego_and_the_recorded_one_comes_back() {
    let mut bench = Bench::bundled();
    let recorded = bench.model.scene().unwrap().ego.id;
    bench.press("n space e t");
    let taken = bench.model.scene().unwrap().ego.id;
    assert_ne!(taken, recorded);
    assert!(bench.frame(120, 40).contains(&format!("{taken} as ego")));
    bench.press(":");
    bench.type_text("recorded-ego");
    bench.press("enter");
    assert_eq!(bench.model.scene().unwrap().ego.id, recorded);
}

#[test]
fn a_chosen_file_is_shown_as_the_source_of_the_ego_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.csv");
    let mut bench = Bench::bundled();
    let scene = bench.model.opened.as_ref().unwrap().scene.clone().unwrap();
    std::fs::write(&path, write_recording(77, &scene.ego.track).unwrap()).unwrap();
    bench.ego = EgoSelection::File {
        path: path.clone(),
        planning_problem: None,
    };
    bench.press("n space e t");
    assert!(bench.frame(160, 45).contains("as ego"));
    bench.press(":");
    bench.type_text("recorded-ego");
    bench.press("enter");
    assert_eq!(bench.model.scene().unwrap().ego.id, 77);
    assert!(bench.frame(160, 45).contains("ego recorded in mine.csv"));
    bench.press("space o i");
    let folder = folder.path().display().to_string();
    assert!(
        bench.frame(200, 45).contains(&folder),
        "{}",
        bench.frame(200, 45)
    );
}

#[test]
fn a_scenario_without_ego_is_shown_and_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alone.xml");
    let source =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/ZAM_Merge-1_1_T-1.xml");
    std::fs::copy(source, &path).unwrap();
    let mut bench = Bench::empty();
    bench.send(Msg::reply::<Find>(Found::All(Ok(vec![Entry::of_file(
        &path,
    )]
    .into()))));
    assert!(bench.frame(120, 40).contains("no ego"));
    bench.press("r");
    assert!(
        bench
            .effects
            .iter()
            .all(|e| !matches!(e.request(), Some(Ask { .. })))
    );
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("makes it the ego")
    );
    bench.press("n space e t");
    assert!(bench.model.scene().is_some());
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
        .iter()
        .map(|o| o.id)
        .max()
        .unwrap();
    bench.model.picked = Some(parked + 1_000);
    bench.press("space e t");
    assert_eq!(bench.model.opened.as_ref().unwrap().name, name);
    assert_eq!(bench.model.clock.step(), step);
    assert_eq!(bench.model.toasts.last().unwrap().kind, Notice::Error);
    bench.model.picked = Some(302);
    bench.press("space e t");
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
    bench.send(Msg::reply::<Find>(Found::All(Ok(vec![Entry::of_file(
        &path,
    )]
    .into()))));
    assert!(bench.frame(160, 45).contains("! 3 warnings (Space o i)"));
    bench.press("space o i");
    let frame = bench.frame(160, 45);
    for words in [
        "someone",
        "1 × dynamic unknown",
        "`spaceship` is not a known <type>",
        "line 2",
    ] {
        assert!(frame.contains(words), "{words}: {frame}");
    }
    bench.press("q");
    assert!(bench.model.screens.is_empty());
}

#[test]
fn an_obstacle_as_the_ego_is_seen_at_once_and_r_goes_back() {
    let mut bench = Bench::bundled();
    let badge = |bench: &Bench| {
        let frame = bench.frame(80, 24);
        let row = frame
            .lines()
            .find(|l| l.contains("▸ "))
            .unwrap()
            .to_string();
        row.split('┃').nth(1).unwrap().trim_end().to_string()
    };
    bench.press("space e r");
    assert!(bench.frame(80, 24).contains("no obstacle is the ego"));
    let risk = crate::loaded::Facts {
        obstacles: 9,
        headline: bench.model.opened.as_ref().unwrap().headline.clone(),
        ..crate::loaded::Facts::default()
    };
    bench.send(Msg::reply::<Survey>((0, Ok(risk))));
    let recorded = badge(&bench);
    assert!(recorded.ends_with("0X"), "{recorded}");
    bench.press("space e t");
    let taken = bench.model.taken.unwrap();
    let frame = bench.frame(80, 24);
    assert!(
        frame.starts_with(&format!(" nearmiss {taken} as ego · ")),
        "{frame}"
    );
    assert!(frame.contains("Space e r goes back"), "{frame}");
    assert_ne!(badge(&bench), recorded, "the list is about the same ego");
    bench.press("right");
    let hints = bench.frame(80, 24);
    let hints = hints.lines().last().unwrap();
    assert!(hints.starts_with(" Space e r recorded ego"), "{hints}");
    bench.press("space e r");
    assert_eq!(bench.model.taken, None);
    assert_eq!(badge(&bench), recorded);
    assert!(!bench.frame(80, 24).contains("recorded ego"));
}

#[test]
fn without_an_ego_every_pane_says_what_to_do_and_no_names_run_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alone.xml");
    let source =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/ZAM_JamTail-1_1_T-1.xml");
    std::fs::copy(source, &path).unwrap();
    let mut bench = Bench::empty();
    bench.send(Msg::reply::<Find>(Found::All(Ok(vec![Entry::of_file(
        &path,
    )]
    .into()))));
    let panes = bench.frame(120, 40).matches("makes it the ego").count();
    assert!(panes >= 3, "{}", bench.frame(120, 40));
    let ids: Vec<String> = bench
        .model
        .opened
        .as_ref()
        .unwrap()
        .scenario
        .obstacles
        .iter()
        .map(|o| o.id.to_string())
        .collect();
    let mut named = 0;
    bench.model.focus = Pane::Map;
    // Their numbers are not names.
    bench.model.map.layers.goal = false;
    bench.model.map.layers.signs = false;
    for keys in ["z", "a", "- -", "-", "end"] {
        bench.press(keys);
        for (columns, rows) in [(80, 24), (120, 40)] {
            let frame = bench.frame(columns, rows);
            let map = frame
                .lines()
                .filter(|l| l.starts_with('┃') && !l.contains('├'));
            for word in map.flat_map(|l| l.split(|c: char| !c.is_ascii_digit())) {
                assert!(
                    word.is_empty() || ids.iter().any(|id| id == word),
                    "{word}: {frame}"
                );
                named += usize::from(!word.is_empty());
            }
        }
    }
    assert!(named > 10);
}
