//! What is known of a question's window beside its label: whom the ego touches, traffic, speed and length.

use super::question_builder::{Ask, obstacle};
use crate::evaluation::windows::Traffic;
use crate::evaluation::{Label, Question};
use crate::store::WindowFacts;

/// What is known of a question's window.
pub(super) fn facts(question: &Question, ask: &Ask, label: Option<Label>) -> WindowFacts {
    let case = &question.case;
    let traffic = Traffic::in_window(&case.scene, &case.window, case.options.radius);
    let critical = match (&ask.truth, label) {
        (Some(truth), _) => truth.critical.clone(),
        (None, label) => obstacle(label).into_iter().collect(),
    };
    WindowFacts {
        steps: (case.window.first(), case.window.last()),
        critical,
        obstacles: traffic.obstacles as u64,
        speed: traffic.speed,
        tokens: question.tokens() as u64,
        template_hash: question.template_hash.clone(),
    }
}
