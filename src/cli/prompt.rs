//! `nearmiss prompt show` and `describe`: the messages as they would be sent, a window in words and where each number is from.

use std::path::{Path, PathBuf};

use nearmiss_ask::llm::Message;
use nearmiss_ask::prompts::{Library, Problem, Techniques, estimate_tokens};
use nearmiss_base::system;
use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_formats::Entry;
use nearmiss_render::svg;
use nearmiss_scene::description::{self, Frame};
use nearmiss_scene::metrics::Context;
use nearmiss_scene::story::Sentence;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::{Config, Folders};
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::{AttackTerms, Question, ScenePicture, validate};
use nearmiss_workflow::{QuestionRequest, ToldStory, described, question};
use schemars::JsonSchema;
use serde::Serialize;

use super::many_files::Failed;
use super::open::{
    EgoChoice, ScenarioArguments, check_reading, configuration, entry, scene, techniques,
    user_thresholds,
};
use super::span::Span;
use super::{Failure, Outcome, knobs, output};

/// What is asked, about what, and how: shared by `prompt` and `ask`.
#[derive(Debug, clap::Args)]
pub struct QuestionArguments {
    #[command(flatten)]
    which: ScenarioArguments,
    /// Task: collision, safety, recording, attacker or trajectory.
    #[arg(long, default_value = "collision")]
    pub task: Task,
    /// Frame of the description [default: ego; metrics for attacker; trajectory for trajectory]
    ///
    /// ego, cartesian, metrics or trajectory describe the scene in words. picture shows it from above. ego+picture,
    /// cartesian+picture, metrics+picture and trajectory+picture have both.
    #[arg(long)]
    frame: Option<Frame>,
    /// Prompting techniques: cp, cot and icl, joined by commas; base for none, all for all [default: from the template,
    /// else all].
    #[arg(long, value_parser = techniques)]
    techniques: Option<Techniques>,
    #[command(flatten)]
    pub span: Span,
}

impl QuestionArguments {
    /// The question, ready to be sent.
    pub fn question(
        &self,
        set: &Experiment,
        folders: &Folders,
        config: &Config,
    ) -> Result<Question, Failure> {
        let (entry, scene) = self.which.open()?;
        let library = validate(Library::load(Some(&folders.prompts()))).with_pack(set.pack);
        // A template that is wanted may be among those that cannot be read.
        let problems = library.problems.clone();
        question(QuestionRequest {
            name: entry.name,
            scene,
            task: self.task,
            frame: self.frame,
            techniques: self.techniques,
            span: self.span.named(),
            set,
            library: &library,
            thresholds: user_thresholds(folders)?,
            attack: AttackTerms::of_style(config.attack_style),
        })
        .map_err(|why| {
            if why.starts_with("no prompt template") {
                let say = |problem: &Problem| output::say(&format!("nearmiss: {problem}"));
                problems.iter().for_each(say);
            }
            Failure::input(why)
        })
    }
}

/// Arguments of `prompt`.
#[derive(Debug, clap::Args)]
pub struct PromptArguments {
    #[command(flatten)]
    asked: QuestionArguments,
    /// Change a setting of the template: stride, radius, precision, form, contact, road, axes, measures, or pack=paper
    /// for the prompts of "From Words to Collisions". See `nearmiss help prompting`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::of_question)]
    set: Vec<(String, String)>,
    #[command(flatten)]
    format: output::FormatOption,
}

/// The messages for programs.
#[derive(Serialize, JsonSchema)]
pub struct PromptDocument {
    scenario: String,
    task: &'static str,
    frame: &'static str,
    techniques: String,
    window: [i64; 2],
    template: String,
    template_version: Option<String>,
    template_hash: String,
    tokens: usize,
    #[schemars(with = "Vec<serde_json::Value>")]
    messages: Vec<Message>,
}

/// Runs `prompt`.
pub fn show(arguments: &PromptArguments) -> Outcome {
    let (folders, config) = configuration()?;
    let set = knobs::of_one_question(&config, &arguments.set)?;
    let question = arguments.asked.question(&set, &folders, &config)?;
    if arguments.format.is_json() {
        let case = &question.case;
        output::document(&PromptDocument {
            scenario: case.name.clone(),
            task: case.task.name(),
            frame: case.frame.name(),
            techniques: case.techniques.to_string(),
            window: [case.window.first(), case.window.last()],
            template: question.template.clone(),
            template_version: question.template_version.clone(),
            template_hash: question.template_hash.clone(),
            tokens: question.tokens(),
            messages: question.messages(),
        })?;
        return Ok(());
    }
    let prompt = &question.prompt;
    let text = format!("[system]\n{}\n\n[user]\n{}\n", prompt.system, prompt.user);
    output::text(&output::visible(&text))?;
    if let Some(picture) = &question.picture {
        let (width, height) = picture.size();
        output::say(&format!(
            "with a picture of {width} × {height} pixels, about {} tokens (estimated; models differ); `nearmiss describe --frame {} -o FILE.png` writes it",
            picture.tokens(),
            question.case.frame.name(),
        ));
    }
    output::say(&format!(
        "{} ({}), about {} tokens (estimated)",
        question.template,
        &question.template_hash[..12],
        question.tokens()
    ));
    Ok(())
}

