//! Price tables of others, such as models.dev and litellm publish: read, kept as a file, and laid over the shipped prices.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use jiff::civil::Date;
use jiff::tz::TimeZone;
use nearmiss_base::system;
use reqwest::Url;
use reqwest::header::LOCATION;
use serde::Deserialize;
use serde_json::{Map, Value};

use super::body_text::{BodyError, Deadlines, Elapsed, read_to_end};
use super::client::{Client, deepest};
use super::endpoint::{Endpoint, Timeouts, plain};
use super::price::Price;
use super::provider::{PriceLine, RegistryError, date};
use super::redaction::is_loopback;
use super::registry::Registry;
use crate::llm::body_text::{MAX_VALUES, is_bounded};

/// The file's name, beside `config.toml`.
pub(super) const FILE: &str = "prices.toml";

/// More than any such table is long, in bytes.
const MAX_FILE_BYTES: usize = 32 << 20;

/// Prices of models by provider, from a table of others.
#[derive(Debug, Clone, PartialEq)]
pub struct PriceTable {
    /// The day on which the source had them so.
    as_of: Date,
    source: String,
    /// By our names of the providers: models with their prices.
    providers: BTreeMap<&'static str, BTreeMap<String, Steps>>,
    /// Models of these providers without a price that can be used.
    left_out: usize,
}

/// Prices by the longest question they hold for, the shortest first; the last one holds for all others.
type Steps = Vec<(Option<u64>, Price)>;

impl PriceTable {
    /// The table in a file, of the day on which that was written.
    ///
    /// # Errors
    /// The file cannot be read, or is no such table: why, with the file.
    pub fn in_file(path: &Path, today: Date) -> Result<Self, String> {
        let wrong = |why: String| format!("{}: {why}", system::shown_path(path));
        let text = system::read_text(path, MAX_FILE_BYTES as u64)
            .map_err(|e| wrong(system::error_text(&e)))?;
        let written = std::fs::metadata(path)
            .and_then(|found| found.modified())
            .ok()
            .and_then(|time| jiff::Timestamp::try_from(time).ok());
        let day = written.map_or(today, |time| time.to_zoned(TimeZone::system()).date());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let source = |form: &str| format!("{name} ({form})");
        Self::read(&text, source, day.min(today)).map_err(wrong)
    }

    /// The table at an address, as it is today; from this machine alone without encryption.
    ///
    /// # Errors
    /// It cannot be got, or is no such table: why, with the address.
    pub async fn at_address(client: &Client, address: &str, today: Date) -> Result<Self, String> {
        let url = Url::parse(address.trim()).map_err(|error| format!("{address}: {error}"))?;
        let place = plain(&url);
        let wrong = |why: String| format!("{place}: {why}");
        let text = download(client, url).await.map_err(wrong)?;
        Self::read(&text, |_| place.clone(), today).map_err(wrong)
    }

    fn read(text: &str, source: impl Fn(&str) -> String, as_of: Date) -> Result<Self, String> {
        let (form, providers, left_out) = read(text)?;
        let table = Self {
            as_of,
            source: source(form),
            providers,
            left_out,
        };
        if table.to_toml().len() as u64 > system::LARGEST_TEXT {
            Err("more prices than a file of 1 MiB holds".into())
        } else {
            Ok(table)
        }
    }

    /// What is in it, in words: counts by provider, day and source.
    #[must_use]
    pub fn summary(&self) -> String {
        let counts = self.providers.iter();
        let counts: Vec<String> = counts
            .map(|(name, models)| format!("{name} {}", models.len()))
            .collect();
        let left_out = match self.left_out {
            0 => String::new(),
            count => format!(
                "; {count} left out: no price a token, a price of 0, or another one for reasoning"
            ),
        };
        let (day, source) = (self.as_of, &self.source);
        format!(
            "prices of models as of {day}, {source}: {}{left_out}",
            counts.join(", ")
        )
    }

    /// Where it is kept, beside the configuration file.
    #[must_use]
    pub fn file(config_file: &Path) -> PathBuf {
        config_file.with_file_name(FILE)
    }

