//! Questions and their answers: asked, stored ones loaded, and judged.

pub mod claims;
pub mod claims_state;
pub mod obstacles;
pub mod reasoning;
pub mod state;
pub mod verdict;

use std::sync::Arc;

use crate::action::Action;
use crate::features::Step;
use crate::features::jobs::notes;
use crate::features::prompt::show_error;
use crate::features::{batch, compare, generation, scenarios, timeline};
use crate::message::Effect;
use crate::model::{
    Column, Job, JobId, JobKind, JobState, Model, Pane, Progress, PromptView, ShownAnswer, Update,
    WindowJudgement, WindowsToJudge,
};
use crate::request::{Computation, Replies, Request};
use crate::services::{Canceller, Services};
use crate::update::opened;
use nearmiss_ask::llm::{Chunk, Discovered, ModelOffer, ToolLimits, probe};
use nearmiss_scene::judge::{self, judge_under};
use nearmiss_scene::scenario::{EgoSource, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::Origin;
use nearmiss_study::evaluation::{
    Answer, Event, JudgeOutcome, Question, RunOptions, is_stored_alone,
};
use nearmiss_workflow::AskRequest;

/// Asks the chosen model the question as it stands; `fresh` even where the store has its answer.
pub fn ask(model: &mut Model, fresh: bool) -> Vec<Effect> {
    if model.fill_held() {
        // The new question must be displayed first.
        model.say("prompt rendered; press again to ask");
        return Vec::new();
    }
    let asked = model.model.clone();
    if asked == judge::MODEL && (model.prompt.editing || model.prompt.is_draft()) {
        model.say("the built-in judge reads no prompt: choose a model for the draft");
        return vec![Effect::Step(Step::Perform(Action::ChooseModel))];
    }
    if is_stored_alone(&asked) && (model.prompt.editing || model.prompt.is_draft()) {
        model.say(format!(
            "{asked} is imported answers, which no prompt changes: choose a model for the draft"
        ));
        return vec![Effect::Step(Step::Perform(Action::ChooseModel))];
    }
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
        model.say(format!("cannot ask: {}", model.without_ego()));
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
    let ask = Ask {
        id,
        question: Box::new(question),
        model: asked,
        tools,
        fresh,
    };
    if model.prompt.editing {
        model.prompt.beside = PromptView::Answer;
        model.prompt.turned = !model.prompt.fits_beside(model.size.0);
        model.prompt.scroll = 0;
    }
    vec![ask.into()]
}

/// Whether a model is asked over the network, so that it may call tools.
pub fn calls_tools(model: &str) -> bool {
    model != judge::MODEL && !is_stored_alone(model)
}

/// Moves through the obstacles of the verdict pane's table, which stays in sight; says whether there is one to go to.
pub fn move_cursor(model: &mut Model, action: Action) -> bool {
    let named = obstacles::named(model);
    let (last, by) = match action {
        Action::Down => (named.len().saturating_sub(1), 1),
        Action::Up => (named.len().saturating_sub(1), -1),
        _ => {
            // Pages scroll the text.
            model.answers.cursor = None;
            return false;
        }
    };
    let cursor = model.answers.cursor;
    let now = cursor.and_then(|id| named.iter().position(|known| *known == id));
    let next = match (now, by) {
        _ if named.is_empty() => return false,
        (None, _) => 0,
        // Beyond the table the text goes on.
        (Some(now), 1) if now == last => return false,
        (Some(0), -1) => {
            model.answers.cursor = None;
            return false;
        }
        (Some(now), by) => now.saturating_add_signed(by),
    };
    model.answers.cursor = Some(named[next]);
    model.answers.verdict_top = model.drawn.extent(Pane::Verdict).top;
    true
}

/// Picks the obstacle that the keys stand on in the verdict pane, or shows the details of one that is picked; says whether
/// there is one.
pub fn pick(model: &mut Model) -> Option<Action> {
    let id = model.cursor_obstacle()?;
    if model.picked == Some(id) {
        return Some(Action::Details);
    }
    model.picked = Some(id);
    Some(Action::PaneMain)
}

/// Judgements to request for answers without a truth: those from the store, and those that were asked before the
/// built-in judge was ready.
pub fn missing_truths(model: &mut Model) -> Option<WindowsToJudge> {
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
    (!windows.is_empty()).then_some(WindowsToJudge {
        scene,
        task: model.task,
        windows,
        thresholds,
    })
}

/// A piece of an answer, or the whole one; the list counts anew what is stored on its scenario.
pub fn on_update(model: &mut Model, id: JobId, update: Update<Event, Box<Answer>>) -> Vec<Effect> {
    match update {
        Update::Progress(event) => arrived(model, id, event),
        Update::Ended(result) => {
            let name = scenarios::name_of(model, id);
            model.end_stream(id);
            answered(model, id, result);
            return name.map_or_else(Vec::new, |name| scenarios::recount(model, &name));
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
                // The tour keeps nothing.
                let run = answer.run.filter(|_| model.tour.is_none());
                let run = match (run, &answer.past) {
                    (None, _) => "not saved".into(),
                    (Some(run), None) => format!("saved as run {run}"),
                    (Some(run), Some(_)) => format!("the same as stored run {run}"),
                };
                let word = answer.verdict_label();
                model.tell(format!("built-in judge: {word}, {run}"));
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
    effects.extend(generation::cancel(model));
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

impl Computation for WindowsToJudge {
    /// The windows, and the judge's answers about them.
    type Value = (Self, Vec<WindowJudgement>);

    fn compute(self) -> Self::Value {
        let judge = |&(first, last): &(i64, i64)| {
            let steps = last.saturating_sub(first).saturating_add(1);
            let steps = usize::try_from(steps).unwrap_or(1);
            let window = Window::ending_at(&self.scene, last, steps);
            let judgement = judge_under(&self.scene, self.task, &window, &self.thresholds);
            ((first, last), judgement)
        };
        let judgements = self.windows.iter().map(judge).collect();
        (self, judgements)
    }

    /// Those of a scene or task that is no longer open are dropped.
    fn take(model: &mut Model, (asked, found): Self::Value) {
        let Self {
            scene,
            task,
            thresholds,
            ..
        } = asked;
        let open = model.opened.as_ref().and_then(|o| o.scene.as_ref());
        if task != model.task || !open.is_some_and(|open| Arc::ptr_eq(open, &scene)) {
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
            model.judgements.take(&scene, &thresholds, &found);
            if model.answers.reference.is_none() {
                model.take_reference();
            }
        }
        timeline::arrived(model);
    }
}

/// Loads the earlier answers on what is open.
pub fn load(model: &Model) -> Option<Effect> {
    subject(model).map(|of| LoadStored(of).into())
}

/// The subject that earlier answers must have.
pub fn subject(model: &Model) -> Option<StoredOf> {
    let scene = model.scene()?;
    Some(StoredOf {
        scenario: scene.scenario.hash.to_string(),
        name: model.opened.as_ref()?.name.clone(),
        ego: scene.ego.to_string(),
        recorded: matches!(scene.ego.source, EgoSource::Recording(_)),
        task: model.task,
    })
}

/// Shows earlier answers that say something, the newest of each model and way of asking, unless something newer is
/// there. Those that were asked as it would be asked now come first, one of each model.
pub fn show(model: &mut Model, stored: Vec<Answer>) {
    if !model.answers.columns.is_empty() {
        return;
    }
    let how = model.way();
    let mut seen = std::collections::HashSet::new();
    // Incomplete answers come after complete ones to the same question.
    let (whole, broken): (Vec<_>, Vec<_>) = stored.into_iter().partition(Answer::arrived);
    let mut newest: Vec<Answer> = whole
        .into_iter()
        .chain(broken)
        // A run that reached no model says nothing about the scenario, nor about an older answer of that model.
        .filter(|a| a.model != nearmiss_scene::judge::MODEL && !a.text.trim().is_empty())
        .filter(|a| seen.insert((a.model.clone(), a.how.clone())))
        .collect();
    newest.sort_by_key(|answer| answer.how != how);
    newest.truncate(STORED);
    for answer in newest {
        model.answers.columns.push(Column::from(answer));
    }
    model.answers.arrange(&how);
    if !model.answers.columns.is_empty() {
        model.answers.show(ShownAnswer::Column(0));
    }
}

/// Earlier answers kept at hand.
const STORED: usize = 32;

/// The scenario, ego and task that stored answers are about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredOf {
    /// Hash of the scenario.
    pub scenario: String,
    /// Its name.
    pub name: String,
    /// The ego, as the store writes it.
    pub ego: String,
    /// Whether its motion is the recorded one, which recorded answers are about.
    pub recorded: bool,
    /// The task.
    pub task: Task,
}

/// Earlier answers that are looked through: the newest on a scenario and task.
const MAX_STORED: usize = 100;

/// Loads earlier answers.
#[derive(Debug)]
pub struct LoadStored(pub StoredOf);

impl Request for LoadStored {
    type Reply = (StoredOf, Vec<Answer>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Some(store) = services.store.clone() else {
            return;
        };
        let Self(of) = self;
        tokio::task::spawn_blocking(move || {
            match store.of_scenario(&of.scenario, &of.name, of.task, MAX_STORED) {
                Ok(runs) => {
                    let same = runs.into_iter().filter(|run| match run.origin {
                        Origin::Recorded => of.recorded,
                        _ => run.question.ego == of.ego,
                    });
                    let answers = same.map(Answer::from).collect();
                    replies.send((of, answers));
                }
                Err(error) => replies.complain(format!("earlier answers are not shown: {error}")),
            }
        });
    }

    /// They are taken if they are on what is open.
    fn reply(model: &mut Model, (of, stored): Self::Reply) -> Vec<Effect> {
        if subject(model).as_ref() == Some(&of) {
            let reopened = opened::before_stored(model);
            show(model, stored);
            if let Some(column) = reopened {
                opened::after_stored(model, column);
            }
            timeline::arrived(model);
            compare::arrived(model);
        }
        Vec::new()
    }
}

/// Asks a model.
#[derive(Debug)]
pub struct Ask {
    /// Its number.
    pub id: JobId,
    /// The question.
    pub question: Box<Question>,
    /// The model, `provider/model`.
    pub model: String,
    /// How often it may call tools; `None` where it may not.
    pub tools: Option<ToolLimits>,
    /// Whether it is asked anew where the store has its answer.
    pub fresh: bool,
}

impl Request for Ask {
    /// Pieces of an answer; then the whole answer, or why the store refused.
    type Reply = (JobId, Update<Event, Box<Answer>>);

    fn sent(&self, model: &mut Model) {
        let title = format!("{} on {}", self.model, self.question.case.name);
        let mut job = Job::new(self.id, JobKind::Question, title, 1, model.uptime);
        job.state = JobState::Waiting(String::new());
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self {
            id,
            question,
            model,
            tools,
            fresh,
        } = self;
        let reply = move |update| {
            replies.send((id, update));
        };
        let judge = match services.judge(&model, tools) {
            Ok(judge) => judge,
            Err(error) => return reply(Update::Ended(Err(error))),
        };
        let store = services.store.clone();
        let task = tokio::spawn(async move {
            let request = AskRequest {
                question: &question,
                judge: &judge,
                store,
                options: RunOptions {
                    fresh,
                    ..RunOptions::default()
                },
            };
            let outcome =
                nearmiss_workflow::ask(request, |event| reply(Update::Progress(event))).await;
            let answer = outcome.map(|outcome| Box::new(outcome.answer));
            reply(Update::Ended(answer.map_err(|error| error.to_string())));
        });
        // Aborting the task closes the connection and writes the run down as cancelled.
        let task = task.abort_handle();
        services.jobs.insert(id, Canceller::Abort, task);
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        if let Update::Ended(Ok(answer)) = &update
            && answer.verdict().is_some()
        {
            model.recall.hint = false;
        }
        let is_current = notes::note(model, id, |job, now| {
            notes::note_question(job, &update, now)
        });
        if is_current {
            on_update(model, id, update)
        } else {
            Vec::new()
        }
    }
}

/// Looks which model servers run on this machine.
#[derive(Debug)]
pub struct Probe;

impl Request for Probe {
    type Reply = Vec<Discovered>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let registry = services.models.registry().clone();
        let environment = services.models.environment().clone();
        tokio::spawn(async move {
            let mut found = probe(&registry, &environment).await;
            found.models.retain(|model| !model.is_no_chat());
            replies.send(found.models);
            for note in found.notes {
                replies.complain(note);
            }
        });
    }

    /// Offers models that were found on this machine, beside those that are known.
    fn reply(model: &mut Model, found: Self::Reply) -> Vec<Effect> {
        for Discovered { id, .. } in found {
            if model.offers.iter().all(|offer| offer.id != id) {
                model.offers.push(ModelOffer {
                    id,
                    key: None,
                    warning: None,
                });
            }
        }
        Vec::new()
    }
}
