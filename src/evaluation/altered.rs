//! Questions about changed scenes, and about windows that end some time before a collision.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Label;
use super::lead::{Labelled, Lead};
use super::plan::{Plan, PlanError};
use super::question::Question;
use crate::scenario::{Entry, Transform, WantedEgo};

/// A question, and whose ids it is asked with.
#[derive(Debug, Clone)]
pub struct Altered {
    /// The question; the description and the window are those of the changed scene. Its scenario is called as
    /// [`Transform::name`] says, and has a hash of its own, so that answers to it are not taken for others.
    pub question: Question,
    /// From the ids of its obstacles to those of the scenario as it is.
    pub ids: BTreeMap<i64, i64>,
}

/// The question of a plan about a scenario with this ego, as it is or changed, with the plan's window or one that ends
/// a time before the collision; see [`altered`].
///
/// # Errors
/// See [`altered`].
pub fn question_for(
    plan: &Plan,
    entry: &Entry,
    ego: &WantedEgo,
    transform: Option<Transform>,
    lead: Option<Lead>,
) -> Result<Question, PlanError> {
    altered(plan, entry, ego, transform, lead.map(|lead| (lead, None))).map(|a| a.question)
}

/// The same with the ids. A lead is counted from the collision of the label, where there is one, else from the first step
/// at which the bodies of the ego and anyone else overlap; see [`Labelled::window`].
///
/// # Errors
/// It cannot be read, has no ego, the window would end before the recording begins, or no prompt can be made of it.
pub fn altered(
    plan: &Plan,
    entry: &Entry,
    ego: &WantedEgo,
    transform: Option<Transform>,
    lead: Option<(Lead, Option<Label>)>,
) -> Result<Altered, PlanError> {
    let scene = plan.scene(entry, ego)?;
    let window = match lead {
        None => plan.window(&scene),
        Some((lead, label)) => {
            let labelled = Labelled::new(&scene, label);
            let window = labelled.window(lead, plan.decided.history);
            window.ok_or_else(|| PlanError::TooEarly {
                scenario: entry.name.clone(),
                lead: lead.to_string(),
            })?
        }
    };
    let Some(transform) = transform else {
        let obstacles = scene.scenario.obstacles.iter();
        let ids = obstacles.map(|o| (o.id, o.id)).collect();
        let question = plan.question_about(entry.name.clone(), scene, window, None)?;
        return Ok(Altered { question, ids });
    };
    let changed = transform.apply(&scene);
    let obstacle = plan.decided.options.obstacle;
    let obstacle = obstacle.map(|old| {
        let mut all = changed.ids.iter();
        all.find(|(_, id)| **id == old).map_or(old, |(new, _)| *new)
    });
    let name = transform.name(&entry.name);
    let scene = Arc::new(changed.scene);
    let question = plan.question_about(name, scene, window, obstacle)?;
    Ok(Altered {
        question,
        ids: changed.ids,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::Settings;
    use crate::judge::judge;
    use crate::metrics::Thresholds;
    use crate::prompts::Library;
    use crate::scenario::{Window, bundled};
    use crate::text::Frame;
    use crate::verdict::Task;

    fn plan(frame: Frame) -> Plan {
        Plan {
            task: Task::Safety,
            frame,
            decided: Settings::default().with(&crate::prompts::Defaults::default()),
            library: Library::load(None),
            draft: None,
            thresholds: Arc::new(Thresholds::shipped().clone()),
        }
    }

    #[test]
    fn the_changed_scene_is_described_under_a_name_and_hash_of_its_own() {
        let entry = &bundled()[0];
        let beside = WantedEgo::Beside;
        let ask =
            |frame, transform| question_for(&plan(frame), entry, &beside, transform, None).unwrap();
        let plain = plan(Frame::Ego).question(entry, &beside).unwrap();
        assert_eq!(ask(Frame::Ego, None).messages(), plain.messages());
        let turned = ask(Frame::Cartesian, Some(Transform::Rotate(1.0)));
        let as_it_is = ask(Frame::Cartesian, None);
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
        let turned = ask(Frame::Ego, Some(Transform::Rotate(1.0)));
        assert_eq!(turned.description, ask(Frame::Ego, None).description);
    }

    #[test]
    fn new_numbers_are_described_and_can_be_told_back() {
        let entry = bundled()
            .into_iter()
            .find(|e| e.name.contains("CutIn"))
            .unwrap();
        let plan = plan(Frame::Ego);
        let beside = WantedEgo::Beside;
        let change = Some(Transform::Renumber(1));
        let altered = altered(&plan, &entry, &beside, change, None).unwrap();
        let original = plan.question(&entry, &beside).unwrap();
        assert_ne!(altered.question.description, original.description);
        let said = plan.truth(&altered.question).unwrap();
        let before = plan.truth(&original).unwrap();
        let back: Vec<i64> = said.obstacles.iter().map(|o| altered.ids[&o.id]).collect();
        let known: Vec<i64> = before.obstacles.iter().map(|o| o.id).collect();
        assert!(!known.is_empty());
        assert_eq!(back, known);
    }

    #[test]
    fn a_lead_ends_the_window_before_the_collision() {
        let plan = plan(Frame::Ego);
        let beside = WantedEgo::Beside;
        let mut collisions = 0;
        for entry in bundled() {
            let whole = plan.question(&entry, &beside).unwrap();
            let scene = &whole.case.scene;
            let all = Window::ending_at(scene, i64::MAX, 1);
            let Some(contact) = judge(scene, Task::Collision, &all).decisive_step else {
                continue;
            };
            collisions += 1;
            let ask = |seconds| {
                let lead = Some(Lead::Seconds(seconds));
                question_for(&plan, &entry, &beside, Some(Transform::Mirror), lead)
            };
            let steps = (1.0 / scene.scenario.dt()).round() as i64;
            assert_eq!(ask(1.0).unwrap().case.window.last(), contact - steps);
            let error = ask(3000.0).unwrap_err().to_string();
            assert!(
                error.contains(&entry.name) && error.contains("3000"),
                "{error}"
            );
        }
        assert!(collisions > 0);
    }
}