    /// The file that keeps it, in the form of `config.toml`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
        let mut text = format!(
            "# Written by `nearmiss models --update`. These prices overlay the shipped ones, config.toml overlays them.\n\
             # Delete this file to go back to the shipped ones. US dollars per million tokens.\n\
             as_of = {}\nsource = {}\n",
            self.as_of,
            quoted(&self.source)
        );
        for (provider, models) in &self.providers {
            let _ = writeln!(text, "\n[provider.{provider}]\nprices = [");
            for (model, steps) in models {
                for (up_to, price) in steps {
                    let part = |name: &str, value: Option<f64>| {
                        value.map_or_else(String::new, |value| format!(", {name} = {value:?}"))
                    };
                    let up_to = up_to.map_or_else(String::new, |n| format!(", up_to = {n}"));
                    let _ = writeln!(
                        text,
                        "    {{ model = {}{up_to}{}{}{}{} }},",
                        quoted(model),
                        part("input", Some(price.input)),
                        part("cached", price.cached),
                        part("cache_write", price.cache_write),
                        part("output", Some(price.output)),
                    );
                }
            }
            text.push_str("]\n");
        }
        text
    }
}

/// The file of prices.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    #[serde(deserialize_with = "date")]
    as_of: Option<Date>,
    source: String,
    #[serde(default)]
    provider: BTreeMap<String, KeptPrices>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptPrices {
    prices: Vec<PriceLine>,
}

impl Registry {
    /// Lays the file of prices beside the configuration file over the prices, where there is one. A price that is known
    /// since a later day than the file's, or holds from one on, stays before it.
    ///
    /// # Errors
    /// [`RegistryError::Prices`]: the file cannot be used; then no price is changed.
    pub fn lay_prices(&mut self, config_file: &Path) -> Result<(), RegistryError> {
        let file = PriceTable::file(config_file);
        let wrong = |why: String| RegistryError::Prices {
            message: format!("{}: {why}", system::shown_path(&file)),
        };
        let text = match system::read_text(&file, system::LARGEST_TEXT) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(wrong(system::error_text(&error))),
        };
        let kept: Kept = toml::from_str(&text).map_err(|error| {
            let line = error
                .span()
                .map_or(1, |span| system::line_at(&text, span.start));
            let words: Vec<&str> = error.message().split_whitespace().collect();
            wrong(format!("line {line}: {}", words.join(" ")))
        })?;
        for (name, entry) in kept.provider {
            let Some(own) = self.providers.get_mut(&name) else {
                continue;
            };
            let is_later = |line: &PriceLine| line.as_of > kept.as_of || line.from > kept.as_of;
            let shipped = std::mem::take(&mut own.prices).into_iter();
            let (later, earlier): (Vec<_>, Vec<_>) = shipped.partition(is_later);
            let laid = entry.prices.into_iter().map(|mut line| {
                line.as_of = line.as_of.or(kept.as_of);
                line.source = line.source.or_else(|| Some(kept.source.clone()));
                line
            });
            own.prices = later.into_iter().chain(laid).chain(earlier).collect();
        }
        Ok(())
    }
}

/// The text at an address.
async fn download(client: &Client, url: Url) -> Result<String, String> {
    if url.scheme() != "https" && !is_loopback(&url) {
        return Err("write https:// before the host".into());
    }
    let timeouts = Timeouts::default();
    let deadlines = Deadlines::starting_now(timeouts);
    let late = |elapsed: Elapsed| format!("no answer within {} s", elapsed.after.as_secs());
    let http = client.http(&Endpoint::new("prices", url.as_str()), timeouts.connect)?;
    let answer = deadlines.wait(http.get(url).send()).await;
    let response = answer.map_err(late)?.map_err(|error| deepest(&error))?;
    let status = response.status();
    if status.is_redirection() {
        let moved = response
            .headers()
            .get(LOCATION)
            .and_then(|to| to.to_str().ok())
            .unwrap_or("another address");
        return Err(format!(
            "moved to {moved}; pass that address if you trust it"
        ));
    }
    if !status.is_success() {
        return Err(format!("answered with status {}", status.as_u16()));
    }
    let body = read_to_end(response, deadlines, MAX_FILE_BYTES).await;
    body.map_err(|(_, fault)| match fault {
        BodyError::Elapsed(elapsed) => late(elapsed),
        BodyError::Cut(why) => format!("the connection was cut: {why}"),
        BodyError::NotText => "not text".into(),
        BodyError::TooLong => format!("more than {} MiB", MAX_FILE_BYTES >> 20),
    })
}

