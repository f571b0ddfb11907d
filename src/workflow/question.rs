//! A question about a window of a scene, put into words as every face asks it.

use std::sync::Arc;

use nearmiss_ask::prompts::{Defaults, Library, Techniques};
use nearmiss_scene::description::{Description, DescriptionError, Frame, Options, describe_in};
use nearmiss_scene::metrics::{Context, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::{
    AttackTerms, Case, CaseError, Question, default_frame, prepare, template,
};

use super::span::Span;

/// What is asked, about what, and how.
#[derive(Debug)]
pub struct QuestionRequest<'a> {
    /// Name of the scenario.
    pub name: String,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The task.
    pub task: Task,
    /// The frame; that of the task's template where none is named.
    pub frame: Option<Frame>,
    /// The techniques; those of the template where none are named.
    pub techniques: Option<Techniques>,
    /// The window.
    pub span: Span,
    /// Settings of the description.
    pub set: &'a Experiment,
    /// The templates, checked.
    pub library: &'a Library,
    /// Thresholds of the measures.
    pub thresholds: Thresholds,
    /// How attackers may drive.
    pub attack: AttackTerms,
}

/// The question, ready to be sent.
///
/// # Errors
/// There is no template or no such window, or the window cannot be described: in words.
pub fn question(request: QuestionRequest<'_>) -> Result<Question, String> {
    let (task, library) = (request.task, request.library);
    let frame = request
        .frame
        .unwrap_or_else(|| default_frame(library, task));
    let (_, chosen) = template(library, task, frame).map_err(|error| error.to_string())?;
    let settings = request
        .span
        .settings(request.set, request.techniques, frame)?;
    let decided = settings.with(&chosen.front.defaults);
    let (scene, thresholds) = (&request.scene, &request.thresholds);
    let window = request
        .span
        .window(scene, thresholds, Some(task), decided.history)?;
    let case = Case {
        name: request.name,
        task,
        frame,
        techniques: decided.techniques,
        window,
        options: decided.options,
        thresholds: Arc::new(request.thresholds),
        scene: request.scene,
        horizon: Case::HORIZON,
        attack: request.attack,
    };
    prepare(case, library, None).map_err(|error| match &error {
        CaseError::Text(text) => advised(text),
        _ => error.to_string(),
    })
}

/// A window in words.
#[derive(Debug, Clone)]
pub struct DescribedWindow {
    /// The window.
    pub window: Window,
    /// How it is described.
    pub options: Options,
    /// The words, and where each number is from.
    pub described: Description,
}

/// A window of a scene in words, without a template.
///
/// # Errors
/// There is no such window, or it cannot be described: in words.
pub fn described(
    scene: &Scene,
    thresholds: &Thresholds,
    frame: Frame,
    span: Span,
    set: &Experiment,
) -> Result<DescribedWindow, String> {
    let decided = span.settings(set, None, frame)?.with(&Defaults::default());
    let window = span.window(scene, thresholds, None, decided.history)?;
    let context = Context::under(scene, thresholds);
    let described = describe_in(&context, frame, &window, &decided.options);
    Ok(DescribedWindow {
        described: described.map_err(|error| advised(&error))?,
        options: decided.options,
        window,
    })
}

/// An error of a description, with what to do.
fn advised(error: &DescriptionError) -> String {
    let advice = match error {
        DescriptionError::NoObstacle => " with --obstacle ID; `nearmiss inspect` lists them",
        DescriptionError::UnknownObstacle { .. } => "",
        DescriptionError::NotThere { .. } => "; choose other steps with --at and --history",
    };
    format!("{error}{advice}")
}
