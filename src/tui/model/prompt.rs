//! The prompt pane: which template is in use, its draft in the editor, and what comes of it.

use std::cell::RefCell;
use std::collections::HashMap;

use edtui::{EditorState, Lines};

use crate::evaluation::Question;
use crate::prompts::{Library, Template};
use crate::text::Frame;
use crate::verdict::Task;

/// What the prompt pane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PromptView {
    /// The messages as they would be sent.
    #[default]
    Rendered,
    /// The template.
    Template,
    /// The scene in words.
    Description,
}

impl PromptView {
    /// The next one.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Rendered => Self::Template,
            Self::Template => Self::Description,
            Self::Description => Self::Rendered,
        }
    }

    /// What it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rendered => "rendered",
            Self::Template => "template",
            Self::Description => "description",
        }
    }
}

/// The prompt pane.
#[derive(Default)]
pub struct PromptPane {
    /// What is shown.
    pub view: PromptView,
    /// How far it is scrolled.
    pub scroll: usize,
    /// Whether keys go to the editor.
    pub editing: bool,
    /// The question as it would be asked now, from the last template that could be filled.
    pub question: Option<Question>,
    /// What is wrong with the template.
    pub error: Option<String>,
    /// The file in the editor.
    file: String,
    /// Its text when it was loaded or saved.
    saved: String,
    /// Drafts of other files that are not saved, by file.
    drafts: HashMap<String, String>,
    /// The last draft that could be filled, with its file.
    good: Option<(String, String)>,
    /// The editor. Its view moves while it is drawn, hence the cell.
    pub editor: RefCell<EditorState>,
}

impl std::fmt::Debug for PromptPane {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PromptPane")
            .field("file", &self.file)
            .field("view", &self.view)
            .finish_non_exhaustive()
    }
}

impl PromptPane {
    /// Takes up the draft of a template that an earlier session left.
    pub fn take_up(&mut self, file: String, draft: String) {
        self.drafts.insert(file, draft);
    }

    /// Puts the template for a task and frame into the editor, unless it is there already.
    pub fn load(&mut self, library: &Library, task: Task, frame: Frame) {
        let Some((file, template)) = library.find(task.name(), frame.name()) else {
            return;
        };
        if file == self.file {
            return;
        }
        if let Some((file, draft)) = self.draft() {
            self.drafts.insert(file, draft);
        }
        let (file, template) = (file.to_string(), template.clone());
        let draft = self.drafts.remove(&file);
        self.put(file, &template, draft);
    }

    /// Takes the template of the current file from the library again; the draft is gone.
    pub fn reload(&mut self, library: &Library) {
        if let Some((template, _)) = library.file(&self.file.clone()) {
            self.put(self.file.clone(), &template.clone(), None);
        }
    }

    fn put(&mut self, file: String, template: &Template, draft: Option<String>) {
        self.saved.clone_from(&template.source);
        let text = draft.unwrap_or_else(|| template.source.clone());
        self.editor = RefCell::new(EditorState::new(Lines::from(text.as_str())));
        self.good = None;
        self.file = file;
    }

    /// The file in the editor.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The text in the editor.
    #[must_use]
    pub fn text(&self) -> String {
        self.editor.borrow().lines.to_string()
    }

    /// Whether the text differs from the saved one.
    #[must_use]
    pub fn is_draft(&self) -> bool {
        !self.file.is_empty() && self.text().trim_end() != self.saved.trim_end()
    }

    /// The file and text in the editor, if they differ from the saved ones.
    #[must_use]
    pub fn draft(&self) -> Option<(String, String)> {
        self.is_draft().then(|| (self.file.clone(), self.text()))
    }

    /// Remembers a draft that could be filled.
    pub(super) fn accept(&mut self, draft: Option<(String, String)>) {
        self.good = draft;
    }

    /// The last draft that could be filled.
    pub(super) fn good(&self) -> Option<(String, String)> {
        self.good.clone()
    }

    /// The text was saved.
    pub fn mark_saved(&mut self) {
        self.saved = self.text();
    }
}
