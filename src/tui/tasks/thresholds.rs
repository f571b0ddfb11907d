//! The user's thresholds of risk scores: read again, and used.

use std::sync::Arc;

use crate::message::Effect;
use crate::model::Model;
use crate::request::{Replies, Request};
use crate::services::{self, Services};
use crate::update::values;
use nearmiss_scene::metrics::Thresholds;

/// Reads them again.
#[derive(Debug)]
pub struct ReadThresholds;

impl Request for ReadThresholds {
    /// They, or why they cannot be used.
    type Reply = Result<Arc<Thresholds>, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let path = services.folders.thresholds();
        services.background(replies, move || services::thresholds(&path).map(Arc::new));
    }

    fn reply(model: &mut Model, read: Self::Reply) -> Vec<Effect> {
        values::thresholds(model, read)
    }
}

/// Measures with these from now on.
#[derive(Debug)]
pub struct UseThresholds(pub Arc<Thresholds>);

impl Request for UseThresholds {
    type Reply = ();

    fn perform(self, services: &mut Services, _: Replies<Self>) {
        services.thresholds = self.0;
    }
}
