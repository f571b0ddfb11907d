//! The forms of price tables: models.dev's, providers with models, and litellm's, models with their provider.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};

use super::Steps;
use crate::llm::json::{MOST_VALUES, is_bounded};
use crate::llm::price::Price;

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
pub fn read(text: &str) -> Result<(&'static str, Providers, usize), String> {
    if !is_bounded(text.as_bytes(), MOST_VALUES) {
        return Err(format!("more than {MOST_VALUES} values"));
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
