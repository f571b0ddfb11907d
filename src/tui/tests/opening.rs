//! From the first start over opening scenarios to quitting.

use std::path::Path;
use std::time::Duration;

use crate::features::answers::Ask;
use crate::features::batch::BatchScreen;
use crate::features::batch::request::EstimateBatch;
use crate::features::results::ResultsScreen;
use crate::features::scenarios::request::{Find, Found, Survey};
use crate::keymap::Keymap;
use crate::message::{Effect, Msg};
use crate::model::{Column, Model, Notice, OpenId, Pane, Update};
use crate::tests::bench::{Bench, answer};
use crate::tests::side_by_side::{sized, two};
use crate::update::Open;
use nearmiss_formats::{EgoSelection, Entry, write_recording};
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;

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
fn without_a_planning_problem_the_list_agrees_with_the_obstacle_that_stands_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("aimless.xml");
    let source =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/ZAM_Merge-1_1_T-1.xml");
    let text = std::fs::read_to_string(source).unwrap();
    let (before, _) = text.split_once("<planningProblem").unwrap();
    std::fs::write(&path, format!("{before}</commonRoad>")).unwrap();
    let entry = Entry::of_file(&path);
    let mut bench = Bench::empty();
    bench.send(Msg::reply::<Find>(Found::All(Ok(vec![entry].into()))));
    let facts = crate::loaded::Facts {
        obstacles: 9,
        ..crate::loaded::Facts::default()
    };
    bench.send(Msg::reply::<Survey>((0, Ok(facts))));
    let ego = bench.model.scene().unwrap().ego.id;
    let frame = bench.frame(160, 45);
    let row = frame.lines().find(|line| line.contains("▸ ")).unwrap();
    assert!(row.contains(&format!(" {ego} as ego ")), "{frame}");
    assert!(!frame.contains("no ego in"), "{frame}");
    assert_eq!(
        bench.model.list.rows[0].headline(),
        bench.model.opened.as_ref().unwrap().headline.as_ref()
    );
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
    let frame = bench.frame(120, 40);
    let words = [
        "makes it the ego",
        "nothing to judge without an ego",
        "no values without an ego",
    ];
    assert!(words.iter().all(|words| frame.contains(words)), "{frame}");
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

fn said(model: &Model) -> String {
    let last = model.toasts.last();
    last.map_or(String::new(), |toast| toast.text.clone())
}

fn pass(bench: &mut Bench, seconds: f64) {
    bench.send(Msg::Passed(Duration::from_secs_f64(seconds)));
}

#[test]
fn after_editing_the_keys_are_back_in_the_list() {
    let mut bench = Bench::bundled();
    bench.press("e x esc");
    assert_eq!(bench.model.focus, Pane::Scenarios);
    bench.press("* j *");
    assert_eq!(bench.model.marks.count(&bench.model.list), 2);
    bench.press("tab tab");
    assert_eq!(bench.model.focus, Pane::Prompt);
    bench.press("enter esc");
    assert_eq!(bench.model.focus, Pane::Prompt, "it was there before");
    bench.press("*");
    let words = said(&bench.model);
    assert!(words.contains("select others in the list"), "{words}");
}

#[test]
fn without_marks_the_dialog_says_that_it_asks_all() {
    let mut bench = Bench::bundled();
    bench.press("space a a");
    let all = bench.model.list.visible.len();
    let words = format!("No scenario is marked: this asks all {all}. * marks");
    assert!(bench.frame(120, 40).contains(&words));
    bench.press("esc * space a a");
    assert!(!bench.frame(120, 40).contains("No scenario is marked"));
}

