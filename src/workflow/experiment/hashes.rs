//! Hashes of scenarios: an experiment names the contents that it was written with.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::HASH_DIGITS;
use crate::formats::Entry;
use crate::store::Item;

/// The contents of scenarios by name, each as the start of its SHA-256, several where scenarios of one name differ;
/// those that cannot be read are left out.
#[must_use]
pub fn hashes_of(entries: &[Entry]) -> BTreeMap<String, Vec<String>> {
    let hash = |entry: &Entry| {
        let hash = entry.read().ok()?.hash.to_string();
        let start = hash.get(..HASH_DIGITS).unwrap_or(&hash).to_string();
        Some((entry.name.clone(), start))
    };
    let found: Vec<(String, String)> = entries.par_iter().filter_map(hash).collect();
    by_name(found)
}

/// The same of the scenarios that a batch asks about, as they were when it was begun.
pub fn hashes_in(items: &[Item]) -> BTreeMap<String, Vec<String>> {
    let plain = items.iter().filter(|item| item.asked.transform.is_none());
    by_name(plain.filter_map(|item| {
        let start = item.asked.scenario_hash.as_ref()?.get(..HASH_DIGITS)?;
        Some((item.asked.scenario.clone(), start.to_string()))
    }))
}

fn by_name(found: impl IntoIterator<Item = (String, String)>) -> BTreeMap<String, Vec<String>> {
    let mut by_name: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, hash) in found {
        let of_name = by_name.entry(name).or_default();
        if !of_name.contains(&hash) {
            of_name.push(hash);
            of_name.sort_unstable();
        }
    }
    by_name
}

/// Compares the contents of scenarios with those that an experiment was written with; scenarios that it does not name
/// may be any.
///
/// # Errors
/// The first scenario with other contents, or that is missing.
pub(super) fn check(
    wanted: &BTreeMap<String, Vec<String>>,
    entries: &[Entry],
) -> Result<(), String> {
    if wanted.is_empty() {
        return Ok(());
    }
    let missing = |name: &&String| !entries.iter().any(|entry| entry.name == **name);
    if let Some(name) = wanted.keys().find(missing) {
        return Err(format!(
            "hashes: {name} is not among the scenarios; add it to `scenarios`, or remove its hash"
        ));
    }
    let named: Vec<&Entry> = entries
        .iter()
        .filter(|entry| wanted.contains_key(&entry.name))
        .collect();
    let other = named.par_iter().find_map_first(|entry| {
        let hash = match entry.read() {
            Ok(scenario) => scenario.hash.to_string(),
            Err(error) => return Some(format!("hashes: {error}")),
        };
        let wanted = &wanted[&entry.name];
        let same = wanted.iter().any(|start| hash.starts_with(start.as_str()));
        (!same).then(|| {
            format!(
                "hashes: {} has the hash {}, but the experiment was written with {}; use that file, or remove its hash",
                entry.display(),
                hash.get(..HASH_DIGITS).unwrap_or(&hash),
                wanted.join(" or ")
            )
        })
    });
    other.map_or(Ok(()), Err)
}
