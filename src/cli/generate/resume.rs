//! Resumes an earlier run: finished variants are taken over with everything their manifests record.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::document;
use super::line::{Line, OutcomeName};
use crate::{Failure, output};
use nearmiss_base::system;
use nearmiss_drive::generation::AttackStyle;
use nearmiss_drive::planner::RuleMode;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_workflow::is_unchanged;

/// Results of an earlier run, by the hash of the original.
#[derive(Debug, Default)]
pub struct EarlierRun {
    papers: HashMap<String, Vec<Papers>>,
}

/// The record of one variant.
#[derive(Debug)]
struct Papers {
    original: String,
    settings: Value,
    line: Line,
}

/// Contents of a file.
enum FileKind {
    /// How a variant was made.
    Papers(Box<Papers>),
    /// The figures of a run.
    Report,
}

impl EarlierRun {
    /// Contents of `folder`, with descriptions of untrusted files.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn read(folder: &Path) -> Result<(Self, Vec<String>), Failure> {
        let failed = |e: &std::io::Error| Failure::system(folder.display(), e);
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(|e| failed(&e))? {
            let path = entry.map_err(|e| failed(&e))?.path();
            if path.extension().is_some_and(|ending| ending == "json") {
                paths.push(path);
            }
        }
        // The first of several that fit is taken, in every run the same.
        paths.sort();
        let (mut past, mut doubts) = (Self::default(), Vec::new());
        for path in paths {
            match read(&path) {
                Ok(FileKind::Papers(papers)) => {
                    let same = past.papers.entry(papers.original.clone()).or_default();
                    same.push(*papers);
                }
                Ok(FileKind::Report) => {}
                Err(why) => doubts.push(format!("{}: not reused: {why}", path.display())),
            }
        }
        Ok((past, doubts))
    }

    /// The line of a variant of a scenario with this content that was made with these settings: first of all of one
    /// that was called so.
    pub fn line_for(
        &self,
        entry: &Entry,
        original: &ContentHash,
        settings: &Value,
    ) -> Option<Line> {
        // As a file says it: digits that no file keeps make no difference.
        let settings: Value = serde_json::from_str(&settings.to_string()).ok()?;
        let mut same = self
            .papers
            .get(&original.to_string())?
            .iter()
            .filter(|papers| papers.differences(&settings).is_empty());
        let name = output::visible(&entry.name);
        let named = same.clone().find(|p| p.line.figures.scenario == name);
        let mut line = named.or_else(|| same.next())?.line.clone();
        line.document["scenario"] = name.clone().into();
        line.document["file"] = entry.display().into();
        line.figures.scenario = name;
        Some(line)
    }

    /// Which variant of a scenario with this content is nearest to these settings, and why it is not taken over; `None`
    /// where there is none of it.
    pub fn why_not(&self, original: &ContentHash, settings: &Value) -> Option<String> {
        let settings: Value = serde_json::from_str(&settings.to_string()).ok()?;
        let papers = self.papers.get(&original.to_string())?.iter();
        let all = papers.map(|papers| (papers, papers.differences(&settings)));
        let (papers, differences) = all.min_by_key(|(_, differences)| differences.len())?;
        let named = &differences[..differences.len().min(NAMED)];
        let more = match differences.len() - named.len() {
            0 => String::new(),
            n => format!("; and {n} more"),
        };
        let prompts = differences.iter().any(|one| one.starts_with(PROMPTS));
        let todo = if prompts {
            // No option brings back the prompts of another version.
            "keep it as it is in another folder, or drop it"
        } else {
            "with the options of that run it is reused"
        };
        Some(format!(
            "variant {} is not reused, its settings differ: {}{more}; a new one is generated; {todo}",
            papers.line.figures.id.as_deref().unwrap_or("without an id"),
            named.join("; "),
        ))
    }
}

/// Differences that are named.
const NAMED: usize = 4;

/// How a difference of prompts begins.
const PROMPTS: &str = "model.templates";

