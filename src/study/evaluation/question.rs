//! Builds the messages of a case, with its picture for models that see: the same for every face and for batches.

use std::sync::{Arc, OnceLock};

use nearmiss_ask::llm::{Image, ImageTokens, Message, Role};
use nearmiss_ask::prompts::{self, Library, Pack, Prompt, RenderError, Techniques, Template};
use nearmiss_drive::generation::{AttackStyle, Effort};
use nearmiss_render::{Picture, Storyboard, StoryboardPanel, png};
use nearmiss_scene::description::{self, Frame, Options, picture_moments};
use nearmiss_scene::judge::{Criterion, Judgement, judge_under};
use nearmiss_scene::metrics::{Context, Thresholds};
use nearmiss_scene::scenario::{Scene, Window, WindowEnd};
use nearmiss_scene::verdict::{self, Task, Verdict};

use super::claims::TimeOrigin;
use super::prompt_summary::{TemplateVersion, prompt_label, with_tools};
use super::settings::template_measures;
use super::values::Values;

/// The task, the scene and its description.
#[derive(Debug, Clone)]
pub struct Case {
    /// Name of the scenario, for people and for the store.
    pub name: String,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The task.
    pub task: Task,
    /// From where it is described.
    pub frame: Frame,
    /// How it is asked.
    pub techniques: Techniques,
    /// Which steps are described.
    pub window: Window,
    /// How precisely, and how far around the ego.
    pub options: Options,
    /// Thresholds of the risk scores, in the prompt and for the built-in judge.
    pub thresholds: Arc<Thresholds>,
    /// The horizon of the safety task: a contact within so many seconds after the window is critical.
    pub horizon: f64,
    /// What an attack has to keep to, as the trajectory task's prompt says it.
    pub attack: AttackTerms,
}

/// What an attack has to keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttackTerms {
    /// How attackers move.
    pub style: AttackStyle,
    /// Reaction time of the ideal driver who has to avoid it, seconds.
    pub delay: f64,
}

impl AttackTerms {
    /// Those of a style; the usual ones without one.
    #[must_use]
    pub fn of_style(style: Option<AttackStyle>) -> Self {
        Self {
            style: style.unwrap_or_default(),
            ..Self::default()
        }
    }
}

impl Default for AttackTerms {
    fn default() -> Self {
        Self {
            style: AttackStyle::default(),
            delay: Effort::default().delay,
        }
    }
}

impl Case {
    /// The horizon of the built-in judge, seconds.
    pub const HORIZON: f64 = Criterion::REFERENCE.horizon;

    /// What the built-in judge says about it.
    #[must_use]
    pub fn judgement(&self) -> Judgement {
        judge_under(&self.scene, self.task, &self.window, &self.thresholds)
    }
}

/// Where the window of a task's question ends: of the collision task with the recording, of the recording task it is
/// the whole recording, of the others it ends at the present step, whose past they look at.
#[must_use]
pub fn window_end(task: Task) -> WindowEnd {
    match task {
        Task::Collision => WindowEnd::Recording,
        Task::Recording => WindowEnd::Whole,
        Task::Safety | Task::Attacker | Task::Trajectory => WindowEnd::Present,
    }
}

/// A case with its description and messages.
#[derive(Debug, Clone)]
pub struct Question {
    /// The case.
    pub case: Case,
    /// The description of the scene.
    pub description: String,
    /// The picture that is shown with it, of frames that have one.
    pub picture: Option<ScenePicture>,
    /// The filled template.
    pub prompt: Prompt,
    /// The template's file name.
    pub template: String,
    /// Its version, as it says itself; `None` for a draft, which may say what it likes.
    pub template_version: Option<String>,
    /// SHA-256 of its text and of the fragments that it includes.
    pub template_hash: String,
    /// The pack of the template, which decides the keys of the answer.
    pub pack: Pack,
    /// The temperature that the template asks for.
    pub temperature: Option<f64>,
    /// The conversation after the prompt: answers, and replies to them.
    pub turns: Vec<Message>,
}

