//! Sends questions and receives answers.

use std::sync::Arc;

use super::super::action::Action;
use super::super::message::{Computation, Effect, JobId, JobRequest, Update, WindowJudgement};
use super::super::model::{Column, Model, Pane, Progress, ShownAnswer};
use super::editing::show_error;
use super::{batch, list, making};
use nearmiss_ask::llm::Chunk;
use nearmiss_ask::llm::{Discovered, ModelOffer};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scene;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome, RECORDED};

/// Asks the chosen model the question as it stands; `fresh` even where the store has its answer.
pub fn ask(model: &mut Model, fresh: bool) -> Vec<Effect> {
    if model.fill_held() {
        // The new question must be displayed first.
        model.say("prompt rendered; press again to ask");
        return Vec::new();
    }
    let asked = model.model.clone();
    if asked == judge::MODEL && !Task::VERDICTS.contains(&model.task) {
        let key = model.look.key(Action::ChooseModel);
        model.say(format!(
            "the built-in judge answers {} only; {key} chooses a model",
            Task::names(&Task::VERDICTS)
        ));
        return Vec::new();
    }
    // The built-in judge reads the scene, not the prompt.
    if asked != judge::MODEL && show_error(model) {
        return Vec::new();
    }
    let Some(question) = model.prompt.question.clone() else {
        let why = model
            .opened
            .as_ref()
            .and_then(|o| o.no_ego.as_ref())
            .map_or("no scenario is open".to_string(), ToString::to_string);
        let (pick, take) = (
            model.look.key(Action::NextObstacle),
            model.look.key(Action::TakeAsEgo),
        );
        model.say(format!(
            "cannot ask: {why}; {pick} picks an obstacle, {take} makes it the ego"
        ));
        return Vec::new();
    };
    let id = JobId(model.new_id());
    // Recorded answers are looked up: nothing is called.
    let tools = model.tool_limits().filter(|_| calls_tools(&asked));
    if asked == judge::MODEL {
        model.answers.asking_reference = Some(id);
        model.answers.show(ShownAnswer::Reference);
    } else {
        let column = Column {
            ask: Some(id),
            model: asked.clone(),
            how: question.label(tools.is_some()),
            steps: Some((question.case.window.first(), question.case.window.last())),
            times: question.times(),
            begun: false,
            truth: model.answers.reference.as_ref().map(|r| r.verdict.clone()),
            judging: false,
            tool_rounds: Vec::new(),
            reasoning: String::new(),
            text: String::new(),
            progress: Progress::Waiting(0.0),
        };
        model.answers.add(column);
    }
    vec![Effect::Start(
        id,
        JobRequest::Question {
            question: Box::new(question),
            model: asked,
            tools,
            fresh,
        },
    )]
}

/// Whether a model is asked over the network, so that it may call tools.
pub fn calls_tools(model: &str) -> bool {
    model != judge::MODEL && !model.starts_with(RECORDED)
}

/// Judgements to request for answers without a truth: those from the store, and those that were asked before the
/// built-in judge was ready.
pub fn missing_truths(model: &mut Model) -> Option<Computation> {
    let scene = model.opened.as_ref()?.scene.clone()?;
    let mut windows = Vec::new();
    for column in &mut model.answers.columns {
        if (column.ask.is_none() || model.task == Task::Safety)
            && column.truth.is_none()
            && !column.judging
            && let Some(steps) = column.steps
        {
            column.judging = true;
            windows.push(steps);
        }
    }
    windows.sort_unstable();
    windows.dedup();
    let thresholds = model.thresholds.clone();
    (!windows.is_empty()).then_some(Computation::Judge(scene, model.task, windows, thresholds))
}

/// Takes judgements of windows; those of a scene or task that is no longer open are dropped.
pub fn judged(
    model: &mut Model,
    scene: &Arc<Scene>,
    task: Task,
    thresholds: &Arc<Thresholds>,
    found: &[WindowJudgement],
) {
    let open = model.opened.as_ref().and_then(|o| o.scene.as_ref());
    if task != model.task || !open.is_some_and(|open| Arc::ptr_eq(open, scene)) {
        return;
    }
    for column in model.answers.columns.iter_mut().filter(|c| c.judging) {
        let same = found.iter().find(|(steps, _)| Some(*steps) == column.steps);
        if let Some((_, judgement)) = same {
            column.truth = Some(judgement.verdict.clone());
            column.judging = false;
        }
    }
    if task == Task::Safety {
        model.judgements.take(scene, thresholds, found);
        if model.answers.reference.is_none() {
            model.take_reference();
        }
    }
}

