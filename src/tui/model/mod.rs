//! The complete state of the workbench: changed by `update` alone, read by the views.

pub mod camera;
pub mod last_frame;
pub mod look;
pub mod pane;
pub mod picker;
pub mod question;

pub use super::features::answers::claims_state::{Claims, Document};
pub use super::features::answers::state::{
    Answers, Column, Judgements, Progress, ReadingView, ShownAnswer, WindowJudgement,
    WindowsToJudge, parts,
};
pub use super::features::batch::state::{Batch, BatchProposal, Counts, MarkedScenarios};
pub use super::features::compare::state::{
    BlindMode, Compare, MAX_COMPARED, Marking, PendingRating, REASONS, shuffle,
};
pub use super::features::drivers::state::{Drivers, EncounterKey, EncounterToJudge};
pub use super::features::experiment::state::{
    CountedExperiment, ExperimentOutline, ExperimentView,
};
pub use super::features::generation::state::{
    GenerationState, Search, consequence_words, listed, working_words,
};
pub use super::features::history::state::{COUNTED, History, InputPurpose, PAGE};
pub use super::features::index::IndexChoice;
pub use super::features::jobs::state::{Job, JobKind, JobState, Jobs};
pub use super::features::map::state::{
    Detail, End, Foreseen, Foresight, Future, Layers, Measurement, Moment, On, PathRequest, Strip,
    Tape, Tools, Trails, as_text,
};
pub use super::features::planner::state::{Driver, RunningDrive, forecast_words};
pub use super::features::plot::state::{Drives, Plot};
pub use super::features::prompt::editor::{Change, Editor, Find, HEAVY, next, rows, width_of};
pub use super::features::prompt::state::{
    EntryLine, PromptPane, PromptView, TextChanges, changed_lines, diff_of,
};
pub use super::features::results::state::{
    COLUMNS as RESULTS_COLUMNS, CountedAnswers, ResultsDrawn, ResultsView,
};
pub use super::features::scenarios::state::{
    Filtering, Group, Grouping, HEADLINE, Line, List, ListIndex, Matching, Order, Row, TERMS,
    WordMatch, nearest,
};
pub use super::features::timeline::state::{Disagreement, Heat, Seek, heat};
pub use super::features::values::Values;
pub use camera::{Camera, NEIGHBOURHOOD};
pub use last_frame::{Extent, HistoryDrawn, LastFrame, MapDrawn, MapPicture, Readings};
pub use look::{DisplaySettings, Glyphs, MapChoice, themes_shown};
pub use nearmiss_study::evaluation::claims::counted;
pub use pane::{Arrangement, Border, Edge, Pane, PaneShares, Sizes};
pub use picker::{
    Picker, matching, measures_shown, models_shown, orders_shown, palette_shown, templates_shown,
};
pub use question::{Prices, RequestTokens};

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use nearmiss_ask::llm::ModelOffer;
use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window, WindowRule};
use nearmiss_scene::verdict::Task;
use nearmiss_settings::Config;
use nearmiss_store::{Run, RunId};
use nearmiss_study::evaluation::{EffectiveSettings, Settings, window_end};

use super::action::{Action, EVEN_THERE, MOVES_FOCUS, Scope, opens};
use super::clock::Clock;
use super::features::{Screen, Screens};
use super::loaded::{Opened, Source};
use super::session::SessionState;
use super::theme::Theme;

