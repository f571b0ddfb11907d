//! Two versions of a prompt over many scenarios: which versions, and their stored answers.

use super::Model;
use crate::message::JobId;
use nearmiss_ask::prompts::{Library, Origin};
use nearmiss_store::AskedTemplate;
use nearmiss_workflow::{ComparedAnswers, VersionChange, VersionComparison};

/// A version of the prompt for the task and frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PromptVersion {
    /// Its kind.
    pub kind: VersionKind,
    /// The template's file.
    pub file: String,
    /// SHA-256 of its text and of the fragments that it includes.
    pub hash: String,
}

/// Where the text of a version is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum VersionKind {
    /// With the program.
    Shipped,
    /// In the user's folder.
    Saved,
    /// In the editor, not saved.
    Draft,
    /// Nowhere any longer: it was asked with, and so many answers are stored.
    Stored(u64),
}

/// Letters of a hash that are shown.
const SHOWN: usize = 6;

impl PromptVersion {
    /// Its name: `collision-ego@3fa2c1`, or `draft@130d0c`.
    #[must_use]
    pub fn name(&self) -> String {
        let hash: String = self.hash.chars().take(SHOWN).collect();
        match self.kind {
            VersionKind::Draft => format!("draft@{hash}"),
            _ => format!("{}@{hash}", self.file.trim_end_matches(".md")),
        }
    }

    /// Its kind in words.
    #[must_use]
    pub fn origin(&self) -> String {
        match self.kind {
            VersionKind::Shipped => "shipped".into(),
            VersionKind::Saved => "saved".into(),
            VersionKind::Draft => format!("unsaved draft of {}", self.file),
            VersionKind::Stored(1) => "text gone, 1 stored answer".into(),
            VersionKind::Stored(n) => format!("text gone, {n} stored answers"),
        }
    }
}

/// The comparison of two versions.
#[derive(Debug, Default)]
pub struct VersionsView {
    /// The versions; `None` before two were chosen.
    pub sides: Option<[PromptVersion; 2]>,
    /// The lookup that is under way.
    pub job: Option<JobId>,
    /// Questions that it has made, of how many.
    pub looked: (usize, usize),
    /// The answers.
    pub found: Option<VersionComparison>,
    /// What the answers are of: versions, model, techniques and scenarios.
    pub of: String,
    /// The versions that the store knows.
    pub asked: Vec<AskedTemplate>,
    /// Why there are none.
    pub error: Option<String>,
    /// The selected scenario.
    pub selected: usize,
    /// The side that another version is being chosen for, and the selected one.
    pub choosing: Option<(usize, usize)>,
    /// Sides that are still to be proposed for asking.
    pub queue: Vec<usize>,
    /// The batch that was proposed last.
    pub proposed: Option<JobId>,
    /// Batches that ask what was missing.
    pub asking: Vec<JobId>,
    /// The two runs that are being read to stand side by side.
    pub pair: Option<JobId>,
    /// The runs that shall stand side by side once their scenario is open.
    pub beside: Option<[nearmiss_store::Run; 2]>,
    /// Rows of the table that were drawn last.
    pub rows: std::cell::Cell<usize>,
}

impl VersionsView {
    /// The scenarios with their answers.
    #[must_use]
    pub fn answers(&self) -> &[ComparedAnswers] {
        self.found.as_ref().map_or(&[], |found| &found.rows)
    }

    /// Whether one of its jobs has this id.
    #[must_use]
    pub fn owns(&self, id: JobId) -> bool {
        self.job == Some(id) || self.pair == Some(id)
    }

    /// Moves the selection by this many lines.
    pub fn move_by(&mut self, lines: isize, versions: usize) {
        if let Some((_, selected)) = &mut self.choosing {
            let last = versions.saturating_sub(1);
            *selected = selected.saturating_add_signed(lines).min(last);
            return;
        }
        let last = self.answers().len().saturating_sub(1);
        self.selected = self.selected.saturating_add_signed(lines).min(last);
    }

    /// Whether both answers of some scenario are there.
    #[must_use]
    pub fn compares(&self) -> bool {
        let mut rows = self.answers().iter();
        rows.any(|row| row.change() != VersionChange::Missing)
    }

    /// Goes to the next scenario whose answers differ; says whether there is one.
    pub fn next_change(&mut self) -> bool {
        let rows = self.answers();
        let differs = |at: &usize| {
            let same = [VersionChange::Same, VersionChange::Missing];
            !same.contains(&rows[*at].change())
        };
        let count = rows.len();
        let after = (1..=count).map(|n| (self.selected + n) % count);
        match after.into_iter().find(differs) {
            Some(at) => {
                self.selected = at;
                true
            }
            None => false,
        }
    }
}

impl Model {
    /// The versions of the prompt for the task and frame: the draft, the saved ones, the shipped one, and those that
    /// only the store knows.
    #[must_use]
    pub fn prompt_versions(&self) -> Vec<PromptVersion> {
        let mut found: Vec<PromptVersion> = Vec::new();
        let mut add = |kind, file: &str, hash: String| {
            if found.iter().all(|known| known.hash != hash) {
                let file = file.to_string();
                found.push(PromptVersion { kind, file, hash });
            }
        };
        if let Some((file, text)) = self.prompt.draft() {
            add(VersionKind::Draft, &file, self.library.hash(&text));
        }
        let (task, frame) = (self.task.name(), self.frame.name());
        for (file, template, origin) in self.library.candidates(task, frame) {
            let kind = match origin {
                Origin::Shipped => VersionKind::Shipped,
                Origin::User(_) => VersionKind::Saved,
            };
            add(kind, file, self.library.hash(&template.source));
        }
        if let Some((file, text)) = self.prompt.shipped() {
            add(VersionKind::Shipped, file, self.library.hash(text));
        }
        for stored in &self.versions.asked {
            let kind = VersionKind::Stored(stored.answers);
            add(kind, &stored.template, stored.hash.clone());
        }
        found
    }

    /// The text of a version as a draft of its file; nothing where the library uses it anyway, or its text is gone.
    #[must_use]
    pub fn draft_of(&self, version: &PromptVersion) -> Option<(String, String)> {
        let text = match version.kind {
            VersionKind::Draft => return self.prompt.draft(),
            VersionKind::Shipped => Library::shipped(&version.file).map(str::to_string),
            VersionKind::Saved => {
                let found = self.library.source(&version.file);
                found.map(|(text, _)| text.to_string())
            }
            VersionKind::Stored(_) => None,
        };
        let in_use = self.library.find(self.task.name(), self.frame.name());
        let same = |text: &String| {
            in_use.is_some_and(|(file, t)| file == version.file && t.source == *text)
        };
        let text = text.filter(|text| !same(text))?;
        Some((version.file.clone(), text))
    }
}
