//! Tools that compute for language models: one table of functions with arguments, results, units and documentation.
//!
//! The table is offered to a model that is asked and may call tools, and printed by `nearmiss help tools`. A tool sees
//! nothing after the window that the question is about.

mod arguments;
mod instruments;
mod pair;
mod view;

pub use arguments::{Argument, ArgumentKind, Arguments, Field, ToolError};
pub use view::WindowView;

use serde_json::Value;

/// A function that a model may call.
#[derive(Debug)]
pub struct Tool {
    /// Its name on the wire: letters and underscores.
    pub name: &'static str,
    /// What it computes, for the model and for people.
    pub about: &'static str,
    /// Its arguments.
    pub arguments: &'static [Argument],
    /// The fields of its result.
    pub result: &'static [Field],
    /// Computes the result, a JSON object.
    pub call: fn(&WindowView<'_>, &Arguments) -> Result<Value, ToolError>,
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
    let arguments = Arguments::parse(arguments, tool.arguments)?;
    (tool.call)(view, &arguments)
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
