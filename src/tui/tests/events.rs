//! Events of jobs, as they arrive.

use crate::features::answers::Ask;
use crate::features::generation::request::Generate;
use crate::loaded::{GenerationOutcome, GenerationProgress, GenerationStage};
use crate::message::Msg;
use crate::model::{JobId, Update};
use nearmiss_study::evaluation::{Answer, Event};

/// A piece of an answer.
pub fn piece(id: JobId, event: Event) -> Msg {
    Msg::reply::<Ask>((id, Update::Progress(event)))
}

/// A whole answer.
pub fn answered(id: JobId, result: Result<Box<Answer>, String>) -> Msg {
    Msg::reply::<Ask>((id, Update::Ended(result)))
}

/// How far the generation of a variant is.
pub fn generating(id: JobId, at: GenerationStage) -> Msg {
    let progress = Update::Progress(GenerationProgress::Working(at));
    Msg::reply::<Generate>((id, progress))
}

/// What came of the generation of a variant.
pub fn generated(id: JobId, result: Result<GenerationOutcome, String>) -> Msg {
    Msg::reply::<Generate>((id, Update::Ended(result)))
}
