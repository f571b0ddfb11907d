//! Ratings of answers side by side: kept, read, and what is left to rate.

use crate::message::Effect;
use crate::model::Model;
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::update::rating;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{NewRating, Rating, Unrated};

/// Keeps a rating of the answers of a round of the comparison.
#[derive(Debug)]
pub struct Rate {
    /// The round.
    pub round: u64,
    /// The rating.
    pub rating: Box<NewRating>,
    /// The number of the one in whose place it is kept.
    pub replaced: Option<i64>,
}

impl Request for Rate {
    /// The round, and the number under which it was kept, or why not.
    type Reply = (u64, Result<i64, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        services.with_store(replies, move |store| {
            let kept = store.and_then(|store| {
                let kept = match self.replaced {
                    None => store.rate(&self.rating),
                    Some(id) => store.rate_anew(id, &self.rating).map(|()| id),
                };
                kept.map_err(|error| error.to_string())
            });
            (self.round, kept)
        });
    }

    fn reply(model: &mut Model, (round, kept): Self::Reply) -> Vec<Effect> {
        rating::kept(model, round, kept)
    }
}

/// Reads every rating.
#[derive(Debug)]
pub struct ReadRatings;

impl Request for ReadRatings {
    type Reply = Result<Vec<Rating>, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        services.with_store(replies, |store| {
            store.and_then(|store| store.ratings().map_err(|error| error.to_string()))
        });
    }

    fn reply(model: &mut Model, ratings: Self::Reply) -> Vec<Effect> {
        match ratings {
            Ok(ratings) => model.compare.ratings = Some(ratings),
            Err(error) => model.complain(error),
        }
        Vec::new()
    }
}

/// Finds out which answers to a task a person has not rated.
#[derive(Debug)]
pub struct FindUnrated {
    /// The task.
    pub task: Task,
    /// The person.
    pub person: String,
}

impl Request for FindUnrated {
    type Reply = Result<Unrated, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        services.with_store(replies, move |store| {
            let unrated = store?.unrated(self.task, &self.person, judge::MODEL);
            unrated.map_err(|error| error.to_string())
        });
    }

    fn reply(model: &mut Model, unrated: Self::Reply) -> Vec<Effect> {
        rating::unrated(model, unrated)
    }
}
