//! The keys of an experiment file: what each is for and which values it takes; errors, schema and manual agree on it.

use serde_json::{Value, json};

use nearmiss_ask::llm::Effort;
use nearmiss_ask::prompts::Pack;
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::Protocol;

/// A key of the file.
pub struct ExperimentKey {
    /// Its name.
    pub name: &'static str,
    /// What it is for, and what holds without it.
    pub about: &'static str,
    /// Which values it takes.
    pub(super) values: Values,
}

/// The values of a key.
#[derive(Clone, Copy)]
pub(super) enum Values {
    /// Any text.
    Text,
    /// Texts.
    Texts,
    /// One of these words.
    Word(fn() -> Vec<&'static str>),
    /// Words out of these.
    Words(fn() -> Vec<&'static str>),
    /// One of these words, or a list of them.
    OneOrMoreWords(fn() -> Vec<&'static str>),
    /// A whole number between these, or a list of them.
    OneOrMoreWhole(i64, i64),
    /// A number between these, or a list of them.
    OneOrMoreNumbers(f64, f64),
    /// A table of texts, or of lists of texts.
    TableOfTexts,
    /// A table with the share of a split and its seed.
    Split,
    /// Tables over axes.
    Tables,
    /// Two texts.
    Pair,
    /// Seconds, or the word `end`.
    Leads,
    /// True or false.
    Boolean,
    /// True or false, or a list of both.
    OneOrMoreBooleans,
    /// A whole number, between these.
    Whole(i64, i64),
    /// A number, between these.
    Number(f64, f64),
}

const fn key(name: &'static str, values: Values, about: &'static str) -> ExperimentKey {
    ExperimentKey {
        name,
        about,
        values,
    }
}

fn tasks() -> Vec<&'static str> {
    Task::VERDICTS.map(Task::name).to_vec()
}

fn frames() -> Vec<&'static str> {
    Frame::ALL.map(Frame::name).to_vec()
}

fn efforts() -> Vec<&'static str> {
    Effort::ALL.map(Effort::name).to_vec()
}

fn forms() -> Vec<&'static str> {
    Form::ALL.map(Form::name).to_vec()
}

fn protocols() -> Vec<&'static str> {
    Protocol::ALL.map(Protocol::name).to_vec()
}

fn ego_axes() -> Vec<&'static str> {
    EgoAxes::ALL.map(EgoAxes::name).to_vec()
}

fn packs() -> Vec<&'static str> {
    Pack::ALL.map(Pack::name).to_vec()
}

/// The smallest number above 0 that anything is measured in.
pub(super) const ABOVE_ZERO: f64 = 1e-6;

