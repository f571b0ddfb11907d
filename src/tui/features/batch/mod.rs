//! One question about many scenarios: marked, counted, confirmed and asked.

pub mod request;
pub mod state;

use std::sync::Arc;

use nearmiss_formats::Entry;
use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::{Lead, with_tools};
use nearmiss_workflow::configured_experiment;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::Paragraph;

use crate::action::Action;
use crate::features::batch::request::AskBatch;
use crate::features::prompt::show_error;
use crate::features::{Screen, Step, answers};
use crate::keymap::Key;
use crate::message::Effect;
use crate::model::{
    Batch, BatchProposal, Column, Counts, JobId, JobKind, JobState, Model, Pane, Update,
};
use crate::widgets::hints::Hint;
use crate::widgets::window;
use crate::widgets::words::{fit, thousands};
use request::{BatchAnswer, BatchProgress, BatchUpdate, EstimateBatch};

/// The confirmation of a batch, with its estimated consumption.
#[derive(Debug)]
pub struct BatchScreen;

impl Screen for BatchScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        match key.writes()? {
            'y' => Some(begin(model)),
            'n' => Some(decline(model)),
            _ => None,
        }
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            Action::Accept => begin(model),
            Action::Cancel | Action::Quit => decline(model),
            _ => Step::stay(),
        }
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let Some(card) = &model.proposal else { return };
        let title = if !card.is_counted() {
            "ask many · counting…"
        } else if blocked(card).is_some() {
            "ask many · nothing can be asked"
        } else {
            "ask many"
        };
        let text = text(model, card, window::width_in(screen, COLUMNS));
        let height = u16::try_from(text.lines.len() + 2).unwrap_or(u16::MAX);
        let inner = window::window(frame, screen, model, title, (COLUMNS, height));
        frame.render_widget(Paragraph::new(text), inner);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let key = |action, words: &str| (model.look.key(action), words.to_string());
        match model.proposal.as_ref().and_then(blocked) {
            Some(_) => vec![key(Action::Cancel, "close")],
            None => vec![key(Action::Accept, "ask"), key(Action::Cancel, "cancel")],
        }
    }
}

/// Why nothing can be asked, once all was counted.
fn blocked(card: &BatchProposal) -> Option<String> {
    let counts = &card.counts;
    if !card.is_counted() {
        return None;
    }
    let estimate = &counts.estimate;
    let questions = estimate.questions() - estimate.unaskable;
    let none = || (questions == 0).then(|| "there is no question to ask".to_string());
    counts.refused.clone().or_else(none)
}

/// Closes without asking.
fn decline(model: &mut Model) -> Step {
    let card = model.proposal.take();
    Step::Close(
        card.map(|card| Effect::Cancel(card.id))
            .into_iter()
            .collect(),
    )
}

/// Asks, or says why it cannot be asked.
fn begin(model: &mut Model) -> Step {
    let Some(card) = model.proposal.take_if(|card| card.is_counted()) else {
        let key = model.look.key(Action::Accept);
        model.say(format!("still counting; {key} asks when done"));
        return Step::stay();
    };
    if let Some(why) = blocked(&card) {
        model.proposal = Some(card);
        model.say(why);
        return Step::stay();
    }
    let key = model.look.key(Action::TaskList);
    model.say(format!(
        "asking {} about {} scenarios; {key} shows progress",
        card.batch.model,
        card.batch.entries.len()
    ));
    let ask = AskBatch {
        id: card.id,
        batch: card.batch,
    };
    Step::Close(vec![ask.into()])
}

/// Which windows are asked about.
fn windows(batch: &Batch) -> String {
    if batch.task == Task::Recording {
        return "each recording as a whole".to_string();
    }
    let steps = batch.history;
    match (batch.experiment.within, batch.experiment.lead(), batch.task) {
        (Some(_), Some(Lead::Seconds(lead)), _) => {
            format!("{steps} steps up to {lead} s before contact; safe ones like them")
        }
        (Some(_), Some(Lead::Paper), _) => {
            format!("{steps} steps, ending two before the last; safe ones like them")
        }
        (Some(_), None, _) => format!("{steps} steps with the contact; safe ones like them"),
        (None, _, Task::Collision) => "the end of each scenario".to_string(),
        (None, ..) => format!("{steps} steps of each scenario, ending two before the last"),
    }
}

/// Columns of the window at most.
const COLUMNS: u16 = 84;

/// Columns of the names and of the blanks around them.
const NAME: usize = 13;

