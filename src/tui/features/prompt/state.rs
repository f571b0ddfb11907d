//! The prompt pane: the template in use, its draft in the editor, and the rendered messages.

use std::collections::{BTreeSet, HashMap};

use strum::{IntoStaticStr, VariantArray};

use crate::features::prompt::editor::{Editor, Find};
use crate::model::Pane;
use crate::model::question::Prices;
use nearmiss_ask::prompts::{Library, Prompt, Template};
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::Keys;
use nearmiss_study::evaluation::Question;

/// Views of the prompt pane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum PromptView {
    /// The messages as they would be sent.
    #[default]
    Rendered,
    /// The template.
    Template,
    /// The description of the scene.
    Description,
    /// Differences from the shipped template.
    Diff,
    /// The shown answer, with what changed since the one before.
    Answer,
}

nearmiss_record::named!(PromptView);

/// A line below the editor that is typed into.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EntryLine {
    /// A word to find.
    Find(Find),
    /// The number of a line to go to.
    Line(String),
    /// The name of a new template.
    SaveAs(String),
    /// A command of vim's.
    Command(String),
}

/// The prompt pane.
#[derive(Default)]
pub struct PromptPane {
    /// The current view.
    pub view: PromptView,
    /// How far it is scrolled.
    pub scroll: usize,
    /// Whether keys go to the editor.
    pub editing: bool,
    /// The pane that had the focus before editing.
    pub focus_before: Option<Pane>,
    /// The view beside the editor, or in its place without room beside it.
    pub beside: PromptView,
    /// Whether it stands in the editor's place.
    pub turned: bool,
    /// The line below the editor, while it is typed into.
    pub entry: Option<EntryLine>,
    /// The last search.
    pub sought: Find,
    /// The question as it would be asked now, from the last template that could be filled.
    pub question: Option<Question>,
    /// How many tokens it is, roughly.
    pub tokens: usize,
    /// The template's error.
    pub error: Option<String>,
    /// The line of the template that it is in, from 1.
    pub error_line: Option<usize>,
    /// The same question with the shipped template and its tokens, while the two are compared.
    pub shipped_question: Option<(usize, Prompt)>,
    /// Whether the program ended when this text was filled last, so that it waits for the user.
    pub held: bool,
    /// Token prices.
    pub prices: Prices,
    /// The file in the editor.
    file: String,
    /// The shipped template for the same: its name and text.
    shipped: Option<(&'static str, &'static str)>,
    /// Its text when it was loaded or saved.
    saved: String,
    /// Drafts of other files that are not saved, by file.
    drafts: HashMap<String, String>,
    /// Drafts that were found at the start, by file.
    pub found: HashMap<String, String>,
    /// Files whose drafts changed since they were last kept.
    unkept: BTreeSet<String>,
    /// Seconds until they are kept.
    keep_in: f64,
    /// Whether the last draft could not be kept for the next start.
    pub lost: bool,
    /// Seconds until a heavy text is filled again; `None` if nothing is due.
    pub fill_in: Option<f64>,
    /// The name and text under which a template is being saved.
    pub saving_as: Option<(String, String)>,
    /// The last draft that could be filled, with its file.
    good: Option<(String, String)>,
    /// The editor.
    pub editor: Editor,
}

/// The differences of two texts by lines, those that stand once in each first, so that no paragraph counts as changed for
/// the sake of blank lines; large ones are compared roughly after a while.
#[must_use]
pub fn diff_of<'t>(old: &'t str, new: &'t str) -> similar::TextDiff<'t, 't, 't, str> {
    similar::TextDiff::configure()
        .algorithm(similar::Algorithm::Patience)
        .timeout(std::time::Duration::from_millis(200))
        .diff_lines(old, new)
}

/// A line of two texts: whether it is in both, and its parts, each with whether it changed.
pub type ChangedLine = (similar::ChangeTag, Vec<(bool, String)>);

