//! Short labels for prompt configurations, which tell answers apart in columns, ratings and the history.

use std::collections::HashMap;
use std::sync::OnceLock;

use crate::prompts::Library;

/// Letters of a template's hash that are shown.
const SHOWN: usize = 6;

/// `ego · cp+cot`, and the template where it is not the one that this program ships: `ego · cp+cot · mine 3fa2c1`.
///
/// The letters behind the name begin the template's hash, so that two versions of one file are told apart.
#[must_use]
pub fn how(frame: &str, techniques: &str, template: &str, hash: &str) -> String {
    let way = format!("{frame} · {techniques}");
    match template_words(template, hash) {
        Some(words) => format!("{way} · {words}"),
        None => way,
    }
}

/// The name of a template and the beginning of its hash; `None` if it is the shipped one, or is not known.
#[must_use]
pub fn template_words(template: &str, hash: &str) -> Option<String> {
    if template.is_empty() || hash.is_empty() || shipped(template) == Some(hash) {
        return None;
    }
    let name = template.strip_suffix(".md").unwrap_or(template);
    let short: String = hash.chars().take(SHOWN).collect();
    Some(format!("{name} {short}"))
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
    fn only_a_template_that_is_not_shipped_is_named() {
        let library = Library::load(None);
        let (file, template, _) = library.templates().next().unwrap();
        let hash = library.hash(&template.source);
        assert_eq!(how("ego", "cp", file, &hash), "ego · cp");
        let changed = library.hash(&format!("{}\nBe brief.", template.source));
        let name = file.strip_suffix(".md").unwrap();
        let words = how("ego", "cp", file, &changed);
        assert_eq!(words, format!("ego · cp · {name} {}", &changed[..6]));
        assert_eq!(
            how("ego", "cp", "mine.md", &hash),
            format!("ego · cp · mine {}", &hash[..6])
        );
        // Recorded by others: it is not known.
        assert_eq!(how("ego", "base", "", ""), "ego · base");
    }
}
