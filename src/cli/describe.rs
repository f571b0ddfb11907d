//! `nearmiss describe`: describes a window of a scene, and the source of each number in the text.

use super::open::{ScenarioArguments, configuration, frame, user_thresholds};
use super::span::Span;
use super::{Failure, Outcome, output};
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

/// Runs `describe`.
pub fn run(arguments: &Describe) -> Outcome {
    let (folders, config) = configuration()?;
    let (entry, scene) = arguments.which.open()?;
    let decided = arguments
        .span
        .settings(None, &config)?
        .with(&Defaults::default());
    let thresholds = user_thresholds(&folders)?;
    let window = arguments
        .span
        .window(&scene, &thresholds, None, decided.history)?;
    let context = Context::under(&scene, &thresholds);
    let described = description::describe_in(&context, arguments.frame, &window, &decided.options);
    let described = described.map_err(|error| Failure::input(advised(&error)))?;
    if arguments.json {
        output::json(&serde_json::json!({
            "scenario": entry.name,
            "frame": arguments.frame.name(),
            "window": [window.first(), window.last()],
            "tokens": estimate_tokens(&described.text),
            "form": decided.options.form.name(),
            "first_step": window.first(),
            "last_step": window.last(),
            "text": described.text,
            "spans": described.spans,
        }))?;
    } else {
        output::text(&described.text)?;
    }
    output::say(&format!(
        "about {} tokens (estimated)",
        estimate_tokens(&described.text)
    ));
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
