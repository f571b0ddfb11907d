//! Generation with a model as author: start, progress and cost.

use std::sync::Arc;
use std::time::Duration;

use nearmiss_ask::llm::Chunk;
use nearmiss_scene::description::{Frame, visible};
use nearmiss_scene::judge;
use nearmiss_scene::scenario::{ContentHash, ObstacleRole};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::generating::{Method, Progress};
use nearmiss_study::evaluation::{Event, Settings};
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};

use crate::action::Action;
use crate::features::generation::request::Generate;
use crate::features::generation::{against, ready, show, still_searching, variant_request};
use crate::features::{Screen, Step, scenarios};
use crate::keymap::Key;
use crate::loaded::{AuthoringProgress, Authorship, GenerationStage, VariantRequest, Writer};
use crate::message::Effect;
use crate::model::{Job, JobId, JobKind, JobState, Model, RequestTokens};
use crate::widgets::hints::Hint;
use crate::widgets::words::thousands;
use crate::widgets::{unbroken, window};

/// Offers to let the chosen model write, with its cost; or says how far what is under way is; or shows what it made.
pub fn begin(model: &mut Model, only: Option<i64>) -> Vec<Effect> {
    if still_searching(model) {
        return Vec::new();
    }
    if model.model == judge::MODEL {
        let (choose, search) = (
            model.look.key(Action::ChooseModel),
            model.look.key(Action::Generate),
        );
        model.say(format!(
            "the built-in judge writes no attacks: {choose} chooses a model, {search} searches"
        ));
        return Vec::new();
    }
    let Some((hash, change)) = ready(model) else {
        return Vec::new();
    };
    let asked = model.model.clone();
    let kept = model.generation.find(hash, change);
    let its = kept.and_then(|kept| kept.made.authorship.as_ref());
    if model.variant().is_none() && only.is_none() && its.is_some_and(|its| its.model == asked) {
        return show(model, true);
    }
    // The store would give the same again.
    let fresh = model.generation.was_heard(hash, only, &asked);
    let task = match only {
        Some(id) => format!("write a motion of {id} that endangers the ego"),
        None => "choose an attacker and write its motion".into(),
    };
    let anew = if fresh { " again" } else { "" };
    let reply = format!("asking {asked}{anew}{}", against(model));
    let method = method(model);
    let requests = requests(model, &method, only);
    let price = model.prompt.prices.of_requests(&asked, &requests);
    // A variant has another name, and the question is about its original.
    let name = opened_name(model);
    let writer = Writer {
        model: asked.clone(),
        name: change.map_or_else(|| name.clone(), |change| change.name(&name)),
        library: model.library.clone(),
        settings: Settings {
            history: model.config.history,
            radius: model.config.radius,
            techniques: model.techniques_chosen.then_some(model.techniques),
            ..Settings::default()
        },
        method,
        fresh,
    };
    if let Some((place, request)) = variant_request(model, change, only, 1, Some(Box::new(writer)))
    {
        model.screens.open(AttackScreen {
            request: Some(request),
            place,
            asked,
            task,
            requests: requests.len(),
            counts: (
                method.votes_for(only),
                method.motions(),
                method.most_grades(),
            ),
            tokens: requests.iter().map(|one| one.question).sum(),
            price,
            reply,
        });
    }
    Vec::new()
}

/// How the workbench asks for attacks: as `generate` does.
fn method(model: &Model) -> Method {
    Method {
        within: model.config.attack_within,
        ..Method::default()
    }
}

/// Tokens of what is said about a refused motion, or about the drive against one, at most.
const REPLY: usize = 900;

/// Every request that may be sent, each as long as it can get: the votes for an attacker, the conversations about its
/// motion, in which all that was said before is sent again, and the grades of motions.
fn requests(model: &Model, method: &Method, only: Option<i64>) -> Vec<RequestTokens> {
    let answer = model.config.max_tokens;
    let request = |question| RequestTokens { question, answer };
    let choice = model.tokens_of(Task::Attacker, None);
    let attacker = only.or(model.picked).or_else(|| {
        let opened = model.opened.as_deref()?;
        let mut all = opened.scenario.obstacles.iter();
        Some(all.find(|o| o.role == ObstacleRole::Dynamic)?.id)
    });
    let motion = attacker
        .and_then(|id| model.tokens_of(Task::Trajectory, Some(id)))
        .or(choice)
        .unwrap_or(model.prompt.tokens);
    let said = answer.map_or(0, |most| most as usize) + REPLY;
    let retries = 0..=method.retries as usize;
    let talk = retries.map(|retry| request(motion + retry * said));
    let talks = (0..method.samples).flat_map(|_| talk.clone());
    let votes = method.votes_for(only) as usize;
    let votes = std::iter::repeat_n(request(choice.unwrap_or(motion)), votes);
    let grade = model.tokens_in(Task::Safety, Frame::Metrics, None);
    let grades = method.most_grades() as usize;
    let grades = std::iter::repeat_n(request(grade.or(choice).unwrap_or(motion)), grades);
    votes.chain(talks).chain(grades).collect()
}

