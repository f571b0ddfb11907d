//! Earlier answers about what is open.

use super::super::message::Effect;
use super::super::model::{Column, Model, ShownAnswer};
use super::super::tasks::scenes::{LoadStored, StoredOf};
use super::{compare, reopen, timeline};
use nearmiss_scene::scenario::EgoSource;
use nearmiss_study::evaluation::Answer;

/// Loads the earlier answers on what is open.
pub fn load(model: &Model) -> Option<Effect> {
    subject(model).map(|of| LoadStored(of).into())
}

/// The subject that earlier answers must have.
pub fn subject(model: &Model) -> Option<StoredOf> {
    let scene = model.scene()?;
    Some(StoredOf {
        scenario: scene.scenario.hash.to_string(),
        name: model.opened.as_ref()?.name.clone(),
        ego: scene.ego.to_string(),
        recorded: matches!(scene.ego.source, EgoSource::Recording(_)),
        task: model.task,
    })
}

/// Takes earlier answers, if they are on what is open.
pub fn loaded(model: &mut Model, of: &StoredOf, stored: Vec<Answer>) {
    if subject(model).as_ref() != Some(of) {
        return;
    }
    let reopened = reopen::before_stored(model);
    show(model, stored);
    if let Some(column) = reopened {
        reopen::after_stored(model, column);
    }
    timeline::arrived(model);
    compare::arrived(model);
}

/// Shows earlier answers that say something, the newest of each model and way of asking, unless something newer is
/// there. Those that were asked as it would be asked now come first, one of each model.
pub fn show(model: &mut Model, stored: Vec<Answer>) {
    if !model.answers.columns.is_empty() {
        return;
    }
    let how = model.way();
    let mut seen = std::collections::HashSet::new();
    // Incomplete answers come after complete ones to the same question.
    let (whole, broken): (Vec<_>, Vec<_>) = stored.into_iter().partition(Answer::arrived);
    let mut newest: Vec<Answer> = whole
        .into_iter()
        .chain(broken)
        // A run that reached no model says nothing about the scenario, nor about an older answer of that model.
        .filter(|a| a.model != nearmiss_scene::judge::MODEL && !a.text.trim().is_empty())
        .filter(|a| seen.insert((a.model.clone(), a.how.clone())))
        .collect();
    newest.sort_by_key(|answer| answer.how != how);
    newest.truncate(STORED);
    for answer in newest {
        model.answers.columns.push(Column::from(answer));
    }
    model.answers.arrange(&how);
    if !model.answers.columns.is_empty() {
        model.answers.show(ShownAnswer::Column(0));
    }
}

/// Earlier answers kept at hand.
const STORED: usize = 32;
