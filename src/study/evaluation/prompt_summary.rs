//! Short labels for prompt configurations, and runs and answers in words, for every face.

use std::collections::HashMap;
use std::sync::OnceLock;

use nearmiss_ask::prompts::Library;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{Moment, Motion, Waypoint};
use nearmiss_store::{Origin, Run, StoredTemplate};

use super::consumption::{local_time, tokens, took, unknown};

/// Letters of a template's hash that are shown.
const SHOWN: usize = 6;

/// The name of a draft: the file it is a draft of says nothing about its text.
const DRAFT: &str = "draft";

/// One version of a prompt template: answers to different versions are never counted together.
///
/// Shown as `collision-ego@3fa2c1`, or `draft@130d0c` where the text was not saved; the letters begin the hash.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TemplateVersion {
    /// The file's name without its ending; `draft` for a text that was not saved.
    pub name: String,
    /// SHA-256 of its text and of the fragments that it includes.
    pub hash: String,
}

impl TemplateVersion {
    /// The version that a run was asked with; `None` where that is not known, as for imported answers.
    #[must_use]
    pub fn from_stored(stored: &StoredTemplate) -> Option<Self> {
        let StoredTemplate {
            template,
            template_version,
            template_hash,
        } = stored;
        Self::new(template, template_version.as_deref(), template_hash)
    }

    /// A version by the template's file, the version that it states, which a draft has none of, and its hash; `None`
    /// without a file or a hash.
    #[must_use]
    pub fn new(file: &str, version: Option<&str>, hash: &str) -> Option<Self> {
        if file.is_empty() || hash.is_empty() {
            return None;
        }
        let is_draft = version.is_none() && shipped(file) != Some(hash);
        let name = if is_draft {
            DRAFT
        } else {
            file.strip_suffix(".md").unwrap_or(file)
        };
        Some(Self {
            name: name.into(),
            hash: hash.into(),
        })
    }

    /// The version that a run was asked with, in words: `draft@130d0c of collision-ego.md, not saved`, or
    /// `collision-ego@3fa2c1, version 3`; the file alone where nothing else is known.
    #[must_use]
    pub fn described(stored: &StoredTemplate) -> Option<String> {
        let file = stored.template.as_str();
        let Some(version) = Self::from_stored(stored) else {
            return (!file.is_empty()).then(|| file.to_string());
        };
        Some(match &stored.template_version {
            _ if version.name == DRAFT => format!("{version} of {file}, not saved"),
            Some(number) => format!("{version}, version {number}"),
            None => version.to_string(),
        })
    }

    /// Whether it is one that this version of the program ships.
    #[must_use]
    pub fn is_shipped(&self) -> bool {
        shipped(&format!("{}.md", self.name)) == Some(self.hash.as_str())
    }
}

impl std::fmt::Display for TemplateVersion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let short: String = self.hash.chars().take(SHOWN).collect();
        write!(f, "{}@{short}", self.name)
    }
}

/// Techniques, and tools where the model may call some: `cp+cot+tools`.
#[must_use]
pub fn with_tools(techniques: &str, tools: bool) -> String {
    let more = if tools { "+tools" } else { "" };
    format!("{techniques}{more}")
}

/// `ego · cp+cot`, and the template where it is not the one that this program ships: `ego · cp+cot · mine@3fa2c1`.
/// Techniques are those of [`with_tools`].
#[must_use]
pub fn prompt_label(frame: &str, techniques: &str, template: Option<&TemplateVersion>) -> String {
    let configuration = format!("{frame} · {techniques}");
    match template.filter(|template| !template.is_shipped()) {
        Some(template) => format!("{configuration} · {template}"),
        None => configuration,
    }
}

/// The hash of the template that ships under this name.
fn shipped(file: &str) -> Option<&'static str> {
    static HASHES: OnceLock<HashMap<String, String>> = OnceLock::new();
    let hashes = HASHES.get_or_init(|| {
        let library = Library::load(None);
        let templates = library.templates();
        templates
            .map(|(file, template, _)| (file.to_string(), library.hash(&template.source)))
            .collect()
    });
    hashes.get(file).map(String::as_str)
}

