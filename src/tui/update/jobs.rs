//! The list of tasks: it hears what goes out and what comes back, and can cancel it.

use super::super::action::Action;
use super::super::message::making::MakeAsk;
use super::super::message::planning::PlanAsk;
use super::super::message::runs::{BatchAsk, BatchId, BatchNews, Ended};
use super::super::message::{AskId, Effect, Msg};
use super::super::model::{Column, Job, JobKind, JobState, Model};
use super::{answers, batch, making, planning};
use crate::evaluation::{Answer, Event, Judged};
use crate::llm::Chunk;
use crate::prompts::estimate_tokens;

/// Takes note of what is asked for.
pub fn note_requested(model: &mut Model, effects: &[Effect]) {
    let now = model.uptime;
    for effect in effects {
        let job = match effect {
            Effect::Ask {
                id,
                question,
                model: asked,
                ..
            } => {
                let title = format!("{asked} on {}", question.case.name);
                let mut job = Job::new(JobKind::Question(*id), title, 1, now);
                job.state = JobState::Waiting(String::new());
                job
            }
            Effect::Batch(BatchAsk::Begin(id, batch)) => {
                let count = batch.entries.len();
                let title = format!("{} on {count} scenarios", batch.model);
                Job::new(JobKind::Batch(*id), title, count, now)
            }
            Effect::Survey(entries) => {
                supersede(model, |kind| kind == JobKind::Survey);
                let title = "the most dangerous moments of all scenarios".to_string();
                with_parts(Job::new(JobKind::Survey, title, entries.len(), now))
            }
            Effect::SurveyMore(entries) => match model.jobs.running_mut(JobKind::Survey) {
                Some(job) => {
                    job.of += entries.len();
                    let parts = job.parts.len() + entries.len();
                    job.parts.resize(parts, false);
                    continue;
                }
                None => {
                    let first = entries.first().map_or(0, |(place, _)| *place);
                    let title = "the most dangerous moments of more scenarios".to_string();
                    let mut job = Job::new(JobKind::Survey, title, entries.len(), now);
                    // Those before them are not asked for again.
                    job.parts = vec![false; first + entries.len()];
                    job
                }
            },
            Effect::Rank(measure, entries) => {
                supersede(model, |kind| matches!(kind, JobKind::Ranking(_)));
                let title = format!("{measure} of all scenarios");
                with_parts(Job::new(
                    JobKind::Ranking(measure),
                    title,
                    entries.len(),
                    now,
                ))
            }
            Effect::Plan(PlanAsk::Begin(id, entry, _, forecast)) => {
                let title = format!("the ego of {} planned, {}", entry.name, forecast.name());
                Job::new(JobKind::Plan(*id), title, 1, now)
            }
            Effect::Plan(PlanAsk::Stop(id)) => {
                if let Some(job) = model.jobs.running_mut(JobKind::Plan(*id)) {
                    job.end(JobState::Cancelled(String::new()), now);
                }
                continue;
            }
            Effect::Make(MakeAsk::Begin(id, wish)) => making::job(*id, wish, now),
            Effect::Make(MakeAsk::Stop(id)) => {
                if let Some(job) = model.jobs.running_mut(JobKind::Make(*id)) {
                    job.state = JobState::Stopping;
                }
                continue;
            }
            Effect::Abort(id) => {
                if let Some(job) = model.jobs.running_mut(JobKind::Question(*id)) {
                    let words = "what had arrived is kept".to_string();
                    job.end(JobState::Cancelled(words), now);
                }
                continue;
            }
            _ => continue,
        };
        if job.of > 0 {
            model.jobs.add(job);
        }
    }
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
            job.end(JobState::Cancelled("begun anew".into()), now);
        }
    }
}

/// Takes note of what comes back.
pub fn note(model: &mut Model, msg: &Msg) {
    let now = model.uptime;
    match msg {
        Msg::Asked(id, event) => {
            if let Some(job) = model.jobs.running_mut(JobKind::Question(*id)) {
                piece(job, event);
            }
        }
        Msg::Answered(id, result) => {
            if let Some(job) = model.jobs.running_mut(JobKind::Question(*id)) {
                job.tokens = 0;
                let state = match result {
                    Ok(answer) => outcome(job, answer),
                    Err(error) => JobState::Failed(error.clone()),
                };
                job.done = 1;
                job.end(state, now);
            }
        }
        Msg::Surveyed(place, _) => part(model, JobKind::Survey, *place),
        Msg::Ranked(measure, place, _) => part(model, JobKind::Ranking(measure), *place),
        Msg::Batch(news) => of_batch(model, news),
        Msg::Plan(news) => planning::note(model, news),
        Msg::Make(news) => making::note(model, news),
        _ => {}
    }
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
        Event::Kept(_) | Event::Chunk(_) | Event::NotStored(_) | Event::Barred(_) => {}
    }
}