/// Offers models that were found on this machine, beside those that are known.
pub fn offer(model: &mut Model, found: Vec<Discovered>) {
    for Discovered { id, .. } in found {
        if model.offers.iter().all(|offer| offer.id != id) {
            model.offers.push(ModelOffer {
                id,
                key: None,
                warning: None,
            });
        }
    }
}

/// A piece of an answer, or the whole one; the list counts anew what is stored on its scenario.
pub fn on_update(model: &mut Model, id: JobId, update: Update<Event, Box<Answer>>) -> Vec<Effect> {
    match update {
        Update::Progress(event) => arrived(model, id, event),
        Update::Ended(result) => {
            let name = list::name_of(model, id);
            model.end_stream(id);
            answered(model, id, result);
            return name.map_or_else(Vec::new, |name| list::recount(model, &name));
        }
        Update::Cancelled => {}
    }
    Vec::new()
}

/// A piece of an answer.
fn arrived(model: &mut Model, ask: JobId, event: Event) {
    let Some(column) = model.column_mut(ask) else {
        return;
    };
    match event {
        Event::Kept(_) => column.begun = true,
        Event::Awaiting(run) => {
            column.progress =
                Progress::Retrying(format!("run {run} asks the same; waiting for it"));
        }
        Event::Chunk(Chunk::Note(note)) => {
            let text = format!("{}: {note}", column.model);
            model.say(text);
        }
        Event::Chunk(Chunk::Started { .. }) => {
            column.progress = Progress::Arriving(seconds(column));
        }
        Event::Chunk(Chunk::Reasoning(text)) => {
            column.progress = Progress::Arriving(seconds(column));
            column.reasoning.push_str(&text);
        }
        Event::Chunk(Chunk::Text(text)) => {
            column.progress = Progress::Arriving(seconds(column));
            column.text.push_str(&text);
        }
        Event::NotStored(words) => {
            let text = format!("{}: {words}", column.model);
            model.complain(text);
        }
        Event::Chunk(Chunk::Retrying { attempt, wait, why }) => {
            let wait = wait.as_secs_f64();
            column.progress = Progress::Retrying(format!("{why}; try {attempt} in {wait:.0} s"));
        }
        Event::Tools(round) => column.tool_rounds.push(*round),
        // The answer that follows carries it.
        Event::Chunk(
            Chunk::Usage(_) | Chunk::ToolCalls(_) | Chunk::LogProbabilities(_) | Chunk::Finished(_),
        )
        | Event::Barred(_) => {}
    }
}

fn seconds(column: &Column) -> f64 {
    match column.progress {
        Progress::Waiting(s) | Progress::Arriving(s) => s,
        _ => 0.0,
    }
}

/// Time passes for what is on its way.
pub fn pass(model: &mut Model, seconds: f64) {
    for column in &mut model.answers.columns {
        if let Progress::Waiting(s) | Progress::Arriving(s) = &mut column.progress {
            *s += seconds;
        }
    }
}