/// Names and values, what people look for first; `most` is what it can have cost, US dollars.
#[must_use]
pub fn run_summary(run: &Run, most: Option<f64>) -> Vec<(&'static str, String)> {
    let (question, ending) = (&run.question, &run.ending);
    let name = question.model.split_once('/').map(|(_, name)| name);
    let other = ending.model_returned.clone();
    let asked = || format!("{} · {}", question.frame, question.techniques);
    let how = judge::how(&question.model);
    // The built-in judge reads no prompt.
    let template = || TemplateVersion::described(&question.template());
    let window = question.window;
    let window = || window.map(|(first, last)| format!("{first} to {last}"));
    let steps = judge::looks_at(&question.model, question.task).map(String::from);
    // The time of a recorded answer is unknown.
    let when = match run.origin {
        Origin::Recorded => "imported",
        Origin::Asked | Origin::Replayed => "asked",
    };
    let rows = [
        ("state", Some(ending.state.name().into())),
        ("problem", ending.error.clone()),
        ("reading", ending.reading.clone()),
        ("model", Some(question.model.clone())),
        ("answered by", other.filter(|other| Some(&**other) != name)),
        ("scenario", Some(question.scenario.clone())),
        ("ego", Some(question.ego.clone())),
        ("task", Some(question.task.name().into())),
        ("asked with", Some(how.map_or_else(asked, String::from))),
        ("steps", steps.or_else(window)),
        (when, Some(local_time(run.created_ms))),
        ("took", took(&ending.consumed)),
        ("tokens", tokens(&ending.consumed)),
        ("cost", cost(run, most)),
        ("notes", Some(run.notes.clone())),
        ("pinned", run.pinned.then(|| "yes".into())),
        ("deleted", run.deleted_ms.map(local_time)),
        ("batch", question.batch.clone()),
        (
            "sample",
            (question.sample > 0).then(|| question.sample.to_string()),
        ),
        ("origin", Some(run.origin.name().into())),
        ("read from", run.source.clone()),
        ("server", Some(question.endpoint.clone())),
        ("template", how.map_or_else(template, |_| None)),
        (
            "parameters",
            Some(question.parameters.clone()).filter(|p| p != "{}"),
        ),
    ];
    rows.into_iter()
        .filter_map(|(name, value)| Some((name, value.filter(|v| !v.is_empty())?)))
        .collect()
}

/// What a run cost, and whose figure that is; nothing of what costs nothing here.
fn cost(run: &Run, most: Option<f64>) -> Option<String> {
    let (question, ending) = (&run.question, &run.ending);
    Some(match (ending.consumed.cost_usd, most) {
        (Some(usd), _) => {
            let source = ending.price_source.as_deref().unwrap_or("source unknown");
            format!("{usd} US dollars ({source})")
        }
        (None, _) if run.origin == Origin::Recorded || question.model == judge::MODEL => {
            return None;
        }
        (None, Some(0.0)) => "0 US dollars (nothing was sent, or the server is free)".into(),
        (None, Some(most)) => format!(
            "at most {most:.6} US dollars (no token counts from the server; computed from estimated tokens, the token limit and prices)"
        ),
        (None, None) => {
            let returned = ending.model_returned.as_deref();
            format!(
                "unknown ({})",
                unknown(&ending.consumed, &question.model, returned)
            )
        }
    })
}

/// A motion that an answer asks for, a line for each of its parts.
#[must_use]
pub fn motion_lines(motion: &Motion) -> Vec<String> {
    let number = |name: &str, value: Option<f64>, unit: &str| {
        value.map_or(String::new(), |v| format!(", {name} {v:.2} {unit}"))
    };
    match motion {
        Motion::Manoeuvre(m) => vec![format!(
            "{} from {:.2} s for {:.2} s{}{}",
            m.kind.name(),
            m.start,
            m.duration,
            number("gap", m.gap, "m"),
            number("speed", m.speed, "m/s"),
        )],
        Motion::Waypoints(points) => {
            let words = |p: &Waypoint| {
                let at = match p.at {
                    Moment::Step(step) => format!("step {step}"),
                    Moment::Seconds(seconds) => format!("{seconds:.2} s"),
                };
                format!(
                    "{at}: ({:.2}, {:.2}) m{}{}",
                    p.x,
                    p.y,
                    number("heading", p.heading, "rad"),
                    number("velocity", p.velocity, "m/s"),
                )
            };
            points.iter().map(words).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_template_that_is_not_shipped_is_named_and_a_draft_is_not_named_after_its_file() {
        let library = Library::load(None);
        let (file, template, _) = library.templates().next().unwrap();
        let hash = library.hash(&template.source);
        let version = |file: &str, version: Option<&str>, hash: &str| {
            let version = TemplateVersion::new(file, version, hash);
            prompt_label("ego", "cp", version.as_ref())
        };
        assert_eq!(version(file, Some("3"), &hash), "ego · cp");
        // Runs of older stores may lack the version of a shipped template: it is no draft.
        assert_eq!(version(file, None, &hash), "ego · cp");
        let changed = library.hash(&format!("{}\nBe brief.", template.source));
        let (name, short) = (file.strip_suffix(".md").unwrap(), &changed[..6]);
        let saved = version(file, Some("3"), &changed);
        assert_eq!(saved, format!("ego · cp · {name}@{short}"));
        let draft = version(file, None, &changed);
        assert_eq!(draft, format!("ego · cp · draft@{short}"));
        // Recorded by others: it is not known.
        assert_eq!(version("", None, ""), "ego · cp");
    }
}