#[test]
fn what_cannot_be_asked_is_not_offered() {
    let mut bench = Bench::bundled();
    bench.press("space a a");
    let card = bench.model.proposal.as_ref().unwrap();
    let mut counts = card.counts.clone();
    counts.looked = card.batch.entries.len();
    counts.refused = Some("LAB_KEY is not set".into());
    let id = card.id;
    bench.send(Msg::reply::<EstimateBatch>((id, Update::Ended(Ok(counts)))));
    for (columns, rows) in [(80, 24), (120, 40)] {
        let frame = bench.frame(columns, rows);
        assert!(frame.contains("LAB_KEY is not set"), "{frame}");
        assert!(!frame.contains("Enter ask"), "{frame}");
    }
    bench.effects.clear();
    bench.press("enter");
    assert!(bench.effects.is_empty() && bench.model.screens.is_top::<BatchScreen>());
}

#[test]
fn a_running_search_keeps_its_key_and_the_title_its_place() {
    let mut bench = Bench::bundled();
    let name = bench.model.opened.as_ref().unwrap().name.clone();
    bench.press("space g g");
    for seconds in [0.0, 10.0] {
        pass(&mut bench, seconds);
        let frame = bench.frame(80, 24);
        let (first, last) = (frame.lines().next(), frame.lines().last());
        assert!(last.is_some_and(|l| l.contains("Esc cancel")), "{frame}");
        assert!(first.is_some_and(|l| l.contains(&name)), "{frame}");
    }
}

#[test]
fn with_nothing_to_rate_no_rating_is_offered() {
    let mut bench = sized(Bench::bundled(), 120, 40);
    let column = Column::from(answer("lab/small", true, 301));
    bench.model.answers.columns.push(column);
    bench.press("space o b");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("has 1 complete answer"), "{frame}");
    let footer = frame.lines().last().unwrap_or_default();
    assert!(
        !footer.contains("best") && !footer.contains("tie"),
        "{footer}"
    );
    assert!(footer.contains("Esc"), "{footer}");
}

#[test]
fn countries_are_found_by_their_names() {
    let mut bench = Bench::bundled();
    let countries = |bench: &Bench| {
        let places = bench.model.list.visible.iter();
        let rows = places.map(|place| bench.model.list.rows[*place].country().to_string());
        rows.collect::<std::collections::BTreeSet<_>>()
    };
    let all = bench.model.list.visible.len();
    for filter in ["zamunda", "country:zamunda"] {
        bench.press("/");
        bench.type_text(filter);
        bench.press("enter");
        let found = bench.model.list.visible.len();
        assert_eq!(countries(&bench), ["ZAM".to_string()].into(), "{filter}");
        assert!(found > 0 && found <= all);
    }
    bench.press("/");
    bench.type_text("!zamunda");
    bench.press("enter");
    assert!(!countries(&bench).contains("ZAM"));
}

#[test]
fn the_best_match_opens_when_typing_rests() {
    let mut bench = Bench::bundled();
    let before = bench.model.list.opened;
    bench.press("/");
    bench.type_text("merge");
    assert_eq!(bench.model.list.opened, before, "nothing opens at a key");
    assert!(bench.model.moves());
    pass(&mut bench, 1.0);
    assert_ne!(bench.model.list.opened, before);
    bench.type_text("qqq");
    pass(&mut bench, 1.0);
    let open = bench.model.opened.as_ref().unwrap().name.clone();
    let list = bench.frame(200, 60);
    assert!(list.contains("no match; Esc clears the"), "{list}");
    assert!(list.matches(&open).count() > 1, "{list}");
}

#[test]
fn help_on_the_list_begins_with_its_signs() {
    let mut bench = Bench::bundled();
    bench.press("?");
    let frame = bench.frame(120, 40);
    let signs = frame.find("signs in the list").unwrap();
    assert!(signs < frame.find("here: in the list").unwrap(), "{frame}");
    assert!(frame.contains("0 contact"), "{frame}");
}

#[test]
fn menus_open_side_by_side_and_in_the_editor() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c space");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("Space · menu"), "{frame}");
    bench.press("o r");
    assert!(bench.model.screens.is_top::<ResultsScreen>());
    bench.press("esc");
    assert!(bench.model.compare.open && bench.model.screens.is_empty());
    bench.press("esc e f8 a a");
    assert!(bench.model.screens.is_top::<BatchScreen>());
    assert!(
        bench
            .effects
            .iter()
            .any(|effect| { matches!(effect.request(), Some(EstimateBatch { .. })) })
    );
    bench.press("esc f8 w w");
    assert!(bench.model.prompt.editing);
    assert_eq!(bench.model.focus, Pane::Prompt);
    // A space is text there.
    let before = bench.model.prompt.text();
    bench.press("space");
    assert_ne!(bench.model.prompt.text(), before);
}