impl Papers {
    /// Where its settings are others than these: `key then, now`.
    fn differences(&self, settings: &Value) -> Vec<String> {
        let mut found = Vec::new();
        differences("", &self.settings, settings, &mut found);
        found
    }
}

fn differences(path: &str, then: &Value, now: &Value, found: &mut Vec<String>) {
    let candidates = nearmiss_drive::generation::Effort::default().candidates;
    match (then, now) {
        (Value::Object(then), Value::Object(now)) => {
            let more = now.keys().filter(|key| !then.contains_key(*key));
            for key in then.keys().chain(more) {
                let inner = match path {
                    "" => key.clone(),
                    _ => format!("{path}.{key}"),
                };
                let of = |all: &serde_json::Map<String, Value>| {
                    all.get(key).cloned().unwrap_or(Value::Null)
                };
                differences(&inner, &of(then), &of(now), found);
            }
        }
        // Versions without `--within` let the model choose among all that it was told of.
        (Value::Null, _) if path == WITHIN => {}
        // A planner that does not get ready is found out when it drives.
        (_, Value::Null) if IDENTITY.contains(&path) => {}
        // Of a planner in place of another kind of planner the command says all.
        (Value::Object(_), Value::Null) | (Value::Null, Value::Object(_)) if path == PLANNER => {
            let named = |planner: &Value| match planner["command"].as_array() {
                Some(words) => {
                    let words: Vec<&str> = words.iter().filter_map(Value::as_str).collect();
                    format!("`{}`", words.join(" "))
                }
                None => "the built-in one".into(),
            };
            let words = format!("planner {}, now {}", named(then), named(now));
            found.push(output::visible(&words));
        }
        (then, now) if then == now => {}
        // No option sets them: what an earlier version found stays found.
        _ if SEARCH.contains(&path) => {}
        (then, now)
            if path == CANDIDATES
                && CANDIDATES_BEFORE.iter().any(|n| then == n)
                && *now == candidates => {}
        _ if path.starts_with(PROMPTS) => found.push(format!("{path}, another version")),
        _ => found.push(output::visible(&format!("{path} {then}, now {now}"))),
    }
}

/// How a search goes about it.
const SEARCH: [&str; 3] = ["search.rounds", "search.drives", "search.attackers"];

/// The number of motions, and what it was by default in earlier versions.
const CANDIDATES: &str = "search.candidates";
const CANDIDATES_BEFORE: [usize; 3] = [600, 1500, 3000];

/// The planner's process, and what it says of itself.
const PLANNER: &str = "planner";
const IDENTITY: [&str; 2] = ["planner.name", "planner.version"];

/// The setting that old manifests do not know.
const WITHIN: &str = "model.method.within";

