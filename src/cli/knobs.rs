//! Settings of experiments on the command line: `--set KEY=VALUE`, and options that are the same fields.

use std::path::Path;

use crate::{Failure, output};
use nearmiss_ask::prompts::Library;
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_workflow::complete_experiment;

/// Settings of an experiment.
#[derive(Debug, clap::Args)]
pub struct Knobs {
    /// Set what an experiment file would, such as `history=20`, `effort=low,high` or `split.test=0.5`; over what the file
    /// says; repeat it for several. See below, or `nearmiss help experiments`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
}

fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) => Ok((key.trim().into(), value.trim().into())),
        None => Err("expected KEY=VALUE, such as history=20".into()),
    }
}

impl Knobs {
    /// Adds them over what is said already; `flags` are options of their own, each with its key and values.
    pub fn add(&self, layers: &mut Layers<Experiment>, flags: &[(&str, &str, &[String])]) {
        for (flag, key, values) in flags.iter().filter(|(.., values)| !values.is_empty()) {
            layers.word(flag, key, &values.join(","));
        }
        for (key, value) in &self.set {
            layers.word(&format!("--set {key}"), key, value);
        }
    }
}

/// The experiment that layers make, or all that is wrong with it.
pub fn complete(layers: Layers<Experiment>, library: &Library) -> Result<Experiment, Failure> {
    complete_experiment(layers, library)
        .map_err(|mistakes| Failure::input(output::visible(&mistakes)))
}

/// Adds what an experiment file says.
pub fn add_file(layers: &mut Layers<Experiment>, file: &Path) -> Result<(), Failure> {
    let text = nearmiss_settings::TextFile::read(file).map_err(Failure::input)?;
    nearmiss_workflow::add_experiment_file(layers, &text.text, file);
    Ok(())
}

/// The keys of experiments, each with what it is for, for help and manual.
pub fn keys() -> String {
    let lines = Experiment::rows().iter().map(|row| {
        let about = textwrap::fill(row.doc(), 66).replace('\n', &format!("\n{:22}", ""));
        format!("    {:<17} {about}\n", row.key)
    });
    lines.collect()
}

/// The keys below the options of a command.
pub fn help() -> String {
    format!(
        "Settings for --set, the keys of experiment files:\n\n{}",
        keys()
    )
}
