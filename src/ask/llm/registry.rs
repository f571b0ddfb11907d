//! Providers and models by name: resolves `provider/model`, and lists the models with keys, prices and retirement dates.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use jiff::civil::Date;
use nearmiss_base::system::{available, did_you_mean};
use serde::{Deserialize, Serialize};

use super::api_keys::{Environment, ResolvedKey};
use super::dialect::Dialect;
use super::endpoint::{Endpoint, ResponseFormat, Retry, Timeouts};
use super::limits::Limits;
use super::price::{PriceEntry, Prices, Pricing, as_text};
use super::provider::{ModelEntry, PriceLine, Provider, RegistryError, StringOrList};
use super::quirks::StatedQuirks;

/// The providers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Registry {
    pub(super) providers: BTreeMap<String, Provider>,
    /// Providers that are left out, and why.
    pub(super) broken: BTreeMap<String, RegistryError>,
}

impl Registry {
    /// The built-in providers, with the user's entries over them.
    ///
    /// # Errors
    /// An entry of the user's that is not right; it names entry and key.
    pub fn new(users: &toml::Table) -> Result<Self, RegistryError> {
        let mut registry = Self::shipped();
        for (name, value) in users {
            registry.overlay(name, value)?;
        }
        Ok(registry)
    }

    /// The built-in providers.
    pub(super) fn shipped() -> Self {
        #[derive(Deserialize)]
        struct File {
            provider: BTreeMap<String, Provider>,
        }
        let file: File = toml::from_str(include_str!("providers.toml"))
            .expect("the program's own table of providers is right; a test reads it");
        Self {
            providers: file.provider,
            broken: BTreeMap::new(),
        }
    }

    /// Lays an entry of the user's over what is there.
    pub(super) fn overlay(&mut self, name: &str, value: &toml::Value) -> Result<(), RegistryError> {
        let user: Provider = value.clone().try_into().map_err(|e: toml::de::Error| {
            let message = e
                .to_string()
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ");
            RegistryError::Entry {
                name: name.to_string(),
                message,
            }
        })?;
        let own = self.providers.entry(name.to_string()).or_default();
        own.overlay(user);
        Ok(())
    }

    /// The models in the table of providers, as `provider/model`.
    fn listed(&self) -> Vec<String> {
        let of = |(name, provider): (&String, &Provider)| {
            let models = provider.listed().into_iter();
            let ids: Vec<String> = models.map(|model| format!("{name}/{model}")).collect();
            ids
        };
        self.providers.iter().flat_map(of).collect()
    }

    /// What an id probably means that is in the table of no provider, though its provider has one; else nothing. Such a
    /// model may exist all the same.
    #[must_use]
    pub fn unlisted(&self, id: &str) -> Option<String> {
        let (name, model) = split(id)?;
        let provider = self.providers.get(name)?;
        let priced = || provider.prices().pricing_for(model, Date::MAX).is_some();
        if provider.models.as_ref()?.is_empty()
            || provider.entries(model).next().is_some()
            || priced()
        {
            return None;
        }
        let meant = did_you_mean(id, self.listed().iter().map(String::as_str));
        (!meant.is_empty()).then(|| format!("not among the listed models{meant}"))
    }

    /// The endpoint of a model and the server's name for it. A missing key is no error yet: the endpoint reports it
    /// when used, as a stored answer needs none.
    ///
    /// # Errors
    /// See [`RegistryError`].
    pub fn resolve(
        &self,
        id: &str,
        environment: &Environment,
    ) -> Result<(Endpoint, String), RegistryError> {
        let (name, model) = split(id).ok_or_else(|| RegistryError::NotAnId {
            id: id.to_string(),
            meant: did_you_mean(id, self.listed().iter().map(String::as_str)),
        })?;
        if let Some(why) = self.broken.get(name) {
            return Err(why.clone());
        }
        let Some(provider) = self.providers.get(name) else {
            // Baselines have names like models.
            let known = match name {
                "reference" => {
                    "; reference/geometry is the built-in judge, other reference/ ids are baselines of `evaluate`"
                        .into()
                }
                _ => available(name, self.providers.keys().map(String::as_str)),
            };
            return Err(RegistryError::NoProvider {
                name: name.to_string(),
                known,
            });
        };
        let mut endpoint = provider.endpoint(name, model, environment)?;
        match provider.key(environment) {
            Some(found) => {
                endpoint.key = Some(found.key);
                endpoint.key_source = Some(found.source);
            }
            None => endpoint.key_source = provider.key_names(),
        }
        endpoint.key_command = provider.key_command.as_ref().map(StringOrList::command);
        if endpoint.key.is_none()
            && let Some(command) = &endpoint.key_command
        {
            endpoint.key_source = Some(format!("the command {command}"));
        }
        endpoint.missing_key = provider.missing_key(&endpoint).map(|variable| {
            let problems = environment.problems.iter();
            let problems: String = problems.map(|p| format!("; {p}")).collect();
            format!("no key: set {variable} in the environment or in a .env file{problems}")
        });
        Ok((endpoint, model.to_string()))
    }

