//! Everything that the workbench knows; changed by `update` alone, read by the views.

mod answers;
mod camera;
mod drawn;
mod list;
mod notices;
mod picker;
mod picture;
mod plot;
mod prompt;
mod values;

use std::path::PathBuf;
use std::sync::Arc;

pub use answers::{Answers, Column, Progress, Shown};
pub use camera::Camera;
pub use drawn::{Drawn, Extent, MapDrawn};
pub use list::List;
pub use notices::{Notice, Toast};
pub use picker::{Picker, measures_shown, models_shown, palette_shown};
pub use picture::pictures_shown;
pub use plot::Plot;
pub use prompt::{PromptPane, PromptView};
pub use values::Values;

use super::action::Scope;
use super::clock::Clock;
use super::loaded::Opened;
use super::message::{AskId, OpenId};
use super::theme::Theme;
use crate::config::Config;
use crate::evaluation::{Case, Decided, Settings, prepare};
use crate::judge::{self, judge_under};
use crate::llm::Offer;
use crate::metrics::Thresholds;
use crate::prompts::{Library, Techniques};
use crate::scenario::{Scene, Window};
use crate::text::Frame;
use crate::verdict::Task;

/// The panes of the main screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pane {
    /// The list of scenarios.
    Scenarios,
    /// The map from above.
    Map,
    /// Danger over time.
    Timeline,
    /// The prompt.
    Prompt,
    /// Verdicts side by side.
    Verdict,
    /// The reasoning of one answer.
    Reasoning,
    /// A measure over time.
    Plot,
}

impl Pane {
    /// Every pane that can have the keys, in the order of Tab.
    pub const ALL: [Self; 6] = [
        Self::Scenarios,
        Self::Map,
        Self::Prompt,
        Self::Verdict,
        Self::Reasoning,
        Self::Plot,
    ];

    /// Whose keys it takes.
    #[must_use]
    pub fn scope(self) -> Scope {
        match self {
            Self::Scenarios => Scope::Scenarios,
            Self::Map => Scope::Map,
            Self::Prompt | Self::Reasoning | Self::Verdict => Scope::Text,
            Self::Timeline | Self::Plot => Scope::Global,
        }
    }
}

/// What lies over the main screen and takes the keys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Overlay {
    /// All keys; scrolled by so many lines.
    Help {
        /// Lines scrolled.
        scroll: usize,
    },
    /// What is in the opened scenario and what reading it had to assume; scrolled by so many lines.
    About {
        /// Lines scrolled.
        scroll: usize,
    },
    /// Every measure at the current step, and the thresholds; scrolled by so many lines.
    Values {
        /// Lines scrolled.
        scroll: usize,
    },
    /// Actions by name.
    Palette(Picker),
    /// Models; the chosen one is asked at once if `ask`.
    Models {
        /// What is typed and selected.
        picker: Picker,
        /// Whether the chosen one is asked at once.
        ask: bool,
    },
    /// Pictures that can be saved.
    Pictures(Picker),
    /// Measures, to plot one or to sort the list by it.
    Measures {
        /// What is typed and selected.
        picker: Picker,
        /// Whether the list is sorted by the chosen one.
        sort: bool,
    },
}

impl Overlay {
    /// How far it is scrolled, if it is text.
    pub fn scroll_mut(&mut self) -> Option<&mut usize> {
        match self {
            Self::Help { scroll } | Self::About { scroll } | Self::Values { scroll } => {
                Some(scroll)
            }
            Self::Palette(_) | Self::Models { .. } | Self::Pictures(_) | Self::Measures { .. } => {
                None
            }
        }
    }
}

