//! Descriptions of random windows with random options: never a panic, every number traced, the right steps.

use std::sync::LazyLock;

use nearmiss::description::{DescriptionError, EgoAxes, Form, Frame, Options, Value, describe};
use nearmiss::formats::bundled;
use nearmiss::scenario::{Scene, Window};
use proptest::prelude::*;

use crate::words::{check_spans, scene};

static SCENES: LazyLock<Vec<Scene>> =
    LazyLock::new(|| bundled().iter().map(|e| scene(&e.name)).collect());

fn options() -> impl Strategy<Value = Options> {
    (
        prop_oneof![0.01..80.0, Just(f64::MAX)],
        0..=9_usize,
        prop_oneof![0..20_usize, Just(usize::MAX)],
        prop::bool::ANY,
        prop::option::of(0..40_usize),
    )
        .prop_map(|(radius, precision, stride, compact, obstacle)| Options {
            road: compact,
            axes: EgoAxes::ALL[stride % 2],
            measures: None,
            contact: compact,
            radius,
            reach: compact.then_some(2.0),
            precision,
            stride,
            most_times: None,
            nearest: false,
            form: if compact { Form::Compact } else { Form::Prose },
            obstacle: obstacle.map(|n| n as i64),
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn any_window_any_options(
        which in 0..8_usize,
        last in -10..250_i64,
        history in prop_oneof![1..30_usize, Just(usize::MAX)],
        frame in 0..4_usize,
        options in options(),
    ) {
        let scene = &SCENES[which];
        let frame = Frame::ALL[frame];
        let all: Vec<i64> = scene.participants().map(|p| p.obstacle.id).collect();
        let options = Options {
            // Some of them exist.
            obstacle: options.obstacle.map(|n| all.get(n as usize).copied().unwrap_or(n)),
            ..options
        };
        let window = Window::ending_at(scene, last, history);
        let steps = options.steps(&window);
        prop_assert_eq!(steps.last(), Some(&window.last()));
        prop_assert!(steps[0] >= window.first());
        let stride = i64::try_from(options.stride.max(1)).unwrap_or(i64::MAX);
        prop_assert!(steps.windows(2).all(|pair| pair[1] - pair[0] == stride));
        prop_assert!(steps[0] - window.first() < stride);
        match describe(scene, frame, &window, &options) {
            Ok(described) => {
                check_spans(&described);
                // Between the line that says what times are relative to and the worst values.
                let text = &described.text;
                let first = if frame.is_of_one_obstacle() { 0 } else { text.find('\n').unwrap() };
                // A table along the lane first says at which times there is none.
                let notes = text.rfind("along and across its heading.\n");
                let first = notes.filter(|_| options.form == Form::Compact).unwrap_or(first);
                let end = text.find("\nWorst").unwrap_or(text.len());
                let mut told: Vec<i64> = described
                    .spans
                    .iter()
                    .filter(|s| s.quantity == "time" && s.start > first && s.end < end)
                    .filter_map(|s| s.step)
                    .collect();
                told.dedup();
                prop_assert_eq!(told, steps);
                let outside = described.spans.iter().filter_map(|s| s.step).find(|s| {
                    !window.steps().contains(s)
                });
                prop_assert_eq!(outside, None);
                let finite = described.spans.iter().all(|s| match s.value {
                    Value::Real(value) => value.is_finite(),
                    Value::Whole(_) => true,
                });
                prop_assert!(finite);
            }
            Err(DescriptionError::NoObstacle) => prop_assert!(frame.is_of_one_obstacle()),
            Err(DescriptionError::UnknownObstacle { id, .. }) => prop_assert!(!all.contains(&id)),
            Err(DescriptionError::NotThere { .. }) => prop_assert!(frame.is_of_one_obstacle()),
        }
    }
}
