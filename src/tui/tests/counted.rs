//! What results count, and their table.

use nearmiss_ask::prompts::Techniques;
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{BatchId, ItemState, NewItem, RunId};
use nearmiss_study::evaluation::Outcome;
use nearmiss_study::evaluation::batch::{AnswerSet, BatchPart, Experiment, Spec, TruthSource};
use nearmiss_study::evaluation::report::{DataHalf, Report};
use nearmiss_workflow::TruthChoice;
use ratatui::layout::Position;

use crate::features::results::request::{ResultsCommand, ResultsEvent};
use crate::loaded::Opened;
use crate::message::{Mouse, Msg};
use crate::tests::everywhere::seen_in_every_theme;
use crate::tests::history::{FIRST, Fixture};
use crate::tests::results::{counts, four, press, settle};

pub(super) const YES: &str = r#"{"safety_critical": true, "obstacles": [{"id": 9, "risk_score": 0, "reason": "r"}], "justification": "j"}"#;
pub(super) const NO: &str = r#"{"safety_critical": false, "obstacles": [], "justification": "j"}"#;

pub(super) fn item(scenario: &str, label: (bool, Option<i64>), transform: Option<&str>) -> NewItem {
    NewItem {
        path: scenario.into(),
        scenario: scenario.into(),
        scenario_hash: None,
        ego: None,
        task: Task::Safety,
        frame: Some("cartesian".into()),
        techniques: Some("cp".into()),
        model: "lab/small".into(),
        sample: 0,
        lead: None,
        transform: transform.map(Into::into),
        key: None,
        facts: None,
        scene: None,
        window: None,
        collides: Some(label.0),
        obstacle: label.1,
        unaskable: None,
        settings: None,
        split: None,
    }
}

pub(super) fn spec() -> Spec {
    Spec {
        experiment: Experiment {
            tasks: vec![Task::Safety],
            frames: vec![Frame::Cartesian],
            techniques: vec![Techniques::parse("cp").unwrap()],
            models: vec!["lab/small".into()],
            transforms: vec![Transform::Mirror],
            truth: Some(TruthSource::Files(vec!["/labels/ours.csv".into()])),
            scenarios: vec!["recorded".into()],
            ..Experiment::default()
        },
        ..Spec::default()
    }
}

/// Adds a run about the bundled scenario mirrored.
fn mirrored(kept: &mut Fixture) -> RunId {
    let entry = bundled().into_iter().find(|e| e.name == FIRST).unwrap();
    let thresholds = Thresholds::shipped();
    let opened = Opened::changed(
        &entry,
        &EgoSelection::Beside,
        thresholds,
        Some(Transform::Mirror),
    );
    let opened = Box::new(opened.unwrap());
    let name = opened.name.clone();
    assert_eq!(name, format!("{FIRST} [mirror]"));
    let before = kept.bench.model.opened.replace(opened);
    let run = kept.add(&name, "lab/small", true, YES);
    kept.bench.model.opened = before;
    run
}

/// A batch whose labels say that all is safe in the first scenario, that another obstacle is hit in another one, and
/// that the mirrored first one is safe too; a fourth question waits.
pub(super) fn labelled() -> (Fixture, BatchId, RunId) {
    let mut kept = Fixture::new();
    let runs = [
        kept.add(FIRST, "lab/small", true, YES),
        kept.add("ZAM_Other-1_1_T-1", "lab/small", true, YES),
        mirrored(&mut kept),
        kept.add("ZAM_Third-1_1_T-1", "lab/small", false, NO),
    ];
    let items = [
        item(FIRST, (false, None), None),
        item("ZAM_Other-1_1_T-1", (true, Some(77)), None),
        item(FIRST, (false, None), Some("mirror")),
        item("ZAM_Third-1_1_T-1", (true, None), None),
        item("ZAM_Waits-1_1_T-1", (true, None), None),
    ];
    let batch = kept
        .store
        .begin_batch(&spec().to_json(), None, &items)
        .unwrap();
    for (place, run) in (0..).zip(runs) {
        let (store, state) = (&kept.store, ItemState::Answered);
        let set = store.set_item(batch, place, None, state, Some(run), None);
        set.unwrap();
    }
    (kept, batch, runs[2])
}

