//! Providers and models by name: `provider/model` becomes an endpoint and the server's model name.

use std::collections::BTreeMap;

use secrecy::SecretString;
use serde::Deserialize;

use super::{Endpoint, ResponseFormat};

/// What is known of one provider.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Provider {
    /// The address.
    pub base_url: Option<String>,
    /// Environment variable that overrides the address.
    pub base_url_env: Option<String>,
    /// Environment variable that holds the key; keys are never written in files.
    pub key_env: Option<String>,
    /// `json_schema`, `json_object` or `off`: what of the answer's form is asked of the server.
    pub response_format: Option<String>,
    /// Models offered in lists; any other name works too.
    pub models: Option<Vec<String>>,
}

/// Why a model cannot be asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegistryError {
    /// The id is not `provider/model`.
    #[error("`{0}` is not a model id; write provider/model, e.g. openai/gpt-4o")]
    NotAnId(String),
    /// No provider has this name.
    #[error(
        "no provider `{name}`; there are {known}, and the built-in reference/geometry; add [provider.{name}] with base_url to config.toml, or pass --base-url"
    )]
    NoProvider {
        /// The name asked for.
        name: String,
        /// Those that exist.
        known: String,
    },
    /// The key of a server elsewhere is missing.
    #[error("{name} needs a key: set {variable} in the environment")]
    NoKey {
        /// Which provider.
        name: String,
        /// Where its key is looked for.
        variable: String,
    },
    /// A provider's entry is not right.
    #[error("[provider.{name}] in config.toml: {message}")]
    Entry {
        /// Which provider.
        name: String,
        /// What is wrong.
        message: String,
    },
}

/// A model that can be chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// `provider/model`.
    pub id: String,
    /// The variable its key is read from, and whether it is set; nothing where none is needed.
    pub key: Option<(String, bool)>,
}

/// The providers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Registry {
    providers: BTreeMap<String, Provider>,
}

impl Registry {
    /// The built-in providers, with the user's entries over them.
    ///
    /// # Errors
    /// An entry of the user's that is not right.
    pub fn new(users: &toml::Table) -> Result<Self, RegistryError> {
        let mut providers: BTreeMap<String, Provider> =
            toml::from_str(include_str!("providers.toml"))
                .expect("the program's own table of providers is right; a test reads it");
        for (name, value) in users {
            let user: Provider =
                value
                    .clone()
                    .try_into()
                    .map_err(|e: toml::de::Error| RegistryError::Entry {
                        name: name.clone(),
                        message: e.message().to_string(),
                    })?;
            if let Some(format) = &user.response_format {
                response_format(format).map_err(|message| RegistryError::Entry {
                    name: name.clone(),
                    message,
                })?;
            }
            let entry = providers.entry(name.clone()).or_default();
            if user.base_url.is_some() {
                // An address given by hand is not overridden by a variable meant for another one.
                entry.base_url_env = None;
            }
            entry.base_url = user.base_url.or(entry.base_url.take());
            entry.base_url_env = user.base_url_env.or(entry.base_url_env.take());
            entry.key_env = user.key_env.or(entry.key_env.take());
            entry.response_format = user.response_format.or(entry.response_format.take());
            entry.models = user.models.or(entry.models.take());
        }
        Ok(Self { providers })
    }

    /// The endpoint of a model and the name the server knows it by; `env` looks up variables.
    ///
    /// # Errors
    /// See [`RegistryError`].
    pub fn resolve(
        &self,
        id: &str,
        env: impl Fn(&str) -> Option<String>,
    ) -> Result<(Endpoint, String), RegistryError> {
        let (name, model) = split(id)?;
        let Some(provider) = self.providers.get(name) else {
            let known: Vec<&str> = self.providers.keys().map(String::as_str).collect();
            return Err(RegistryError::NoProvider {
                name: name.to_string(),
                known: known.join(", "),
            });
        };
        let Some(url) = provider.url(&env) else {
            return Err(RegistryError::Entry {
                name: name.to_string(),
                message: "it has no base_url".into(),
            });
        };
        let mut endpoint = Endpoint::new(name, url);
        endpoint.key_source.clone_from(&provider.key_env);
        let key = provider.key_env.as_deref().and_then(&env);
        let key = key.filter(|key| !key.trim().is_empty());
        if let (None, Some(variable), false) = (&key, &provider.key_env, is_here(&endpoint)) {
            // Nothing is sent elsewhere that would only be refused.
            return Err(RegistryError::NoKey {
                name: name.to_string(),
                variable: variable.clone(),
            });
        }
        endpoint.key = key.map(SecretString::from);
        let format = provider.response_format.as_deref().unwrap_or("off");
        endpoint.response_format = response_format(format).unwrap_or(ResponseFormat::Off);
        Ok((endpoint, model.to_string()))
    }

