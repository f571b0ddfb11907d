//! Earlier answers about what is open.

use super::super::message::Effect;
use super::super::model::{Column, Model, ShownAnswer};
use super::{compare, reopen, timeline};
use crate::request::{Replies, Request};
use crate::services::Services;
use nearmiss_scene::scenario::EgoSource;
use nearmiss_scene::verdict::Task;
use nearmiss_store::Origin;
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

/// The scenario, ego and task that stored answers are about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredOf {
    /// Hash of the scenario.
    pub scenario: String,
    /// Its name.
    pub name: String,
    /// The ego, as the store writes it.
    pub ego: String,
    /// Whether its motion is the recorded one, which recorded answers are about.
    pub recorded: bool,
    /// The task.
    pub task: Task,
}

/// Earlier answers that are looked through: the newest on a scenario and task.
const MAX_STORED: usize = 100;

/// Loads earlier answers.
#[derive(Debug)]
pub struct LoadStored(pub StoredOf);

impl Request for LoadStored {
    type Reply = (StoredOf, Vec<Answer>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Some(store) = services.store.clone() else {
            return;
        };
        let Self(of) = self;
        tokio::task::spawn_blocking(move || {
            match store.of_scenario(&of.scenario, &of.name, of.task, MAX_STORED) {
                Ok(runs) => {
                    let same = runs.into_iter().filter(|run| match run.origin {
                        Origin::Recorded => of.recorded,
                        _ => run.question.ego == of.ego,
                    });
                    let answers = same.map(Answer::from).collect();
                    replies.send((of, answers));
                }
                Err(error) => replies.complain(format!("earlier answers are not shown: {error}")),
            }
        });
    }

    /// They are taken if they are on what is open.
    fn reply(model: &mut Model, (of, stored): Self::Reply) -> Vec<Effect> {
        if subject(model).as_ref() == Some(&of) {
            let reopened = reopen::before_stored(model);
            show(model, stored);
            if let Some(column) = reopened {
                reopen::after_stored(model, column);
            }
            timeline::arrived(model);
            compare::arrived(model);
        }
        Vec::new()
    }
}
