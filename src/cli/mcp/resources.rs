//! Resources and prompts: scenarios with their addresses and texts, and the messages a model would be sent about one.

use std::ops::Range;

use nearmiss_ask::llm;
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;
use rmcp::ErrorData;
use rmcp::model::{
    GetPromptRequestParams, GetPromptResult, ListResourcesResult, PaginatedRequestParams, Prompt,
    PromptArgument, PromptMessage, ReadResourceResult, Resource, ResourceContents, Role,
};
use serde::Deserialize;
use serde_json::Value;

use super::catalogue::{EGO, Gives, Job, JobOption, JobValue, SCENARIO};
use super::jobs;
use super::places::Places;

/// Resources of one page.
const PAGE: usize = 200;

/// How the addresses of scenarios begin.
const SCHEME: &str = "nearmiss://scenario/";

/// Largest scenario that is given as a resource, bytes.
const LONGEST: u64 = 8 << 20;

/// What kind of text they are.
const XML: &str = "application/xml";

fn address(places: &Places, entry: &Entry) -> String {
    let name = places.name(entry);
    let escaped: String = { name.bytes() }
        .map(|byte| match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' | b'/' => {
                char::from(byte).to_string()
            }
            other => format!("%{other:02X}"),
        })
        .collect();
    format!("{SCHEME}{escaped}")
}

/// Whether a scenario has a text to read: recordings and protobuf files have none.
fn is_text(entry: &Entry) -> bool {
    match &entry.place {
        EntryLocation::Bundled(_) => true,
        EntryLocation::File(path) => {
            let end = path.extension();
            end.is_some_and(|end| end.eq_ignore_ascii_case("xml")) && !entry.is_recording()
        }
    }
}

/// The range of the page of a list of so many that a request wants, and the cursor of the next one.
///
/// # Errors
/// In words: its cursor is none that an answer gave.
pub fn page(
    cursor: Option<&str>,
    length: usize,
    of: usize,
) -> Result<(Range<usize>, Option<String>), &'static str> {
    let is_given = |place: &usize| (1..of).contains(place) && place.is_multiple_of(length);
    let from = match cursor {
        None => 0,
        Some(cursor) => { cursor.parse().ok().filter(is_given) }
            .ok_or("`cursor` is none that this server gave; list without it")?,
    };
    let until = (from + length).min(of);
    Ok((from..until, (until < of).then(|| until.to_string())))
}

/// Checks that a list of one page is not asked for another one.
///
/// # Errors
/// The request has a cursor.
pub fn no_cursor(request: Option<PaginatedRequestParams>) -> Result<(), ErrorData> {
    match request.and_then(|request| request.cursor) {
        None => Ok(()),
        Some(_) => Err(ErrorData::invalid_params(
            "`cursor`: this list has only one page",
            None,
        )),
    }
}

/// A page of the list.
///
/// # Errors
/// The cursor is none that was given.
pub fn list_resources(
    places: &Places,
    cursor: Option<&str>,
) -> Result<ListResourcesResult, ErrorData> {
    let entries = places.entries();
    let (range, next) =
        page(cursor, PAGE, entries.len()).map_err(|why| ErrorData::invalid_params(why, None))?;
    let resources = entries[range].iter().map(|entry| {
        let resource = Resource::new(address(places, entry), places.name(entry));
        if is_text(entry) {
            resource.with_mime_type(XML)
        } else {
            resource
        }
    });
    let mut list = ListResourcesResult::with_all_items(resources.collect());
    list.next_cursor = next;
    Ok(list)
}

/// The text of one.
///
/// # Errors
/// There is none at this address, or it is too long, or it cannot be read.
pub fn read_resource(places: &Places, uri: &str) -> Result<ReadResourceResult, ErrorData> {
    let unknown = |why: String| ErrorData::resource_not_found(why, None);
    let entries = places.entries();
    let entry = { entries.iter() }
        .find(|entry| address(places, entry) == uri)
        .ok_or_else(|| unknown("no such resource; resources/list has all".into()))?;
    let long = |bytes: u64| {
        unknown(format!(
            "the scenario has {bytes} bytes, more than {LONGEST}; ask tools about it"
        ))
    };
    let file = entry.file().and_then(|file| std::fs::metadata(file).ok());
    if let Some(meta) = file.filter(|meta| meta.len() > LONGEST) {
        return Err(long(meta.len()));
    }
    let text = entry.source().map_err(|why| unknown(places.told(&why)))?;
    // The file may have grown meanwhile.
    if text.len() as u64 > LONGEST {
        return Err(long(text.len() as u64));
    }
    let contents = ResourceContents::text(text, uri).with_mime_type(XML);
    Ok(ReadResourceResult::new(vec![contents]))
}

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
pub fn list_prompts() -> Vec<Prompt> {
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
pub fn prompt_command(request: &GetPromptRequestParams) -> Result<(Vec<String>, Value), String> {
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
    let mut words = jobs::command_line(OPTIONS, &arguments)?;
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
pub fn filled_prompt(given: &[u8], places: &Places) -> Result<GetPromptResult, String> {
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
