//! Lists the registry's models: keys, prices and retirement dates.

use std::collections::BTreeSet;

use jiff::civil::Date;
use serde::Serialize;

use super::api_keys::Environment;
use super::dialect::Dialect;
use super::price::{Pricing, as_text};
use super::provider::{ModelEntry, Provider, StringOrList};
use super::registry::Registry;

/// Lists warn of a model's retirement this many days ahead.
const NEAR: i32 = 90;

/// A model that can be chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelOffer {
    /// `provider/model`.
    pub id: String,
    /// Source of its key, and whether the key is there; `None` if none is needed.
    pub key: Option<(String, bool)>,
    /// A note on its retirement.
    pub warning: Option<String>,
}

/// Availability of a model's key.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "state", content = "source", rename_all = "snake_case")]
pub enum KeyState {
    /// No key is needed.
    #[serde(rename = "not needed")]
    NotNeeded,
    /// The key is in this variable, possibly from a file.
    Present(String),
    /// A command prints the key.
    Command(String),
    /// None of these variables has the key.
    Missing(String),
}

/// Retirement of a model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Retirement {
    /// The first day on which it no longer answers as itself; `None` if it is gone since an unknown date.
    #[serde(serialize_with = "as_text")]
    pub day: Option<Date>,
    /// Another model answers, and is billed, in its place.
    pub routed: bool,
    /// Its replacement.
    pub replacement: Option<String>,
    /// The date is not the provider's own statement.
    pub unconfirmed: bool,
}

/// A model and its metadata.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelListing {
    /// `provider/model`; without a model where every name of one has to be typed.
    pub id: String,
    /// The protocol it is asked in.
    pub dialect: Dialect,
    /// Availability of its key.
    pub key: KeyState,
    /// Today's price, if known.
    pub pricing: Option<Pricing>,
    /// Its retirement, if known.
    pub retirement: Option<Retirement>,
}

impl Retirement {
    /// A note on its retirement as of a day; `None` while it is far off.
    #[must_use]
    pub fn warning(&self, today: Date) -> Option<String> {
        let replacement = self.replacement.as_deref();
        let instead = match (replacement, self.routed) {
            (None, _) => String::new(),
            (Some(model), false) => format!("; use {model}"),
            (Some(model), true) => format!(" by {model}, which is billed"),
        };
        let sure = if self.unconfirmed {
            " (unconfirmed)"
        } else {
            ""
        };
        let Some(day) = self.day else {
            return Some(format!("gone{instead}{sure}"));
        };
        let left = (day - today).get_days();
        let what = match (self.routed, left > 0) {
            (false, true) => format!("shuts down on {day}, in {left} days"),
            (false, false) => format!("shut down since {day}"),
            (true, true) => format!("from {day} on answered"),
            (true, false) => format!("since {day} answered"),
        };
        (left <= NEAR).then(|| format!("{what}{instead}{sure}"))
    }
}

impl ModelEntry {
    fn retirement(&self) -> Option<Retirement> {
        let day = self.shutdown.or(self.routed);
        (self.gone || day.is_some()).then(|| Retirement {
            day,
            routed: self.routed.is_some() && self.shutdown.is_none(),
            replacement: self.replacement.clone(),
            unconfirmed: self.unconfirmed,
        })
    }
}

impl Provider {
    pub(super) fn key_state(&self, name: &str, environment: &Environment) -> KeyState {
        if let Some(found) = self.key(environment) {
            return KeyState::Present(found.source);
        }
        if let Some(command) = self.key_command.as_ref().map(StringOrList::command) {
            return KeyState::Command(command.to_string());
        }
        // Without an address no server is on this machine.
        let names = match self.endpoint(name, "", environment) {
            Ok(endpoint) => self.missing_key(&endpoint),
            Err(_) => self.key_names(),
        };
        names.map_or(KeyState::NotNeeded, KeyState::Missing)
    }
}

/// Address of a provider, and where its key is looked up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    /// The provider's name.
    pub provider: String,
    /// The address, without user, password and query.
    pub url: String,
    /// The variable that the address is from, if it is from one.
    pub variable: Option<String>,
    /// The variables that the key is looked for in.
    pub keys: Vec<String>,
}