/// The state of the workbench.
#[derive(Debug)]
pub struct Model {
    /// Columns and rows of the terminal.
    pub size: (u16, u16),
    /// Where the scenarios come from; empty for the bundled ones.
    pub paths: Vec<PathBuf>,
    /// The list of scenarios.
    pub list: List,
    /// The opened scenario.
    pub opened: Option<Box<Opened>>,
    /// The opening that is under way, and the obstacle that shall be the ego in it.
    pub opening: Option<(OpenId, Option<i64>)>,
    /// The obstacle that was taken as the ego of the opened scenario.
    pub taken: Option<i64>,
    /// The source of a scenario, by its place in the list.
    pub source: Option<(usize, Box<Source>)>,
    /// Why the selected scenario is not open.
    pub open_error: Option<String>,
    /// The current time step.
    pub clock: Clock,
    /// Places that jumps left.
    pub jumps: JumpList,
    /// The pane that has the keys.
    pub focus: Pane,
    /// Whether the pane that has the keys is shown alone.
    pub zoomed: bool,
    /// How the map is seen.
    pub camera: Camera,
    /// Layers, paths and tape of the map.
    pub map: Tools,
    /// The planner, and its drive that is under way.
    pub driver: Driver,
    /// What drivers make of encounters.
    pub drivers: Drivers,
    /// Searches for dangerous variants, and what they made.
    pub generation: GenerationState,
    /// The picked obstacle.
    pub picked: Option<i64>,
    /// The plot over time.
    pub plot: Plot,
    /// The measure of the timeline's strips.
    pub heat: Heat,
    /// A disagreement that is looked for in a scenario that is being opened.
    pub seek: Option<Seek>,
    /// Every measure of the picked obstacle, while displayed.
    pub values: Values,
    /// The built-in judge's cached verdicts.
    pub judgements: Judgements,
    /// From where on values are dangerous, and what measures take for granted.
    pub thresholds: Arc<Thresholds>,
    /// The task.
    pub task: Task,
    /// From where the scene is described.
    pub frame: Frame,
    /// The frame the user chose; `None` while every task uses its default.
    pub frame_chosen: Option<Frame>,
    /// The tour, while it is on.
    pub tour: Option<super::features::tour::Tour>,
    /// The step that the clock was put to, the moment that matters, while the user has not moved it.
    pub placed: Option<i64>,
    /// Seconds within which a second Ctrl-C ends the program.
    pub quit_within: f64,
    /// Seconds within which Esc ends the search for an attack.
    pub stop_within: f64,
    /// How it is asked.
    pub techniques: Techniques,
    /// Whether the techniques were chosen, or are the template's.
    pub techniques_chosen: bool,
    /// Whether models may call tools.
    pub tools: bool,
    /// The prompt.
    pub prompt: PromptPane,
    /// Templates.
    pub library: Library,
    /// The answers.
    pub answers: Answers,
    /// How answers are read.
    pub reading: ReadingView,
    /// Claims of answers about obstacles.
    pub claims: Claims,
    /// Answers side by side on the whole screen.
    pub compare: Compare,
    /// The model that is asked.
    pub model: String,
    /// Models that can be chosen.
    pub offers: Vec<ModelOffer>,
    /// The history of runs.
    pub history: History,
    /// A run that is being opened again, and the opening that does it.
    pub reopening: Option<(OpenId, Box<Run>)>,
    /// A run that was opened again and has yet to stand among the earlier answers.
    pub reopened: Option<RunId>,
    /// The marked scenarios.
    pub marks: MarkedScenarios,
    /// A batch of questions that waits for a yes.
    pub proposal: Option<BatchProposal>,
    /// The chosen index of a corpus.
    pub index: IndexChoice,
    /// Everything that runs, and what ran.
    pub jobs: Jobs,
    /// Results of all stored answers.
    pub results: ResultsView,
    /// The experiment that is shown or asked.
    pub experiment: ExperimentView,
    /// How long the program has been running; the loop sets it.
    pub uptime: Duration,
    /// Screens over the main screen.
    pub screens: Screens,
    /// Messages.
    pub toasts: Vec<Toast>,
    /// The text of the last message.
    pub last_message: String,
    /// The session: what comes back of it, and what is kept.
    pub recall: SessionState,
    /// Colours.
    pub theme: Theme,
    /// Keys, and what else of the look can change.
    pub look: DisplaySettings,
    /// Settings.
    pub config: Config,
    /// Whether the mouse is used.
    pub mouse: bool,
    /// Where things were drawn last: what the mouse and the page keys need.
    pub drawn: LastFrame,
    next_id: u64,
}

impl Model {
    /// A workbench at its start.
    #[must_use]
    pub fn new(
        paths: Vec<PathBuf>,
        config: Config,
        theme: Theme,
        library: Library,
        offers: Vec<ModelOffer>,
    ) -> Self {
        Self {
            size: (0, 0),
            paths,
            list: List::default(),
            opened: None,
            opening: None,
            taken: None,
            source: None,
            open_error: None,
            clock: Clock::new(0..1, 0.1),
            jumps: JumpList::default(),
            focus: Pane::Scenarios,
            zoomed: false,
            camera: Camera::default(),
            map: Tools::default(),
            driver: Driver::default(),
            drivers: Drivers::default(),
            generation: GenerationState::default(),
            picked: None,
            plot: Plot::default(),
            heat: Heat::default(),
            seek: None,
            values: Values::default(),
            judgements: Judgements::default(),
            thresholds: Arc::new(Thresholds::shipped().clone()),
            task: Task::Collision,
            frame: Frame::Ego,
            frame_chosen: None,
            tour: None,
            placed: None,
            quit_within: 0.0,
            stop_within: 0.0,
            techniques: Techniques::ALL,
            techniques_chosen: false,
            tools: config.tools,
            prompt: PromptPane::new(config.editor),
            library,
            answers: Answers::default(),
            reading: ReadingView::default(),
            claims: Claims::default(),
            compare: Compare::default(),
            model: config
                .model
                .clone()
                .unwrap_or_else(|| judge::MODEL.to_string()),
            offers,
            history: History::default(),
            reopening: None,
            reopened: None,
            marks: MarkedScenarios::default(),
            proposal: None,
            index: IndexChoice {
                folder: config.index.clone(),
                configured: config.index.clone(),
                ..IndexChoice::default()
            },
            jobs: Jobs::default(),
            results: ResultsView::default(),
            experiment: ExperimentView::default(),
            uptime: Duration::ZERO,
            screens: Screens::default(),
            toasts: Vec::new(),
            last_message: String::new(),
            recall: SessionState::default(),
            theme,
            look: DisplaySettings::default(),
            mouse: config.mouse,
            config,
            drawn: LastFrame::default(),
            next_id: 0,
        }
    }

