//! Prompts: the messages that a model would be sent about a scenario, by task and frame.

use serde_json::{Value, json};

use super::catalogue::{EGO, Gives, Job, JobOption, JobValue, SCENARIO};
use super::jobs;
use super::lines::RpcError;
use super::places::Places;
use super::session::Work;
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;

/// The command that fills templates.
static PROMPT: Job = Job {
    name: "prompt",
    about: "",
    command: &["prompt"],
    options: &[
        SCENARIO,
        JobOption {
            name: "at",
            option: "--at",
            value: JobValue::Whole(None, None),
            about: "Time step at which the window ends.",
            required: false,
        },
        EGO,
    ],
    gives: Gives::Json,
    needs_ego: true,
    paid: false,
};

/// Frames that a verdict is asked in.
const FRAMES: [Frame; 3] = [Frame::Ego, Frame::Cartesian, Frame::Metrics];

/// Tasks whose prompts are served.
const TASKS: [Task; 2] = [Task::Collision, Task::Safety];

/// The list of prompts.
pub fn list() -> Value {
    let arguments = PROMPT.options.iter().map(|option| {
        json!({"name": option.name, "description": option.about, "required": option.required})
    });
    let arguments = &arguments.collect::<Value>();
    let all = TASKS.into_iter().flat_map(|task| {
        FRAMES.into_iter().map(move |frame| {
            let (task, frame) = (task.name(), frame.name());
            json!({
                "name": format!("{task}-{frame}"),
                "description": format!("The {task} question about a scenario, described in the {frame} frame."),
                "arguments": arguments,
            })
        })
    });
    all.collect()
}

/// What has to be run for a prompt.
///
/// # Errors
/// There is no such prompt or scenario, or an argument is unknown or no number.
pub fn work(places: &Places, parameters: &Value) -> Result<Work, RpcError> {
    let name = parameters["name"].as_str().unwrap_or_default();
    let known = TASKS
        .into_iter()
        .flat_map(|task| FRAMES.map(|frame| (task, frame)));
    let found = known
        .into_iter()
        .find(|(task, frame)| format!("{}-{}", task.name(), frame.name()) == name);
    let Some((task, frame)) = found else {
        let name: String = name.chars().take(80).collect();
        return Err(RpcError::parameters(format!(
            "no prompt `{name}`; prompts/list has all"
        )));
    };
    let mut arguments = parameters["arguments"].clone();
    // Arguments of prompts are strings.
    for option in PROMPT.options {
        let number = arguments[option.name].as_str().map(str::parse::<i64>);
        if let Some(Ok(number)) = number {
            arguments[option.name] = number.into();
        }
    }
    let mut words = jobs::words(PROMPT.options, &arguments).map_err(RpcError::parameters)?;
    let entry = places
        .entry(arguments[SCENARIO.name].as_str().unwrap_or_default())
        .map_err(RpcError::parameters)?;
    words.push(format!("--task={}", task.name()));
    words.push(format!("--frame={}", frame.name()));
    Ok(Work {
        entry,
        ego: arguments[EGO.name].as_i64(),
        needs_ego: PROMPT.needs_ego,
        job: &PROMPT,
        words,
        becomes: messages,
        reserved: None,
    })
}

/// The messages of the filled template.
fn messages(_: &Job, given: &[u8], places: &Places) -> Value {
    let text = places.told(&String::from_utf8_lossy(given));
    let document: Value = serde_json::from_str(&text).unwrap_or_default();
    let messages = document["messages"].as_array().cloned().unwrap_or_default();
    // Prompts of the protocol have no system messages; the first user message carries it.
    let messages: Vec<Value> = messages
        .iter()
        .map(|message| {
            let role = match message["role"].as_str() {
                Some("assistant") => "assistant",
                _ => "user",
            };
            json!({"role": role, "content": {"type": "text", "text": message["content"]}})
        })
        .collect();
    json!({"description": "The question about a scenario.", "messages": messages})
}
