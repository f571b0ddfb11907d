//! `nearmiss describe`: a window of a scene in words.

use super::open::{Which, configuration, frame};
use super::span::Span;
use super::{Outcome, output};
use crate::text::{self, Frame};

/// Arguments of `describe`.
#[derive(Debug, clap::Args)]
pub struct Describe {
    #[command(flatten)]
    which: Which,
    /// From where: ego or cartesian.
    #[arg(long, default_value = "ego", value_parser = frame)]
    frame: Frame,
    #[command(flatten)]
    span: Span,
}

/// Runs `describe`.
pub fn run(arguments: &Describe) -> Outcome {
    let (_, config) = configuration()?;
    let (_, scene) = arguments.which.open()?;
    let window = arguments.span.window(&scene, None, &config)?;
    let options = arguments.span.options(&config)?;
    output::text(&text::describe(&scene, arguments.frame, &window, &options))
}