/// The lines of a change. Where some of their words stayed, only the others are changed.
#[must_use]
pub fn changed_lines<'d>(
    diff: &'d similar::TextDiff<'d, 'd, 'd, str>,
    op: &similar::DiffOp,
) -> Vec<ChangedLine> {
    let changes: Vec<_> = diff.iter_inline_changes(op).collect();
    let mut parts = changes.iter().flat_map(|change| change.values());
    let by_words = parts.any(|(changed, _)| *changed);
    let lines = changes.iter().map(|change| {
        let parts = change.iter_strings_lossy().map(|(changed, part)| {
            let ended = part.trim_end_matches(['\n', '\r']).to_string();
            (changed || !by_words, ended)
        });
        (change.tag(), parts.collect())
    });
    lines.collect()
}

/// What changed from a text to another one, kept across frames.
#[derive(Debug, Default)]
pub struct TextChanges {
    texts: (String, String),
    lines: Vec<ChangedLine>,
}

impl TextChanges {
    /// The lines of both texts, compared by words.
    pub fn lines(&mut self, old: &str, new: &str) -> &[ChangedLine] {
        if (self.texts.0.as_str(), self.texts.1.as_str()) != (old, new) {
            // The last line, which has no end, is the same as one in the middle.
            let [a, b] = [old, new].map(|text| format!("{}\n", text.trim()));
            let diff = diff_of(&a, &b);
            let ops = diff.ops().iter();
            self.lines = ops.flat_map(|op| changed_lines(&diff, op)).collect();
            self.texts = (old.into(), new.into());
        }
        &self.lines
    }
}

/// Columns from which on something fits beside the editor.
const SIDE_BY_SIDE_COLUMNS: u16 = 110;

/// Seconds after which a changed draft is saved.
const KEEP_AFTER: f64 = 0.8;

impl std::fmt::Debug for PromptPane {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PromptPane")
            .field("file", &self.file)
            .field("view", &self.view)
            .finish_non_exhaustive()
    }
}