/// Why a case cannot be asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CaseError {
    /// No template is for this task and frame.
    #[error("no prompt template{} for task {task} in frame {frame}; for this task there are {known}", of_pack(*.pack))]
    NoTemplate {
        /// The task.
        task: &'static str,
        /// The frame.
        frame: &'static str,
        /// The pack that was asked for.
        pack: Pack,
        /// The frames that have one.
        known: String,
    },
    /// The scene cannot be described.
    #[error(transparent)]
    Text(#[from] description::DescriptionError),
    /// The user's file that would be asked with is broken.
    #[error("{0}")]
    Broken(Box<prompts::Problem>),
    /// The draft is no template.
    #[error("{}", error.in_file(file))]
    Draft {
        /// Which file it is a draft of.
        file: String,
        /// The error.
        error: prompts::TemplateError,
    },
    /// The template cannot be filled.
    #[error(transparent)]
    Render(#[from] prompts::RenderError),
}

/// The words for a pack other than the standard one.
fn of_pack(pack: Pack) -> String {
    match pack {
        Pack::Standard => String::new(),
        other => format!(" of the pack {}", other.name()),
    }
}

/// Describes the scene of a case and fills the template for it.
///
/// `draft` is a template's file name and text to use instead of the library's, as an editor has it.
///
/// # Errors
/// The template is missing, or it cannot be filled.
pub fn prepare(
    mut case: Case,
    library: &Library,
    draft: Option<(&str, &str)>,
) -> Result<Question, CaseError> {
    if case.task == Task::Recording {
        case.window = Window::full(&case.scene);
    }
    let read;
    let is_draft = draft.is_some();
    let (file, template) = match draft {
        Some((file, source)) => {
            read = Template::read(source).map_err(|error| CaseError::Draft {
                file: file.to_string(),
                error,
            })?;
            (file, &read)
        }
        None => {
            let (file, template) = template(library, case.task, case.frame)?;
            if let Some(problem) = library.stands_for(file, template) {
                return Err(CaseError::Broken(Box::new(problem.clone())));
            }
            (file, template)
        }
    };
    if let Some(Err(message)) = template_measures(&template.front.defaults) {
        let named = |line: &str| line.trim_start().starts_with("measures");
        return Err(CaseError::Render(RenderError {
            file: file.to_string(),
            line: template.source.lines().position(named).map(|at| at + 1),
            message,
        }));
    }
    // The paper describes what is within the radius.
    case.options.reach = (template.front.pack != Pack::Paper).then_some(case.horizon);
    let context = Context::under(&case.scene, &case.thresholds);
    let described = description::describe_in(&context, case.frame, &case.window, &case.options)?;
    let values = Values::new(&case, &described.text, &verdict::schema(case.task));
    let prompt = prompts::render(file, &template.source, library.fragments(), values)?;
    Ok(Question {
        picture: ScenePicture::from_case(&case),
        prompt,
        template: file.to_string(),
        template_version: (!is_draft && !library.is_draft(file))
            .then(|| template.front.version.clone()),
        template_hash: library.hash(&template.source),
        pack: template.front.pack,
        temperature: template.front.defaults.temperature,
        description: described.text,
        turns: Vec::new(),
        case,
    })
}

/// The template for a task and a frame, with its file name.
///
/// # Errors
/// No such template.
pub fn template(
    library: &Library,
    task: Task,
    frame: Frame,
) -> Result<(&str, &Template), CaseError> {
    let (task, frame) = (task.name(), frame.name());
    library.find(task, frame).ok_or_else(|| {
        let all = library.templates();
        let fits = all.filter(|(_, template, _)| {
            template.front.task == task && template.front.pack == library.pack()
        });
        let frames: Vec<&str> = fits.map(|(_, t, _)| t.front.frame.as_str()).collect();
        CaseError::NoTemplate {
            task,
            frame,
            pack: library.pack(),
            known: if frames.is_empty() {
                "none".into()
            } else {
                frames.join(", ")
            },
        }
    })
}

impl Question {
    /// How it is asked, with tools or without, in a few words.
    #[must_use]
    pub fn label(&self, tools: bool) -> String {
        prompt_label(
            self.case.frame.name(),
            &with_tools(&self.case.techniques.to_string(), tools),
            self.version().as_ref(),
        )
    }

    /// The version of its template.
    #[must_use]
    pub fn version(&self) -> Option<TemplateVersion> {
        let version = self.template_version.as_deref();
        TemplateVersion::new(&self.template, version, &self.template_hash)
    }

    /// What the times in answers to it count from.
    #[must_use]
    pub fn times(&self) -> TimeOrigin {
        TimeOrigin::from_messages(&self.description)
    }

    /// The messages as they are sent.
    #[must_use]
    pub fn messages(&self) -> Vec<Message> {
        let shown = self.picture.iter().map(ScenePicture::image);
        let prompt = [
            Message::new(Role::System, &self.prompt.system),
            Message {
                images: shown.collect(),
                ..Message::new(Role::User, &self.prompt.user)
            },
        ];
        prompt.into_iter().chain(self.turns.clone()).collect()
    }

    /// The same conversation after `answer`, with `words` as the reply. A blank answer is left out, since many servers
    /// reject blank messages, and the reply follows the last message.
    #[must_use]
    pub fn after(&self, answer: &str, words: &str) -> Self {
        let mut next = self.clone();
        if answer.trim().is_empty() {
            let last = match next.turns.last_mut() {
                Some(last) => &mut last.content,
                None => &mut next.prompt.user,
            };
            last.push_str("\n\n");
            last.push_str(words);
            return next;
        }
        for (role, content) in [(Role::Assistant, answer), (Role::User, words)] {
            next.turns.push(Message::new(role, content));
        }
        next
    }

    /// The built-in judge's answer; `None` for tasks it does not answer.
    #[must_use]
    pub fn reference(&self) -> Option<Verdict> {
        let case = &self.case;
        Task::VERDICTS
            .contains(&case.task)
            .then(|| case.judgement().verdict)
    }

    /// Roughly how many tokens the messages are, a picture as most providers count it.
    #[must_use]
    pub fn tokens(&self) -> usize {
        let turns = self.turns.iter().map(|turn| &turn.content);
        let all = [&self.prompt.system, &self.prompt.user]
            .into_iter()
            .chain(turns);
        let words: usize = all.map(|text| prompts::estimate_tokens(text)).sum();
        words + self.picture.as_ref().map_or(0, ScenePicture::tokens)
    }
}

/// Pixels an inch of a storyboard: as many as its size was counted in.
const DPI: f64 = 96.0;

/// A storyboard of a window of a scene.
#[derive(Debug, Clone)]
pub struct ScenePicture {
    scene: Arc<Scene>,
    panels: Vec<StoryboardPanel>,
    from: i64,
    north_up: bool,
    recorded_times: bool,
    contact: bool,
    drawn: Arc<OnceLock<Image>>,
}

impl ScenePicture {
    /// The picture of a case; `None` if its frame has none.
    #[must_use]
    pub fn from_case(case: &Case) -> Option<Self> {
        Self::new(&case.scene, case.frame, &case.window, &case.options)
    }

    /// The picture of a window; `None` if the frame has none.
    #[must_use]
    pub fn new(
        scene: &Arc<Scene>,
        frame: Frame,
        window: &Window,
        options: &Options,
    ) -> Option<Self> {
        if !frame.has_picture() {
            return None;
        }
        let moments = picture_moments(scene, frame, window, options).into_iter();
        let panels = moments.map(|moment| StoryboardPanel {
            step: moment.step,
            obstacles: moment.obstacles,
        });
        Some(Self {
            scene: scene.clone(),
            panels: panels.collect(),
            from: window.first(),
            north_up: frame.is_on_the_map(),
            recorded_times: frame.is_of_one_obstacle(),
            contact: options.contact,
            drawn: Arc::default(),
        })
    }

    /// The picture to be drawn in any format.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let board = Storyboard {
            scene: &self.scene,
            panels: &self.panels,
            from: self.from,
            north_up: self.north_up,
            recorded_times: self.recorded_times,
            contact: self.contact,
        };
        board.picture()
    }

    /// The picture as a model is sent it.
    #[must_use]
    pub fn image(&self) -> Image {
        // It has fewer pixels than any PNG may have.
        let draw = || Image::png(png(&self.picture(), DPI).unwrap_or_default(), self.size());
        self.drawn.get_or_init(draw).clone()
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        Storyboard::size(self.panels.len())
    }

    /// Tokens that it is taken for where the provider is not known.
    #[must_use]
    pub fn tokens(&self) -> usize {
        let (width, height) = self.size();
        ImageTokens::default().count(width, height) as usize
    }
}