    /// Where a model's key is from, in words, if that is a `.env` file of the current folder: one that came with
    /// downloaded scenarios would send questions to a stranger's account.
    #[must_use]
    pub fn key_of_folder(&self, id: &str, environment: &Environment) -> Option<String> {
        let (name, _) = split(id)?;
        let found = self.providers.get(name)?.key(environment)?;
        let words = || format!("{name}: asked with the key {}", found.source);
        found.from_current_folder.then(words)
    }
}

impl Provider {
    /// The endpoint of a model, without its key.
    pub(super) fn endpoint(
        &self,
        name: &str,
        model: &str,
        environment: &Environment,
    ) -> Result<Endpoint, RegistryError> {
        let dialect = self.dialect.unwrap_or_default();
        let variable = self.base_url_env.as_deref();
        let url = variable.and_then(|name| environment.variable(name));
        let Some(url) = url.or_else(|| self.base_url.clone()) else {
            return Err(RegistryError::Entry {
                name: name.to_string(),
                message: "no base_url".into(),
            });
        };
        let quirks = self
            .entries(model)
            .map(|entry| entry.quirks)
            .fold(StatedQuirks::default(), StatedQuirks::or);
        let format = self.entries(model).find_map(|entry| entry.response_format);
        let seconds = |n: std::num::NonZeroU32| Duration::from_secs(u64::from(n.get()));
        let (timeouts, retry) = (Timeouts::default(), Retry::default());
        let headers = self.header_env.iter().filter_map(|(header, variable)| {
            Some((header.clone(), environment.variable(variable)?))
        });
        let mut endpoint = Endpoint {
            dialect,
            auth: self.auth,
            headers: headers.collect(),
            allow_http: self.allow_http.unwrap_or_default(),
            timeouts: Timeouts {
                idle: self.idle_timeout.map_or(timeouts.idle, seconds),
                total: self.total_timeout.map_or(timeouts.total, seconds),
                ..timeouts
            },
            retry: Retry {
                attempts: self.attempts.map_or(retry.attempts, |n| n.get()),
                ..retry
            },
            prompt_cache: self.prompt_cache.unwrap_or(true),
            quirks: quirks.or(self.quirks).settled(),
            limits: Limits {
                requests_per_minute: self.requests_per_minute,
                tokens_per_minute: self.tokens_per_minute,
                concurrency: self.concurrency,
            },
            prices: self.prices(),
            ..Endpoint::new(name, dialect.protocol().base_url(&url))
        };
        // All servers that people run themselves take a form of the answer; small models give none without.
        let usual = if endpoint.is_here() {
            ResponseFormat::JsonSchema
        } else {
            ResponseFormat::Off
        };
        endpoint.response_format = format.or(self.response_format).unwrap_or(usual);
        // A server here that wants a key may forward to one that is paid.
        let forwards = self.key_wanted || self.key_command.is_some() || !self.header_env.is_empty();
        if endpoint.prices.entries.is_empty() && endpoint.is_here() && !forwards {
            endpoint.prices = Prices::free();
        }
        Ok(endpoint)
    }

    /// The price of a model on a day, if known, with what is free on this machine.
    pub(super) fn pricing(
        &self,
        name: &str,
        model: &str,
        environment: &Environment,
        day: Date,
    ) -> Option<Pricing> {
        let endpoint = self.endpoint(name, model, environment);
        let prices = endpoint.map_or_else(|_| self.prices(), |endpoint| endpoint.prices);
        prices.pricing_for(model, day)
    }

    /// The prices of its models that are stated; [`Provider::endpoint`] knows which server is free.
    pub(super) fn prices(&self) -> Prices {
        let entries: Vec<PriceEntry> = self.prices.iter().flat_map(PriceLine::entries).collect();
        Prices {
            entries,
            peak: self.peak.clone(),
            batch_factor: self.batch_factor,
        }
    }

    pub(super) fn key(&self, environment: &Environment) -> Option<ResolvedKey> {
        environment.key(self.key_env.as_ref().map_or(&[], StringOrList::list))
    }

    /// The variables that the key should be in and is not. Servers on this machine rarely want one: there it is missed
    /// only where the user names the variables. Nothing is sent elsewhere that would only be refused.
    pub(super) fn missing_key(&self, endpoint: &Endpoint) -> Option<String> {
        let found = endpoint.key.is_some() || endpoint.key_command.is_some();
        let wanted = self.key_wanted || !endpoint.is_here();
        self.key_names().filter(|_| wanted && !found)
    }

    /// The variables its key is looked for in, for people.
    pub(super) fn key_names(&self) -> Option<String> {
        let names = self.key_env.as_ref()?.list();
        (!names.is_empty()).then(|| names.join(" or "))
    }
}

/// Provider and model of an id.
fn split(id: &str) -> Option<(&str, &str)> {
    let (provider, model) = id.split_once('/')?;
    (!provider.is_empty() && !model.is_empty()).then_some((provider, model))
}

/// Lists warn of a model's retirement this many days ahead.
const RETIREMENT_NOTICE_DAYS: i32 = 90;

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
        (left <= RETIREMENT_NOTICE_DAYS).then(|| format!("{what}{instead}{sure}"))
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

#[cfg(test)]
#[path = "registry_tests.rs"]
mod tests;