#[test]
fn blind_menus_stay_shut() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o b space");
    assert!(bench.model.look.pending.is_empty() && bench.model.compare.open);
    assert!(said(&bench.model).contains("rate first"));
}

#[test]
fn menus_spell_out_what_they_switch_and_how_it_stands() {
    let mut bench = Bench::bundled();
    bench.press("space a");
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("contextual prompting on/off (on)"),
        "{frame}"
    );
    assert!(frame.contains("discard draft"), "{frame}");
    for state in ["on", "north up"] {
        bench.press("esc space m");
        let frame = bench.frame(120, 40);
        let words = format!("turn with the ego ({state})");
        assert!(frame.contains(&words), "{frame}");
        bench.press("u");
    }
}

#[test]
fn a_keymap_file_may_still_say_earlier_names_of_actions() {
    let text = "[global]\nreset-template = \"f9\"\ncertificate-map = \"f8\"\n";
    let map = Keymap::parse("keymap.toml", text).unwrap();
    assert_eq!(map.key_of(crate::action::Action::DiscardDraft), "F9");
    assert_eq!(map.key_of(crate::action::Action::DriverMap), "F8");
}

#[test]
fn q_asks_again_while_something_runs() {
    let mut bench = super::answers::asking();
    let quits = |bench: &Bench| bench.effects.iter().any(|e| matches!(e, Effect::Quit));
    bench.press("q");
    assert!(!quits(&bench));
    assert!(
        bench
            .frame(120, 40)
            .contains("1 question is running; q again")
    );
    bench.press("q");
    assert!(quits(&bench));
    let mut bench = Bench::bundled();
    bench.press("q");
    assert!(quits(&bench), "nothing runs");
}

/// Goes on to a task.
fn to(bench: &mut Bench, task: Task) {
    for _ in Task::ALL {
        if bench.model.task == task {
            return;
        }
        bench.press("space a t");
    }
    assert_eq!(bench.model.task, task);
}

#[test]
fn every_task_begins_in_its_usual_frame_and_window() {
    let mut bench = Bench::bundled();
    let last = bench.model.scene().map(|s| s.last_step());
    let end = |bench: &Bench| bench.model.window().map(|w| w.last());
    to(&mut bench, Task::Safety);
    assert_eq!(end(&bench), last.map(|l| l - 2));
    to(&mut bench, Task::Attacker);
    assert_eq!((end(&bench), bench.model.frame), (last, Frame::Metrics));
    let said = bench.frame(120, 40);
    assert!(said.contains("built-in judge does not"), "{said}");
    assert!(!said.contains("nothing to judge yet"), "{said}");
    to(&mut bench, Task::Trajectory);
    assert_eq!(end(&bench), last);
    to(&mut bench, Task::Safety);
    assert_eq!(
        (end(&bench), bench.model.frame),
        (last.map(|l| l - 2), Frame::Ego)
    );
}

#[test]
fn what_somebody_chose_stays() {
    let mut bench = Bench::bundled();
    to(&mut bench, Task::Safety);
    bench.press("space a f");
    let chosen = bench.model.frame;
    assert_ne!(chosen, Frame::Ego);
    let pane = bench.model.focus;
    bench.model.focus = crate::model::Pane::Map;
    bench.press("left");
    bench.model.focus = pane;
    let step = bench.model.clock.step();
    for _ in Task::ALL {
        bench.press("space a t");
        assert_eq!(bench.model.clock.step(), step, "{:?}", bench.model.task);
    }
    assert_eq!(
        (bench.model.task, bench.model.frame),
        (Task::Safety, chosen)
    );
}
