//! What users keep about scenarios: tags, and views of the list under a name.

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss_base::system::line_at;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Folders, TextFile};

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
        Ok(Self { of: read(path)? })
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
        write(path, &all.of)?;
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

/// What a file says of each name; without one there is nothing.
fn read<T: DeserializeOwned>(path: &Path) -> Result<BTreeMap<String, T>, String> {
    let Some(TextFile { file, text }) = TextFile::read_if_there(path)? else {
        return Ok(BTreeMap::new());
    };
    toml::from_str(&text).map_err(|error| {
        let line = line_at(&text, error.span().map_or(0, |span| span.start));
        format!("{file}: line {line}: {}", error.message())
    })
}

fn write<T: Serialize>(path: &Path, all: &BTreeMap<String, T>) -> Result<(), String> {
    let wrong = |why: String| format!("{}: {why}", path.display());
    let text = toml::to_string(all).map_err(|error| wrong(error.to_string()))?;
    Folders::write(path, &text).map_err(|error| wrong(nearmiss_base::system::error_text(&error)))
}

/// What the list shows, and how. What a file does not say is as at the start; what a newer version wrote stays.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct SavedView {
    /// The filter as it is typed.
    pub filter: String,
    /// The id of the sort order.
    pub sort: String,
    /// Whether the order is reversed.
    pub reversed: bool,
    /// By what it is grouped.
    pub group: String,
    #[serde(flatten)]
    other: toml::Table,
}

impl SavedView {
    /// A view with this filter, order and grouping.
    #[must_use]
    pub fn new(filter: &str, sort: &str, reversed: bool, group: &str) -> Self {
        Self {
            filter: filter.into(),
            sort: sort.into(),
            reversed,
            group: group.into(),
            other: toml::Table::new(),
        }
    }
}

/// Views by name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SavedViews(BTreeMap<String, SavedView>);

impl SavedViews {
    /// Reads the file; without one there are no views.
    ///
    /// # Errors
    /// It cannot be read or is damaged: with its name, and the line.
    pub fn read(path: &Path) -> Result<Self, String> {
        read(path).map(Self)
    }

    /// Saves a view under a name, or deletes it, in the file too: it is read anew, so that what others wrote meanwhile
    /// stays, and written whole.
    ///
    /// # Errors
    /// The file is damaged (it stays as it is then) or cannot be written.
    pub fn change(path: &Path, name: &str, view: Option<SavedView>) -> Result<Self, String> {
        let mut all = Self::read(path)?;
        match view {
            None => drop(all.0.remove(name)),
            Some(view) => drop(all.0.insert(name.to_string(), view)),
        }
        write(path, &all.0)?;
        Ok(all)
    }

    /// The view of a name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&SavedView> {
        self.0.get(name)
    }

    /// All views, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &SavedView)> {
        self.0.iter().map(|(name, view)| (name.as_str(), view))
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

    #[test]
    fn views_are_kept_with_what_newer_versions_wrote_and_a_damaged_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data/views.toml");
        assert_eq!(SavedViews::read(&path), Ok(SavedViews::default()));
        let view = SavedView::new("tag:cut_in risk<3", "ttc", true, "country");
        SavedViews::change(&path, "cut-ins, near", Some(view.clone())).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        // Another version knows more, and less.
        let newer = format!("{text}\n[other]\nfilter = \"a\"\ncolumns = [\"ttc\"]\n");
        std::fs::write(&path, newer).unwrap();
        let found = SavedViews::change(&path, "third", Some(SavedView::default())).unwrap();
        assert_eq!(found.get("cut-ins, near"), Some(&view));
        assert_eq!(found.get("other").map(|v| v.sort.as_str()), Some(""));
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("columns = [\"ttc\"]"), "{text}");
        let found = SavedViews::change(&path, "third", None).unwrap();
        assert_eq!(found.iter().count(), 2);
        std::fs::write(&path, "[a]\nfilter = 3\n").unwrap();
        let error = SavedViews::change(&path, "a", None).unwrap_err();
        assert!(error.contains("views.toml: line "), "{error}");
        let left = std::fs::read_to_string(&path).unwrap();
        assert_eq!(left, "[a]\nfilter = 3\n");
    }
}
