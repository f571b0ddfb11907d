//! Prompts: the messages that a model would be sent about a scenario, by task and frame.

use serde_json::{Value, json};

use super::catalogue::Job;
use super::lines::RpcError;
use super::places::Places;
use super::session::Work;
use crate::description::Frame;
use crate::verdict::Task;

/// The command that fills templates.
static PROMPT: Job = Job {
    name: "prompt",
    about: "",
    command: "prompt",
    options: &[],
    paid: false,
};

/// Frames that a verdict is asked in.
const FRAMES: [Frame; 3] = [Frame::Ego, Frame::Cartesian, Frame::Metrics];

/// Tasks whose prompts are served.
const TASKS: [Task; 2] = [Task::Collision, Task::Safety];

/// The list of prompts.
pub fn list() -> Value {
    let all = TASKS.into_iter().flat_map(|task| {
        FRAMES.into_iter().map(move |frame| {
            let (task, frame) = (task.name(), frame.name());
            json!({
                "name": format!("{task}-{frame}"),
                "description": format!("The {task} question about a scenario, described in the {frame} frame."),
                "arguments": [
                    {"name": "scenario", "description": "Path or name of the scenario.", "required": true},
                    {"name": "at", "description": "Time step at which the window ends.", "required": false},
                ],
            })
        })
    });
    all.collect()
}

/// What has to be run for a prompt.
///
/// # Errors
/// There is no such prompt or scenario.
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
    let arguments = &parameters["arguments"];
    let scenario = arguments["scenario"].as_str();
    let scenario =
        scenario.ok_or_else(|| RpcError::parameters("argument `scenario` is missing"))?;
    let entry = places.entry(scenario).map_err(RpcError::parameters)?;
    let mut words = vec![
        PROMPT.command.to_string(),
        Places::argument(&entry),
        format!("--task={}", task.name()),
        format!("--frame={}", frame.name()),
    ];
    match &arguments["at"] {
        Value::Null => {}
        at => {
            let step = at.as_i64().or_else(|| at.as_str()?.parse().ok());
            let step = step.ok_or_else(|| RpcError::parameters("argument `at` is no time step"))?;
            words.push(format!("--at={step}"));
        }
    }
    Ok(Work {
        entry,
        job: &PROMPT,
        words,
        becomes: messages,
        reserved: None,
        token: None,
    })
}

/// The messages of the filled template.
fn messages(_: &Job, text: &str) -> Value {
    let document: Value = serde_json::from_str(text).unwrap_or_default();
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
