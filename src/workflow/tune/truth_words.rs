//! What is exactly true about a question, with the reason, for the reflecting model.

use super::prepare::{TunePlan, TuneQuestion};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::{Label, Labelled};

/// The truth about a question in a sentence.
pub(super) fn truth_words(plan: &TunePlan, asked: &TuneQuestion) -> String {
    let case = &asked.question.case;
    let whom = match asked.critical.as_slice() {
        [] => "another body".to_string(),
        [one] => format!("obstacle {one}"),
        several => {
            let ids: Vec<String> = several.iter().map(ToString::to_string).collect();
            format!("obstacles {}", ids.join(", "))
        }
    };
    let extreme = Task::HIGH_RISK;
    match (asked.truth, case.task) {
        (Label::Collision(_), _) if plan.by_score => {
            format!("yes: the exact risk score of {whom} is {extreme} or lower")
        }
        (Label::Safe, _) if plan.by_score => {
            format!("no: no obstacle has an exact risk score of {extreme} or lower")
        }
        (Label::Collision(_), Task::Safety) => {
            let label = Some(asked.truth);
            let contact = Labelled::new(&case.scene, label).contact;
            let after =
                contact.map(|step| (step - case.window.last()) as f64 * case.scene.scenario.dt());
            match after.filter(|seconds| *seconds > 0.0) {
                Some(seconds) => format!(
                    "yes: the ego's body touches {whom}, first {seconds:.1} s after the last described moment"
                ),
                None => format!("yes: the ego's body touches {whom}"),
            }
        }
        (Label::Safe, Task::Safety) => format!(
            "no: the ego's body touches no other body within {} s after the last described moment",
            case.horizon
        ),
        (Label::Collision(_), _) => format!("yes: the ego's body touches that of {whom}"),
        (Label::Safe, _) => "no: no body touches the ego's at any step or between two".to_string(),
    }
}
