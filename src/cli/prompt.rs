//! `nearmiss prompt`: prints the messages as they would be sent.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::describe::advised;
use super::knobs;
use super::open::{ScenarioArguments, configuration, techniques, user_thresholds};
use super::span::Span;
use super::{Failure, Outcome, json, output};
use nearmiss_ask::llm::Message;
use nearmiss_ask::prompts::{Library, Problem, Techniques};
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::{Config, Folders};
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::{
    AttackTerms, Case, CaseError, Question, default_frame, prepare, template, validate,
};

/// What is asked, about what, and how: shared by `prompt` and `ask`.
#[derive(Debug, clap::Args)]
pub struct QuestionArguments {
    #[command(flatten)]
    which: ScenarioArguments,
    /// Task: collision, safety, recording, attacker or trajectory.
    #[arg(long, default_value = "collision")]
    pub task: Task,
    /// Frame of the description: ego, cartesian, metrics or trajectory; picture for a picture from above in place of
    /// words, ego+picture, cartesian+picture, metrics+picture or trajectory+picture for both [default: ego; metrics for
    /// attacker; trajectory for trajectory].
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
        let frame = self
            .frame
            .unwrap_or_else(|| default_frame(&library, self.task));
        let say = |problem: &Problem| output::say(&format!("nearmiss: {problem}"));
        let (_, chosen) = template(&library, self.task, frame).map_err(|error| {
            // The one that is wanted may be among those that cannot be read.
            library.problems.iter().for_each(say);
            Failure::input(error)
        })?;
        let settings = self.span.settings(set, self.techniques, frame)?;
        let decided = settings.with(&chosen.front.defaults);
        let thresholds = user_thresholds(folders)?;
        let window = (self.span).window(&scene, &thresholds, Some(self.task), decided.history)?;
        let case = Case {
            name: entry.name,
            task: self.task,
            frame,
            techniques: decided.techniques,
            window,
            options: decided.options,
            thresholds: Arc::new(thresholds),
            scene,
            horizon: Case::HORIZON,
            attack: AttackTerms::of_style(config.attack_style),
        };
        prepare(case, &library, None).map_err(|error| match &error {
            CaseError::Text(text) => Failure::input(advised(text)),
            _ => Failure::input(error),
        })
    }
}

/// Arguments of `prompt`.
#[derive(Debug, clap::Args)]
pub struct PromptArguments {
    #[command(flatten)]
    asked: QuestionArguments,
    /// Change a setting of the template: stride, radius, precision, form, contact, road, axes, measures; or pack=paper, to
    /// ask as "From Words to Collisions" does. See `nearmiss help prompting`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::of_question)]
    set: Vec<(String, String)>,
    #[command(flatten)]
    format: output::FormatOption,
}

/// The messages for programs.
#[derive(Serialize, JsonSchema)]
pub struct Document {
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

impl json::Output for Document {
    const NAME: &'static str = "prompt-show";
    const TITLE: &'static str = "`prompt show --format json`: the messages to a model";
}

/// Runs `prompt`.
pub fn run(arguments: &PromptArguments) -> Outcome {
    let (folders, config) = configuration()?;
    let set = knobs::of_one_question(&config, &arguments.set)?;
    let question = arguments.asked.question(&set, &folders, &config)?;
    if arguments.format.is_json() {
        let case = &question.case;
        output::document(&Document {
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
            "with a picture of {width} × {height} pixels, about {} tokens (estimated; models differ); `nearmiss prompt describe --frame {} -o FILE.png` writes it",
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
