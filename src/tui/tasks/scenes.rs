//! Opens scenarios, reads their sources, and loads earlier answers about them.

use crate::loaded::{Opened, Source};
use crate::message::Effect;
use crate::model::{Model, OpenId};
use crate::request::{Replies, Request};
use crate::screens::source;
use crate::services::Services;
use crate::update::{opened, stored_answers};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;
use nearmiss_store::Origin;
use nearmiss_study::evaluation::Answer;

/// Opens a scenario.
#[derive(Debug)]
pub struct Open {
    /// Its number.
    pub id: OpenId,
    /// The scenario.
    pub entry: Entry,
    /// The obstacle that is its ego; `None` for the recorded or chosen one.
    pub obstacle: Option<i64>,
    /// The change of its scene.
    pub change: Option<Transform>,
}

impl Request for Open {
    /// The scenario, or why it is not open.
    type Reply = (OpenId, Result<Box<Opened>, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let ego = self.obstacle.map(EgoSelection::Obstacle);
        let ego = ego.unwrap_or_else(|| services.ego.clone());
        let thresholds = services.thresholds.clone();
        services.background(replies, move || {
            let opened = Opened::changed(&self.entry, &ego, &thresholds, self.change);
            (self.id, opened.map(Box::new))
        });
    }

    fn reply(model: &mut Model, (id, result): Self::Reply) -> Vec<Effect> {
        model.recall.changed = true;
        opened(model, id, result)
    }
}

/// Reads the source of a scenario, by its place in the list.
#[derive(Debug)]
pub struct ReadSource(pub usize, pub Entry);

impl Request for ReadSource {
    type Reply = (usize, Result<Box<Source>, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self(place, entry) = self;
        services.background(replies, move || (place, Source::read(&entry).map(Box::new)));
    }

    fn reply(model: &mut Model, (place, read): Self::Reply) -> Vec<Effect> {
        source::read(model, place, read);
        Vec::new()
    }
}

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

    fn reply(model: &mut Model, (of, answers): Self::Reply) -> Vec<Effect> {
        stored_answers::loaded(model, &of, answers);
        Vec::new()
    }
}
