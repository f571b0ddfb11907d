//! `nearmiss models`: lists models with their keys, prices and retirement dates, and updates the prices.

use std::path::Path;

use jiff::civil::Date;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::open::configuration;
use super::{Failure, Outcome, output};
use nearmiss_ask::llm::{
    Client, Discovered, Environment, KeyState, ModelListing, PriceTable, Pricing, Probed, Registry,
    Retirement, probe,
};
use nearmiss_base::system::{error_text, shown_path};
use nearmiss_scene::judge;
use nearmiss_settings::Folders;

/// Arguments of `models`.
#[derive(Debug, clap::Args)]
pub struct Models {
    #[command(flatten)]
    format: output::FormatOption,
    /// Skip the search for local servers.
    #[arg(long)]
    offline: bool,
    /// Include local models that cannot chat, such as embeddings.
    #[arg(long)]
    all: bool,
    /// Override the built-in prices with a price table: JSON of models.dev or litellm, from a file or URL.
    #[arg(long, value_name = "FILE|URL", conflicts_with_all = ["format", "offline", "all"])]
    update: Option<String>,
}

/// Runs `models`.
pub fn run(arguments: &Models) -> Outcome {
    let (folders, config) = configuration()?;
    if let Some(source) = &arguments.update {
        return update(source, &folders.config_file());
    }
    let registry = Registry::lenient(&config.provider, &folders.config_file());
    for (_, broken) in registry.broken() {
        output::say(&format!("nearmiss: {broken}"));
    }
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    for problem in &environment.problems {
        output::say(&format!("nearmiss: {problem}"));
    }
    let Probed {
        models: found,
        notes,
    } = if arguments.offline {
        Probed::default()
    } else {
        runtime()?.block_on(probe(&registry, &environment))
    };
    for note in notes {
        output::say(&format!("nearmiss: {note}"));
    }
    let today = jiff::Zoned::now().date();
    let listed = registry.models(&environment, today);
    let shown = new(&listed, &found)
        .filter(|d| arguments.all || !d.is_no_chat())
        .filter_map(|d| registry.known(&d.id, &environment, today));
    let shown: Vec<ModelListing> = shown.collect();
    let listed = [listed, shown].concat();
    if arguments.format.is_json() {
        let lines = listed.iter().map(|one| ModelLine::new(one, &found, today));
        let mut lines = std::iter::once(BUILT_IN).chain(lines);
        lines.try_for_each(|line| output::document(&line))
    } else {
        output::text(&output::visible(&table(&listed, &found, today)))
    }
}

/// Keeps the prices of a table beside the configuration file.
fn update(source: &str, config_file: &Path) -> Outcome {
    let today = jiff::Zoned::now().date();
    let table = if source.contains("://") {
        let runtime = runtime()?;
        runtime.block_on(PriceTable::at_address(&Client::new(), source, today))
    } else {
        PriceTable::in_file(Path::new(source), today)
    };
    let file = PriceTable::file(config_file);
    let table = table.map_err(|why| Failure::input(format!("{why}; no price is changed")))?;
    Folders::write(&file, &table.to_toml()).map_err(|error| {
        Failure::input(format!("{}: {}", shown_path(&file), error_text(&error)))
    })?;
    output::text(&output::visible(&format!(
        "{}\nkept in {}: they overlay the shipped prices, and those in config.toml overlay them; delete the file to go back\n",
        table.summary(),
        shown_path(&file)
    )))
}

fn runtime() -> Result<tokio::runtime::Runtime, Failure> {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    builder.enable_all().build().map_err(Failure::input)
}

fn is_found(listed: &ModelListing, found: &[Discovered]) -> bool {
    found.iter().any(|discovered| discovered.id == listed.id)
}

/// Those that were found and are not listed anyway.
fn new<'a>(
    listed: &[ModelListing],
    found: &'a [Discovered],
) -> impl Iterator<Item = &'a Discovered> {
    let known: Vec<String> = listed.iter().map(|listed| listed.id.clone()).collect();
    found.iter().filter(move |d| !known.contains(&d.id))
}

