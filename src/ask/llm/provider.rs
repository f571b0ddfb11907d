//! A provider's entry in the registry or the user's configuration: how two are merged, and what happens to an invalid one.

use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroU32;
use std::path::Path;

use jiff::civil::{Date, Time};
use nearmiss_base::system;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::de::{DeTable, ValueDeserializer};

use super::api_keys::KeyCommand;
use super::dialect::{Auth, Dialect};
use super::endpoint::ResponseFormat;
use super::price::{Peak, Price, PriceEntry};
use super::quirks::StatedQuirks;
use super::registry::Registry;

/// Metadata of one provider. Unstated values are unknown.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Provider {
    pub dialect: Option<Dialect>,
    pub base_url: Option<String>,
    /// Variable that overrides the address.
    pub base_url_env: Option<String>,
    /// Variables that hold the key, the first that is set wins; keys are never written in these files.
    pub key_env: Option<StringOrList>,
    /// Whether the user names these variables, and so wants the key sent wherever the server is.
    #[serde(skip)]
    pub key_wanted: bool,
    pub key_command: Option<StringOrList>,
    pub auth: Option<Auth>,
    /// Headers, and the variables that hold their values.
    pub header_env: BTreeMap<String, String>,
    /// Whether keys may go to another machine unencrypted.
    pub allow_http: Option<bool>,
    pub response_format: Option<ResponseFormat>,
    /// Whether the beginning of questions is marked for the server's cache; it is where the server has marks.
    pub prompt_cache: Option<bool>,
    pub models: Option<Vec<ModelEntry>>,
    pub quirks: StatedQuirks,
    pub prices: Vec<PriceLine>,
    pub peak: Option<Peak>,
    pub batch_factor: Option<f64>,
    pub requests_per_minute: Option<NonZeroU32>,
    pub tokens_per_minute: Option<NonZeroU32>,
    pub concurrency: Option<NonZeroU32>,
    /// Tries in all.
    pub attempts: Option<NonZeroU32>,
    /// Seconds without a sign of life, and for an answer as a whole.
    pub idle_timeout: Option<NonZeroU32>,
    pub total_timeout: Option<NonZeroU32>,
}

/// One string or several.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "expected a string or a list of strings")]
pub(super) enum StringOrList {
    One(String),
    Many(Vec<String>),
}

impl StringOrList {
    pub fn list(&self) -> &[String] {
        match self {
            Self::One(word) => std::slice::from_ref(word),
            Self::Many(words) => words,
        }
    }

    pub fn command(&self) -> KeyCommand {
        match self {
            Self::One(line) => KeyCommand::Shell(line.clone()),
            Self::Many(words) => KeyCommand::Program(words.clone()),
        }
    }
}

/// A model of a provider, or several by the beginning of their names and `*`.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub(super) struct ModelEntry {
    pub name: String,
    /// Whether the entry says that it is offered in lists.
    pub listed: Option<bool>,
    #[serde(default)]
    pub quirks: StatedQuirks,
    pub response_format: Option<ResponseFormat>,
    /// The day from which it does not answer any more.
    #[serde(default, deserialize_with = "date")]
    pub shutdown: Option<Date>,
    /// It is gone, whenever that was.
    #[serde(default)]
    pub gone: bool,
    /// The day from which another model answers in its place.
    #[serde(default, deserialize_with = "date")]
    pub routed: Option<Date>,
    /// Which model takes its place.
    pub replacement: Option<String>,
    /// The retirement date is not the provider's own statement.
    #[serde(default)]
    pub unconfirmed: bool,
}

impl ModelEntry {
    /// Whether it is offered in lists: models with a retirement date stay there only if the entry says so.
    fn is_listed(&self) -> bool {
        let ended = self.gone || self.shutdown.is_some();
        self.listed.unwrap_or(!ended && !self.name.ends_with('*'))
    }
}

impl<'de> Deserialize<'de> for ModelEntry {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct NameOrTable;
        impl<'de> Visitor<'de> for NameOrTable {
            type Value = ModelEntry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a model's name or a table with `name`")
            }

            fn visit_str<E>(self, name: &str) -> Result<ModelEntry, E> {
                Ok(ModelEntry {
                    name: name.to_owned(),
                    ..ModelEntry::default()
                })
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ModelEntry, A::Error> {
                ModelEntry::deserialize(MapAccessDeserializer::new(map))
            }
        }
        source.deserialize_any(NameOrTable)
    }
}

/// A price as entries state it: US dollars per million tokens.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PriceLine {
    /// A model, or several that cost the same.
    model: StringOrList,
    #[serde(deserialize_with = "amount")]
    input: f64,
    #[serde(deserialize_with = "amount")]
    output: f64,
    #[serde(default, deserialize_with = "amount_if_any")]
    cached: Option<f64>,
    #[serde(default, deserialize_with = "amount_if_any")]
    cache_write: Option<f64>,
    #[serde(default, deserialize_with = "date")]
    pub from: Option<Date>,
    #[serde(default, deserialize_with = "date")]
    to: Option<Date>,
    /// The longest question it holds for, tokens.
    up_to: Option<u64>,
    /// The day on which the source had it so.
    #[serde(default, deserialize_with = "date")]
    pub as_of: Option<Date>,
    pub source: Option<String>,
}

