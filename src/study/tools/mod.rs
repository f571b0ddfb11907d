//! Tools that compute for language models: one table of functions with arguments, results, units and documentation.
//!
//! The table is offered to a model that is asked and may call tools, and printed by `nearmiss help tools`. A tool sees
//! nothing after the window that the question is about.

mod arguments;
mod instruments;
mod pair;
mod view;

pub use arguments::ToolError;
pub use view::WindowView;

use nearmiss_record::fields::{Fields, Row};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

/// A function that a model may call.
#[derive(Debug)]
pub struct Tool {
    /// Its name on the wire: letters and underscores.
    pub name: &'static str,
    /// What it computes, for the model and for people.
    pub about: &'static str,
    /// Its arguments.
    pub arguments: fn() -> &'static [Row],
    /// The JSON schema of its arguments.
    pub arguments_schema: fn() -> Value,
    /// The JSON schema of its result.
    pub result_schema: fn() -> Value,
    /// Computes the result, a JSON object, from arguments as a model wrote them.
    pub call: fn(&WindowView<'_>, &str) -> Result<Value, ToolError>,
}

/// A tool with arguments `A` and result `R`.
const fn tool<A: Fields, R: Serialize + JsonSchema>(
    name: &'static str,
    about: &'static str,
    call: fn(&WindowView<'_>, &str) -> Result<Value, ToolError>,
) -> Tool {
    Tool {
        name,
        about,
        arguments: A::rows,
        arguments_schema: arguments::schema::<A>,
        result_schema: nearmiss_record::schema::<R>,
        call,
    }
}

/// What a tool computes from arguments as a model wrote them.
fn answer<A: Fields, R: Serialize>(
    view: &WindowView<'_>,
    text: &str,
    compute: fn(&WindowView<'_>, &A) -> Result<R, ToolError>,
) -> Result<Value, ToolError> {
    let result = compute(view, &arguments::parse(text)?)?;
    serde_json::to_value(result).map_err(|why| ToolError::new(why.to_string()))
}

/// Every tool.
pub const TOOLS: &[Tool] = &[
    instruments::LIST_OBSTACLES,
    instruments::GET_STATE,
    pair::DISTANCE,
    pair::TIME_TO_COLLISION,
    pair::MEASURE,
    instruments::LANE_RELATION,
    instruments::POSITIONS_AHEAD,
    pair::PREDICT,
];

/// Calls a tool with arguments as a model wrote them: a JSON object as text.
///
/// # Errors
/// In words for the model: there is no such tool, or its arguments are wrong.
pub fn call(view: &WindowView<'_>, name: &str, arguments: &str) -> Result<Value, ToolError> {
    let Some(tool) = TOOLS.iter().find(|tool| tool.name == name) else {
        let names = TOOLS.iter().map(|tool| tool.name);
        let unknown = nearmiss_base::system::unknown("tool", &short(name), names);
        return Err(ToolError::new(unknown));
    };
    (tool.call)(view, arguments)
}

/// A name that a model made up, no longer than names are.
fn short(name: &str) -> String {
    name.chars().take(64).collect()
}

/// The table as Markdown, for the manual.
#[must_use]
pub fn table() -> String {
    let mut text = "\n## Tools\n".to_string();
    for tool in TOOLS {
        text.push_str(&format!("\n### {}\n\n{}\n", tool.name, tool.about));
        text.push_str(&arguments::lines(tool));
    }
    text
}

#[cfg(test)]
mod tests;