    /// A number that was not used before.
    pub fn new_id(&mut self) -> u64 {
        self.next_id += 1;
        self.next_id
    }

    /// The opened scene, if it has an ego.
    #[must_use]
    pub fn scene(&self) -> Option<&Scene> {
        self.opened.as_ref()?.scene.as_deref()
    }

    /// The window that is asked about: for the collision task the end of the recording, for the safety
    /// task the past of the current step.
    #[must_use]
    pub fn window(&self) -> Option<Window> {
        let scene = self.scene()?;
        Some(self.window_rule().at(scene, self.clock.step()))
    }

    /// First and last step of the window that the screen shows: that which the shown answer was told of, unless it is of
    /// another step than the clock's in a task about windows, else that which is asked about.
    #[must_use]
    pub fn shown_window(&self) -> Option<(i64, i64)> {
        let told = self.answers.column().and_then(|column| column.steps);
        let is_now =
            |(_, last): &(i64, i64)| self.task.is_about_all_steps() || *last == self.clock.step();
        let asked = || self.window().map(|w| (w.first(), w.last()));
        told.filter(is_now).or_else(asked)
    }

    /// How the window that is asked about is chosen.
    #[must_use]
    pub fn window_rule(&self) -> WindowRule {
        WindowRule {
            end: window_end(self.task),
            history: self.decided().history,
        }
    }

    /// How the scene is described: as the configuration says, else as the saved template does.
    #[must_use]
    pub fn decided(&self) -> EffectiveSettings {
        let found = self.library.find(self.task.name(), self.frame.name());
        let defaults = found.map(|(_, template)| template.front.defaults.clone());
        let said = Settings {
            history: self.config.history,
            radius: self.config.radius,
            techniques: self.techniques_chosen.then_some(self.techniques),
            obstacle: self.picked.filter(|_| self.frame.is_of_one_obstacle()),
            ..Settings::default()
        };
        said.with(&defaults.unwrap_or_default())
    }

    /// Where keys are looked up: on the screen on top, or in the pane that has them.
    #[must_use]
    pub fn scope(&self) -> Scope {
        match self.screens.top() {
            Some(screen) => screen.scope(),
            None if self.compare.open && !self.look.in_menu() => Scope::Compare,
            None if self.compare.open => Scope::Global,
            None => self.focus.scope(),
        }
    }

    /// The full screen that is open, whatever windows are over it, or the pane that has the keys.
    #[must_use]
    pub fn place(&self) -> Scope {
        let mut scopes = self.screens.iter().map(Screen::scope);
        match scopes.find(|scope| scope.is_own()) {
            Some(own) => own,
            None if self.compare.open => Scope::Compare,
            None if self.prompt.editing => Scope::Editor,
            None => self.focus.scope(),
        }
    }

    /// Whether the screens that are open let an action through that none of them has a use for: a window leaves what
    /// is below it alone, and other windows open over it.
    #[must_use]
    pub fn takes(&self, action: Action) -> bool {
        // Keys belong to a full screen while it is open: no pane gets the focus.
        let on_screen = self.compare.open || self.prompt.editing;
        if on_screen && self.screens.is_empty() && MOVES_FOCUS.contains(&action) {
            return false;
        }
        let scope = self.screens.top().map(Screen::scope);
        scope.is_none_or(Scope::is_own) || EVEN_THERE.contains(&action) || opens(action)
    }

    /// Whether time has to pass: something plays, or a message fades.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.clock.playing
            || self.toasts.iter().any(|t| t.left.is_finite())
            || self.answers.is_running()
            || self.jobs.has_batch()
            || self.screens.iter().any(|screen| screen.moves(self))
            || self.prompt.waits()
            || self.list.waits()
            || self.driver.waits.is_some()
            || self.quit_within > 0.0
            || self.stop_within > 0.0
    }

    /// The question with this number, if it is still shown.
    pub fn column_mut(&mut self, ask: JobId) -> Option<&mut Column> {
        self.answers.columns.iter_mut().find(|c| c.ask == Some(ask))
    }
}

