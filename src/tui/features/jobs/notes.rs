//! What the list of tasks notes of what goes out and what comes back.

use std::time::Duration;

use crate::model::{Job, JobId, JobKind, JobState, Model, Update};
use nearmiss_ask::llm::Chunk;
use nearmiss_ask::prompts::estimate_tokens;
use nearmiss_formats::Entry;
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome};

/// The facts of these scenarios are asked for, instead of others.
pub fn begin_survey(model: &mut Model, entries: &[(usize, Entry)]) {
    supersede(model, "restarted", |kind| kind == JobKind::Survey);
    let title = "the most dangerous moments of all scenarios";
    begin(model, JobKind::Survey, title.into(), entries);
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

/// What these scenarios are sorted by is asked for, instead of another order.
pub fn begin_ranking(model: &mut Model, order: &'static str, entries: &[(usize, Entry)]) {
    supersede(model, "restarted", |kind| {
        matches!(kind, JobKind::Ranking(_))
    });
    let title = match model.list.ranking() {
        Some(measure) => format!("{} of all scenarios", measure.id),
        None => format!("{order} of scenarios without an ego: the planner drives"),
    };
    begin(model, JobKind::Ranking(order), title, entries);
}

/// The order needs nothing of what was asked for.
pub fn end_ranking(model: &mut Model) {
    supersede(model, "sorted by something else", |kind| {
        matches!(kind, JobKind::Ranking(_))
    });
}

/// Work on these scenarios begins.
fn begin(model: &mut Model, kind: JobKind, title: String, entries: &[(usize, Entry)]) {
    let id = JobId(model.new_id());
    let mut job = Job::new(id, kind, title, entries.len(), model.uptime);
    let places = entries.iter().map(|(place, _)| place + 1);
    job.parts = vec![false; places.max().unwrap_or(0)];
    model.jobs.add(job);
}

/// Something else is wanted: what was on its way stops, with the reason.
fn supersede(model: &mut Model, why: &str, kinds: impl Fn(JobKind) -> bool) {
    let now = model.uptime;
    for job in model.jobs.all.iter_mut() {
        if job.is_running() && kinds(job.kind) {
            job.end(JobState::Cancelled(why.into()), now);
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
        return JobState::Done(format!("{}, from the store", answer.verdict_label()));
    }
    job.consumed(&answer.consumed);
    match &answer.judged {
        JudgeOutcome::Missing(missing) => JobState::Failed(missing.to_string()),
        JudgeOutcome::Verdict(_) | JudgeOutcome::Other(_) => JobState::Done(answer.verdict_label()),
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
