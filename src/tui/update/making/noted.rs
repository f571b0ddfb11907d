//! Entries of the task list about scenario generation.

use std::time::Duration;

use super::super::super::loaded::{
    GenerationOutcome, GenerationProgress, GenerationStage, VariantRequest,
};
use super::super::super::model::{
    Job, JobId, JobKind, JobState, Update, consequence_words, listed,
};
use super::super::super::tasks::making::GenerationUpdate;
use super::writing;

/// A job for the list of tasks.
pub fn job(id: JobId, request: &VariantRequest, now: Duration) -> Job {
    let name = &request.entry.name;
    match &request.writer {
        Some(writer) => writing::job(id, name, &writer.model, writer.method.samples, now),
        None => {
            let title = format!("{name} made dangerous, seed {}", request.seed);
            Job::new(id, JobKind::Generate, title, 1, now)
        }
    }
}

/// Notes in the list of tasks how far it is.
pub fn note(job: &mut Job, update: &GenerationUpdate, now: Duration) {
    let stopping = job.state == JobState::Stopping;
    let result = match update {
        Update::Progress(GenerationProgress::Working(GenerationStage::Searching(progress, of))) => {
            (job.done, job.of) = (progress.tried.min(*of), *of);
            return;
        }
        Update::Progress(GenerationProgress::Working(_)) if stopping => return,
        Update::Progress(GenerationProgress::Working(_)) => return job.state = JobState::Running,
        Update::Progress(GenerationProgress::Model(progress)) => {
            return writing::note(job, progress);
        }
        // Results of a stopped search are dropped.
        Update::Ended(result) if !stopping => result,
        Update::Ended(_) | Update::Cancelled => {
            return job.end(JobState::Cancelled(String::new()), now);
        }
    };
    let state = match result {
        Ok(GenerationOutcome::Unwritten(words, wrote)) if wrote.failed() => {
            JobState::Failed(words.clone())
        }
        Ok(GenerationOutcome::Unwritten(words, _) | GenerationOutcome::Nothing(words)) => {
            JobState::Done(words.clone())
        }
        Ok(GenerationOutcome::Found { variant, .. }) => {
            let shown = variant.variant.as_ref();
            let effect = shown.map(|shown| &shown.made.effect);
            JobState::Done(effect.map_or(String::new(), |effect| {
                let what = consequence_words(&effect.consequence);
                let ids: Vec<i64> = effect.ids().collect();
                match ids.len() {
                    1 => format!("{what}, attacker {}", listed(&ids)),
                    _ => format!("{what}, attackers {}", listed(&ids)),
                }
            }))
        }
        Err(why) => JobState::Failed(why.clone()),
    };
    job.end(state, now);
}
