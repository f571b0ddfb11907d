//! `--set KEY=VALUE`: settings by the names that templates, experiments and the configuration have for them.

use std::str::FromStr;

use nearmiss_base::system::unknown;

/// Settings that `--set` changes.
pub trait Settable: Default {
    /// Their names.
    fn keys() -> Vec<&'static str>;

    /// Sets one of them.
    ///
    /// # Errors
    /// It cannot have this value: what is expected.
    fn set(&mut self, key: &str, value: &str) -> Result<(), String>;
}

/// A setting as it was given.
#[derive(Debug, Clone)]
pub struct Assignment {
    key: String,
    value: String,
}

/// Reads a setting, and checks it.
pub fn assignment<S: Settable>(text: &str) -> Result<Assignment, String> {
    let (key, value) = text.split_once('=').ok_or("expected KEY=VALUE")?;
    let keys = S::keys();
    if !keys.contains(&key) {
        return Err(unknown("key", key, keys));
    }
    S::default()
        .set(key, value)
        .map_err(|why| format!("{key}: {why}"))?;
    Ok(Assignment {
        key: key.into(),
        value: value.into(),
    })
}

/// All settings; of several for one key the last counts.
pub fn settings<S: Settable>(given: &[Assignment]) -> Result<S, String> {
    let mut all = S::default();
    for Assignment { key, value } in given {
        all.set(key, value)?;
    }
    Ok(all)
}

/// `on` or `off`.
pub fn on_or_off(word: &str) -> Result<bool, String> {
    match word {
        "on" | "yes" | "true" => Ok(true),
        "off" | "no" | "false" => Ok(false),
        _ => Err("expected on or off".into()),
    }
}

/// A number from `least` to `most`.
pub fn number<N: FromStr + PartialOrd + std::fmt::Display>(
    word: &str,
    least: N,
    most: N,
) -> Result<N, String> {
    let number = word.parse().ok();
    number
        .filter(|n| (&least..=&most).contains(&n))
        .ok_or_else(|| format!("expected {least} to {most}"))
}
