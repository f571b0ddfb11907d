//! Prompts: the messages that a model would be sent about a scenario, by task and frame.

use rmcp::model::{
    GetPromptRequestParams, GetPromptResult, Prompt, PromptArgument, PromptMessage, Role,
};
use serde::Deserialize;
use serde_json::Value;

use super::catalogue::{EGO, Gives, Job, JobOption, JobValue, SCENARIO};
use super::jobs;
use super::places::Places;
use nearmiss_ask::llm;
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;

/// The command that fills templates.
pub const PROMPT: Job = Job {
    command: "prompt show",
    gives: Gives::Json,
    needs_ego: true,
};

/// Its arguments.
pub const OPTIONS: &[JobOption] = &[
    SCENARIO,
    JobOption {
        name: "at",
        option: "--at",
        value: JobValue::Whole(None, None),
        about: "Time step at which the window ends.",
        required: false,
    },
    EGO,
];

/// Frames that a verdict is asked in.
const FRAMES: [Frame; 3] = [Frame::Ego, Frame::Cartesian, Frame::Metrics];

/// Tasks whose prompts are served.
const TASKS: [Task; 2] = [Task::Collision, Task::Safety];

/// Task and frame of each prompt.
fn all() -> impl Iterator<Item = (Task, Frame)> {
    TASKS
        .into_iter()
        .flat_map(|task| FRAMES.map(|frame| (task, frame)))
}

fn name(task: Task, frame: Frame) -> String {
    format!("{}-{}", task.name(), frame.name())
}

/// The list of prompts.
pub fn list() -> Vec<Prompt> {
    let arguments = OPTIONS.iter().map(|option| {
        PromptArgument::new(option.name)
            .with_description(option.about)
            .with_required(option.required)
    });
    let arguments: Vec<PromptArgument> = arguments.collect();
    let prompt = |(task, frame): (Task, Frame)| {
        let about = format!(
            "The {} question about a scenario, described in the {} frame.",
            task.name(),
            frame.name()
        );
        Prompt::new(name(task, frame), Some(about), Some(arguments.clone()))
    };
    all().map(prompt).collect()
}

/// The options of the command for a prompt, and its checked arguments.
///
/// # Errors
/// In words: there is no such prompt, or an argument is unknown or no number.
pub fn words(request: &GetPromptRequestParams) -> Result<(Vec<String>, Value), String> {
    let is_meant = |(task, frame): &(Task, Frame)| name(*task, *frame) == request.name;
    let (task, frame) = all().find(is_meant).ok_or_else(|| {
        let name: String = request.name.chars().take(80).collect();
        format!("no prompt `{name}`; prompts/list has all")
    })?;
    let mut arguments = request.arguments.clone().unwrap_or_default();
    // Arguments of prompts are strings.
    for (name, value) in &mut arguments {
        if let Some(Ok(number)) = value.as_str().map(str::parse::<i64>)
            && name != SCENARIO.name
        {
            *value = number.into();
        }
    }
    let arguments = Value::Object(arguments);
    let mut words = jobs::words(OPTIONS, &arguments)?;
    words.push(format!("--task={}", task.name()));
    words.push(format!("--frame={}", frame.name()));
    Ok((words, arguments))
}

/// What is read of the filled template.
#[derive(Deserialize)]
struct Filled {
    messages: Vec<llm::Message>,
}

/// The messages of the filled template.
///
/// # Errors
/// In words: the command gave something else.
pub fn filled(given: &[u8], places: &Places) -> Result<GetPromptResult, String> {
    let text = places.told(&String::from_utf8_lossy(given));
    let filled: Filled = serde_json::from_str(&text).map_err(|why| why.to_string())?;
    let messages = filled.messages.into_iter().map(|message| {
        // Prompts of the protocol have no system messages; the first user message carries it.
        let role = match message.role {
            llm::Role::Assistant => Role::Assistant,
            _ => Role::User,
        };
        PromptMessage::new_text(role, message.content)
    });
    Ok(GetPromptResult::new(messages.collect()).with_description("The question about a scenario."))
}
