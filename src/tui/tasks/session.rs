//! What a killed program leaves: the session and drafts of templates.

use std::time::Duration;

use crate::message::Effect;
use crate::model::Model;
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::session::{self, Session, restore};

/// How long after a change the session is saved: what a killed program loses.
const SESSION_DELAY: Duration = Duration::from_secs(2);

/// Replies after a while: the session is to be kept.
#[derive(Debug)]
pub struct KeepSessionLater;

impl Request for KeepSessionLater {
    type Reply = ();

    fn perform(self, _: &mut Services, replies: Replies<Self>) {
        tokio::spawn(async move {
            tokio::time::sleep(SESSION_DELAY).await;
            replies.send(());
        });
    }

    fn reply(model: &mut Model, (): ()) -> Vec<Effect> {
        restore::keep(model)
    }
}

/// Keeps what the workbench looks like for the next start.
#[derive(Debug)]
pub struct KeepSession(pub Box<Session>);

impl Request for KeepSession {
    type Reply = ();

    // At once and not in the background: the program may be about to end.
    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        if let Err(error) = session::file::write(&services.folders.sessions(), &self.0) {
            replies.complain(format!("{error}; the session is not kept"));
        }
    }
}