impl Registry {
    /// Every provider that has an address, in the order of their names.
    #[must_use]
    pub fn addresses(&self, environment: &Environment) -> Vec<Address> {
        let all = self.providers.iter().filter_map(|(name, provider)| {
            let endpoint = provider.endpoint(name, "", environment).ok()?;
            let variable = provider.base_url_env.clone();
            let keys = provider.key_env.as_ref();
            Some(Address {
                provider: name.clone(),
                url: endpoint.place().url,
                variable: variable.filter(|name| environment.variable(name).is_some()),
                keys: keys.map_or_else(Vec::new, |names| names.list().to_vec()),
            })
        });
        all.collect()
    }

    /// The providers that cost nothing: their server is on this machine, and neither a price nor a key is
    /// stated ([`crate::llm::Prices::free`]).
    #[must_use]
    pub fn free(&self, environment: &Environment) -> BTreeSet<String> {
        let free = |(name, provider): (&String, &Provider)| {
            let endpoint = provider.endpoint(name, "", environment).ok()?;
            endpoint.prices.are_free().then(|| name.clone())
        };
        self.providers.iter().filter_map(free).collect()
    }

    /// The stated price of a model, `provider/model`, on a day, if known.
    #[must_use]
    pub fn pricing(&self, id: &str, day: Date) -> Option<Pricing> {
        let (name, model) = id.split_once('/')?;
        self.providers.get(name)?.prices().pricing_for(model, day)
    }

    /// Every offered model, with its metadata on a day; a provider that offers none by name has one line.
    #[must_use]
    pub fn models(&self, environment: &Environment, today: Date) -> Vec<ModelListing> {
        let mut listed = Vec::new();
        for (name, provider) in &self.providers {
            let mut names = provider.listed();
            if names.is_empty() {
                names.push("…");
            }
            let key = provider.key_state(name, environment);
            listed.extend(names.into_iter().map(|model| ModelListing {
                id: format!("{name}/{model}"),
                dialect: provider.dialect.unwrap_or_default(),
                key: key.clone(),
                pricing: provider.pricing(name, model, environment, today),
                retirement: provider.entries(model).find_map(ModelEntry::retirement),
            }));
        }
        listed
    }

    /// A model by its name, listed or not, with its metadata on a day.
    #[must_use]
    pub fn known(&self, id: &str, environment: &Environment, today: Date) -> Option<ModelListing> {
        let (name, model) = id.split_once('/')?;
        let provider = self.providers.get(name)?;
        Some(ModelListing {
            id: id.to_string(),
            dialect: provider.dialect.unwrap_or_default(),
            key: provider.key_state(name, environment),
            pricing: provider.pricing(name, model, environment, today),
            retirement: provider.entries(model).find_map(ModelEntry::retirement),
        })
    }

    /// The end of a model, if it is known.
    #[must_use]
    pub fn retirement(&self, id: &str) -> Option<Retirement> {
        let (provider, model) = id.split_once('/')?;
        let provider = self.providers.get(provider)?;
        provider.entries(model).find_map(ModelEntry::retirement)
    }

    /// Every model that is offered by name, with whether its key is there and whether it is about to go.
    #[must_use]
    pub fn offers(&self, environment: &Environment, today: Date) -> Vec<ModelOffer> {
        let mut offers = Vec::new();
        for (name, provider) in &self.providers {
            let key = match provider.key_state(name, environment) {
                KeyState::NotNeeded => None,
                KeyState::Present(source) => Some((source, true)),
                KeyState::Command(command) => Some((command, true)),
                KeyState::Missing(names) => Some((names, false)),
            };
            let models = provider.listed().into_iter();
            offers.extend(models.map(|model| {
                ModelOffer {
                    id: format!("{name}/{model}"),
                    key: key.clone(),
                    warning: provider
                        .entries(model)
                        .find_map(ModelEntry::retirement)
                        .and_then(|retirement| retirement.warning(today)),
                }
            }));
        }
        offers
    }
}