fn text(model: &Model, card: &BatchProposal, width: usize) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let (batch, counts) = (&card.batch, &card.counts);
    let mut text = Text::default();
    let mut row = |name: &str, value: String, style: Style| {
        let value = visible(&value).into_owned();
        // Further lines stand below the value, not below its name.
        let mut label = format!(" {name:<11} ");
        for words in textwrap::wrap(&value, width.saturating_sub(NAME).max(16)) {
            text.push_line(Line::from(vec![
                Span::styled(label, dim),
                Span::styled(words.into_owned(), style),
            ]));
            label = " ".repeat(NAME);
        }
    };
    let all = batch.entries.len() == model.list.visible.len();
    if !card.marked && all {
        let key = model.look.key(Action::MarkScenario);
        row(
            "unmarked",
            format!(
                "No scenario is marked: this asks all {}. {key} marks",
                batch.entries.len()
            ),
            Style::new().fg(theme.warning),
        );
    }
    let estimate = &counts.estimate;
    let own = batch.model == judge::MODEL;
    let who = if own {
        format!("{} ({})", judge::NAME, judge::MODEL)
    } else {
        batch.model.clone()
    };
    row("model", who, bold);
    let tools = batch.experiment.parameters().tools;
    let prompt = format!(
        "{} · {} · {}",
        batch.task.name(),
        batch.frame.name(),
        with_tools(&batch.techniques.to_string(), tools.is_some())
    );
    row("prompt", prompt, Style::new());
    if batch.draft.is_some() {
        row(
            "template",
            "draft, not saved".into(),
            Style::new().fg(theme.warning),
        );
    }
    row("windows", windows(batch), Style::new());
    let which = if card.marked { "marked" } else { "listed" };
    row(
        "scenarios",
        format!("{} {which}", batch.entries.len()),
        Style::new(),
    );
    if !card.is_counted() {
        let done = match counts.read {
            (read, of) if counts.looked == 0 && of > 0 => format!("{read} of {of} recordings read"),
            _ => format!("{} of {} counted", counts.looked, batch.entries.len()),
        };
        row("so far", done, Style::new().fg(theme.warning));
    }
    if counts.unlabelled > 0 {
        let words = format!("{} without a ground truth", counts.unlabelled);
        row("left out", words, Style::new().fg(theme.warning));
    }
    if let Some(words) = &counts.left_out {
        row("left out", words.clone(), Style::new().fg(theme.warning));
    }
    if estimate.unaskable > 0 {
        let why = estimate.why.first().map_or("", |(why, _)| why.as_str());
        let words = format!(
            "{} cannot be asked about: {}",
            estimate.unaskable,
            fit(why, 300)
        );
        row("left out", words, Style::new().fg(theme.warning));
    }
    let there = format!("{}, free", estimate.stored);
    row("in store", there, Style::new());
    let name = if own { "answers" } else { "requests" };
    let asks = if own {
        format!("{}, on this machine", estimate.free)
    } else {
        format!("{}, {} at once", estimate.requests, counts.at_once)
    };
    let asks = match tools.filter(|_| !own) {
        Some(limits) => format!("{asks}; each with up to {} rounds of tools", limits.rounds),
        None => asks,
    };
    row(name, asks, bold);
    if !own {
        let tokens = format!("about {} in the questions", thousands(estimate.tokens));
        row("tokens", tokens, Style::new());
        let price = if model.prompt.prices.is_free(&batch.model) {
            "free: a server on this machine".to_string()
        } else {
            estimate.price()
        };
        row("price", price, bold);
        for bound in &estimate.bounds {
            row("counted", bound.clone(), Style::new());
        }
    }
    if let Some(left) = counts.budget {
        row(
            "budget",
            format!("${left:.4} left in this session"),
            Style::new(),
        );
    }
    if let Some(why) = blocked(card) {
        row("cannot ask", fit(&why, 400), Style::new().fg(theme.warning));
    }
    text
}

/// Marks the selected scenario, or takes its mark away.
pub fn mark(model: &mut Model) {
    match model.list.current() {
        Some(place) => {
            let entry = model.list.rows[place].entry.clone();
            model.marks.toggle(&entry);
            let count = model.marks.count(&model.list);
            let key = model.look.key(Action::AskMarked);
            let words = match count {
                0 => format!("no scenario marked; {key} asks about all listed"),
                _ => format!("{count} marked; {key} asks about them"),
            };
            model.say(match model.focus {
                Pane::Scenarios => words,
                // Away from the list, moving keys select nothing there.
                _ => {
                    let sign = if model.marks.has(&entry) {
                        "*"
                    } else {
                        "unmarked:"
                    };
                    format!("{sign} {}; select others in the list · {words}", entry.name)
                }
            });
        }
        None => model.say("no scenario selected"),
    }
}