#[test]
fn a_batch_counts_by_its_own_truth_and_the_screen_says_so() {
    let (mut kept, batch, _) = labelled();
    press(&mut kept, "space o r");
    let results = &kept.bench.model.results;
    let plain = Some(AnswerSet::Batch(batch, BatchPart::Plain));
    assert_eq!(results.counting, plain);
    assert_eq!(results.unasked, 1);
    // Safe by the labels; and a yes is a yes, whichever obstacle it names.
    assert_eq!(counts(&kept, 0), [1, 1, 1, 0, 0, 0, 0]);
    // As the report of the batch has it.
    let answers = nearmiss_study::evaluation::batch::answers(&kept.store, batch).unwrap();
    let report = Report::from_scored(&answers.plain);
    let mut cells = report.cells.iter();
    let cell = cells.find(|c| c.half == DataHalf::All).unwrap();
    let row = &kept.bench.model.results.rows[0];
    assert_eq!((row.confusion(), row.f1), (cell.confusion, cell.f1_ci));
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = kept.bench.frame(columns, rows);
        let line: Vec<&str> = frame.split_whitespace().collect();
        let words = line.join(" ").replace(" ┃┃", "").replace('┃', "");
        let truth = "truth: labels from /labels/ours.csv";
        for said in ["batch b1", truth, "1 question not asked"] {
            assert!(words.contains(said), "{said}\n{frame}");
        }
    }
    press(&mut kept, "enter");
    let frame = kept.bench.frame(80, 24);
    assert!(
        frame.contains("of batch b1") && frame.contains("ours.csv"),
        "{frame}"
    );
}

#[test]
fn what_is_counted_can_be_chosen() {
    let (mut kept, batch, _) = labelled();
    press(&mut kept, "space o r b");
    let offers: Vec<String> = kept
        .bench
        .model
        .results
        .offers
        .iter()
        .map(|o| o.counting.to_string())
        .collect();
    assert_eq!(
        offers,
        [
            "batch b1",
            "batch b1, transform mirror",
            "everything in the store"
        ]
    );
    for size in [(80, 24), (200, 60)] {
        let words = seen_in_every_theme("what is counted", &mut kept.bench, size, true);
        assert!(
            words.contains("4 of 5") && words.contains("truth: labels from"),
            "{words}"
        );
    }
    press(&mut kept, "esc");
    assert_eq!(kept.bench.model.results.choosing, None);
    press(&mut kept, "b j enter");
    let mirror = AnswerSet::Batch(batch, BatchPart::Changed(Transform::Mirror));
    assert_eq!(kept.bench.model.results.counting, Some(mirror));
    assert_eq!(counts(&kept, 0), [0, 1, 0, 0, 0, 0, 0]);
    press(&mut kept, "b j enter");
    assert_eq!(
        kept.bench.model.results.counting,
        Some(AnswerSet::Everything)
    );
    // The labels of the batch count there, too; a changed scene is another question.
    assert_eq!(counts(&kept, 0), [1, 1, 1, 0, 0, 0, 0]);
    // Of a batch another truth can be chosen; where there are labels, the judge's prediction is none.
    press(&mut kept, "b g enter t");
    assert_eq!(kept.bench.model.results.truth, TruthChoice::Labels);
    assert_eq!(counts(&kept, 0), [1, 1, 1, 0, 0, 0, 0]);
    press(&mut kept, "t");
    assert_eq!(kept.bench.model.results.truth, TruthChoice::Recorded);
    assert_eq!(counts(&kept, 0)[4], 2, "two scenarios are not in the list");
    press(&mut kept, "t");
    let score = TruthChoice::Score(nearmiss_scene::metrics::RiskConvention::Exact);
    assert_eq!(kept.bench.model.results.truth, score);
    press(&mut kept, "t t b shift-g enter");
    assert_eq!(kept.bench.model.results.truth, TruthChoice::Usual);
    press(&mut kept, "esc space o r");
    assert_eq!(
        kept.bench.model.results.counting,
        Some(AnswerSet::Everything)
    );
}

#[test]
fn an_answer_about_a_changed_scene_opens_it_changed() {
    let (mut kept, _, run) = labelled();
    press(&mut kept, "space o r b j enter enter enter");
    let model = &kept.bench.model;
    let opened = model.opened.as_ref().unwrap();
    assert_eq!(opened.name, format!("{FIRST} [mirror]"));
    assert_eq!(opened.change, Some(Transform::Mirror));
    assert_eq!(
        model.answers.column().unwrap().answer().unwrap().run,
        Some(run)
    );
    let said = &model.toasts.last().unwrap().text;
    assert!(
        said.contains("transformed") && said.contains("mirror") && !said.contains("changed since"),
        "{said}"
    );
    let frame = kept.bench.frame(160, 45);
    assert!(frame.contains("[mirror]"), "{frame}");
    // Another ego leaves it changed; the way back is named.
    let picked = kept.bench.model.picked.unwrap();
    press(&mut kept, "space e t");
    let opened = kept.bench.model.opened.as_ref().unwrap();
    assert_eq!(
        (opened.change, opened.scene.as_ref().unwrap().ego.id),
        (Some(Transform::Mirror), picked)
    );
    press(&mut kept, "space e r");
    assert_eq!(
        kept.bench.model.opened.as_ref().unwrap().change,
        Some(Transform::Mirror)
    );
    press(&mut kept, "space e r");
    let opened = kept.bench.model.opened.as_ref().unwrap();
    assert_eq!((opened.name.as_str(), opened.change), (FIRST, None));
}