    /// Every model that is listed, with whether its key is there. Where a server on this machine could take a key and
    /// none is set, none is needed.
    #[must_use]
    pub fn offers(&self, env: impl Fn(&str) -> Option<String>) -> Vec<Offer> {
        let set = |name: &String| (name.clone(), env(name).is_some_and(|v| !v.is_empty()));
        let offers = self.providers.iter().flat_map(|(name, provider)| {
            let url = provider.url(&env);
            let here = url.is_some_and(|url| is_here(&Endpoint::new(name, url)));
            let key = provider.key_env.as_ref().map(set);
            let key = key.filter(|(_, set)| *set || !here);
            let models = provider.models.iter().flatten();
            models.map(move |model| Offer {
                id: format!("{name}/{model}"),
                key: key.clone(),
            })
        });
        offers.collect()
    }
}

impl Provider {
    /// Its address: that of a variable before its own.
    fn url(&self, env: impl Fn(&str) -> Option<String>) -> Option<String> {
        let of_variable = self.base_url_env.as_deref().and_then(env);
        let of_variable = of_variable.filter(|url| !url.is_empty());
        of_variable.or_else(|| self.base_url.clone())
    }
}

/// Whether a server is on this machine; such servers rarely want a key.
fn is_here(endpoint: &Endpoint) -> bool {
    let url = endpoint.chat_url().ok();
    let host = url.as_ref().and_then(|url| url.host_str());
    host.is_none_or(|host| {
        let bare = host.trim_matches(['[', ']']);
        let address = bare.parse::<std::net::IpAddr>();
        bare == "localhost" || address.is_ok_and(|address| address.is_loopback())
    })
}

/// Provider and model of an id.
fn split(id: &str) -> Result<(&str, &str), RegistryError> {
    match id.split_once('/') {
        Some((provider, model)) if !provider.is_empty() && !model.is_empty() => {
            Ok((provider, model))
        }
        _ => Err(RegistryError::NotAnId(id.to_string())),
    }
}

fn response_format(name: &str) -> Result<ResponseFormat, String> {
    match name {
        "json_schema" => Ok(ResponseFormat::JsonSchema),
        "json_object" => Ok(ResponseFormat::JsonObject),
        "off" => Ok(ResponseFormat::Off),
        _ => Err(format!(
            "response_format `{name}` is not one of json_schema, json_object, off"
        )),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn registry(user: &str) -> Result<Registry, RegistryError> {
        Registry::new(&toml::from_str(user).unwrap())
    }

    #[test]
    fn the_built_in_file_is_right() {
        let registry = registry("").unwrap();
        assert!(registry.providers.len() >= 5);
        let offers = registry.offers(|name| (name == "OPENAI_API_KEY").then(|| "k".into()));
        let gpt = offers.iter().find(|o| o.id == "openai/gpt-4o").unwrap();
        assert_eq!(gpt.key, Some(("OPENAI_API_KEY".into(), true)));
        let local = offers.iter().find(|o| o.id.starts_with("local/")).unwrap();
        assert_eq!(local.key, None, "a server on this machine");
        let elsewhere =
            |name: &str| (name == "NEARMISS_LOCAL_URL").then(|| "http://far.example/v1".into());
        let offers = registry.offers(elsewhere);
        let local = offers.iter().find(|o| o.id.starts_with("local/")).unwrap();
        assert!(matches!(local.key, Some((_, false))));
    }

    #[test]
    fn ids_become_endpoints() {
        let registry =
            registry("[lab]\nbase_url = \"http://127.0.0.1:9\"\nkey_env = \"K\"").unwrap();
        let (endpoint, model) = registry.resolve("lab/a/b", |_| None).unwrap();
        assert_eq!(
            (endpoint.base_url.as_str(), model.as_str()),
            ("http://127.0.0.1:9", "a/b")
        );
        assert!(matches!(
            registry.resolve("gpt-4o", |_| None),
            Err(RegistryError::NotAnId(_))
        ));
        assert!(matches!(
            registry.resolve("x/y", |_| None),
            Err(RegistryError::NoProvider { .. })
        ));
        let no_key = registry.resolve("openai/a", |_| None);
        assert!(matches!(no_key, Err(RegistryError::NoKey { .. })));
        let (endpoint, _) = registry
            .resolve("openai/a", |n| {
                Some(
                    if n == "OPENAI_BASE_URL" {
                        "http://b"
                    } else {
                        "key"
                    }
                    .into(),
                )
            })
            .unwrap();
        assert_eq!(endpoint.base_url, "http://b");
    }

    #[test]
    fn wrong_entries_are_named() {
        let error = registry("[lab]\nurl = \"x\"").unwrap_err().to_string();
        assert!(
            error.contains("[provider.lab]") && error.contains("url"),
            "{error}"
        );
        assert!(registry("[lab]\nresponse_format = \"xml\"").is_err());
    }
}
