//! Jobs: the list of tasks notes what goes out and what comes back, and can cancel it.

use std::time::Duration;

use super::super::action::Action;
use super::super::message::Effect;
use super::super::model::{Column, Job, JobId, JobKind, JobState, Model, Update};
use super::super::tasks::batch::{BatchAnswer, BatchProgress, BatchUpdate};
use super::super::tasks::scenarios::{Rank, Survey};
use super::{answers, batch, index, making, planning};
use nearmiss_ask::llm::Chunk;
use nearmiss_ask::prompts::estimate_tokens;
use nearmiss_formats::Entry;
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome};

/// Takes note of what goes out.
pub fn note_requested(model: &mut Model, effects: &[Effect]) {
    let now = model.uptime;
    for effect in effects {
        match effect {
            Effect::Request(request) => request.sent(model),
            Effect::Cancel(id) => {
                if let Some(job) = model.jobs.running_mut(*id) {
                    cancelled(job, now);
                }
            }
            _ => {}
        }
    }
}

/// The facts of these scenarios are asked for, instead of others.
pub fn begin_survey(model: &mut Model, entries: &[(usize, Entry)]) {
    supersede(model, |kind| kind == JobKind::Survey);
    let title = "the most dangerous moments of all scenarios";
    begin(model, JobKind::Survey, title.into(), entries.len());
}

/// The facts of these too are asked for.
pub fn extend_survey(model: &mut Model, entries: &[(usize, Entry)]) {
    if let Some(job) = model.jobs.newest_mut(JobKind::Survey) {
        job.of += entries.len();
        let parts = job.parts.len() + entries.len();
        job.parts.resize(parts, false);
        return;
    }
    let id = JobId(model.new_id());
    let first = entries.first().map_or(0, |(place, _)| *place);
    let title = "the most dangerous moments of more scenarios".to_string();
    let mut job = Job::new(id, JobKind::Survey, title, entries.len(), model.uptime);
    // Those before them are not asked for again.
    job.parts = vec![false; first + entries.len()];
    model.jobs.add(job);
}

/// A measure of these scenarios is asked for, instead of another.
pub fn begin_ranking(model: &mut Model, measure: &'static str, entries: &[(usize, Entry)]) {
    supersede(model, |kind| matches!(kind, JobKind::Ranking(_)));
    let title = format!("{measure} of all scenarios");
    begin(model, JobKind::Ranking(measure), title, entries.len());
}

/// Work on so many scenarios begins.
fn begin(model: &mut Model, kind: JobKind, title: String, count: usize) {
    let id = JobId(model.new_id());
    let mut job = Job::new(id, kind, title, count, model.uptime);
    job.parts = vec![false; count];
    model.jobs.add(job);
}

/// A job is to end: at once, or once it says so.
fn cancelled(job: &mut Job, now: Duration) {
    let words = match job.kind {
        JobKind::Generate | JobKind::Batch => return job.state = JobState::Stopping,
        JobKind::Question => "partial answer kept",
        JobKind::Plan | JobKind::Index | JobKind::Survey | JobKind::Ranking(_) => "",
    };
    job.end(JobState::Cancelled(words.into()), now);
}

/// The same is asked for anew: what was on its way stops.
fn supersede(model: &mut Model, kinds: impl Fn(JobKind) -> bool) {
    let now = model.uptime;
    for job in model.jobs.all.iter_mut() {
        if job.is_running() && kinds(job.kind) {
            job.end(JobState::Cancelled("restarted".into()), now);
        }
    }
}

/// Notes in the list of tasks how far a job is; says whether it is there, which an event must be about.
pub fn note(model: &mut Model, id: JobId, note: impl FnOnce(&mut Job, Duration)) -> bool {
    let now = model.uptime;
    let job = model.jobs.running_mut(id);
    job.map(|job| note(job, now)).is_some()
}

/// Notes how far a question is.
pub fn note_question(job: &mut Job, update: &Update<Event, Box<Answer>>, now: Duration) {
    let state = match update {
        Update::Progress(event) => return piece(job, event),
        Update::Ended(Ok(answer)) => {
            job.tokens = 0;
            outcome(job, answer)
        }
        Update::Ended(Err(error)) => {
            job.tokens = 0;
            JobState::Failed(error.clone())
        }
        Update::Cancelled => JobState::Cancelled(String::new()),
    };
    job.done = 1;
    job.end(state, now);
}

fn piece(job: &mut Job, event: &Event) {
    match event {
        Event::Chunk(Chunk::Reasoning(text) | Chunk::Text(text)) => {
            job.state = JobState::Running;
            job.tokens += estimate_tokens(text) as u64;
        }
        Event::Chunk(Chunk::Started { .. }) => job.state = JobState::Running,
        Event::Awaiting(run) => {
            job.state = JobState::Waiting(format!("run {run} asks the same"));
        }
        Event::Chunk(Chunk::Retrying { why, .. }) => job.state = JobState::Waiting(why.clone()),
        Event::Kept(_)
        | Event::Tools(_)
        | Event::Chunk(_)
        | Event::NotStored(_)
        | Event::Barred(_) => {}
    }
}

