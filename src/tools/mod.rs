//! Tools that compute for language models: one table of functions with arguments, results, units and documentation.
//!
//! The same table is offered to a judge that may call tools, served to other programs, and printed by
//! `nearmiss help tools`. An [`Kind::Instrument`] sees nothing after the window that the question is about; an
//! [`Kind::Oracle`] reads the recorded future or the built-in judge, and no model that is judged gets it.

mod arguments;
mod instruments;
mod lanes;
mod oracles;
mod pair;
mod prediction;
mod schema;
mod view;

pub use arguments::{Argument, ArgumentKind, Arguments, ToolError};
pub use schema::Field;
pub use view::WindowView;

use serde_json::Value;

/// Whether a tool keeps to the window of the question.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// It computes from the described window alone.
    Instrument,
    /// It knows more than the question tells: the recorded future, or the right answer.
    Oracle,
}

/// A function that a model may call.
#[derive(Debug)]
pub struct Tool {
    /// Its name on the wire: letters and underscores.
    pub name: &'static str,
    /// What it computes, for the model and for people.
    pub about: &'static str,
    /// Whether it keeps to the window.
    pub kind: Kind,
    /// Its arguments.
    pub arguments: &'static [Argument],
    /// The fields of its result.
    pub result: &'static [Field],
    /// Computes the result, a JSON object.
    pub call: fn(&WindowView<'_>, &Arguments) -> Result<Value, ToolError>,
}

/// Every tool, instruments first.
pub const TOOLS: &[Tool] = &[
    instruments::LIST_OBSTACLES,
    instruments::GET_STATE,
    pair::DISTANCE,
    pair::TIME_TO_COLLISION,
    pair::MEASURE,
    lanes::LANE_RELATION,
    lanes::POSITIONS_AHEAD,
    prediction::PREDICT,
    oracles::RECORDED_FUTURE,
    oracles::MEASURE_RECORDED,
    oracles::FIRST_CONTACT,
    oracles::JUDGE,
];

/// Tools of one kind, in the order of the table.
pub fn tools(kind: Kind) -> impl Iterator<Item = &'static Tool> {
    TOOLS.iter().filter(move |tool| tool.kind == kind)
}

/// The tool of this kind with this name.
#[must_use]
pub fn tool(kind: Kind, name: &str) -> Option<&'static Tool> {
    tools(kind).find(|tool| tool.name == name)
}

/// Calls a tool of these kinds with arguments as a model wrote them: a JSON object as text.
///
/// # Errors
/// In words for the model: there is no such tool, or its arguments are wrong.
pub fn call(
    view: &WindowView<'_>,
    kinds: &[Kind],
    name: &str,
    arguments: &str,
) -> Result<Value, ToolError> {
    let offered = || TOOLS.iter().filter(|tool| kinds.contains(&tool.kind));
    let Some(tool) = offered().find(|tool| tool.name == name) else {
        return Err(ToolError::new(crate::system::unknown(
            "tool",
            &short(name),
            offered().map(|tool| tool.name),
        )));
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
    let mut text = String::new();
    for (kind, title) in [(Kind::Instrument, "Tools"), (Kind::Oracle, "Oracles")] {
        text.push_str(&format!("\n## {title}\n"));
        for tool in tools(kind) {
            text.push_str(&format!("\n### {}\n\n{}\n", tool.name, tool.about));
            text.push_str(&schema::lines(tool));
        }
    }
    text
}

#[cfg(test)]
mod other_futures;
#[cfg(test)]
mod tests;
