//! `nearmiss describe`: describes a window of a scene, and the source of each number in the text.

use super::open::{ScenarioArguments, configuration, frame, user_thresholds};
use super::span::Span;
use schemars::JsonSchema;
use serde::Serialize;

use super::{Failure, Outcome, json, output};
use crate::description::{self, DescriptionError, Frame};
use crate::metrics::Context;
use crate::prompts::{Defaults, estimate_tokens};

/// Arguments of `describe`.
#[derive(Debug, clap::Args)]
pub struct Describe {
    #[command(flatten)]
    which: ScenarioArguments,
    /// Frame of the description: ego, cartesian, metrics, or trajectory (of one --obstacle).
    #[arg(long, default_value = "ego", value_parser = frame)]
    frame: Frame,
    #[command(flatten)]
    span: Span,
    /// Print one JSON object: the text, and the position (in bytes) and source of each number in it.
    #[arg(long, alias = "trace")]
    json: bool,
}

/// A description for programs.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    scenario: String,
    frame: &'static str,
    window: [i64; 2],
    tokens: usize,
    /// Wording: prose or compact.
    form: &'static str,
    /// Use window.
    #[schemars(extend("deprecated" = true))]
    first_step: i64,
    /// Use window.
    #[schemars(extend("deprecated" = true))]
    last_step: i64,
    /// The description.
    text: String,
    /// Every number of the text: start and end in bytes, step, quantity, value and whose it is.
    #[schemars(with = "Vec<serde_json::Value>")]
    spans: Vec<description::Span>,
}

impl json::Output for Document {
    const NAME: &'static str = "describe";
    const TITLE: &'static str = "`describe --json`: a description and the source of its numbers";
}

/// Runs `describe`.
pub fn run(arguments: &Describe) -> Outcome {
    let (folders, config) = configuration()?;
    let (entry, scene) = arguments.which.open()?;
    let decided = arguments
        .span
        .settings(None, arguments.frame, &config)?
        .with(&Defaults::default());
    let thresholds = user_thresholds(&folders)?;
    let window = arguments
        .span
        .window(&scene, &thresholds, None, decided.history)?;
    let context = Context::under(&scene, &thresholds);
    let described = description::describe_in(&context, arguments.frame, &window, &decided.options);
    let described = described.map_err(|error| Failure::input(advised(&error)))?;
    let tokens = estimate_tokens(&described.text);
    if arguments.json {
        output::document(&Document {
            scenario: entry.name,
            frame: arguments.frame.name(),
            window: [window.first(), window.last()],
            tokens,
            form: decided.options.form.name(),
            first_step: window.first(),
            last_step: window.last(),
            text: described.text,
            spans: described.spans,
        })?;
    } else {
        output::text(&described.text)?;
    }
    output::say(&format!("about {tokens} tokens (estimated)"));
    Ok(())
}

/// An error with what to do on the command line.
pub fn advised(error: &DescriptionError) -> String {
    let advice = match error {
        DescriptionError::NoObstacle => " with --obstacle ID; `nearmiss inspect` lists them",
        DescriptionError::UnknownObstacle { .. } => "",
        DescriptionError::NotThere { .. } => "; choose other steps with --at and --history",
    };
    format!("{error}{advice}")
}