/// What came of an answer; one of the store costs nothing.
fn outcome(job: &mut Job, answer: &Answer) -> JobState {
    if answer.past.is_some() {
        return JobState::Done(format!("{}, from the store", answer.word()));
    }
    job.consumed(&answer.consumed);
    match &answer.judged {
        Judged::Missing(missing) => JobState::Failed(missing.to_string()),
        Judged::Verdict(_) | Judged::Other(_) => JobState::Done(answer.word()),
    }
}

/// One part of work on all scenarios is done.
fn part(model: &mut Model, kind: JobKind, place: usize) {
    let now = model.uptime;
    let Some(job) = model.jobs.running_mut(kind) else {
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

fn of_batch(model: &mut Model, news: &BatchNews) {
    let now = model.uptime;
    let (BatchNews::Named(id, ..) | BatchNews::Ended(id, ..) | BatchNews::Over(id)) = news else {
        return;
    };
    let Some(job) = model.jobs.running_mut(JobKind::Batch(*id)) else {
        return;
    };
    match news {
        BatchNews::Named(_, name, questions) => {
            job.batch = Some(name.clone());
            job.of = *questions;
        }
        BatchNews::Ended(_, Ok(ended)) => answered(job, ended),
        BatchNews::Ended(_, Err(why)) => {
            job.done += 1;
            job.tally.2 += 1;
            job.why.get_or_insert_with(|| why.clone());
        }
        _ => {
            let left = job.of.saturating_sub(job.done);
            let words = job.outcome();
            let state = match (left, job.tally.2 == job.done && job.done > 0) {
                (0, false) => JobState::Done(words),
                (0, true) => JobState::Failed(words),
                (left, _) => JobState::Cancelled(format!("{words}, {left} not asked")),
            };
            job.end(state, now);
        }
    }
}

/// One answer of a batch is here.
fn answered(job: &mut Job, ended: &Ended) {
    let answer = &ended.answer;
    job.done += 1;
    if answer.past.is_none() {
        job.consumed(&answer.consumed);
    }
    let said = answer.verdict().map(|verdict| verdict.dangerous);
    match (&answer.judged, said, ended.truth) {
        (Judged::Missing(missing), ..) => {
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
        let kinds: Vec<_> = running.map(|job| job.kind).collect();
        let kinds = kinds.into_iter();
        return kinds.flat_map(|kind| cancel(model, kind)).collect();
    }
    match model.jobs.current().filter(|job| job.is_running()) {
        Some(job) => cancel(model, job.kind),
        None => {
            model.say("that is over");
            Vec::new()
        }
    }
}

fn cancel(model: &mut Model, kind: JobKind) -> Vec<Effect> {
    let now = model.uptime;
    match kind {
        JobKind::Question(id) => abort(model, id),
        JobKind::Batch(id) => stop(model, id),
        JobKind::Plan(_) => planning::cancel(model),
        JobKind::Make(_) => making::cancel(model),
        JobKind::Survey | JobKind::Ranking(_) => {
            if let Some(job) = model.jobs.running_mut(kind) {
                job.end(JobState::Cancelled(String::new()), now);
            }
            vec![match kind {
                JobKind::Survey => Effect::StopSurvey,
                _ => Effect::StopRanking,
            }]
        }
    }
}

/// Cancels one question.
fn abort(model: &mut Model, id: AskId) -> Vec<Effect> {
    if let Some(column) = model.column_mut(id).filter(|c| Column::is_running(c)) {
        column.progress = answers::cancelled();
    }
    model.answers.elsewhere.retain(|(ask, _)| *ask != id);
    if model.answers.asking_reference == Some(id) {
        model.answers.asking_reference = None;
    }
    vec![Effect::Abort(id)]
}

/// Lets a batch begin nothing more; the second time, what it began is cancelled too.
pub fn stop(model: &mut Model, id: BatchId) -> Vec<Effect> {
    if let Some(job) = model.jobs.running_mut(JobKind::Batch(id)) {
        job.state = JobState::Stopping;
    }
    batch::stopping(model);
    vec![Effect::Batch(BatchAsk::Stop(id))]
}