/// A provider as models.dev and litellm call it, and as it is called here.
const PROVIDERS: [(&str, &str, &[&str]); 8] = [
    ("openai", "openai", &["openai", "openai-responses"]),
    ("google", "gemini", &["gemini"]),
    ("anthropic", "anthropic", &["anthropic"]),
    ("deepseek", "deepseek", &["deepseek"]),
    ("openrouter", "openrouter", &["openrouter"]),
    ("xai", "xai", &["xai"]),
    ("mistral", "mistral", &["mistral"]),
    ("alibaba", "dashscope", &["qwen"]),
];

/// Ways of asking that are billed by token here.
const MODES: [&str; 3] = ["chat", "responses", "completion"];

/// More than any name of a model is long, in bytes.
const LONGEST_NAME: usize = 256;

type Providers = BTreeMap<&'static str, BTreeMap<String, Steps>>;

/// The form of a table, its prices, and how many models have none that can be used.
///
/// # Errors
/// Why it is no table, in words.
fn read(text: &str) -> Result<(&'static str, Providers, usize), String> {
    if !is_bounded(text.as_bytes(), MAX_VALUES) {
        return Err(format!("more than {MAX_VALUES} values"));
    }
    let value: Value = serde_json::from_str(text).map_err(|error| format!("not JSON: {error}"))?;
    let table = value.as_object();
    let any = |key: &str| table.is_some_and(|t| t.values().any(|entry| entry.get(key).is_some()));
    let mut read = Read::default();
    let form = match table {
        Some(table) if any("litellm_provider") => {
            read.litellm(table);
            "litellm"
        }
        Some(table) if any("models") => {
            read.models_dev(table);
            "models.dev"
        }
        _ => {
            return Err(
                "neither a table of models.dev (providers with `models`) nor one of litellm (models with `litellm_provider`)".into(),
            );
        }
    };
    if read.providers.is_empty() {
        Err("no price of a provider that `nearmiss models` lists is in it".into())
    } else {
        Ok((form, read.providers, read.left_out))
    }
}

#[derive(Default)]
struct Read {
    providers: Providers,
    left_out: usize,
}

impl Read {
    fn models_dev(&mut self, table: &Map<String, Value>) {
        for (theirs, _, ours) in PROVIDERS {
            let models = table.get(theirs).and_then(|entry| entry.get("models"));
            for (name, model) in models.and_then(Value::as_object).into_iter().flatten() {
                self.take(ours, name, model.get("cost").and_then(dev_steps));
            }
        }
    }

    fn litellm(&mut self, table: &Map<String, Value>) {
        for (name, model) in table {
            let provider = model.get("litellm_provider").and_then(Value::as_str);
            let known = PROVIDERS
                .iter()
                .find(|(_, theirs, _)| provider == Some(*theirs));
            let mode = model.get("mode").and_then(Value::as_str).unwrap_or("chat");
            let Some((_, theirs, ours)) = known.filter(|_| MODES.contains(&mode)) else {
                continue;
            };
            let prefix = name
                .strip_prefix(theirs)
                .and_then(|rest| rest.strip_prefix('/'));
            self.take(ours, prefix.unwrap_or(name), lite_steps(model));
        }
    }

