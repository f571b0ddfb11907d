//! Settings of experiments on the command line: `--set KEY=VALUE`, and options that are the same fields.

use std::path::Path;

use crate::{Failure, output};
use nearmiss_ask::prompts::Library;
use nearmiss_base::system::unknown;
use nearmiss_record::fields::{Fields, Layers, Row};
use nearmiss_settings::Config;
use nearmiss_study::evaluation::batch::{Experiment, TuneSettings};
use nearmiss_workflow::{complete_experiment, configured_experiment};

/// Settings of an experiment.
#[derive(Debug, clap::Args)]
pub struct Knobs {
    /// Set a key of experiment files, such as `history=20`, `effort=low,high` or `split.test=0.5`; repeat for several.
    /// Overrides the experiment file. See the list below or `nearmiss help experiments`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
}

/// Reads `KEY=VALUE`.
pub fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) => Ok((key.trim().into(), value.trim().into())),
        None => Err("expected KEY=VALUE, such as radius=50".into()),
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
            let given = flags
                .iter()
                .find(|(_, of, values)| of == key && !values.is_empty());
            if let Some((flag, ..)) = given {
                layers.mistake(key, &format!("{flag} sets it, too; remove one"));
            }
        }
    }
}

/// A setting of a question, by the keys of an experiment's description and sampling: `nearmiss ask --set`.
pub fn of_request(text: &str) -> Result<(String, String), String> {
    let others = ["dialect", "key_env"];
    one(text, |row| {
        ["description", "sampling"].contains(&row.section) || others.contains(&row.key)
    })
}

/// The same of a question that is not sent.
pub fn of_question(text: &str) -> Result<(String, String), String> {
    one(text, |row| row.section == "description")
}

/// The same of a description, which has no template.
pub fn of_description(text: &str) -> Result<(String, String), String> {
    one(text, |row| {
        row.section == "description" && row.key != "pack"
    })
}

/// A setting with one value.
fn one(text: &str, is_taken: impl Fn(&Row) -> bool) -> Result<(String, String), String> {
    let (key, value) = setting(text)?;
    let rows = Experiment::rows().iter().filter(|row| is_taken(row));
    let known: Vec<&Row> = rows.collect();
    let Some(row) = known.iter().find(|row| row.key == key) else {
        return Err(unknown("key", &key, known.iter().map(|row| row.key)));
    };
    let is_several = |value: &toml::Value| value.as_array().is_some_and(|all| all.len() > 1);
    if row.is("axis") && is_several(&row.parse(&value)) {
        return Err(format!("{key}: expected one value"));
    }
    Ok((key, value))
}

/// The settings of a question: those of the configuration, and over them what is set.
pub fn of_one_question(config: &Config, set: &[(String, String)]) -> Result<Experiment, Failure> {
    let mut layers = Layers::<Experiment>::default();
    layers.fields("config.toml: ", &configured_experiment(config));
    add(&mut layers, set);
    let is_set = |key: &str| set.iter().any(|(set, _)| set == key);
    if !is_set("tools") && (is_set("tool_rounds") || is_set("tool_calls")) {
        layers.word("--set tools", "tools", "on");
    }
    let settings = layers.fields_so_far();
    // Secrets of an address are left out where one answer is stored.
    let mistakes = settings.mistakes().into_iter();
    for (key, words) in mistakes.filter(|(key, _)| *key != "base_url") {
        layers.mistake(key, &words);
    }
    let checked = layers.checked();
    checked.map_err(|mistakes| Failure::input(output::visible(&mistakes)))?;
    Ok(settings)
}

fn add<F: Fields>(layers: &mut Layers<F>, set: &[(String, String)]) {
    for (key, value) in set {
        layers.word(&format!("--set {key}"), key, value);
    }
}

/// The settings of layers, and over them what is set.
pub fn read<F: Fields>(mut layers: Layers<F>, set: &[(String, String)]) -> Result<F, Failure> {
    add(&mut layers, set);
    let settings = layers.read();
    settings.map_err(|mistakes| Failure::input(output::visible(&mistakes)))
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

/// The keys of a file, each with what it is for, for help and manual.
pub fn keys<F: Fields>() -> String {
    let lines = F::rows().iter().map(|row| {
        let about = textwrap::fill(row.doc(), 66).replace('\n', &format!("\n{:22}", ""));
        format!("    {:<17} {about}\n", row.key)
    });
    lines.collect()
}

/// The names of the keys.
pub fn names() -> impl Iterator<Item = &'static str> {
    Experiment::rows().iter().map(|row| row.key)
}

/// The same for `tune`, those of its search first.
pub fn names_for_tune() -> impl Iterator<Item = String> {
    let search = { TuneSettings::rows().iter() }.map(|row| format!("tune.{}", row.key));
    search.chain(names().map(Into::into))
}

/// The keys below the options of a command.
pub fn help() -> String {
    format!(
        "Settings for --set, the keys of experiment files:\n\n{}",
        keys::<Experiment>()
    )
}