/// A model for programs.
#[derive(Serialize, JsonSchema)]
pub struct ModelLine<'m> {
    model: &'m str,
    /// Whether it is the built-in judge.
    built_in: bool,
    /// Wire protocol.
    dialect: Option<&'static str>,
    /// State and source of the API key.
    #[schemars(with = "Value")]
    key: &'m KeyState,
    /// Prices: input, output, cached and more, with source and day.
    #[schemars(with = "Value")]
    usd_per_million_tokens: Option<&'m Pricing>,
    /// Retirement: day, routed, replacement, unconfirmed.
    #[schemars(with = "Value")]
    end: Option<&'m Retirement>,
    /// Warning about its retirement.
    warning: Option<String>,
    /// Whether it runs on this machine.
    running: bool,
}

/// The built-in judge.
const BUILT_IN: ModelLine<'_> = ModelLine {
    model: judge::MODEL,
    built_in: true,
    dialect: None,
    key: &KeyState::NotNeeded,
    usd_per_million_tokens: None,
    end: None,
    warning: None,
    running: false,
};

impl<'m> ModelLine<'m> {
    fn new(model: &'m ModelListing, found: &[Discovered], today: Date) -> Self {
        let end = model.retirement.as_ref();
        Self {
            model: &model.id,
            built_in: false,
            dialect: Some(model.dialect.name()),
            key: &model.key,
            usd_per_million_tokens: model.pricing.as_ref(),
            end,
            warning: end.and_then(|end| end.warning(today)),
            running: is_found(model, found),
        }
    }
}

/// Where prices are from, each place once: those that `[1]` and so on point at.
#[derive(Default)]
struct Sources(Vec<String>);

impl Sources {
    fn cell(&mut self, pricing: &Pricing) -> String {
        let day = pricing.as_of.map(|day| day.to_string());
        let Some(source) = &pricing.source else {
            return day.unwrap_or_else(|| "config.toml".into());
        };
        let found = self.0.iter().position(|known| known == source);
        let place = found.unwrap_or_else(|| {
            self.0.push(source.clone());
            self.0.len() - 1
        });
        format!("{} [{}]", day.unwrap_or_default(), place + 1)
    }
}

fn table(listed: &[ModelListing], found: &[Discovered], today: Date) -> String {
    let head = ["model", "dialect", "key", "$/M in, out", "as of", ""];
    let mut rows = vec![head.map(str::to_string)];
    let mut sources = Sources::default();
    let row = |cells: [&str; 6]| cells.map(str::to_string);
    rows.push(row([judge::MODEL, "built in", "–", "–", "–", ""]));
    for model in listed {
        let key = match &model.key {
            KeyState::NotNeeded => "–".to_string(),
            KeyState::Present(source) => source.clone(),
            KeyState::Command(command) => format!("from {command}"),
            KeyState::Missing(names) => format!("missing: {names}"),
        };
        let price = model.pricing.as_ref().map(|pricing| {
            let price = &pricing.price;
            if pricing.is_free() {
                "free".to_string()
            } else {
                format!("{}, {}", price.input, price.output)
            }
        });
        let end = model.retirement.as_ref();
        let mut remarks: Vec<String> = Vec::new();
        remarks.extend(is_found(model, found).then(|| "running here".to_string()));
        remarks.extend(end.and_then(|end| end.warning(today)));
        rows.push([
            model.id.clone(),
            model.dialect.name().to_string(),
            key,
            price.unwrap_or_else(|| "unknown".into()),
            model
                .pricing
                .as_ref()
                .filter(|pricing| !pricing.is_free())
                .map_or("–".into(), |pricing| sources.cell(pricing)),
            remarks.join("; "),
        ]);
    }
    let mut text: String = output::table_lines(&rows, &[]).collect();
    if !sources.0.is_empty() {
        text += "\nprices in US dollars per million tokens, from these pages and tables on that day; prices in config.toml override them\n";
    }
    for (i, source) in sources.0.iter().enumerate() {
        text += &format!("[{}] {source}\n", i + 1);
    }
    text
}