/// Every key, in the order in which a file is written.
pub const KEYS: [ExperimentKey; 37] = [
    key(
        "title",
        Values::Text,
        "What the experiment asks, in a line.",
    ),
    key(
        "scenarios",
        Values::Texts,
        "Scenario files and folders, relative to the folder of this file, and names of bundled scenarios.",
    ),
    key(
        "select",
        Values::Text,
        "Only scenarios that this filter of the workbench's list lets through, such as `tag:cut_in risk<3`.",
    ),
    key(
        "split",
        Values::Split,
        "A split into dev and test: `{ test = 0.5, seed = 7 }`; the figures of the test split stay locked until all its questions are answered.",
    ),
    key(
        "truth",
        Values::Texts,
        "Ground truth: `auto` for the exact geometry, `layout` for the folders collision_scenarios and normal_scenarios, \
         `score` or `score:paper` for the risk score of TTC and MDC, or CSV files with labels; by default layout where these folders exist, else auto.",
    ),
    key("models", Values::Texts, "The models, as provider/model."),
    key(
        "tasks",
        Values::Words(tasks),
        "The tasks; by default safety.",
    ),
    key(
        "frames",
        Values::Words(frames),
        "The frames of the description; by default that of the first task.",
    ),
    key(
        "techniques",
        Values::Texts,
        "Prompting techniques: base, cp, cot, icl, all, or combinations such as cp+cot; by default all.",
    ),
    key(
        "samples",
        Values::Whole(1, 1000),
        "Answers to each question; by default 1.",
    ),
    key(
        "leads",
        Values::Leads,
        "Ends of the dangerous windows of the safety task: seconds before the contact, or `end`.",
    ),
    key(
        "within",
        Values::Number(ABOVE_ZERO, 10.0),
        "A window is dangerous if the ego touches another body within so many seconds after it.",
    ),
    key(
        "protocol",
        Values::Word(protocols),
        "`paper` for the windows and the counting of \"From Words to Collisions\", without leads and within; by default \
         `matched`: windows at leads, and safe ones like them.",
    ),
    key(
        "transforms",
        Values::Texts,
        "Changes of the scene under which everything is asked once more: rotate:DEGREES, mirror, move:X,Y, renumber:SEED.",
    ),
    key(
        "history",
        Values::Whole(1, 1000),
        "Steps in a window; by default those of the template.",
    ),
    key(
        "radius",
        Values::Number(ABOVE_ZERO, 1e6),
        "Obstacles within this distance of the ego are described, metres, and farther away those that can reach it soon; by default that of the template.",
    ),
    key(
        "temperature",
        Values::OneOrMoreNumbers(0.0, 2.0),
        "Sampling temperature, or several; by default that of the template, else the server's.",
    ),
    key(
        "max_tokens",
        Values::Whole(1, u32::MAX as i64),
        "Most tokens of an answer; by default the server's.",
    ),
    key(
        "effort",
        Values::OneOrMoreWords(efforts),
        "Reasoning effort, or several; by default the server's.",
    ),
    key(
        "form",
        Values::OneOrMoreWords(forms),
        "Wording of the description, or several; by default that of the template, else compact.",
    ),
    key(
        "stride",
        Values::OneOrMoreWhole(1, 1000),
        "Every so many steps are described, or several numbers; by default those of the template, else 1.",
    ),
    key(
        "road",
        Values::Boolean,
        "Whether the Cartesian frame describes the road near the ego; by default as the template says, else not.",
    ),
    key(
        "axes",
        Values::Word(ego_axes),
        "What the ego frame measures along: the ego's `heading` or its `lane`; by default as the template says, else \
         heading.",
    ),
    key(
        "measures",
        Values::Texts,
        "The measures of the metrics frame, such as `[\"ttc\", \"thw\"]`; by default those of the template.",
    ),
    key(
        "pack",
        Values::Word(packs),
        "The templates: `paper` asks as \"From Words to Collisions\" does; by default `standard`.",
    ),
    key(
        "seed",
        Values::OneOrMoreWhole(0, i64::MAX),
        "Seed of the sampling, or several, for servers that take one; by default none.",
    ),
    key(
        "log_probabilities",
        Values::Boolean,
        "Whether to ask for the log probabilities of answers, where a model gives them.",
    ),
    key(
        "tools",
        Values::OneOrMoreBooleans,
        "Whether models may call tools that compute, or `[false, true]` to ask with and without; by default not.",
    ),
    key(
        "tool_rounds",
        Values::Whole(1, 100),
        "Most requests of one answer that may end in tool calls; by default 8.",
    ),
    key(
        "tool_calls",
        Values::Whole(1, 1000),
        "Most tool calls of one answer; by default 32.",
    ),
    key(
        "base_url",
        Values::Text,
        "Address of one server for all models, instead of the providers' own.",
    ),
    key(
        "budget",
        Values::Number(ABOVE_ZERO, 1e9),
        "Most that a run may cost, US dollars; by default `budget` in config.toml.",
    ),
    key(
        "baseline",
        Values::Text,
        "The model or prompt configuration that all others are compared with, as tables name it.",
    ),
    key(
        "compare",
        Values::Pair,
        "The comparison that matters: two names. It is not corrected for the others.",
    ),
    key(
        "tables",
        Values::Tables,
        "Tables over axes that reports of the batch have, as `report --rows` makes them: \
         `[{ rows = \"techniques\", columns = \"model\", measure = \"f1\", against = \"base\" }]`.",
    ),
    key(
        "templates",
        Values::Texts,
        "The templates that the experiment was written with, as NAME@HASH: others are refused.",
    ),
    key(
        "hashes",
        Values::TableOfTexts,
        "The contents of the scenarios, by name, as the start of their SHA-256: others are refused.",
    ),
];

/// The JSON schema of the file, for editors.
#[must_use]
pub fn schema() -> Value {
    let properties = KEYS.iter().map(|key| {
        let mut property = key.values.schema();
        property["description"] = key.about.into();
        (key.name.to_string(), property)
    });
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "nearmiss experiment",
        "description": "`nearmiss evaluate FILE.toml` runs it.",
        "type": "object",
        "properties": properties.collect::<serde_json::Map<_, _>>(),
        "required": ["scenarios", "models"],
        "additionalProperties": false,
    })
}
