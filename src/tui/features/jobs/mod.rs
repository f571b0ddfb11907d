//! Jobs: the list of tasks notes what goes out and what comes back, shows it, and can cancel it.

pub mod notes;
pub mod state;

use std::time::Duration;

use nearmiss_base::system::pad_start;
use nearmiss_scene::description::visible;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::{Action, Scope};
use crate::features::scenarios::request::{Rank, Survey};
use crate::features::{Screen, Step, answers, batch, generation, index, planner};
use crate::message::Effect;
use crate::model::{Column, Job, JobId, JobKind, JobState, Model};
use crate::widgets::hints::{self, Hint};
use crate::widgets::window;
use crate::widgets::words::{duration, fit, pad, thousands};

/// Lines below the list for the selected task.
const BELOW: u16 = 3;

/// The list of running and finished tasks.
#[derive(Debug)]
pub struct JobsScreen;

/// Opens the list, at the newest.
pub fn open(model: &mut Model) {
    model.jobs.selected = 0;
    model.screens.open(JobsScreen);
}

impl Screen for JobsScreen {
    fn scope(&self) -> Scope {
        Scope::Jobs
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        let last = model.jobs.all.len().saturating_sub(1);
        let selected = &mut model.jobs.selected;
        match action {
            Action::Up | Action::Down => {
                let by = model.look.lines(action, 1);
                *selected = selected.saturating_add_signed(by).min(last);
            }
            Action::Cancel | Action::TaskList => return Step::close(),
            Action::ShowJob => return show_runs(model),
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn moves(&self, model: &Model) -> bool {
        model.jobs.all.iter().any(Job::is_running)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let jobs = &model.jobs;
        // The rows, an empty one, what is below, and the borders.
        let height = u16::try_from(jobs.all.len())
            .unwrap_or(u16::MAX)
            .saturating_add(BELOW + 3)
            .clamp(12, 40);
        let inner = window::window(frame, screen, model, &title(model), (120, height));
        let dim = Style::new().fg(model.theme.dim);
        if jobs.all.is_empty() {
            let words = "nothing runs, and nothing ran in this session";
            frame.render_widget(Span::styled(words, dim), inner);
            return;
        }
        let rows = usize::from(inner.height.saturating_sub(BELOW + 1));
        let top = (jobs.selected + 1).saturating_sub(rows);
        let newest = jobs.all.iter().rev().enumerate().skip(top).take(rows);
        let widths = widths(model);
        let lines = newest.map(|(i, job)| row(model, job, i == jobs.selected, inner.width, widths));
        frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), inner);
        if let Some(job) = jobs.current() {
            let below = Rect {
                y: inner.bottom().saturating_sub(BELOW),
                height: BELOW.min(inner.height),
                ..inner
            };
            let text = Paragraph::new(full_row(job)).wrap(Wrap { trim: true });
            frame.render_widget(text.style(Style::new().fg(model.theme.accent)), below);
        }
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        hints::own(model, Scope::Jobs)
    }
}

/// Shows the runs of the selected batch in the history.
fn show_runs(model: &mut Model) -> Step {
    match model.jobs.current().and_then(|job| job.batch.clone()) {
        Some(name) => {
            model.history.search_for(format!("batch:{name}"));
            Step::CloseAndPerform(Action::History)
        }
        None => {
            model.say("only a batch has its own runs");
            Step::stay()
        }
    }
}

/// How many run, and what the session cost.
fn title(model: &Model) -> String {
    let running = model.jobs.all.iter().filter(|job| job.is_running()).count();
    match cost(model.jobs.cost()) {
        Some(cost) => format!("tasks · {running} running · {cost} in this session"),
        None => format!("tasks · {running} running"),
    }
}

/// An amount in US dollars, with a note if further costs are unknown.
fn cost((usd, unknown): (f64, usize)) -> Option<String> {
    match (usd > 0.0, unknown) {
        (false, 0) => None,
        (true, 0) => Some(format!("${usd:.4}")),
        (false, n) => Some(format!("{n} with unknown cost")),
        (true, n) => Some(format!("${usd:.4} and {n} with unknown cost")),
    }
}