/// Arguments of `describe`.
#[derive(Debug, clap::Args)]
pub struct Describe {
    /// Scenario files or names of bundled scenarios; a unique prefix of a name is enough.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    ego: EgoChoice,
    /// Frame of the description
    ///
    /// ego, cartesian, metrics, or trajectory (needs --obstacle) describe the scene in words. picture shows it from
    /// above. ego+picture, cartesian+picture, metrics+picture and trajectory+picture have both.
    #[arg(long, default_value = "ego")]
    frame: Frame,
    /// Tell what happened: the moment that matters in at most four sentences with times and numbers, and which drivers
    /// would have avoided it.
    #[arg(long, conflicts_with_all = ["frame", "set", "at", "history", "obstacle"])]
    story: bool,
    #[command(flatten)]
    span: Span,
    /// Change a setting of the description: stride, radius, precision, form (compact or prose), contact, road, axes,
    /// measures. See `nearmiss help prompting`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::of_description)]
    set: Vec<(String, String)>,
    #[command(flatten)]
    format: output::FormatOption,
    /// Write the picture of a frame that has one (.png, as sent to models, or .svg); any other ending writes the text.
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
pub struct DescriptionDocument {
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

/// What happened, for programs.
#[derive(Serialize, JsonSchema)]
pub struct StoryDocument {
    scenario: String,
    file: String,
    /// Id of the ego.
    ego: i64,
    /// Where the motion of the ego is from.
    ego_source: String,
    obstacle: i64,
    /// All sentences, the last one about drivers.
    text: String,
    /// At most four: the text of each, and its facts with numbers (seconds, metres, m/s, m/s², degrees).
    #[schemars(with = "Vec<serde_json::Value>")]
    sentences: Vec<Sentence>,
    /// Which drivers would have avoided the contact, conflict or near miss; null without one, and where it begins with the
    /// recording.
    preventability: Option<PreventabilityRecord>,
}

/// Runs `describe`.
pub fn describe(arguments: &Describe) -> Outcome {
    check_reading(&arguments.files, arguments.output.as_deref())?;
    let [one] = arguments.files.as_slice() else {
        if arguments.output.is_some() {
            return Err(Failure::input(
                "-o takes the description of one scenario; leave it out, or describe them one by one",
            ));
        }
        return several(arguments);
    };
    describe_one(arguments, one, false)
}

/// Describes one scenario after the other; those that cannot be described are said and counted.
fn several(arguments: &Describe) -> Outcome {
    let mut failed = Failed::of(arguments.files.len());
    for file in &arguments.files {
        if let Err(failure) = describe_one(arguments, file, true) {
            failed.add(failure);
        }
    }
    failed.end("described")
}

/// Describes a scenario, below its name where it is one of several.
fn describe_one(arguments: &Describe, file: &Path, named: bool) -> Outcome {
    let (folders, config) = configuration()?;
    let entry = entry(file)?;
    let scene = scene(&entry, &arguments.ego)?;
    if arguments.story {
        let thresholds = user_thresholds(&folders)?;
        return arguments.tell(&entry, &Context::under(&scene, &thresholds), named);
    }
    let set = knobs::of_one_question(&config, &arguments.set)?;
    let thresholds = user_thresholds(&folders)?;
    let span = arguments.span.named();
    let told =
        described(&scene, &thresholds, arguments.frame, span, &set).map_err(Failure::input)?;
    let (window, described) = (told.window, told.described);
    let picture = ScenePicture::new(&scene, arguments.frame, &window, &told.options);
    let tokens =
        estimate_tokens(&described.text) + picture.as_ref().map_or(0, ScenePicture::tokens);
    let drawn = arguments.write(picture.as_ref(), &described.text)?;
    if arguments.format.is_json() {
        output::document(&DescriptionDocument {
            scenario: entry.name,
            frame: arguments.frame.name(),
            window: [window.first(), window.last()],
            tokens,
            form: told.options.form.name(),
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
    /// Tells what happened.
    fn tell(&self, entry: &Entry, context: &Context<'_>, named: bool) -> Outcome {
        let told = ToldStory::new(entry, context).map_err(Failure::input)?;
        let told = told.ok_or_else(|| {
            Failure::input(format!(
                "{}: nothing to tell: no other road user is there with the ego",
                entry.display()
            ))
        })?;
        let text = if self.format.is_json() {
            let text = told.sentences().join(" ");
            let story = told.story;
            output::document_line(&StoryDocument {
                scenario: entry.name.clone(),
                file: entry.display(),
                ego: story.ego,
                ego_source: context.scene().ego.source.short(),
                obstacle: story.obstacle,
                text,
                sentences: story.sentences,
                preventability: told.drivers,
            })?
        } else {
            let name = if named {
                format!("# {}\n", entry.display())
            } else {
                String::new()
            };
            let lines = told.sentences().join("\n");
            output::visible(&format!("{name}{lines}\n"))
        };
        match output::file_of(self.output.as_deref()) {
            None => output::text(&text),
            Some(file) => output::Target::begin(Some(file), self.overwrite)?.save(text.as_bytes()),
        }
    }

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