#[test]
fn a_batch_that_is_gone_is_said() {
    let mut kept = four();
    kept.bench.model.results.chosen = Some(AnswerSet::Batch(BatchId(7), BatchPart::Plain));
    press(&mut kept, "esc space o r");
    let error = kept.bench.model.results.error.clone().unwrap();
    assert!(error.contains("no batch b7"), "{error}");
    assert!(!kept.bench.model.results.reading);
}

#[test]
fn progress_is_shown_while_scenarios_are_judged() {
    let mut kept = four();
    press(&mut kept, "esc");
    kept.bench.press("space o r");
    let ask = kept.bench.effects.pop().unwrap().into_request();
    let ask = ask.expect("the store is to be read");
    let judging = crate::features::history::request::Judging {
        ego: EgoSelection::Beside,
        thresholds: std::sync::Arc::new(Thresholds::shipped().clone()),
    };
    let mut said = Vec::new();
    let going = std::sync::atomic::AtomicBool::new(false);
    crate::features::results::request::answer(&kept.store, &judging, ask, &going, &mut |news| {
        said.push(news)
    });
    use ResultsEvent::{Judging, Read};
    assert!(matches!(
        &said[..],
        [Read(..), Judging(_, (1, 1)), Read(..)]
    ));
    for (place, news) in said.into_iter().enumerate() {
        kept.bench.send(Msg::reply::<ResultsCommand>(news));
        let done = [Some((0, 0)), Some((1, 1)), None][place];
        assert_eq!(kept.bench.model.results.judging, done);
        // No number that needs the truth is shown until it is known.
        let frame = kept.bench.frame(80, 24);
        assert_eq!(frame.contains("…    …    …    …"), place < 2, "{frame}");
        assert_eq!(frame.contains("judging… 1 of 1"), place == 1, "{frame}");
    }
    assert_eq!(counts(&kept, 1)[4], 1);
}

/// Where a text stands on the screen.
fn find(kept: &Fixture, text: &str) -> Position {
    let frame = kept.bench.frame(200, 60);
    let mut lines = frame.lines().enumerate();
    let found = lines.find_map(|(y, line)| {
        let x = line.find(text).map(|at| line[..at].chars().count())?;
        Some(Position::new(
            u16::try_from(x).unwrap(),
            u16::try_from(y).unwrap(),
        ))
    });
    found.unwrap_or_else(|| panic!("no {text}\n{frame}"))
}

fn mouse(kept: &mut Fixture, mouse: Mouse) {
    kept.bench.frame(200, 60);
    kept.bench.send(Msg::Mouse(mouse));
    settle(kept);
}

#[test]
fn a_click_selects_a_second_one_opens_and_the_wheel_moves() {
    let (mut kept, batch, _) = labelled();
    kept.add("ZAM_Lost-1_1_T-1", "lab/large", true, "something is near");
    press(&mut kept, "space o r b shift-g enter t t");
    kept.bench.model.results.selected = 0;
    let small = find(&kept, "lab/small");
    let head = find(&kept, "no truth  no verdict");
    // On the number of open ones, below their head.
    let open = Position::new(head.x + 7, small.y);
    mouse(&mut kept, Mouse::Press(open));
    let results = &kept.bench.model.results;
    assert_eq!(
        (results.selected, results.column, results.inside),
        (1, 5, None)
    );
    mouse(&mut kept, Mouse::WheelUp(open));
    assert_eq!(kept.bench.model.results.selected, 0);
    mouse(&mut kept, Mouse::WheelDown(open));
    mouse(&mut kept, Mouse::Press(open));
    assert_eq!(kept.bench.model.results.inside, Some(0));
    let third = find(&kept, "ZAM_Third");
    mouse(&mut kept, Mouse::Press(third));
    assert_eq!(kept.bench.model.results.inside, Some(1));
    press(&mut kept, "esc");
    // A bar is a row of the matrix; what is not in a list does nothing.
    kept.bench.model.results.selected = 1;
    let bar = find(&kept, "right by techniques");
    mouse(&mut kept, Mouse::Press(Position::new(3, bar.y + 1)));
    mouse(&mut kept, Mouse::Press(bar));
    mouse(&mut kept, Mouse::Press(Position::new(119, 39)));
    assert_eq!(kept.bench.model.results.selected, 1);
    // The list of what is counted, too.
    press(&mut kept, "b");
    let first = find(&kept, "batch b1  ");
    mouse(&mut kept, Mouse::Press(first));
    assert_eq!(kept.bench.model.results.choosing, Some(0));
    mouse(&mut kept, Mouse::Press(first));
    let counting = Some(AnswerSet::Batch(batch, BatchPart::Plain));
    assert_eq!(kept.bench.model.results.counting, counting);
    // From an answer to its scenario.
    press(&mut kept, "left left left left left enter");
    let answer = find(&kept, FIRST);
    mouse(&mut kept, Mouse::Press(answer));
    assert!(kept.bench.model.screens.is_empty());
    assert_eq!(kept.bench.model.opened.as_ref().unwrap().name, FIRST);
}

