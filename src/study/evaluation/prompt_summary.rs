//! Short labels for prompt configurations, which tell answers apart in columns, ratings and the history.

use std::collections::HashMap;
use std::sync::OnceLock;

use nearmiss_ask::prompts::Library;
use nearmiss_store::StoredTemplate;

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
    pub fn of(stored: &StoredTemplate) -> Option<Self> {
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
        let Some(version) = Self::of(stored) else {
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
pub fn how(frame: &str, techniques: &str, template: Option<&TemplateVersion>) -> String {
    let way = format!("{frame} · {techniques}");
    match template.filter(|template| !template.is_shipped()) {
        Some(template) => format!("{way} · {template}"),
        None => way,
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
            how("ego", "cp", version.as_ref())
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
