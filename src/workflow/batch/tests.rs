//! Tests of which questions are asked again, and how leads and changes vary a question.

use std::sync::Arc;

use super::{BatchPlan, BatchRequest, PlanningEvent, Selection};
use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Transform, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::{Experiment, QuestionBuilder, Variant};
use nearmiss_study::evaluation::{AxisValues, Lead, PromptConfig, Question};

#[test]
fn what_is_asked_again_depends_on_where_it_stands() {
    use nearmiss_store::ItemState::{Answered, Failed, Truncated, Unaskable, Waiting};
    let all = [Waiting, Answered, Truncated, Failed, Unaskable];
    let of = |selection: Selection| all.map(|state| selection.has(state));
    assert_eq!(of(Selection::Open), [true, false, false, true, true]);
    assert_eq!(of(Selection::Failed), [false, false, true, true, true]);
}

fn builder() -> QuestionBuilder {
    let thresholds = Arc::new(Thresholds::shipped().clone());
    QuestionBuilder::new(
        Library::load(None),
        thresholds,
        Experiment::default(),
        EgoSelection::Beside,
    )
}

fn configuration(task: Task, frame: Frame) -> PromptConfig {
    PromptConfig {
        task,
        frame: Some(frame),
        techniques: Some(Techniques::ALL),
        model: "lab/small".into(),
        settings: AxisValues::default(),
        template: None,
    }
}

fn changed(change: Transform) -> Variant {
    Variant {
        transform: Some(change),
        ..Variant::default()
    }
}

fn question(
    builder: &QuestionBuilder,
    entry: &Entry,
    configuration: &PromptConfig,
    variant: Variant,
) -> Arc<Question> {
    builder
        .question(entry, configuration, &variant, None)
        .unwrap()
}

#[test]
fn every_scenario_is_asked_about_in_the_same_way() {
    let builder = builder();
    let plain = Variant::default();
    let mut dangerous = 0;
    for entry in bundled() {
        let safety = question(
            &builder,
            &entry,
            &configuration(Task::Safety, Frame::Ego),
            plain,
        );
        assert_eq!(safety.case.window.last(), safety.case.scene.last_step() - 2);
        assert!(safety.tokens() > 100);
        let collision = question(
            &builder,
            &entry,
            &configuration(Task::Collision, Frame::Ego),
            plain,
        );
        assert_eq!(
            collision.case.window.last(),
            collision.case.scene.last_step()
        );
        dangerous += usize::from(collision.reference().unwrap().dangerous);
    }
    assert_eq!(dangerous, 2);
    let lost = Entry::of_file(std::path::Path::new("no/such.xml"));
    let why = builder.question(
        &lost,
        &configuration(Task::Safety, Frame::Ego),
        &plain,
        None,
    );
    assert!(why.is_err_and(|why| why.contains("no/such.xml")));
}

#[test]
fn the_changed_scene_is_described_under_a_name_and_hash_of_its_own() {
    let (builder, entry) = (builder(), &bundled()[0]);
    let ask = |frame, variant| {
        question(
            &builder,
            entry,
            &configuration(Task::Safety, frame),
            variant,
        )
    };
    let rotated = changed(Transform::Rotate(1.0));
    let turned = ask(Frame::Cartesian, rotated);
    let as_it_is = ask(Frame::Cartesian, Variant::default());
    assert_ne!(turned.description, as_it_is.description);
    assert_eq!(
        turned.case.name,
        format!("{} [rotate:57.295779513]", entry.name)
    );
    let hash = |q: &Question| q.case.scene.scenario.hash;
    assert_ne!(hash(&turned), hash(&as_it_is));
    assert_eq!(turned.case.window.last(), as_it_is.case.window.last());
    // The change is for the store; a model is not told.
    assert!(!turned.prompt.user.contains("rotate") && !turned.prompt.system.contains("rotate"));
    // Seen from the ego nothing has turned.
    let turned = ask(Frame::Ego, rotated);
    let plain = ask(Frame::Ego, Variant::default());
    assert_eq!(turned.description, plain.description);
}

