//! Complete descriptions compared with golden texts, and the trace of each number in them.

use nearmiss::description::{DescriptionError, Form, Frame, Options, Subject, Value, describe};
use nearmiss::metrics::{Encounter, measure};
use nearmiss::scenario::Window;

use crate::words::{check_spans, scene};

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";

/// The car that cuts in.
const CAR: i64 = 301;

fn described(frame: Frame, form: Form) -> String {
    let scene = scene(CUT_IN);
    let window = Window::ending_at(&scene, 44, 12);
    let options = Options {
        form,
        stride: 4,
        radius: 25.0,
        obstacle: frame.is_of_one_obstacle().then_some(CAR),
        ..Options::default()
    };
    let described = describe(&scene, frame, &window, &options).unwrap();
    check_spans(&described);
    described.text
}

macro_rules! snapshots {
    ($($name:ident: $frame:ident $form:ident;)+) => {
        $(#[test]
        fn $name() {
            insta::assert_snapshot!(described(Frame::$frame, Form::$form));
        })+
    };
}

snapshots! {
    cartesian_prose: Cartesian Prose;
    cartesian_compact: Cartesian Compact;
    ego_prose: Ego Prose;
    ego_compact: Ego Compact;
    metrics_prose: Metrics Prose;
    metrics_compact: Metrics Compact;
    trajectory_prose: Trajectory Prose;
    trajectory_compact: Trajectory Compact;
}

#[test]
fn both_forms_say_the_same_numbers() {
    let scene = scene(CUT_IN);
    let window = Window::ending_at(&scene, 50, 6);
    for frame in Frame::ALL {
        let values = |form| {
            let options = Options {
                form,
                obstacle: frame.is_of_one_obstacle().then_some(CAR),
                ..Options::default()
            };
            let described = describe(&scene, frame, &window, &options).unwrap();
            let numbers = described.spans.into_iter().filter_map(|span| {
                // Steps, times and ids stand in every row of a table.
                let when_and_who = ["step", "time", "id"].contains(&span.quantity);
                let value = match span.value {
                    // Sentences say the side in words.
                    Value::Real(value) if span.quantity == "heading_rel" => value.abs(),
                    Value::Real(value) => value,
                    Value::Whole(value) => value as f64,
                };
                let key = format!("{:?} {:?} {} {value}", span.step, span.of, span.quantity);
                (!when_and_who).then_some(key)
            });
            let mut numbers: Vec<String> = numbers.collect();
            numbers.sort();
            numbers
        };
        assert_eq!(values(Form::Prose), values(Form::Compact), "{frame:?}");
    }
}

#[test]
fn a_trace_leads_to_the_measure() {
    let scene = scene(CUT_IN);
    let window = Window::ending_at(&scene, 44, 3);
    let described = describe(&scene, Frame::Metrics, &window, &Options::default()).unwrap();
    let who = scene.participants().find(|p| p.obstacle.id == CAR).unwrap();
    let mut traced = 0;
    for id in ["distance", "ttc", "gap_long", "v_rel_lat", "risk"] {
        for step in window.steps() {
            let encounter = Encounter::at(&scene, &who, step).unwrap();
            let expected = measure(id).unwrap().compute(&encounter).value();
            let span = described.spans.iter().find(|s| {
                s.step == Some(step) && s.of == Subject::Obstacle(CAR) && s.quantity == id
            });
            let found = span.map(|s| match s.value {
                Value::Real(value) => value,
                Value::Whole(value) => value as f64,
            });
            // That bodies touch is not told by the score.
            let expected = expected.map(|v| if id == "risk" { v.max(1.0) } else { v });
            assert_eq!(found, expected, "{id} at {step}");
            traced += usize::from(found.is_some());
        }
    }
    assert!(traced >= 12, "{traced}");
}

#[test]
fn a_trajectory_needs_an_obstacle_that_is_there() {
    let scene = scene(CUT_IN);
    let window = Window::ending_at(&scene, 10, 5);
    let with = |obstacle| {
        let options = Options {
            obstacle,
            ..Options::default()
        };
        describe(&scene, Frame::Trajectory, &window, &options)
    };
    assert_eq!(with(None), Err(DescriptionError::NoObstacle));
    match with(Some(-5)) {
        Err(DescriptionError::UnknownObstacle { id: -5, known }) => assert!(known.contains("301")),
        other => panic!("{other:?}"),
    }
    assert!(with(Some(CAR)).is_ok());
}

#[test]
fn one_obstacle_alone_can_be_described_in_every_frame() {
    let scene = scene(CUT_IN);
    let window = Window::ending_at(&scene, 90, 3);
    let options = Options {
        obstacle: Some(CAR),
        ..Options::default()
    };
    for frame in Frame::ALL {
        let described = describe(&scene, frame, &window, &options).unwrap();
        let others = described
            .spans
            .iter()
            .filter(|s| matches!(s.of, Subject::Obstacle(id) if id != CAR));
        assert_eq!(others.count(), 0, "{frame:?}");
        assert!(described.text.contains("car 301"), "{frame:?}");
    }
}
