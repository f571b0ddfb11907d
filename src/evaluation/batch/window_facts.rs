//! What is known of a question's window beside its label: whom the ego touches, traffic, speed and length.

use crate::evaluation::Question;
use crate::evaluation::windows::Traffic;
use crate::store::WindowFacts;

/// What is known of a question's window.
pub(super) fn facts(question: &Question, critical: Vec<i64>) -> WindowFacts {
    let case = &question.case;
    let traffic = Traffic::in_window(&case.scene, &case.window, case.options.radius);
    WindowFacts {
        steps: (case.window.first(), case.window.last()),
        critical,
        obstacles: traffic.obstacles as u64,
        speed: traffic.speed,
        tokens: question.tokens() as u64,
        template_hash: question.template_hash.clone(),
    }
}
