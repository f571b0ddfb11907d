//! Hashes of scenarios: an experiment names the contents that it was written with.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;

use nearmiss_formats::Entry;
use nearmiss_record::fields::OneOrMore;
use nearmiss_store::Item;
use nearmiss_study::evaluation::batch::{ContentHash, HASH_DIGITS};

/// The contents of scenarios by name.
type Hashes = BTreeMap<String, OneOrMore<ContentHash>>;

/// The contents of scenarios, each as the start of its SHA-256, under its name, or under `folder/name` where several have
/// the name; those that cannot be read are left out.
#[must_use]
pub fn scenario_hashes(entries: &[Entry]) -> Hashes {
    let hash = |entry: &Entry| {
        let hash = entry.read().ok()?.hash.to_string();
        Some((entry.clone(), start(&hash).to_string()))
    };
    keyed(entries.par_iter().filter_map(hash).collect())
}

/// The same of the scenarios that a batch asks about, as they were when it was begun.
pub fn hashes_in(items: &[Item]) -> Hashes {
    let plain = items.iter().filter(|item| item.asked.transform.is_none());
    let found = plain.filter_map(|item| {
        let hash = item.asked.scenario_hash.as_ref()?;
        let entry = Entry {
            name: item.asked.scenario.clone(),
            ..Entry::of_argument(Path::new(&item.asked.path))
        };
        Some((entry, start(hash).to_string()))
    });
    keyed(found.collect())
}

fn start(hash: &str) -> &str {
    hash.get(..HASH_DIGITS).unwrap_or(hash)
}

/// A scenario's name with its folder.
fn in_folder(entry: &Entry) -> String {
    format!("{}/{}", entry.group, entry.name)
}

/// The name of the scenario that a key of the hashes is about.
pub fn hashed_name(key: &str) -> &str {
    key.rsplit_once('/').map_or(key, |(_, name)| name)
}

fn keyed(found: Vec<(Entry, String)>) -> Hashes {
    let mut groups: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (entry, _) in &found {
        groups.entry(&entry.name).or_default().insert(&entry.group);
    }
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (entry, hash) in &found {
        let key = match groups[entry.name.as_str()].len() {
            1 => entry.name.clone(),
            _ => in_folder(entry),
        };
        // Several only where folders are called alike, too.
        let of_key = all.entry(key).or_default();
        if !of_key.contains(hash) {
            of_key.push(hash.clone());
            of_key.sort_unstable();
        }
    }
    let all = all.into_iter();
    all.map(|(key, hashes)| (key, hashes.into_iter().map(ContentHash).collect()))
        .collect()
}

/// Compares the contents of scenarios with those that an experiment was written with; scenarios that it does not name
/// may be any.
///
/// # Errors
/// The first scenario with other contents, or that is missing.
pub(super) fn check(wanted: &Hashes, entries: &[Entry]) -> Result<(), String> {
    let missing = |key: &&String| !entries.iter().any(|entry| entry.name == hashed_name(key));
    if let Some(key) = wanted.keys().find(missing) {
        return Err(format!(
            "hashes: {key} is not among the scenarios; add it to `scenarios`, or remove its hash"
        ));
    }
    // In a folder of another name, such as that of an unpacked bundle, the name alone counts.
    let of_entry = |entry: &Entry| -> Vec<&String> {
        let exact = wanted.get(&in_folder(entry));
        let by_name = wanted
            .iter()
            .filter(|(key, _)| hashed_name(key) == entry.name);
        match exact {
            Some(hashes) => hashes.iter().map(|hash| &hash.0).collect(),
            None => by_name
                .flat_map(|(_, hashes)| hashes.iter().map(|hash| &hash.0))
                .collect(),
        }
    };
    let read = |entry: &Entry| {
        let wanted = of_entry(entry);
        let read = || entry.read().map(|scenario| scenario.hash.to_string());
        (!wanted.is_empty()).then(|| (entry.clone(), wanted, read()))
    };
    let read: Vec<_> = entries.par_iter().filter_map(read).collect();
    for (entry, wanted, hash) in &read {
        let hash = hash.as_ref().map_err(|error| format!("hashes: {error}"))?;
        if !wanted.iter().any(|start| hash.starts_with(start.as_str())) {
            let wanted: Vec<&str> = wanted.iter().map(|start| start.as_str()).collect();
            return Err(format!(
                "hashes: {} has the hash {}, but the experiment was written with {}; use that file, or remove its hash",
                entry.display(),
                start(hash),
                wanted.join(" or ")
            ));
        }
    }
    // Several of one name: each of the contents has to be there.
    for (key, hashes) in wanted {
        let there = |start: &&String| {
            let of_name = read
                .iter()
                .filter(|(entry, ..)| entry.name == hashed_name(key));
            let mut hashes = of_name.filter_map(|(_, _, hash)| hash.as_ref().ok());
            hashes.any(|hash| hash.starts_with(start.as_str()))
        };
        if let Some(start) = hashes
            .iter()
            .map(|hash| &hash.0)
            .find(|start| !there(start))
        {
            return Err(format!(
                "hashes: no scenario {} has the hash {start}, but the experiment was written with one that has; use that file, or remove its hash",
                hashed_name(key)
            ));
        }
    }
    Ok(())
}