#[test]
fn how_a_batch_looks_in_every_theme() {
    for size @ (columns, rows) in [(80, 24), (200, 60)] {
        let mut kept = techniques();
        kept.bench.model.size = size;
        press(&mut kept, "space o r j right right");
        let text = seen_in_every_theme("a batch", &mut kept.bench, size, true);
        insta::assert_snapshot!(format!("results_of_a_batch_at_{columns}_by_{rows}"), text);
    }
}

#[test]
fn rows_are_sorted_by_any_column_and_written_where_pictures_go() {
    let folder = tempfile::tempdir().unwrap();
    let mut kept = techniques();
    kept.bench.model.config.pictures = Some(folder.path().into());
    press(&mut kept, "space o r");
    let column = |kept: &Fixture| -> Vec<u32> {
        let rows = kept.bench.model.results.rows.iter();
        rows.map(|row| row.count(Outcome::TruePositive)).collect()
    };
    let by_prompt = column(&kept);
    press(&mut kept, "right s");
    assert!(column(&kept).is_sorted_by(|a, b| a >= b));
    assert!(kept.bench.frame(120, 40).contains("▼=tp"));
    press(&mut kept, "s");
    assert!(column(&kept).is_sorted());
    assert!(kept.bench.frame(120, 40).contains("▲=tp"));
    press(&mut kept, "s");
    assert_eq!(column(&kept), by_prompt);
    press(&mut kept, "e e");
    let said = &kept.bench.model.toasts.last().unwrap().text;
    assert!(said.contains("results_2.csv"), "{said}");
    let table = std::fs::read_to_string(folder.path().join("results.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert!(table.contains("labels from /labels/ours.csv"), "{table}");
    let lines = std::fs::read_to_string(folder.path().join("results.jsonl")).unwrap();
    let row: serde_json::Value = serde_json::from_str(lines.lines().next().unwrap()).unwrap();
    assert_eq!(row["tp"], by_prompt[0]);
}

/// A batch of two models, each asked with four sets of techniques about twelve scenarios; what they say is up to their
/// places.
pub(super) fn techniques() -> Fixture {
    let mut kept = Fixture::new();
    let mut items = Vec::new();
    for (model, skill) in [("lab/large", 5), ("lab/small", 3)] {
        for (place, words) in ["base", "cp", "cp+cot", "cp+cot+icl"]
            .into_iter()
            .enumerate()
        {
            for n in 0..12 {
                let right = (n * 7 + place * 3) % 8 < skill + place / 2;
                let text = if (n % 2 == 0) == right { YES } else { NO };
                let run = kept.add(&format!("ZAM_Town-{n}_1_T-1"), model, text == YES, text);
                let asked = NewItem {
                    techniques: Some(words.into()),
                    model: model.into(),
                    ..item(&format!("ZAM_Town-{n}_1_T-1"), (n % 2 == 0, None), None)
                };
                items.push((asked, run));
            }
        }
    }
    let asked: Vec<NewItem> = items.iter().map(|(item, _)| item.clone()).collect();
    let (store, state) = (&kept.store, ItemState::Answered);
    let batch = store.begin_batch(&spec().to_json(), None, &asked).unwrap();
    for (place, (_, run)) in (0..).zip(items) {
        let set = store.set_item(batch, place, None, state, Some(run), None);
        set.unwrap();
    }
    kept
}
