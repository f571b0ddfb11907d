//! `nearmiss prompt`: the messages as they would be sent.

use std::sync::Arc;

use super::open::{Which, configuration, frame, task, techniques, user_thresholds};
use super::span::Span;
use super::{Failure, Outcome, output};
use crate::config::{Config, Folders};
use crate::evaluation::{Case, Question, prepare};
use crate::prompts::{Library, Techniques};
use crate::text::Frame;
use crate::verdict::Task;

/// What is asked, about what, and how: shared by `prompt` and `ask`.
#[derive(Debug, clap::Args)]
pub struct Asked {
    #[command(flatten)]
    which: Which,
    /// What is asked: collision or safety.
    #[arg(long, default_value = "collision", value_parser = task)]
    pub task: Task,
    /// From where the scene is described: ego or cartesian.
    #[arg(long, default_value = "ego", value_parser = frame)]
    frame: Frame,
    /// Prompting techniques: any of cp, cot, icl; base for none, all for all.
    #[arg(long, default_value = "all", value_parser = techniques)]
    techniques: Techniques,
    #[command(flatten)]
    pub span: Span,
}

impl Asked {
    /// The question, ready to be sent.
    pub fn question(&self, folders: &Folders, config: &Config) -> Result<Question, Failure> {
        let (entry, scene) = self.which.open()?;
        let library = Library::load(Some(&folders.prompts()));
        for problem in &library.problems {
            output::say(&format!(
                "nearmiss: {}: {}; the shipped template is used instead",
                problem.path.display(),
                problem.message
            ));
        }
        let case = Case {
            name: entry.name,
            task: self.task,
            frame: self.frame,
            techniques: self.techniques,
            window: self.span.window(&scene, Some(self.task), config)?,
            options: self.span.options(config)?,
            thresholds: Arc::new(user_thresholds(folders)?),
            scene,
        };
        prepare(case, &library, None).map_err(Failure::input)
    }
}

/// Arguments of `prompt`.
#[derive(Debug, clap::Args)]
pub struct PromptArguments {
    #[command(flatten)]
    asked: Asked,
    /// The messages as a JSON array.
    #[arg(long)]
    json: bool,
}

/// Runs `prompt`.
pub fn run(arguments: &PromptArguments) -> Outcome {
    let (folders, config) = configuration()?;
    let question = arguments.asked.question(&folders, &config)?;
    if arguments.json {
        return output::json(&question.messages());
    }
    let prompt = &question.prompt;
    let text = format!("[system]\n{}\n\n[user]\n{}\n", prompt.system, prompt.user);
    output::text(&output::visible(&text))?;
    output::say(&format!(
        "{} ({}), about {} tokens",
        question.template,
        &question.template_hash[..12],
        question.tokens()
    ));
    Ok(())
}