/// An answer is complete.
fn answered(model: &mut Model, ask: JobId, result: Result<Box<Answer>, String>) {
    if model.answers.asking_reference == Some(ask) {
        model.answers.asking_reference = None;
        match result {
            Ok(answer) => {
                model.answers.reference_ms = answer.consumed.duration_ms;
                let run = match (answer.run, &answer.past) {
                    (None, _) => "not saved".into(),
                    (Some(run), None) => format!("saved as run {run}"),
                    (Some(run), Some(_)) => format!("the same as stored run {run}"),
                };
                let word = answer.verdict_label();
                model.tell(format!("{}: {word}, {run}", judge::MODEL));
            }
            Err(error) => model.complain(error),
        }
        return;
    }
    if let Some(place) = model
        .answers
        .elsewhere
        .iter()
        .position(|(id, _)| *id == ask)
    {
        let (_, name) = model.answers.elsewhere.remove(place);
        match result {
            Ok(answer) => {
                let word = answer.verdict_label();
                model.tell(format!("{} on {name}: {word}", answer.model));
            }
            Err(error) => model.complain(error),
        }
        return;
    }
    let Some(column) = model.column_mut(ask) else {
        return;
    };
    match result {
        Ok(answer) => {
            let twice = answer.past.and(answer.run);
            let failed = match &answer.judged {
                JudgeOutcome::Missing(missing) => Some(format!("{}: {missing}", answer.model)),
                JudgeOutcome::Verdict(_) | JudgeOutcome::Other(_) => None,
            };
            // The whole answer counts, whatever was shown of it so far.
            column.text.clone_from(&answer.text);
            column.reasoning.clone_from(&answer.reasoning);
            column.tool_rounds.clone_from(&answer.tool_rounds);
            column.progress = Progress::Done(answer);
            if let Some(run) = twice {
                let key = model.look.key(Action::RunAnew);
                model.say(format!("stored answer, run {run}; {key} asks again"));
                model.answers.show_once(ask, run);
            }
            if let Some(text) = failed {
                failed_with(model, ask, text);
            }
        }
        Err(error) => {
            column.progress = if column.begun {
                Progress::Broken(error.clone())
            } else {
                Progress::Unasked(error.clone())
            };
            failed_with(model, ask, error);
        }
    }
}

/// Says why there is no verdict, unless it is read beside the answer anyway.
fn failed_with(model: &mut Model, ask: JobId, why: String) {
    let read = !model.zoomed || model.focus == Pane::Reasoning;
    match model
        .answers
        .column()
        .filter(|c| read && c.ask == Some(ask))
    {
        // A reason is read from its beginning.
        Some(column) if column.text.is_empty() && column.reasoning.is_empty() => {
            model.answers.scroll = Some(0);
        }
        Some(_) => {}
        None => model.complain(why),
    }
}

/// Lets what is on its way go on without its column, as another scenario is opened.
pub fn leave(model: &mut Model, name: &str) {
    for column in model.answers.columns.drain(..) {
        if let (true, Some(ask)) = (column.is_running(), column.ask) {
            model.answers.elsewhere.push((ask, name.to_string()));
        }
    }
}

/// Where an answer stands that was cancelled.
pub fn cancelled() -> Progress {
    Progress::Broken("cancelled; partial answer kept".into())
}

/// Cancels everything that is on its way; batches begin nothing more.
pub fn abort_all(model: &mut Model) -> Vec<Effect> {
    let mut effects = Vec::new();
    for column in &mut model.answers.columns {
        if column.is_running() {
            column.progress = cancelled();
            effects.extend(column.ask.map(Effect::Cancel));
        }
    }
    effects.extend(
        model
            .answers
            .elsewhere
            .drain(..)
            .map(|(id, _)| Effect::Cancel(id)),
    );
    if !effects.is_empty() {
        model.say("cancelled");
    }
    effects.extend(batch::stop_all(model));
    effects.extend(making::cancel(model));
    effects
}

/// Takes the shown answer off the comparison.
pub fn close(model: &mut Model) -> Vec<Effect> {
    let ShownAnswer::Column(place) = model.answers.shown else {
        model.say("the built-in judge cannot be closed");
        return Vec::new();
    };
    if place >= model.answers.columns.len() {
        return Vec::new();
    }
    let column = model.answers.columns.remove(place);
    let last = model.answers.columns.len();
    model.answers.show(if last == 0 {
        ShownAnswer::Reference
    } else {
        ShownAnswer::Column(place.min(last - 1))
    });
    if column.is_running() {
        column.ask.map(Effect::Cancel).into_iter().collect()
    } else {
        Vec::new()
    }
}

/// The text of the shown answer.
pub fn shown_text(model: &Model) -> Option<String> {
    match model.answers.column() {
        Some(column) if column.reasoning.is_empty() => Some(column.text.clone()),
        Some(column) => Some(format!("{}\n\n{}", column.reasoning, column.text)),
        None => model
            .answers
            .reference
            .as_ref()
            .map(|r| r.reasoning.clone()),
    }
}
