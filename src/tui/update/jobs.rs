//! Jobs: the list of tasks notes what goes out and what comes back, and can cancel it.

use std::time::Duration;

use super::super::action::Action;
use super::super::message::runs::BatchAnswer;
use super::super::message::{BatchProgress, Effect, JobEvent, JobId, JobRequest, Msg, Update};
use super::super::model::{Column, Job, JobKind, JobState, Model};
use super::{answers, batch, experiment, index, making, planning};
use nearmiss_ask::llm::Chunk;
use nearmiss_ask::prompts::estimate_tokens;
use nearmiss_base::system::shown_path;
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome};

/// Takes note of what is asked for.
pub fn note_requested(model: &mut Model, effects: &[Effect]) {
    let now = model.uptime;
    for effect in effects {
        let job = match effect {
            Effect::Start(id, request) => match started(*id, request, now) {
                Some(job) => job,
                None => continue,
            },
            Effect::Cancel(id) => {
                if let Some(job) = model.jobs.running_mut(*id) {
                    cancelled(job, now);
                }
                continue;
            }
            Effect::Survey(entries) => {
                supersede(model, |kind| kind == JobKind::Survey);
                let id = JobId(model.new_id());
                let title = "the most dangerous moments of all scenarios".to_string();
                with_parts(Job::new(id, JobKind::Survey, title, entries.len(), now))
            }
            Effect::SurveyMore(entries) => match model.jobs.newest_mut(JobKind::Survey) {
                Some(job) => {
                    job.of += entries.len();
                    let parts = job.parts.len() + entries.len();
                    job.parts.resize(parts, false);
                    continue;
                }
                None => {
                    let id = JobId(model.new_id());
                    let first = entries.first().map_or(0, |(place, _)| *place);
                    let title = "the most dangerous moments of more scenarios".to_string();
                    let mut job = Job::new(id, JobKind::Survey, title, entries.len(), now);
                    // Those before them are not asked for again.
                    job.parts = vec![false; first + entries.len()];
                    job
                }
            },
            Effect::Rank(measure, entries) => {
                supersede(model, |kind| matches!(kind, JobKind::Ranking(_)));
                let id = JobId(model.new_id());
                let title = format!("{measure} of all scenarios");
                with_parts(Job::new(
                    id,
                    JobKind::Ranking(measure),
                    title,
                    entries.len(),
                    now,
                ))
            }
            _ => continue,
        };
        if job.of > 0 {
            model.jobs.add(job);
        }
    }
}

/// What the list says of a job that starts; nothing of what is shown on a screen of its own.
fn started(id: JobId, request: &JobRequest, now: Duration) -> Option<Job> {
    let (kind, title, parts) = match request {
        JobRequest::Question {
            question, model, ..
        } => {
            let title = format!("{model} on {}", question.case.name);
            let mut job = Job::new(id, JobKind::Question, title, 1, now);
            job.state = JobState::Waiting(String::new());
            return Some(job);
        }
        JobRequest::Plan(entry, _, forecast) | JobRequest::PlanBy(entry, _, forecast, _) => {
            let title = format!("the ego of {} planned, {}", entry.name, forecast.name());
            (JobKind::Plan, title, 1)
        }
        JobRequest::Generate(request) => return Some(making::job(id, request, now)),
        JobRequest::Estimate(_) | JobRequest::Experiment(_) | JobRequest::WriteExperiment(_) => {
            return None;
        }
        JobRequest::ExperimentBatch(batch) => {
            let title = format!("experiment {}", batch.name);
            (JobKind::Batch, title, batch.questions)
        }
        JobRequest::Index(folder) => {
            let title = format!("the index {}", shown_path(folder));
            (JobKind::Index, title, 1)
        }
        JobRequest::Batch(batch) => {
            let count = batch.entries.len();
            let title = format!("{} on {count} scenarios", batch.model);
            (JobKind::Batch, title, count)
        }
    };
    Some(Job::new(id, kind, title, parts, now))
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

fn with_parts(mut job: Job) -> Job {
    job.parts = vec![false; job.of];
    job
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

/// Takes note of what comes back of work on all scenarios.
pub fn note(model: &mut Model, msg: &Msg) {
    match msg {
        Msg::Surveyed(place, _) => part(model, JobKind::Survey, *place),
        Msg::Ranked(measure, place, _) => part(model, JobKind::Ranking(measure), *place),
        _ => {}
    }
}

/// Takes an event of a job; one of a job that has ended is dropped.
pub fn on_event(model: &mut Model, id: JobId, event: JobEvent) -> Vec<Effect> {
    let now = model.uptime;
    let stopping = match model.jobs.running_mut(id) {
        Some(job) => {
            let stopping = job.state == JobState::Stopping;
            note_event(job, &event, now);
            stopping
        }
        None if model.card.as_ref().is_some_and(|card| card.id == id) => false,
        None if model.experiment.owns(id) => false,
        None => return Vec::new(),
    };
    match event {
        JobEvent::Question(update) => return answers::on_update(model, id, update),
        JobEvent::Plan(update) => return planning::on_update(model, update),
        JobEvent::Generate(Update::Progress(_)) if stopping => {}
        JobEvent::Generate(_) if stopping => making::stopped(model),
        JobEvent::Generate(update) => return making::on_update(model, update),
        JobEvent::Estimate(update) => batch::estimated(model, update),
        JobEvent::Batch(update) => {
            let effects = experiment::on_batch(model, id, &update);
            batch::on_update(model, id, update);
            return effects;
        }
        JobEvent::Experiment(update) => experiment::on_read(model, update),
        JobEvent::ExperimentWritten(update) => return experiment::written(model, update),
        JobEvent::Index(update) => index::on_update(model, id, update),
    }
    Vec::new()
}

/// Notes in the list of tasks how far a job is; an estimate is not listed.
fn note_event(job: &mut Job, event: &JobEvent, now: Duration) {
    match event {
        JobEvent::Question(update) => note_question(job, update, now),
        JobEvent::Plan(update) => planning::note(job, update, now),
        JobEvent::Generate(update) => making::note(job, update, now),
        JobEvent::Estimate(_) | JobEvent::Experiment(_) | JobEvent::ExperimentWritten(_) => {}
        JobEvent::Batch(update) => note_batch(job, update, now),
        JobEvent::Index(update) => index::note(job, update, now),
    }
}

fn note_question(job: &mut Job, update: &Update<Event, Box<Answer>>, now: Duration) {
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
fn part(model: &mut Model, kind: JobKind, place: usize) {
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

fn note_batch(job: &mut Job, update: &Update<BatchProgress, ()>, now: Duration) {
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
        JobKind::Survey => Effect::StopSurvey,
        JobKind::Ranking(_) => Effect::StopRanking,
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