    /// Keeps the prices of a model. A price of 0 is a trial, or not known.
    fn take(&mut self, ours: &[&'static str], name: &str, steps: Option<Steps>) {
        // A star would make the name a pattern.
        let is_name = !name.is_empty() && name.len() <= LONGEST_NAME && !name.ends_with('*');
        let steps = steps.filter(|steps| steps.iter().all(|(_, p)| p.input + p.output > 0.0));
        let Some(steps) = steps.filter(|_| is_name && !name.chars().any(char::is_control)) else {
            self.left_out += 1;
            return;
        };
        for provider in ours {
            let models = self.providers.entry(provider).or_default();
            models.insert(name.to_owned(), steps.clone());
        }
    }
}

/// The prices of models.dev: US dollars per million tokens, with steps by the length of the question.
fn dev_steps(cost: &Value) -> Option<Steps> {
    let price = |cost: &Value| {
        let part = |key: &str| match cost.get(key) {
            None | Some(Value::Null) => Some(None),
            Some(value) => usd(value.as_f64()?).map(Some),
        };
        // One price has to do for all that is answered.
        let same =
            part("reasoning")?.is_none_or(|reasoning| Some(Some(reasoning)) == part("output"));
        let price = Price {
            input: part("input")??,
            output: part("output")??,
            cached: part("cache_read")?,
            cache_write: part("cache_write")?,
        };
        same.then_some(price)
    };
    let mut longer: Vec<(u64, Price)> = Vec::new();
    if let Some(tiers) = cost.get("tiers").and_then(Value::as_array) {
        for tier in tiers {
            let kind = tier.pointer("/tier/type").and_then(Value::as_str);
            let size = tier
                .pointer("/tier/size")
                .and_then(Value::as_u64)
                .filter(|_| kind.is_none_or(|kind| kind == "context"));
            longer.push((size?, price(tier)?));
        }
    } else if let Some(tier) = cost.get("context_over_200k") {
        longer.push((200_000, price(tier)?));
    }
    Some(stepped(price(cost)?, longer))
}

/// The prices of litellm: US dollars a token, with steps as keys of their own or as a list.
fn lite_steps(model: &Value) -> Option<Steps> {
    let part = |from: &Value, key: &str| match from.get(key) {
        None | Some(Value::Null) => Some(None),
        Some(value) => usd(value.as_f64()? * 1e6).map(Some),
    };
    let price = |from: &Value, above: &str, base: Option<Price>| {
        let key = |name: &str| part(from, &format!("{name}{above}"));
        let output = key("output_cost_per_token")?.or(base.map(|base| base.output))?;
        let reasoning = key("output_cost_per_reasoning_token")?;
        let price = Price {
            input: key("input_cost_per_token")?.or(base.map(|base| base.input))?,
            output,
            cached: key("cache_read_input_token_cost")?,
            cache_write: key("cache_creation_input_token_cost")?,
        };
        reasoning
            .is_none_or(|reasoning| reasoning == output)
            .then_some(price)
    };
    if let Some(tiers) = model.get("tiered_pricing").and_then(Value::as_array) {
        let mut steps = Vec::new();
        for tier in tiers {
            let from = tier.pointer("/range/0").and_then(Value::as_f64)?;
            steps.push((from as u64, price(tier, "", None)?));
        }
        steps.sort_by_key(|(from, _)| *from);
        let (_, base) = *steps.first()?;
        return Some(stepped(base, steps.split_off(1)));
    }
    let base = price(model, "", None)?;
    let sizes = model.as_object()?.keys().filter_map(|key| {
        let size = key.split_once("_cost_per_token_above_")?.1;
        size.strip_suffix("k_tokens")?.parse::<u64>().ok()
    });
    let mut longer = Vec::new();
    for size in sizes.collect::<BTreeSet<u64>>() {
        let above = format!("_above_{size}k_tokens");
        longer.push((size.checked_mul(1000)?, price(model, &above, Some(base))?));
    }
    Some(stepped(base, longer))
}

/// Steps of a price and those of questions longer than so many tokens.
fn stepped(base: Price, mut longer: Vec<(u64, Price)>) -> Steps {
    longer.sort_by_key(|(size, _)| *size);
    let ends = longer.iter().map(|(size, _)| Some(*size)).chain([None]);
    let prices = [base]
        .into_iter()
        .chain(longer.iter().map(|(_, price)| *price));
    ends.zip(prices).collect()
}

/// A price in US dollars per million tokens, rounded to a millionth of a dollar; `None` where it can be none.
fn usd(amount: f64) -> Option<f64> {
    let sound = amount.is_finite() && (0.0..1e6).contains(&amount);
    sound.then(|| (amount * 1e6).round() / 1e6)
}

#[cfg(test)]
#[path = "price_table_tests.rs"]
mod tests;