/// Handles progress of the authoring model.
pub fn on_progress(model: &mut Model, progress: &Progress) {
    if let Progress::Heard {
        event: Event::Chunk(Chunk::Note(note)),
        ..
    } = progress
    {
        model.say(format!("{}: {note}", model.model));
    }
    let method = method(model);
    let Some(search) = &mut model.generation.under_way else {
        return;
    };
    let mut at = match search.at {
        Some(GenerationStage::Writing(at)) => at,
        _ => AuthoringProgress::default(),
    };
    at.on_event(progress, &method);
    search.at = Some(GenerationStage::Writing(at));
    search.waits = match progress {
        Progress::Heard { event, .. } => match waiting(event) {
            Some(why) => Some(why),
            // Something arrives: the server is there again.
            None => { search.waits.take() }
                .filter(|_| matches!(event, Event::Kept(_) | Event::Chunk(Chunk::Note(_)))),
        },
        _ => search.waits.take(),
    };
}

/// Why an answer does not arrive yet.
fn waiting(event: &Event) -> Option<String> {
    match event {
        Event::Chunk(Chunk::Retrying { attempt, wait, why }) => {
            let wait = wait.as_secs_f64();
            Some(format!("{why}; try {attempt} in {wait:.0} s"))
        }
        Event::Awaiting(run) => Some(format!("run {run} asks the same; waiting for it")),
        _ => None,
    }
}

/// Handles a result that is not dangerous; the model's output can be read.
pub fn unwritten(model: &mut Model, words: String, wrote: Arc<Authorship>) {
    if let Some(of) = model.made_of() {
        model.generation.keep_fruitless(of, Ok(wrote.clone()));
        note_asked(model, of.0, &wrote);
    }
    let key = model.look.key(Action::VariantPanel);
    let words = format!("{words}; {key} details");
    if wrote.failed() {
        model.complain(words)
    } else {
        model.announce(words)
    }
}

/// A model has said all that it was to say about a scenario: where it is asked once more, it is asked anew.
pub fn note_asked(model: &mut Model, hash: ContentHash, wrote: &Authorship) {
    if wrote.authored.stopped.is_none() {
        model.generation.heard_out(hash, wrote.only, &wrote.model);
    }
}

/// Counts the answers on what is open anew.
pub fn recount(model: &Model) -> Vec<Effect> {
    scenarios::recount(model, &opened_name(model))
}

/// The name of what is open, in the list.
fn opened_name(model: &Model) -> String {
    let place = model.list.opened;
    let row = place.and_then(|place| model.list.rows.get(place));
    row.map_or(String::new(), |row| row.entry.name.clone())
}

/// Work of a model, for the list of tasks.
pub fn job(id: JobId, name: &str, asked: &str, conversations: u32, now: Duration) -> Job {
    let title = format!("{name} made dangerous by {asked}");
    let conversations = usize::try_from(conversations).unwrap_or(1);
    Job::new(id, JobKind::Generate, title, conversations, now).asking()
}

/// Takes note of what it takes.
pub fn note(job: &mut Job, progress: &Progress) {
    if job.state == JobState::Stopping && !matches!(progress, Progress::Answered { .. }) {
        return;
    }
    match progress {
        Progress::Heard { event, .. } => match (waiting(event), event) {
            (Some(why), _) => job.state = JobState::Waiting(why),
            (None, Event::Chunk(Chunk::Started { .. } | Chunk::Reasoning(_) | Chunk::Text(_))) => {
                job.state = JobState::Running;
            }
            _ => {}
        },
        // From the store it costs nothing.
        Progress::Answered {
            consumed, stored, ..
        } => {
            if !stored {
                job.consumed(consumed);
            }
        }
        Progress::Ended { .. } => job.done += 1,
        Progress::Choosing { .. }
        | Progress::Chosen(_)
        | Progress::Writing { .. }
        | Progress::Made(_)
        | Progress::Driving(_)
        | Progress::ToldOfDrive(_)
        | Progress::Refused(_)
        | Progress::Grading { .. } => {}
    }
}

