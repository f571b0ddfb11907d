//! `nearmiss prompt describe`: describes a window of a scene, and the source of each number in the text.

use std::path::{Path, PathBuf};

use super::knobs;
use super::open::{EgoChoice, configuration, entry, scene, user_thresholds};
use super::span::Span;
use schemars::JsonSchema;
use serde::Serialize;

use super::many_files::Failed;
use super::{Failure, Outcome, json, output};
use nearmiss_ask::prompts::{Defaults, estimate_tokens};
use nearmiss_base::system;
use nearmiss_render::svg;
use nearmiss_scene::description::{self, DescriptionError, Frame};
use nearmiss_scene::metrics::Context;
use nearmiss_study::evaluation::ScenePicture;

/// Arguments of `describe`.
#[derive(Debug, clap::Args)]
pub struct Describe {
    /// Scenario files or names of bundled scenarios; a unique prefix of a name is enough.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    ego: EgoChoice,
    /// Frame of the description: ego, cartesian, metrics, or trajectory (of one --obstacle); picture, ego+picture,
    /// cartesian+picture, metrics+picture or trajectory+picture for a picture from above, alone or with words.
    #[arg(long, default_value = "ego")]
    frame: Frame,
    #[command(flatten)]
    span: Span,
    /// Change how the scene is described: stride, radius, precision, form (compact or prose), contact, road, axes, measures.
    /// See `nearmiss help prompting`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::of_description)]
    set: Vec<(String, String)>,
    #[command(flatten)]
    format: output::FormatOption,
    /// File for the picture of a frame that has one: .png, as models are sent it, or .svg; with another name for the
    /// text.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

/// The picture of a description, for programs.
#[derive(Serialize, JsonSchema)]
struct PictureDocument {
    /// SHA-256 of the PNG.
    sha256: String,
    /// Pixels.
    width: u32,
    /// Pixels.
    height: u32,
    /// Tokens that it is taken for where the provider is not known.
    tokens: usize,
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
    /// The description.
    text: String,
    /// The picture of a frame that has one.
    picture: Option<PictureDocument>,
    /// Every number of the text: start and end in bytes, step, quantity, value and whose it is.
    #[schemars(with = "Vec<serde_json::Value>")]
    spans: Vec<description::Span>,
}

impl json::Output for Document {
    const NAME: &'static str = "prompt-describe";
    const TITLE: &'static str =
        "`prompt describe --format json`: a description and the source of its numbers";
}

/// Runs `describe`.
pub fn run(arguments: &Describe) -> Outcome {
    let [one] = arguments.files.as_slice() else {
        if arguments.output.is_some() {
            return Err(Failure::input(
                "-o takes the description of one scenario; leave it out, or describe them one by one",
            ));
        }
        return several(arguments);
    };
    describe(arguments, one, false)
}

/// Describes one scenario after the other; those that cannot be described are said and counted.
fn several(arguments: &Describe) -> Outcome {
    let mut failed = Failed::of(arguments.files.len());
    for file in &arguments.files {
        if let Err(failure) = describe(arguments, file, true) {
            failed.add(failure);
        }
    }
    failed.end("described")
}

/// Describes a scenario, below its name where it is one of several.
fn describe(arguments: &Describe, file: &Path, named: bool) -> Outcome {
    let (folders, config) = configuration()?;
    let entry = entry(file)?;
    let scene = scene(&entry, &arguments.ego)?;
    let set = knobs::of_one_question(&config, &arguments.set)?;
    let decided = arguments
        .span
        .settings(&set, None, arguments.frame)?
        .with(&Defaults::default());
    let thresholds = user_thresholds(&folders)?;
    let window = arguments
        .span
        .window(&scene, &thresholds, None, decided.history)?;
    let context = Context::under(&scene, &thresholds);
    let described = description::describe_in(&context, arguments.frame, &window, &decided.options)
        .map_err(|error| Failure::input(advised(&error)))?;
    let picture = ScenePicture::new(&scene, arguments.frame, &window, &decided.options);
    let tokens =
        estimate_tokens(&described.text) + picture.as_ref().map_or(0, ScenePicture::tokens);
    let drawn = arguments.write(picture.as_ref(), &described.text)?;
    if arguments.format.is_json() {
        output::document(&Document {
            scenario: entry.name,
            frame: arguments.frame.name(),
            window: [window.first(), window.last()],
            tokens,
            form: decided.options.form.name(),
            text: described.text,
            picture: picture.map(|picture| {
                let (image, tokens) = (picture.image(), picture.tokens());
                PictureDocument {
                    sha256: image.sha256,
                    width: image.width,
                    height: image.height,
                    tokens,
                }
            }),
            spans: described.spans,
        })?;
    } else if drawn != Some(Written::Text) {
        let heading = if named {
            format!("# {}\n", output::visible(&entry.display()))
        } else {
            String::new()
        };
        output::text(&(heading + &described.text))?;
    }
    output::say(&format!("about {tokens} tokens (estimated)"));
    Ok(())
}

/// What was written to the file of `-o`.
#[derive(PartialEq)]
enum Written {
    Picture,
    Text,
}

impl Describe {
    /// Writes the file that was asked for, if there is one.
    fn write(
        &self,
        picture: Option<&ScenePicture>,
        text: &str,
    ) -> Result<Option<Written>, Failure> {
        let Some(file) = self
            .output
            .as_deref()
            .filter(|path| *path != Path::new("-"))
        else {
            return Ok(None);
        };
        let ending = file
            .extension()
            .and_then(|ending| ending.to_str())
            .map(str::to_ascii_lowercase);
        let (bytes, written) = match (ending.as_deref(), picture) {
            (Some("png"), Some(picture)) => (picture.image().bytes.to_vec(), Written::Picture),
            (Some("svg"), Some(picture)) => {
                (svg(&picture.picture()).into_bytes(), Written::Picture)
            }
            (Some("png" | "svg"), None) => {
                return Err(Failure::input(format!(
                    "{}: the {} frame has no picture; add --frame picture or --frame ego+picture",
                    file.display(),
                    self.frame.name()
                )));
            }
            _ => (text.as_bytes().to_vec(), Written::Text),
        };
        system::save(file, &bytes, self.overwrite).map_err(|error| output::refused(&error))?;
        Ok(Some(written))
    }
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
