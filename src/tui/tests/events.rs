//! Events of jobs, as they arrive.

use crate::loaded::{GenerationOutcome, GenerationProgress, GenerationStage};
use crate::message::{JobEvent, JobId, Msg, Update};
use nearmiss_study::evaluation::{Answer, Event};

/// A piece of an answer.
pub fn piece(id: JobId, event: Event) -> Msg {
    Msg::Job(id, JobEvent::Question(Update::Progress(event)))
}

/// A whole answer.
pub fn answered(id: JobId, result: Result<Box<Answer>, String>) -> Msg {
    Msg::Job(id, JobEvent::Question(Update::Ended(result)))
}

/// How far the generation of a variant is.
pub fn generating(id: JobId, at: GenerationStage) -> Msg {
    let progress = Update::Progress(GenerationProgress::Working(at));
    Msg::Job(id, JobEvent::Generate(progress))
}

/// What came of the generation of a variant.
pub fn generated(id: JobId, result: Result<GenerationOutcome, String>) -> Msg {
    Msg::Job(id, JobEvent::Generate(Update::Ended(result)))
}
