//! From a case to the messages that are sent: the same for the workbench, the command line and batches.

use std::sync::Arc;

use serde::Serialize;

use crate::llm::{Message, Role};
use crate::metrics::{RiskLevel, Thresholds};
use crate::prompts::{self, Library, Prompt, Techniques};
use crate::scenario::{Scene, Window};
use crate::text::{self, Frame, Options};
use crate::verdict::Task;

/// What is asked about which scene, and how it is described.
#[derive(Debug, Clone)]
pub struct Case {
    /// Name of the scenario, for people and for the store.
    pub name: String,
    /// The scene.
    pub scene: Arc<Scene>,
    /// What is asked.
    pub task: Task,
    /// From where it is described.
    pub frame: Frame,
    /// How it is asked.
    pub techniques: Techniques,
    /// Which steps are described.
    pub window: Window,
    /// How precisely, and how far around the ego.
    pub options: Options,
    /// What the risk scores are, in the prompt and for the built-in judge.
    pub thresholds: Arc<Thresholds>,
}

/// A case with its description and messages.
#[derive(Debug, Clone)]
pub struct Question {
    /// The case.
    pub case: Case,
    /// The scene in words.
    pub description: String,
    /// The filled template.
    pub prompt: Prompt,
    /// The template's file name.
    pub template: String,
    /// Its version, as it says itself.
    pub template_version: Option<String>,
    /// SHA-256 of its text.
    pub template_hash: String,
}

/// Why a case cannot be asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CaseError {
    /// No template is for this task and frame.
    #[error("no prompt template for task {task} in frame {frame}")]
    NoTemplate {
        /// The task.
        task: &'static str,
        /// The frame.
        frame: &'static str,
    },
    /// The template cannot be filled.
    #[error(transparent)]
    Render(#[from] prompts::RenderError),
}

/// What templates may use.
#[derive(Serialize)]
struct Values<'a> {
    task: &'static str,
    frame: &'static str,
    cp: bool,
    cot: bool,
    icl: bool,
    description: &'a str,
    dt: f64,
    radius: f64,
    ego: i64,
    scenario: &'a str,
    window: WindowValues,
    risk_levels: &'a [RiskLevel],
}

#[derive(Serialize)]
struct WindowValues {
    first: i64,
    last: i64,
    steps: i64,
    seconds: f64,
}

/// Describes the scene of a case and fills the template for it.
///
/// `draft` is a template's file name and text to use instead of the library's, as an editor has it.
///
/// # Errors
/// There is no template, or it cannot be filled.
pub fn prepare(
    case: Case,
    library: &Library,
    draft: Option<(&str, &str)>,
) -> Result<Question, CaseError> {
    let description = text::describe(&case.scene, case.frame, &case.window, &case.options);
    let (task, frame) = (case.task.name(), case.frame.name());
    let shipped;
    let (file, source, hash, version) = match draft {
        Some((file, source)) => {
            let version = prompts::Template::read(source)
                .ok()
                .map(|t| t.front.version);
            (file, source, prompts::hash(source), version)
        }
        None => {
            shipped = library
                .find(task, frame)
                .ok_or(CaseError::NoTemplate { task, frame })?;
            let (file, template) = shipped;
            let version = Some(template.front.version.clone());
            (
                file,
                template.source.as_str(),
                template.hash.clone(),
                version,
            )
        }
    };
    let (file, source) = (file.to_string(), source.to_string());
    let steps = case.window.last() - case.window.first() + 1;
    let dt = case.scene.scenario.dt();
    let values = Values {
        task,
        frame,
        cp: case.techniques.cp,
        cot: case.techniques.cot,
        icl: case.techniques.icl,
        description: &description,
        dt,
        radius: case.options.radius,
        ego: case.scene.ego.id,
        scenario: &case.name,
        window: WindowValues {
            first: case.window.first(),
            last: case.window.last(),
            steps,
            // Without the dust of binary fractions.
            seconds: (steps as f64 * dt * 1e6).round() / 1e6,
        },
        risk_levels: &case.thresholds.risk.levels,
    };
    let prompt = prompts::render(&file, &source, library.fragments(), values)?;
    Ok(Question {
        description,
        prompt,
        template: file,
        template_version: version,
        template_hash: hash,
        case,
    })
}

impl Question {
    /// The messages as they are sent.
    #[must_use]
    pub fn messages(&self) -> Vec<Message> {
        let message = |role, content: &String| Message {
            role,
            content: content.clone(),
        };
        vec![
            message(Role::System, &self.prompt.system),
            message(Role::User, &self.prompt.user),
        ]
    }

    /// Roughly how many tokens the messages are.
    #[must_use]
    pub fn tokens(&self) -> usize {
        prompts::estimate_tokens(&self.prompt.system) + prompts::estimate_tokens(&self.prompt.user)
    }
}