/// A word for where it stands, its progress, its time, its tokens and its cost.
fn row(model: &Model, job: &Job, chosen: bool, width: u16, widths: [usize; 4]) -> Line<'static> {
    let theme = &model.theme;
    let (word, color) = match &job.state {
        JobState::Waiting(_) => ("waiting", theme.warning),
        JobState::Running => ("running", theme.accent),
        JobState::Stopping => ("stopping", theme.warning),
        JobState::Done(_) => ("done", theme.safe),
        JobState::Failed(_) => ("failed", theme.danger),
        JobState::Cancelled(_) => ("cancelled", theme.dim),
    };
    let facts = Facts::new(model, job).padded(widths);
    let rest = usize::from(width).saturating_sub(2 + 10 + facts.width() + 1);
    let line = Line::from(vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::styled(
            pad(word, 10),
            Style::new().fg(color).add_modifier(Modifier::BOLD),
        ),
        Span::raw(pad(&job.title, rest)),
        Span::styled(format!(" {facts}"), Style::new().fg(theme.dim)),
    ]);
    if chosen {
        theme.select(line)
    } else {
        line.style(theme.base())
    }
}

/// Its progress, its time, its tokens and its cost.
struct Facts([String; 4]);

impl Facts {
    fn new(model: &Model, job: &Job) -> Self {
        let progress = match job.kind {
            JobKind::Question => String::new(),
            _ => format!("{}/{}", job.done, job.of),
        };
        let ms = u64::try_from(job.took(model.uptime).as_millis()).unwrap_or(u64::MAX);
        let tokens = match job.tokens {
            0 => String::new(),
            n if job.is_running() && job.kind == JobKind::Question => {
                format!("~{} tok", thousands(n))
            }
            n => format!("{} tok", thousands(n)),
        };
        let price = if job.cost > 0.0 {
            format!("${:.4}", job.cost)
        } else {
            String::new()
        };
        Self([progress, duration(ms), tokens, price])
    }

    /// In columns as wide as all tasks need; what none of them has takes none.
    fn padded(&self, widths: [usize; 4]) -> String {
        let columns = self
            .0
            .iter()
            .zip(widths)
            .filter(|(_, width)| *width > 0)
            .map(|(fact, width)| pad_start(fact, width));
        columns.collect::<Vec<_>>().join("  ")
    }
}

/// Columns of what is known of tasks.
fn widths(model: &Model) -> [usize; 4] {
    let mut widths = [0; 4];
    for job in &model.jobs.all {
        for (width, fact) in widths.iter_mut().zip(Facts::new(model, job).0) {
            *width = fact.width().max(*width);
        }
    }
    widths
}

/// The selected task in whole words.
fn full_row(job: &Job) -> String {
    let said = match &job.state {
        JobState::Waiting(why) | JobState::Done(why) | JobState::Failed(why) => why.clone(),
        JobState::Cancelled(why) if why.is_empty() => "cancelled".into(),
        JobState::Cancelled(why) => format!("cancelled: {why}"),
        JobState::Stopping => "no new requests; waiting for those already sent".into(),
        JobState::Running if job.kind == JobKind::Batch => job.outcome(),
        JobState::Running => String::new(),
    };
    let why = job
        .why
        .as_ref()
        .map_or(String::new(), |why| format!("; first failure: {why}"));
    let text = if said.is_empty() {
        job.title.clone()
    } else {
        format!("{}: {said}{why}", job.title)
    };
    fit(&visible(&text), 600)
}

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

/// A job is to end: at once, or once it says so.
fn cancelled(job: &mut Job, now: Duration) {
    let words = match job.kind {
        JobKind::Generate | JobKind::Batch => return job.state = JobState::Stopping,
        JobKind::Question => "partial answer kept",
        JobKind::Plan | JobKind::Index | JobKind::Survey | JobKind::Ranking(_) => "",
    };
    job.end(JobState::Cancelled(words.into()), now);
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
        JobKind::Plan => return planner::cancel(model),
        JobKind::Generate => return generation::cancel(model),
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
