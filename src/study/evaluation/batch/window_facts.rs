//! What is known of a question's window beside its label: whom the ego touches, traffic, speed, measures and length.

use crate::evaluation::Question;
use crate::evaluation::windows::Traffic;
use nearmiss_scene::metrics::{Context, MEASURES};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_store::WindowFacts;

/// What trivial rules look at in a window.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct RuleValues {
    nearest: Option<f64>,
    ttc: Option<f64>,
}

impl RuleValues {
    /// Least distance in a window, metres, and least time to collision at its end, seconds.
    pub fn new(scene: &Scene, window: &Window) -> Self {
        let context = Context::new(scene);
        let least = |id: &str, steps: std::ops::RangeInclusive<i64>| {
            let measure = MEASURES.iter().find(|measure| measure.id == id)?;
            let pairs = (0..context.participants().len())
                .flat_map(|place| steps.clone().map(move |step| (place, step)));
            let values = pairs.filter_map(|(place, step)| {
                measure.evaluate(&context.encounter(place, step)?).value()
            });
            values.min_by(f64::total_cmp)
        };
        Self {
            nearest: least("distance", window.first()..=window.last()),
            ttc: least("ttc", window.last()..=window.last()),
        }
    }
}

/// What is known of a question's window.
pub(super) fn facts(question: &Question, critical: Vec<i64>, values: RuleValues) -> WindowFacts {
    let case = &question.case;
    let traffic = Traffic::in_window(&case.scene, &case.window, case.options.radius);
    WindowFacts {
        steps: (case.window.first(), case.window.last()),
        critical,
        obstacles: traffic.obstacles as u64,
        speed: traffic.speed,
        nearest: values.nearest,
        ttc: values.ttc,
        tokens: question.tokens() as u64,
        template_hash: question.template_hash.clone(),
    }
}