#[test]
fn new_numbers_are_described_and_can_be_told_back() {
    let entry = bundled()
        .into_iter()
        .find(|e| e.name.contains("CutIn"))
        .unwrap();
    let (builder, configuration) = (builder(), configuration(Task::Safety, Frame::Ego));
    let change = Transform::Renumber(1);
    let renumbered = question(&builder, &entry, &configuration, changed(change));
    let original = question(&builder, &entry, &configuration, Variant::default());
    assert_ne!(renumbered.description, original.description);
    let (now, before) = (
        renumbered.reference().unwrap(),
        original.reference().unwrap(),
    );
    let ids = change.ids(&entry.read().unwrap());
    let back: Vec<i64> = now.obstacles.iter().map(|o| ids[&o.id]).collect();
    let known: Vec<i64> = before.obstacles.iter().map(|o| o.id).collect();
    assert!(!known.is_empty());
    assert_eq!(back, known);
}

fn request(entries: Vec<Entry>, every_scenario: bool) -> BatchRequest {
    let mut experiment = Experiment {
        tasks: vec![Task::Safety],
        frames: vec![Frame::Ego],
        techniques: vec![Techniques::ALL],
        scenarios: vec!["scenarios".into()],
        models: vec!["lab/small".into()],
        every_scenario,
        ..Experiment::default()
    };
    experiment.draw_windows();
    BatchRequest {
        experiment,
        entries,
        ego: EgoSelection::Beside,
        shard: None,
        drafts: Default::default(),
    }
}

#[test]
fn where_every_scenario_is_to_be_asked_about_each_has_a_window() {
    let thresholds = Arc::new(Thresholds::shipped().clone());
    let library = Library::load(None);
    let mut read = Vec::new();
    let mut plan = |entries: Vec<Entry>, every: bool| {
        let on_event = &mut |event| read.push(event);
        let plan =
            request(entries, every).plan(&library, &thresholds, &Cancel::default(), on_event);
        plan.unwrap().unwrap()
    };
    let windows = |plan: &BatchPlan| -> Vec<usize> {
        let asks = plan.scenarios.iter().map(|(_, asks)| asks);
        asks.map(|asks| asks.iter().filter(|ask| ask.truth.is_some()).count())
            .collect()
    };
    let some = plan(bundled(), false);
    assert!(windows(&some).contains(&0), "{:?}", windows(&some));
    let words = some.left_out.as_deref().unwrap();
    assert!(words.contains("unlike the dangerous windows"), "{words}");
    let all = plan(bundled(), true);
    assert!(!windows(&all).contains(&0), "{:?}", windows(&all));
    assert_eq!(all.left_out, None);
    // What is matched stays as it is.
    for ((entry, with), (_, without)) in all.scenarios.iter().zip(&some.scenarios) {
        assert!(
            without.iter().all(|ask| with.contains(ask)),
            "{}",
            entry.name
        );
    }
    // Of one that collides, of safe ones alone.
    for entry in bundled() {
        let name = entry.name.clone();
        assert!(windows(&plan(vec![entry], true))[0] > 0, "{name}");
    }
    let of = bundled().len();
    assert!(read.contains(&PlanningEvent::Read { done: of, of }));
}

#[test]
fn drawing_windows_can_be_cancelled() {
    let thresholds = Arc::new(Thresholds::shipped().clone());
    let cancel = Cancel::default();
    cancel.ask();
    let plan =
        request(bundled(), true).plan(&Library::load(None), &thresholds, &cancel, &mut |_| {});
    assert!(plan.unwrap().is_none());
}

#[test]
fn a_lead_ends_the_window_before_the_collision() {
    let (builder, configuration) = (builder(), configuration(Task::Safety, Frame::Ego));
    let mut collisions = 0;
    for entry in bundled() {
        let whole = question(&builder, &entry, &configuration, Variant::default());
        let scene = &whole.case.scene;
        let all = Window::ending_at(scene, i64::MAX, 1);
        let Some(contact) = judge(scene, Task::Collision, &all).decisive_step else {
            continue;
        };
        collisions += 1;
        let ask = |seconds| {
            let variant = Variant {
                lead: Some(Lead::Seconds(seconds)),
                ..changed(Transform::Mirror)
            };
            builder.question(&entry, &configuration, &variant, None)
        };
        let steps = (1.0 / scene.scenario.dt()).round() as i64;
        assert_eq!(ask(1.0).unwrap().case.window.last(), contact - steps);
        let error = ask(3000.0).unwrap_err();
        assert!(
            error.contains(&entry.name) && error.contains("3000"),
            "{error}"
        );
    }
    assert!(collisions > 0);
}