/// Everything that the workbench knows.
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
    /// Why the selected scenario is not open.
    pub open_error: Option<String>,
    /// The current time step.
    pub clock: Clock,
    /// The pane that has the keys.
    pub focus: Pane,
    /// Whether the pane that has the keys is shown alone.
    pub zoomed: bool,
    /// How the map is seen.
    pub camera: Camera,
    /// The picked obstacle.
    pub picked: Option<i64>,
    /// What is plotted over time.
    pub plot: Plot,
    /// Every measure of the picked obstacle, while somebody looks at them.
    pub values: Values,
    /// From where on values are dangerous, and what measures take for granted.
    pub thresholds: Arc<Thresholds>,
    /// What is asked.
    pub task: Task,
    /// From where the scene is described.
    pub frame: Frame,
    /// How it is asked.
    pub techniques: Techniques,
    /// Whether the techniques were chosen, or are the template's.
    pub techniques_chosen: bool,
    /// The prompt.
    pub prompt: PromptPane,
    /// Templates.
    pub library: Library,
    /// The answers.
    pub answers: Answers,
    /// The model that is asked.
    pub model: String,
    /// Models that can be chosen.
    pub offers: Vec<Offer>,
    /// What lies over the main screen, the top last.
    pub overlays: Vec<Overlay>,
    /// Messages.
    pub toasts: Vec<Toast>,
    /// Colours.
    pub theme: Theme,
    /// Settings.
    pub config: Config,
    /// Whether the mouse is used.
    pub mouse: bool,
    /// Where things were drawn last: what the mouse and the page keys need.
    pub drawn: Drawn,
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
        offers: Vec<Offer>,
    ) -> Self {
        Self {
            size: (0, 0),
            paths,
            list: List::default(),
            opened: None,
            opening: None,
            taken: None,
            open_error: None,
            clock: Clock::new(0..1, 0.1),
            focus: Pane::Scenarios,
            zoomed: false,
            camera: Camera::default(),
            picked: None,
            plot: Plot::default(),
            values: Values::default(),
            thresholds: Arc::new(Thresholds::shipped().clone()),
            task: Task::Collision,
            frame: Frame::Ego,
            techniques: Techniques::ALL,
            techniques_chosen: false,
            prompt: PromptPane::default(),
            library,
            answers: Answers::default(),
            model: config
                .model
                .clone()
                .unwrap_or_else(|| judge::MODEL.to_string()),
            offers,
            overlays: Vec::new(),
            toasts: Vec::new(),
            theme,
            mouse: config.mouse,
            config,
            drawn: Drawn::default(),
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

    /// Why there is nothing to judge or plot, and what to do.
    #[must_use]
    pub fn without_ego(&self) -> String {
        let why = self.opened.as_ref().map(|o| o.no_ego.as_deref());
        match why {
            None => "no scenario is open".into(),
            Some(None) => "there is no ego: n picks an obstacle, E makes it the ego".into(),
            Some(Some(why)) => format!("{why}: n picks an obstacle, E makes it the ego"),
        }
    }

    /// The window that is asked about: for the collision task the end of the recording, for the safety
    /// task the past of the current step.
    #[must_use]
    pub fn window(&self) -> Option<Window> {
        let scene = self.scene()?;
        let last = match self.task {
            Task::Collision => scene.last_step(),
            Task::Safety | Task::Attacker | Task::Trajectory => self.clock.step(),
        };
        Some(Window::ending_at(scene, last, self.decided().history))
    }

    /// Steps in the window of the safety task, where the current step has fewer before it than are wanted.
    #[must_use]
    pub fn short_window(&self) -> Option<i64> {
        let window = self.window().filter(|_| self.task == Task::Safety)?;
        let steps = window.last() - window.first() + 1;
        let wanted = i64::try_from(self.decided().history).unwrap_or(i64::MAX);
        Some(steps).filter(|&steps| steps < wanted)
    }

    /// How it is asked now, in short: as [`Column::how`] has it.
    #[must_use]
    pub fn way(&self) -> String {
        format!("{} · {}", self.frame.name(), self.techniques)
    }

    /// How the scene is described: as the configuration says, else as the saved template does.
    #[must_use]
    pub fn decided(&self) -> Decided {
        let found = self.library.find(self.task.name(), self.frame.name());
        let defaults = found.map(|(_, template)| template.front.defaults);
        let said = Settings {
            history: self.config.history,
            radius: self.config.radius,
            techniques: self.techniques_chosen.then_some(self.techniques),
            obstacle: self.picked.filter(|_| self.frame == Frame::Trajectory),
            ..Settings::default()
        };
        said.with(&defaults.unwrap_or_default())
    }

    /// The frame after the present one that has a template for the task.
    #[must_use]
    pub fn next_frame(&self) -> Frame {
        let all = Frame::ALL;
        let now = all.iter().position(|f| *f == self.frame).unwrap_or(0);
        let mut after = (1..=all.len()).map(|n| all[(now + n) % all.len()]);
        let fits = |f: &Frame| self.library.find(self.task.name(), f.name()).is_some();
        after.find(fits).unwrap_or(self.frame)
    }

    /// Works out again what depends on the scene, the window, the template and the switches:
    /// the prompt and the built-in judge's verdict.
    pub fn refresh(&mut self) {
        let (Some(opened), Some(window)) = (&self.opened, self.window()) else {
            self.prompt.question = None;
            self.answers.reference = None;
            return;
        };
        let Some(scene) = opened.scene.clone() else {
            return;
        };
        self.answers.reference = match self.task {
            Task::Collision => opened.collision.clone(),
            Task::Safety => Some(judge_under(&scene, Task::Safety, &window, &self.thresholds)),
            Task::Attacker | Task::Trajectory => None,
        };
        let decided = self.decided();
        self.techniques = decided.techniques;
        let case = Case {
            name: opened.name.clone(),
            scene,
            task: self.task,
            frame: self.frame,
            techniques: self.techniques,
            window,
            options: decided.options,
            thresholds: self.thresholds.clone(),
        };
        self.prompt.load(&self.library, self.task, self.frame);
        let draft = self.prompt.draft();
        let prepared = prepare(
            case.clone(),
            &self.library,
            draft.as_ref().map(|(f, s)| (f.as_str(), s.as_str())),
        );
        match prepared {
            Ok(question) => {
                self.prompt.error = None;
                self.prompt.accept(draft);
                self.prompt.question = Some(question);
            }
            Err(error) => {
                self.prompt.error = Some(error.to_string());
                // The last template that could be filled stays in use.
                let good = self.prompt.good();
                let again = prepare(
                    case,
                    &self.library,
                    good.as_ref().map(|(f, s)| (f.as_str(), s.as_str())),
                );
                self.prompt.question = again.ok();
            }
        }
    }

    /// Whether time has to pass: something plays, or a message fades.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.clock.playing
            || self.toasts.iter().any(|t| t.left.is_finite())
            || self.answers.is_running()
    }

    /// The question with this number, if it is still shown.
    pub fn column_mut(&mut self, ask: AskId) -> Option<&mut Column> {
        self.answers.columns.iter_mut().find(|c| c.ask == Some(ask))
    }
}