impl PriceLine {
    pub fn entries(&self) -> impl Iterator<Item = PriceEntry> {
        self.model.list().iter().map(|model| PriceEntry {
            model: model.clone(),
            from: self.from,
            to: self.to,
            up_to: self.up_to,
            price: Price {
                input: self.input,
                output: self.output,
                cached: self.cached,
                cache_write: self.cache_write,
            },
            as_of: self.as_of,
            source: self.source.clone(),
        })
    }
}

/// Days may be written as strings or as TOML's own.
pub(super) fn date<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Date>, D::Error> {
    let value = toml::Value::deserialize(source)?;
    let text = match &value {
        toml::Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let date = text.parse().map_err(|_| {
        D::Error::custom(format!("`{text}` is not a date; write it like 2026-11-30"))
    })?;
    Ok(Some(date))
}

pub(super) fn amount<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    let amount = f64::deserialize(source)?;
    if amount.is_finite() && amount >= 0.0 {
        Ok(amount)
    } else {
        Err(D::Error::custom(format!("`{amount}` is not a price")))
    }
}

fn amount_if_any<'de, D: Deserializer<'de>>(source: D) -> Result<Option<f64>, D::Error> {
    amount(source).map(Some)
}

pub(super) fn hours<'de, D: Deserializer<'de>>(source: D) -> Result<Vec<(Time, Time)>, D::Error> {
    let span = |text: &String| {
        let (from, to) = text.split_once('-')?;
        Some((from.trim().parse().ok()?, to.trim().parse().ok()?))
    };
    let texts = Vec::<String>::deserialize(source)?;
    let spans = texts.iter().map(|text| {
        span(text).ok_or_else(|| {
            D::Error::custom(format!(
                "`{text}` is not a time span; write it like 09:00-12:00"
            ))
        })
    });
    spans.collect()
}

pub(super) fn offset<'de, D: Deserializer<'de>>(source: D) -> Result<i8, D::Error> {
    let hours = i8::deserialize(source)?;
    if (-12..=14).contains(&hours) {
        Ok(hours)
    } else {
        Err(D::Error::custom(format!(
            "{hours} is not a UTC offset in hours"
        )))
    }
}

impl Provider {
    /// The user's entry over this one.
    pub fn overlay(&mut self, user: Self) {
        if user.base_url.is_some() {
            // An address given by hand is not overridden by a variable meant for another one.
            self.base_url_env = None;
        }
        fn over<T>(own: &mut Option<T>, user: Option<T>) {
            if user.is_some() {
                *own = user;
            }
        }
        if user.dialect.is_some() {
            // Who states the dialect means it for questions with tools, too.
            let models = self.models.iter_mut().flatten();
            models.for_each(|model| model.quirks.tools_dialect = None);
        }
        over(&mut self.dialect, user.dialect);
        over(&mut self.base_url, user.base_url);
        over(&mut self.base_url_env, user.base_url_env);
        // An empty list says that there is none.
        let named = user.key_env.as_ref().map(|names| !names.list().is_empty());
        self.key_wanted = named.unwrap_or(self.key_wanted);
        over(&mut self.key_env, user.key_env);
        over(&mut self.key_command, user.key_command);
        over(&mut self.auth, user.auth);
        over(&mut self.allow_http, user.allow_http);
        over(&mut self.response_format, user.response_format);
        over(&mut self.prompt_cache, user.prompt_cache);
        over(&mut self.peak, user.peak);
        over(&mut self.batch_factor, user.batch_factor);
        over(&mut self.requests_per_minute, user.requests_per_minute);
        over(&mut self.tokens_per_minute, user.tokens_per_minute);
        over(&mut self.concurrency, user.concurrency);
        over(&mut self.attempts, user.attempts);
        over(&mut self.idle_timeout, user.idle_timeout);
        over(&mut self.total_timeout, user.total_timeout);
        self.header_env.extend(user.header_env);
        self.quirks = user.quirks.or(self.quirks);
        self.prices.splice(0..0, user.prices);
        if let Some(models) = user.models {
            // The user's models replace the built-in ones on offer; metadata of the built-in ones still applies.
            let mut known = self.models.take().unwrap_or_default();
            known
                .iter_mut()
                .for_each(|model| model.listed = Some(false));
            self.models = Some(models.into_iter().chain(known).collect());
        }
    }

    /// The models on offer, each once: several entries may speak of one.
    pub fn listed(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for entry in self
            .models
            .iter()
            .flatten()
            .filter(|entry| entry.is_listed())
        {
            if !names.contains(&entry.name.as_str()) {
                names.push(&entry.name);
            }
        }
        names
    }

    /// The entries that speak of a model, the most telling first.
    pub fn entries<'a>(&'a self, model: &'a str) -> impl Iterator<Item = &'a ModelEntry> {
        let entries = self.models.iter().flatten();
        entries.filter(move |entry| super::price::fits(&entry.name, model))
    }
}

