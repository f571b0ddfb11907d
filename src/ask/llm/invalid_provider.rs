//! An invalid provider entry: its line in the file, and the registry without it.

use std::path::Path;

use serde::Deserialize;
use toml::de::{DeTable, ValueDeserializer};

use super::provider::{Provider, RegistryError};
use super::registry::Registry;
use nearmiss_base::system;

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