/// What came of an answer; one of the store costs nothing.
fn outcome(job: &mut Job, answer: &Answer) -> JobState {
    if answer.past.is_some() {
        return JobState::Done(format!("{}, from the store", answer.word()));
    }
    job.consumed(&answer.consumed);
    match &answer.judged {
        JudgeOutcome::Missing(missing) => JobState::Failed(missing.to_string()),
        JudgeOutcome::Verdict(_) | JudgeOutcome::Other(_) => JobState::Done(answer.word()),
    }
}

/// One part of work on all scenarios is done.
pub fn note_part(model: &mut Model, kind: JobKind, place: usize) {
    let now = model.uptime;
    let Some(job) = model.jobs.newest_mut(kind) else {
        return;
    };
    if let Some(done) = job.parts.get_mut(place).filter(|done| !**done) {
        *done = true;
        job.done += 1;
        if job.done == job.of {
            job.end(JobState::Done(String::new()), now);
        }
    }
}

/// Notes how far a batch is.
pub fn note_batch(job: &mut Job, update: &BatchUpdate, now: Duration) {
    match update {
        Update::Progress(BatchProgress::Named(name, questions)) => {
            job.batch = Some(name.clone());
            job.of = *questions;
            return;
        }
        Update::Progress(BatchProgress::Changed(_)) => return,
        Update::Progress(BatchProgress::Answered(Ok(ended))) => return answered(job, ended),
        Update::Progress(BatchProgress::Answered(Err(why))) => return failed(job, why),
        Update::Ended(Err(why)) => failed(job, why),
        Update::Ended(Ok(())) | Update::Cancelled => {}
    }
    let left = job.of.saturating_sub(job.done);
    let words = job.outcome();
    let state = match (left, job.tally.2 == job.done && job.done > 0) {
        (0, false) => JobState::Done(words),
        (0, true) => JobState::Failed(words),
        (left, _) => JobState::Cancelled(format!("{words}, {left} not asked")),
    };
    job.end(state, now);
}

/// A question of a batch has no answer.
fn failed(job: &mut Job, why: &str) {
    job.done += 1;
    job.tally.2 += 1;
    job.why.get_or_insert_with(|| why.into());
}

/// One answer of a batch is here.
fn answered(job: &mut Job, ended: &BatchAnswer) {
    let answer = &ended.answer;
    job.done += 1;
    if answer.past.is_none() {
        job.consumed(&answer.consumed);
    }
    let said = answer.verdict().map(|verdict| verdict.dangerous);
    match (&answer.judged, said, ended.truth) {
        (JudgeOutcome::Missing(missing), ..) => {
            job.tally.2 += 1;
            job.why.get_or_insert_with(|| missing.to_string());
        }
        (_, Some(said), Some(truth)) if said == truth => job.tally.0 += 1,
        (_, Some(_), Some(_)) => job.tally.1 += 1,
        _ => {}
    }
}

/// Cancels the selected task, or everything that runs.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    if action == Action::CancelAllJobs {
        let running = model.jobs.all.iter().filter(|job| job.is_running());
        let jobs: Vec<_> = running.map(|job| (job.id, job.kind)).collect();
        let jobs = jobs.into_iter();
        return jobs
            .flat_map(|(id, kind)| cancel(model, id, kind))
            .collect();
    }
    match model.jobs.current().filter(|job| job.is_running()) {
        Some(job) => cancel(model, job.id, job.kind),
        None => {
            model.say("already finished");
            Vec::new()
        }
    }
}

fn cancel(model: &mut Model, id: JobId, kind: JobKind) -> Vec<Effect> {
    let stop = match kind {
        JobKind::Question => return abort(model, id),
        JobKind::Batch => return batch::stop(model, id),
        JobKind::Plan => return planning::cancel(model),
        JobKind::Generate => return making::cancel(model),
        JobKind::Index => return index::cancel(model, id),
        JobKind::Survey => Survey::Stop.into(),
        JobKind::Ranking(_) => Rank::Stop.into(),
    };
    let now = model.uptime;
    if let Some(job) = model.jobs.running_mut(id) {
        cancelled(job, now);
    }
    vec![stop]
}

/// Cancels one question.
fn abort(model: &mut Model, id: JobId) -> Vec<Effect> {
    if let Some(column) = model.column_mut(id).filter(|c| Column::is_running(c)) {
        column.progress = answers::cancelled();
    }
    model.answers.elsewhere.retain(|(ask, _)| *ask != id);
    if model.answers.asking_reference == Some(id) {
        model.answers.asking_reference = None;
    }
    vec![Effect::Cancel(id)]
}