/// Reads a manifest, and compares it with its variant.
fn read(path: &Path) -> Result<FileKind, String> {
    let bytes = system::read_file(path, system::LARGEST).map_err(|e| system::words(&e))?;
    let papers: Value =
        serde_json::from_slice(&bytes).map_err(|e| format!("not a manifest of a variant: {e}"))?;
    if says_report(&papers) {
        return Ok(FileKind::Report);
    }
    let word = |value: &Value, what: &str| match value.as_str() {
        Some(word) => Ok(word.to_owned()),
        None => Err(format!("not a manifest of a variant: {what} is missing")),
    };
    let original = word(&papers["original"]["sha256"], "original.sha256")?;
    let id = word(&papers["benchmark_id"], "benchmark_id")?;
    let made = &papers["made"];
    if made.is_null() {
        return Err("its settings are missing".into());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    let beside = |key: &str| file_beside(folder, &word(&papers[key], key)?);
    let (scenario, ego) = (beside("variant")?, beside("ego")?);
    let hashes = papers["sha256"]
        .as_object()
        .ok_or("not a manifest of a variant: sha256 is missing")?;
    if [&scenario, &ego]
        .iter()
        .any(|path| !hashes.contains_key(&file_name(path)))
    {
        return Err("not a manifest of a variant: sha256 lacks its files".into());
    }
    for (name, hash) in hashes {
        is_unchanged(&file_beside(folder, name)?, word(hash, "sha256")?.as_str())?;
    }
    let mut line = made["line"].clone();
    if !line.is_object() {
        return Err("not a manifest of a variant: made.line is missing".into());
    }
    line["rejected"] = papers["rejected"].clone();
    line["taken_over"] = true.into();
    document::place(&mut line, &id, &scenario, &ego);
    let line = Line::from_document(line)
        .map_err(|e| format!("not a manifest of a variant: made.line: {e}"))?;
    if line.figures.outcome == OutcomeName::None {
        return Err("not a manifest of a variant: nothing was generated".into());
    }
    let stopped = line.figures.model.as_ref();
    if let Some(why) = stopped.and_then(|model| model.stopped.as_ref()) {
        return Err(format!("the model stopped early: {why}"));
    }
    Ok(FileKind::Papers(Box::new(Papers {
        original,
        settings: with_identity(
            as_today(made["settings"].clone()),
            &papers["planning"]["planner"],
        ),
        line,
    })))
}

/// Settings with what the planner's process says of itself, where one is attacked.
pub fn with_identity(mut settings: Value, said: &Value) -> Value {
    if let Some(planner) = settings.get_mut("planner").and_then(Value::as_object_mut) {
        for key in ["name", "version"] {
            planner.insert(key.into(), said[key].clone());
        }
    }
    settings
}

/// The settings of a manifest; those of versions that knew no style are those of [`AttackStyle::Limit`], their models
/// were asked once for the attacker, without news of drives and without grades, and where one attacker was known, this
/// is the only one that may attack, or any. Those that knew no rules of the road did not obey them.
fn as_today(mut settings: Value) -> Value {
    if let Some(settings) = settings.as_object_mut() {
        let style = settings.entry("style");
        style.or_insert_with(|| AttackStyle::Limit.name().into());
        settings.entry("attackers").or_insert_with(|| 1.into());
        let named = settings.entry("attacker").or_insert(Value::Null);
        *named = match named.take() {
            Value::Null => json!([]),
            Value::Array(ids) => ids.into(),
            one => json!([one]),
        };
        if let Some(Value::Object(planning)) = settings.get_mut("planning") {
            let rules = planning.entry("rules");
            rules.or_insert_with(|| RuleMode::Off.name().into());
        }
        if let Some(Value::Object(model)) = settings.get_mut("model")
            && let (Some(samples), Some(retries)) =
                (model.remove("samples"), model.remove("retries"))
        {
            model.insert(
                "method".into(),
                json!({
                    "votes": 1, "within": null, "samples": samples, "retries": retries, "feedback": false,
                    "grades": false, "rank": "exact",
                }),
            );
        }
    }
    settings
}

/// The file of this name in a folder. A name is meant, not a way out of the folder.
fn file_beside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    match Path::new(name).file_name() {
        Some(file) if file == name => Ok(folder.join(name)),
        _ => Err(format!("not a file name: {name}")),
    }
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Whether the file at `path` is a report of an earlier run, which may be replaced.
///
/// # Errors
/// It is not, or cannot be read.
pub fn is_report(path: &Path) -> Result<(), String> {
    let named = |words: String| format!("{}: {words}", path.display());
    let bytes = system::read_file(path, system::LARGEST).map_err(|e| named(system::words(&e)))?;
    match serde_json::from_slice(&bytes) {
        Ok(document) if says_report(&document) => Ok(()),
        _ => Err(named(
            "exists and is not a report of `nearmiss generate`; name another file".into(),
        )),
    }
}

fn says_report(document: &Value) -> bool {
    document["asked_for"].is_u64() && document["scenarios"].is_u64()
}

#[cfg(test)]
#[path = "resume_tests.rs"]
mod tests;