/// The confirmation, with what is asked on a yes.
#[derive(Debug)]
pub struct AttackScreen {
    /// The work; taken on a yes.
    pub request: Option<Box<VariantRequest>>,
    /// The scenario's place in the list.
    pub place: usize,
    /// The model.
    pub asked: String,
    /// What it is asked.
    pub task: String,
    /// Requests at most.
    pub requests: usize,
    /// Of these, votes for the attacker, answers about motions, and grades of motions.
    pub counts: (u32, u32, u32),
    /// Tokens of the questions at most, estimated.
    pub tokens: usize,
    /// Their cost at most, in words.
    pub price: String,
    /// Said on a yes.
    pub reply: String,
}

/// Columns of the window.
const COLUMNS: u16 = 76;

impl Screen for AttackScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        match key.writes()? {
            'y' => Some(self.begin(model)),
            'n' => Some(Step::close()),
            _ => None,
        }
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            Action::Accept => self.begin(model),
            Action::Cancel | Action::Quit => Step::close(),
            _ => Step::stay(),
        }
    }

    fn draw(&self, frame: &mut ratatui::Frame<'_>, screen: Rect, model: &Model) {
        let [yes, no] = [Action::Accept, Action::Cancel].map(|action| model.look.key(action));
        let title = format!("let a model attack · {yes} ask · {no} cancel");
        let text = Paragraph::new(unbroken::text(self.text(model))).wrap(Wrap { trim: false });
        let width = window::width_in(screen, COLUMNS);
        let lines = text.line_count(u16::try_from(width).unwrap_or(u16::MAX));
        let height = u16::try_from(lines + 2).unwrap_or(u16::MAX);
        let inner = window::window(frame, screen, model, &title, (COLUMNS, height));
        frame.render_widget(text, inner);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let key = |action, words: &str| (model.look.key(action), words.to_string());
        vec![key(Action::Accept, "ask"), key(Action::Cancel, "cancel")]
    }
}

impl AttackScreen {
    fn begin(&mut self, model: &mut Model) -> Step {
        let Some(request) = self.request.take() else {
            return Step::close();
        };
        let id = JobId(model.new_id());
        model.say(self.reply.clone());
        model.generation.begin(id, self.place);
        Step::Close(vec![Generate { id, request }.into()])
    }

    fn text(&self, model: &Model) -> Text<'static> {
        let dim = Style::new().fg(model.theme.dim);
        let bold = Style::new().add_modifier(Modifier::BOLD);
        let (votes, motions, grades) = self.counts;
        let votes = match votes {
            0 => String::new(),
            1 => "1 vote for the attacker, ".into(),
            n => format!("{n} votes for the attacker, "),
        };
        let requests = format!(
            "up to {}: {votes}{motions} about motions, which go back with reasons or with what came of the drive, {grades} to grade them",
            self.requests
        );
        let tokens = thousands(self.tokens as u64);
        let rows = [
            ("model", self.asked.clone(), bold),
            ("task", self.task.clone(), Style::new()),
            ("requests", requests, bold),
            (
                "tokens",
                format!("about {tokens} in the questions at most"),
                Style::new(),
            ),
            ("price", self.price.clone(), bold),
        ];
        let bound = model
            .prompt
            .prices
            .bound(&self.asked)
            .map(|bound| ("counted", bound, Style::new()));
        let rows = rows.into_iter().chain(bound);
        let line = |(name, value, style): (&str, String, Style)| {
            let value = visible(&value).into_owned();
            Line::from(vec![
                Span::styled(format!(" {name:<9} "), dim),
                Span::styled(value, style),
            ])
        };
        let mut text: Text<'static> = rows.map(line).collect();
        if self.price.contains("+ answers") {
            text.push_line(Line::styled(
                " max_tokens in config.toml bounds the length of answers, and so the price",
                Style::new().fg(model.theme.warning),
            ));
        }
        text
    }
}