/// Why a model cannot be asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegistryError {
    /// The id is not `provider/model`.
    #[error(
        "`{id}` is not a model id; write provider/model, e.g. openai/gpt-6-luna, or reference/geometry for the built-in judge{meant}"
    )]
    NotAnId {
        /// The words given.
        id: String,
        /// Models that they may mean, as a question.
        meant: String,
    },
    /// No provider has this name.
    #[error(
        "unknown provider `{name}`{known}; `nearmiss models` lists all; for your own server add [provider.{name}] with base_url to config.toml, or pass --base-url"
    )]
    NoProvider {
        /// The name asked for.
        name: String,
        /// What is probably meant, or those that exist.
        known: String,
    },
    /// A provider's entry is not right.
    #[error("[provider.{name}] in config.toml: {message}")]
    Entry {
        /// Which provider.
        name: String,
        /// The error, with the key.
        message: String,
    },
    /// The file of prices ([`super::PriceTable`]) is not right, and is left out.
    #[error(
        "{message}; the shipped prices hold instead: write it anew with `nearmiss models --update`, or delete it"
    )]
    Prices {
        /// The error, with the file.
        message: String,
    },
    /// A provider's entry in a file is not right, and the provider is left out.
    #[error("{place}: [provider.{name}] {message}; this provider is disabled")]
    Broken {
        /// File and line.
        place: String,
        /// Which provider.
        name: String,
        /// The error, with the line's text.
        message: String,
    },
}

impl Registry {
    /// The built-in providers, with the prices of the user's table ([`super::PriceTable`]) over theirs, and the user's
    /// entries over both. An entry that is not right leaves out its provider and nothing else: [`Registry::broken`]
    /// tells of it, and so does [`Registry::resolve`]. `file` is where the entries are from, beside the table; it is
    /// read again for the line of a mistake.
    #[must_use]
    pub fn lenient(users: &toml::Table, file: &Path) -> Self {
        let mut registry = Self::shipped();
        if let Err(error) = registry.lay_prices(file) {
            let key = super::price_table::FILE.to_string();
            registry.broken.insert(key, error);
        }
        let mut text = None;
        for (name, value) in users {
            let Err(error) = registry.overlay(name, value) else {
                continue;
            };
            let text = text.get_or_insert_with(|| {
                system::read_text(file, system::LARGEST_TEXT).unwrap_or_default()
            });
            let error = match in_text(text, name) {
                Some((line, message)) => RegistryError::Broken {
                    place: format!("{}:{line}", file.display()),
                    name: name.clone(),
                    message,
                },
                None => error,
            };
            registry.providers.remove(name);
            registry.broken.insert(name.clone(), error);
        }
        registry
    }

    /// Errors in the user's entries, by provider, and in the table of prices, by its file's name; they are left out.
    pub fn broken(&self) -> impl Iterator<Item = (&str, &RegistryError)> {
        self.broken.iter().map(|(name, why)| (name.as_str(), why))
    }
}

/// The line (from 1) and the message of a mistake in a provider's entry.
fn in_text(text: &str, name: &str) -> Option<(usize, String)> {
    let mut whole = DeTable::parse(text).ok()?.into_inner();
    let (_, providers) = whole.remove_entry("provider")?;
    let toml::de::DeValue::Table(mut providers) = providers.into_inner() else {
        return None;
    };
    let (_, entry) = providers.remove_entry(name)?;
    let error = Provider::deserialize(ValueDeserializer::from(entry)).err()?;
    let line = system::line_at(text, error.span()?.start);
    // The key alone: the value behind it may be a secret.
    let written = text.lines().nth(line - 1).unwrap_or_default();
    let key = written.split('=').next().unwrap_or_default().trim();
    let words: Vec<&str> = error.message().split_whitespace().collect();
    Some((line, format!("{}, in `{key}`", words.join(" "))))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::llm::Environment;

    #[test]
    fn a_broken_entry_leaves_out_its_provider_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("config.toml");
        let text = "mouse = false\n[provider.lab]\nbase_url = \"http://a\"\n[[provider.lab.prices]]\nmodel = \"m\"\n\
                    imput = 1.0\noutput = 2.0\n\n[provider.good]\nbase_url = \"http://b\"\n[provider.odd]\nmodels = 3\n";
        std::fs::write(&file, text).unwrap();
        let whole: toml::Table = toml::from_str(text).unwrap();
        let users = whole["provider"].as_table().unwrap();
        let registry = Registry::lenient(users, &file);
        let said: Vec<String> = registry.broken().map(|(_, why)| why.to_string()).collect();
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(
            said[0].contains("config.toml:6: [provider.lab]"),
            "{said:?}"
        );
        assert!(said[0].contains("`imput`"), "{said:?}");
        assert!(
            !said.iter().any(|s| s.contains("= ")),
            "no values: {said:?}"
        );
        assert!(
            said[1].contains("config.toml:12: [provider.odd]"),
            "{said:?}"
        );
        let environment = Environment::with_files(&[]);
        assert!(registry.resolve("good/m", &environment).is_ok());
        let why = registry.resolve("lab/m", &environment).unwrap_err();
        assert_eq!(why.to_string(), said[0]);
    }
}
