//! Entries of the task list about scenario generation.

use std::time::Duration;

use super::super::super::loaded::{Generated, VariantRequest, Working};
use super::super::super::message::making::{MakeId, MakeNews};
use super::super::super::model::{Job, JobKind, JobState, Model, consequence_words};
use super::writing;

/// Work on a wish, for the list of tasks.
pub fn job(id: MakeId, wish: &VariantRequest, now: Duration) -> Job {
    let name = &wish.entry.name;
    match &wish.writer {
        Some(writer) => writing::job(id, name, &writer.model, now),
        None => {
            let title = format!("{name} made dangerous, seed {}", wish.seed);
            Job::new(JobKind::Make(id), title, 1, now)
        }
    }
}

/// Notes in the list of tasks how far it is.
pub fn note(model: &mut Model, news: &MakeNews) {
    let now = model.uptime;
    let job = news.id().map(JobKind::Make);
    let Some(job) = job.and_then(|kind| model.jobs.running_mut(kind)) else {
        return;
    };
    match news {
        MakeNews::Working(_, Working::Searching(progress, of)) => {
            (job.done, job.of) = (progress.tried.min(*of), *of);
        }
        MakeNews::Working(..) if job.state != JobState::Stopping => job.state = JobState::Running,
        MakeNews::Working(..) => {}
        MakeNews::Heard(_, progress) => writing::note(job, progress),
        MakeNews::Saved(..) => {}
        // What it has found comes too late.
        MakeNews::Stopped(_) | MakeNews::Ended(..) if job.state == JobState::Stopping => {
            job.end(JobState::Cancelled(String::new()), now);
        }
        MakeNews::Stopped(_) => job.end(JobState::Cancelled(String::new()), now),
        MakeNews::Ended(_, Ok(Generated::Unwritten(words, wrote))) => {
            job.end(
                match wrote.failed() {
                    true => JobState::Failed(words.clone()),
                    false => JobState::Done(words.clone()),
                },
                now,
            );
        }
        MakeNews::Ended(_, Ok(Generated::Found { variant, .. })) => {
            let shown = variant.variant.as_ref();
            let effect = shown.map(|shown| &shown.made.effect);
            let words = effect.map_or(String::new(), |effect| {
                let what = consequence_words(&effect.consequence);
                format!("{what}, attacker {}", effect.attacker)
            });
            job.end(JobState::Done(words), now);
        }
        MakeNews::Ended(_, Ok(Generated::Nothing(words))) => {
            job.end(JobState::Done(words.clone()), now);
        }
        MakeNews::Ended(_, Err(why)) => job.end(JobState::Failed(why.clone()), now),
    }
}