/// A message that stays readable for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct Toast {
    /// Its text.
    pub text: String,
    /// Its kind.
    pub kind: Notice,
    /// Seconds it still stays; errors stay until a key is pressed.
    pub left: f64,
    /// Seconds it was shown.
    pub shown: f64,
}

/// Seconds after which a key takes news away, too: they were read.
const READ: f64 = 3.0;

/// Kind of a notice, which determines how long it is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Notice {
    /// The reply to a key: the next key makes it old.
    Reply,
    /// Something that came about by itself: keys meant for something else do not take it away at once.
    News,
    /// Something is wrong.
    Error,
}

impl Model {
    /// Shows a reply to a key.
    pub fn say(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::Reply, 4.0);
    }

    /// Says that something came about by itself.
    pub fn tell(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::News, 4.0);
    }

    /// Says how something long ended: the user may look elsewhere meanwhile.
    pub fn announce(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::News, 60.0);
    }

    /// Says that something is wrong.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::Error, f64::INFINITY);
    }

    /// The newest takes the place of an older one that is no error; errors are all there until they were read.
    fn notify(&mut self, text: String, kind: Notice, left: f64) {
        self.toasts
            .retain(|t| (kind == Notice::Error || t.kind == Notice::Error) && t.text != text);
        self.last_message.clone_from(&text);
        self.toasts.push(Toast {
            text,
            kind,
            left,
            shown: 0.0,
        });
    }

    /// A key was pressed: replies and errors were read, and news that were shown for a while.
    pub fn read_notices(&mut self) {
        let unread = |toast: &Toast| toast.kind == Notice::News && toast.shown < READ;
        self.toasts.retain(unread);
    }
}

/// Numbers the jobs; an event of one that has ended is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct JobId(pub u64);

/// Numbers the openings; a message of an old one is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct OpenId(pub u64);

/// Numbers the lists of runs that are asked for; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct PageId(pub u64);

/// Numbers the requests for every measure; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct MeasureId(pub u64);

/// Numbers the requests for what is plotted; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct SeriesId(pub u64);

/// How far a job is; the last one tells its outcome.
#[derive(Debug)]
pub enum Update<P, T> {
    /// It goes on.
    Progress(P),
    /// It has ended: what came of it, or why it failed.
    Ended(Result<T, String>),
    /// It was cancelled, and has ended.
    Cancelled,
}

/// A place: a scenario, a step and the picked obstacle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The scenario, by its place in the list.
    pub scenario: usize,
    /// The obstacle that was taken as the ego.
    pub taken: Option<i64>,
    /// The time step.
    pub step: i64,
    /// The picked obstacle.
    pub picked: Option<i64>,
}

/// Places to go back to and forward to, the next one last.
#[derive(Debug, Clone, Default)]
pub struct JumpList {
    back: Vec<Place>,
    forward: Vec<Place>,
    /// The place to go to when its scenario has been opened.
    pub arriving: Option<(OpenId, Place)>,
}

/// Places that are kept.
const KEPT: usize = 100;

impl JumpList {
    /// A jump leaves this place: what lay ahead is forgotten.
    pub fn leave(&mut self, place: Place) {
        self.forward.clear();
        if self.back.last() != Some(&place) {
            self.back.push(place);
        }
        let over = self.back.len().saturating_sub(KEPT);
        self.back.drain(..over);
    }

    /// The place before the last jump, or after it, in exchange for the present one.
    pub fn turn(&mut self, back: bool, now: Option<Place>) -> Option<Place> {
        let (from, to) = if back {
            (&mut self.back, &mut self.forward)
        } else {
            (&mut self.forward, &mut self.back)
        };
        // A jump that led nowhere is none.
        while from.last().is_some_and(|place| Some(place) == now.as_ref()) {
            from.pop();
        }
        let place = from.pop()?;
        to.extend(now);
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(step: i64) -> Place {
        Place {
            scenario: 0,
            taken: None,
            step,
            picked: None,
        }
    }

    #[test]
    fn back_and_forward_and_a_jump_forgets_what_lay_ahead() {
        let mut jumps = JumpList::default();
        jumps.leave(at(1));
        jumps.leave(at(2));
        assert_eq!(jumps.turn(true, Some(at(3))), Some(at(2)));
        assert_eq!(jumps.turn(true, Some(at(2))), Some(at(1)));
        assert_eq!(jumps.turn(true, Some(at(1))), None);
        assert_eq!(jumps.turn(false, Some(at(1))), Some(at(2)));
        assert_eq!(jumps.turn(false, Some(at(2))), Some(at(3)));
        assert_eq!(jumps.turn(true, Some(at(3))), Some(at(2)));
        jumps.leave(at(2));
        assert_eq!(jumps.turn(false, Some(at(9))), None);
        for step in 0..500 {
            jumps.leave(at(step));
        }
        assert_eq!(jumps.back.len(), KEPT);
    }
}
