//! Tags that the user gave to scenarios, in a file of the data folder.

use std::collections::BTreeMap;
use std::path::Path;

use super::{Folders, TextFile};
use nearmiss_base::system::line_at;

/// Tags by the name of the scenario; scenarios of the same name share them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tags {
    of: BTreeMap<String, Vec<String>>,
}

impl Tags {
    /// Reads the file; without one there are no tags.
    ///
    /// # Errors
    /// It cannot be read or is damaged: with its name, and the line.
    pub fn read(path: &Path) -> Result<Self, String> {
        let Some(TextFile { file, text }) = TextFile::read_if_there(path)? else {
            return Ok(Self::default());
        };
        let of = toml::from_str(&text).map_err(|error| {
            let line = line_at(&text, error.span().map_or(0, |span| span.start));
            format!("{file}: line {line}: {}", error.message())
        })?;
        Ok(Self { of })
    }

    /// The tags of a scenario.
    #[must_use]
    pub fn tags_for(&self, scenario: &str) -> &[String] {
        self.of.get(scenario).map_or(&[], Vec::as_slice)
    }

    /// Every tag that is in use, in order.
    #[must_use]
    pub fn all(&self) -> Vec<&str> {
        let mut all: Vec<&str> = self.of.values().flatten().map(String::as_str).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Gives a scenario these tags instead of those it has, in the file too: it is read anew, so that what others wrote
    /// meanwhile stays, and written whole.
    ///
    /// # Errors
    /// The file is damaged (it stays as it is then) or cannot be written.
    pub fn change(path: &Path, scenario: &str, tags: Vec<String>) -> Result<Self, String> {
        let mut all = Self::read(path)?;
        if tags.is_empty() {
            drop(all.of.remove(scenario))
        } else {
            drop(all.of.insert(scenario.to_string(), tags))
        }
        let wrong = |why: String| format!("{}: {why}", path.display());
        let text = toml::to_string(&all.of).map_err(|error| wrong(error.to_string()))?;
        Folders::write(path, &text)
            .map_err(|error| wrong(nearmiss_base::system::error_text(&error)))?;
        Ok(all)
    }

    /// The tags in a line that was typed: words, each once, in order of appearance; commas part them too.
    #[must_use]
    pub fn typed(line: &str) -> Vec<String> {
        let mut tags: Vec<String> = Vec::new();
        for word in line.split(|c: char| c.is_whitespace() || c == ',') {
            let word = word.trim_start_matches('#');
            if !word.is_empty() && tags.iter().all(|tag| tag != word) {
                tags.push(word.to_string());
            }
        }
        tags
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_is_written_comes_back_and_a_damaged_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data/tags.toml");
        assert_eq!(Tags::read(&path), Ok(Tags::default()));
        let typed = Tags::typed(" odd, #for_paper  odd ");
        assert_eq!(typed, ["odd", "for_paper"]);
        Tags::change(&path, "DEU_A-1 \"x\"", typed.clone()).unwrap();
        let both = Tags::change(&path, "USA_B-1", vec!["later".into()]).unwrap();
        assert_eq!(Tags::read(&path).as_ref(), Ok(&both));
        assert_eq!(both.tags_for("DEU_A-1 \"x\""), typed);
        assert_eq!(both.all(), ["for_paper", "later", "odd"]);
        let one = Tags::change(&path, "USA_B-1", Vec::new()).unwrap();
        assert!(one.tags_for("USA_B-1").is_empty() && one.all().len() == 2);
        std::fs::write(&path, "a = [\"b\"]\nc = 3\n").unwrap();
        let error = Tags::change(&path, "a", Vec::new()).unwrap_err();
        assert!(error.contains("tags.toml: line 2"), "{error}");
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "a = [\"b\"]\nc = 3\n"
        );
    }
}