/// Shows what asking about the marked scenarios would take, and begins to count it.
pub fn propose(model: &mut Model) -> Vec<Effect> {
    let entries = model.marks.chosen(&model.list);
    let asked = model.model.clone();
    if asked != judge::MODEL && show_error(model) {
        return Vec::new();
    }
    if entries.is_empty() {
        model.say("no scenarios listed");
        return Vec::new();
    }
    if model.frame.is_of_one_obstacle() {
        let key = model.look.key(Action::ToggleFrame);
        model.say(format!(
            "this frame needs one picked obstacle; {key} changes the frame"
        ));
        return Vec::new();
    }
    // The built-in judge gets no prompt.
    let draft = model.prompt.draft().filter(|_| asked != judge::MODEL);
    let mut batch = batch_of(model, entries, draft);
    if Task::VERDICTS.contains(&batch.task) {
        batch.experiment.every_scenario = true;
        batch.experiment.draw_windows();
    }
    let batch = Arc::new(batch);
    let id = JobId(model.new_id());
    model.proposal = Some(BatchProposal {
        id,
        batch: Arc::clone(&batch),
        counts: Counts::default(),
        marked: model.marks.count(&model.list) > 0,
    });
    model.screens.open(BatchScreen);
    vec![EstimateBatch { id, batch }.into()]
}

/// A batch about these scenarios, asked as the workbench would ask, each about the window at its end. `draft` is a
/// template that is not saved.
pub fn batch_of(model: &Model, entries: Vec<Entry>, draft: Option<(String, String)>) -> Batch {
    let decided = model.decided();
    Batch {
        task: model.task,
        frame: model.frame,
        techniques: decided.techniques,
        experiment: Experiment {
            models: vec![model.model.clone()],
            tasks: vec![model.task],
            frames: vec![model.frame],
            techniques: vec![decided.techniques],
            tools: model.tool_limits().map(|_| true).into(),
            pack: model.library.pack(),
            ..configured_experiment(&model.config)
        },
        history: decided.history,
        library: model.library.clone(),
        draft,
        thresholds: model.thresholds.clone(),
        model: model.model.clone(),
        entries,
    }
}

/// Handles a batch's events; the list of tasks has them already.
pub fn on_update(model: &mut Model, id: JobId, update: BatchUpdate) {
    match update {
        Update::Progress(BatchProgress::Answered(Ok(ended))) => show(model, ended),
        Update::Progress(_) => {}
        Update::Ended(_) | Update::Cancelled => over(model, id),
    }
}

/// An answer about the scenario that is open stands among the others; what is shown stays shown.
fn show(model: &mut Model, ended: BatchAnswer) {
    let about = answers::subject(model);
    let same = about.is_some_and(|of| ended.about == Some((of.scenario, of.ego, of.task)));
    let run = ended.answer.run;
    let is_it = |c: &Column| run.is_some() && c.answer().and_then(|a| a.run) == run;
    if !same || ended.answer.model == judge::MODEL || model.answers.columns.iter().any(is_it) {
        return;
    }
    let column = Column::from(*ended.answer);
    let (shown, scroll) = (model.answers.shown, model.answers.scroll);
    let kept = model.answers.columns.len();
    model.answers.add(column);
    // Adding made no room: the places of the others are as they were.
    if model.answers.columns.len() == kept + 1 {
        (model.answers.shown, model.answers.scroll) = (shown, scroll);
    }
}

/// One message for the whole batch.
fn over(model: &mut Model, id: JobId) {
    let mut all = model.jobs.all.iter().rev();
    let Some(job) = all.find(|job| job.id == id) else {
        return;
    };
    let why = job
        .why
        .as_ref()
        .map_or(String::new(), |why| format!("; first: {why}"));
    let (failed, words) = match &job.state {
        JobState::Done(words) | JobState::Cancelled(words) => (job.tally.2 > 0, words.clone()),
        JobState::Failed(words) => (true, words.clone()),
        _ => return,
    };
    let text = format!("{}: {words}{why}", job.title);
    if failed {
        model.complain(text);
    } else {
        model.tell(text);
    }
}

/// Lets every batch begin nothing more.
pub fn stop_all(model: &mut Model) -> Vec<Effect> {
    let running = model.jobs.all.iter().filter(|job| job.is_running());
    let batches = running
        .filter(|job| job.kind == JobKind::Batch)
        .map(|job| job.id);
    let batches: Vec<_> = batches.collect();
    batches.into_iter().flat_map(|id| stop(model, id)).collect()
}

/// Lets a batch begin nothing more; the second time, what it began is cancelled too.
pub fn stop(model: &mut Model, id: JobId) -> Vec<Effect> {
    model.say("no new requests; again cancels those already sent");
    vec![Effect::Cancel(id)]
}