impl PromptPane {
    /// A pane whose editor understands these keys.
    #[must_use]
    pub fn new(keys: Keys) -> Self {
        Self {
            editor: Editor::new(keys, ""),
            ..Self::default()
        }
    }

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
        self.lay_aside();
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
        let front = &template.front;
        self.shipped = Library::shipped_like(&file, &front.task, &front.frame);
        self.editor.load(&text);
        self.good = None;
        self.file = file;
    }

    /// Remembers the draft in the editor while another template is there.
    fn lay_aside(&mut self) {
        if let Some((file, draft)) = self.draft() {
            self.drafts.insert(file, draft);
        }
    }

    /// Files with drafts, the one in the editor included.
    #[must_use]
    pub fn drafted(&self) -> Vec<String> {
        let mut files: Vec<String> = self.drafts.keys().cloned().collect();
        files.extend(self.draft().map(|(file, _)| file));
        files.sort();
        files
    }

    /// The text in the editor changed: its draft is due to be kept.
    pub fn note_change(&mut self) {
        if self.unkept.is_empty() {
            self.keep_in = KEEP_AFTER;
        }
        self.unkept.insert(self.file.clone());
    }

    /// The shipped template for the same task and frame: its name and text.
    #[must_use]
    pub fn shipped(&self) -> Option<(&'static str, &'static str)> {
        self.shipped
    }

    /// The shipped template and the editor's text, to be compared; `None` without changes.
    #[must_use]
    pub fn compared(&self) -> Option<(&'static str, String)> {
        let (_, shipped) = self.shipped?;
        let text = self.editor.text().trim_end();
        (text != shipped.trim_end()).then(|| (shipped, format!("{text}\n")))
    }

    /// The changes of the editor's text to the shipped template, as a unified diff; `None` without changes.
    #[must_use]
    pub fn difference(&self) -> Option<String> {
        let (name, _) = self.shipped?;
        let (shipped, text) = self.compared()?;
        let difference = diff_of(shipped, &text);
        let header = (format!("shipped/{name}"), self.file.clone());
        Some(
            difference
                .unified_diff()
                .header(&header.0, &header.1)
                .to_string(),
        )
    }

    /// Whether a view fits beside the editor at this width.
    #[must_use]
    pub fn fits_beside(&self, columns: u16) -> bool {
        columns >= SIDE_BY_SIDE_COLUMNS
    }

    /// Whether something is due.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.fill_in.is_some() || !self.unkept.is_empty()
    }

    /// Time passes; gives the drafts that are due: files and texts, no text where the file has no draft any longer.
    pub fn due(&mut self, seconds: f64) -> Vec<(String, Option<String>)> {
        self.keep_in -= seconds;
        if self.unkept.is_empty() || self.keep_in > 0.0 {
            return Vec::new();
        }
        self.unkept_drafts()
    }

    /// The drafts that are not kept yet.
    pub fn unkept_drafts(&mut self) -> Vec<(String, Option<String>)> {
        let files = std::mem::take(&mut self.unkept);
        let draft = |file: String| {
            let text = if file == self.file {
                self.draft().map(|(_, text)| text)
            } else {
                self.drafts.get(&file).cloned()
            };
            (file, text)
        };
        files.into_iter().map(draft).collect()
    }

    /// The text in the editor is that of another file now, and saved as it was sent there.
    pub fn become_file(&mut self, file: String, sent: String) {
        self.drafts.remove(&file);
        self.good = None;
        // A name in the front matter may have changed on the way.
        if self.text() != sent {
            self.editor.replace_all(&sent);
        }
        self.saved = sent;
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
        self.editor.text().to_string()
    }

    /// Whether the text differs from the saved one.
    #[must_use]
    pub fn is_draft(&self) -> bool {
        !self.file.is_empty() && self.editor.text().trim_end() != self.saved.trim_end()
    }

    /// The file and text in the editor, if they differ from the saved ones.
    #[must_use]
    pub fn draft(&self) -> Option<(String, String)> {
        self.is_draft().then(|| (self.file.clone(), self.text()))
    }

    /// Remembers a draft that could be filled, but none in which a brace has just been opened: it is the beginning of a
    /// tag that is being typed.
    pub(crate) fn accept(&mut self, draft: Option<(String, String)>) {
        let open = |text: &str| text.matches('{').count() > text.matches('}').count();
        let is_half = |(_, text): &(String, String)| open(text) && !open(&self.saved);
        if !draft.as_ref().is_some_and(is_half) {
            self.good = draft;
        }
    }

    /// The last draft that could be filled.
    pub(crate) fn good(&self) -> Option<(String, String)> {
        self.good.clone()
    }

    /// The text as it was saved.
    #[must_use]
    pub fn saved(&self) -> &str {
        &self.saved
    }

    /// The text was saved.
    pub fn mark_saved(&mut self, text: &str) {
        self.saved = text.to_string();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draft_that_is_half_typed_is_no_good_one() {
        let mut pane = PromptPane::default();
        let draft = |text: &str| Some(("a.md".to_string(), text.to_string()));
        for (typed, good) in [
            ("{% if cp %} you", "{% if cp %} you"),
            ("{{% if cp %} you", "{% if cp %} you"),
            ("{{ x }}{% if cp %} you", "{{ x }}{% if cp %} you"),
        ] {
            pane.accept(draft(typed));
            assert_eq!(pane.good(), draft(good), "{typed}");
        }
        pane.accept(None);
        assert_eq!(pane.good(), None);
    }

    #[test]
    fn paragraphs_that_stay_are_no_changes() {
        use similar::ChangeTag;
        let mut changes = TextChanges::default();
        let (old, new) = ("one\n\ntwo\n\nlast", "two\n\none\n\nlast\n\nmore\n");
        let lines = changes.lines(old, new);
        let equal = |line: &&ChangedLine| line.0 == ChangeTag::Equal;
        let kept: Vec<&str> = lines
            .iter()
            .filter(equal)
            .map(|l| l.1[0].1.as_str())
            .collect();
        assert!(kept.contains(&"last"), "{lines:?}");
        let words = kept.iter().filter(|line| !line.is_empty()).count();
        assert_eq!(words, 2, "{lines:?}");
    }
}
