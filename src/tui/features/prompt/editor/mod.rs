//! The text editor: lines, cursor, selection, undo history and key style.

pub mod moving;
pub mod vim;

use std::cell::{Cell, RefCell};
use std::ops::Range;
use std::rc::Rc;
use std::time::Duration;

use edtui::actions::{Execute, InsertChar, LineBreak};
use edtui::clipboard::ClipboardTrait;
use edtui::events::KeyInput;
use edtui::{EditorEventHandler, EditorMode, EditorState, Index2, Lines};
use nearmiss_settings::Keys;
use unicode_width::UnicodeWidthChar;

use moving::History;

pub use moving::{Change, Find, next};

/// Larger texts are no templates, bytes.
pub const LARGEST: usize = 1 << 20;

/// A text that is edited.
pub struct Editor {
    state: EditorState,
    handler: EditorEventHandler,
    keys: Keys,
    /// The lines as one text, as of the last change.
    text: String,
    history: History,
    /// The time of the last key: a pause between two begins a new step of undo.
    now: Duration,
    /// Where the selection begins; vim's own is in the state.
    anchor: Option<Index2>,
    /// Whether motions keep the selection.
    marking: bool,
    /// Whether vim's next key is the object of a motion such as `f`, and no command.
    awaiting: bool,
    /// What of a command of vim's normal mode was typed.
    pending: vim::Pending,
    /// What `.` repeats.
    last_change: vim::LastChange,
    clip: Rc<RefCell<Clip>>,
    /// The first line that is shown; it follows the cursor when the text is drawn.
    pub top: Cell<usize>,
    /// The rows last drawn.
    pub drawn: RefCell<EditorDrawn>,
    /// Cached styles of its characters.
    pub styles: RefCell<Styles>,
}

impl Default for Editor {
    fn default() -> Self {
        Self::new(Keys::Plain, "")
    }
}

fn lines(text: &str) -> Lines {
    let rows: Vec<Vec<char>> = text.split('\n').map(|l| l.chars().collect()).collect();
    Lines::new(rows)
}

impl Editor {
    /// An editor of a text.
    #[must_use]
    pub fn new(keys: Keys, text: &str) -> Self {
        let clip = Rc::new(RefCell::new(Clip::default()));
        let mut editor = Self {
            state: EditorState::default(),
            handler: match keys {
                Keys::Vim => EditorEventHandler::vim_mode(),
                Keys::Plain | Keys::Emacs => EditorEventHandler::emacs_mode(),
            },
            keys,
            text: String::new(),
            history: History::default(),
            now: Duration::ZERO,
            anchor: None,
            marking: false,
            awaiting: false,
            pending: vim::Pending::default(),
            last_change: vim::LastChange::default(),
            clip,
            top: Cell::new(0),
            drawn: RefCell::default(),
            styles: RefCell::default(),
        };
        editor.put(text.to_string(), Index2::new(0, 0));
        editor
    }

    /// Another text, with nothing to undo.
    pub fn load(&mut self, text: &str) {
        self.history = History::default();
        self.top.set(0);
        self.put(text.to_string(), Index2::new(0, 0));
    }

    /// Puts a text in place, with the cursor near a place. What the crate keeps of earlier texts goes.
    fn put(&mut self, text: String, cursor: Index2) {
        let mode = self.state.mode;
        self.state = EditorState::new(lines(&text));
        self.state.set_clipboard(Shared(self.clip.clone()));
        self.state.mode = match (self.keys, mode) {
            (Keys::Vim, EditorMode::Insert) => EditorMode::Insert,
            (Keys::Vim, _) => EditorMode::Normal,
            _ => EditorMode::Insert,
        };
        self.state.cursor = cursor;
        self.text = text;
        self.anchor = None;
        self.marking = false;
        self.clamp();
    }

    /// Which keys it understands.
    #[must_use]
    pub fn keys(&self) -> Keys {
        self.keys
    }

    /// The text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The lines of the text.
    pub fn lines(&self) -> impl Iterator<Item = &Vec<char>> {
        self.state.lines.iter_row()
    }

    /// How many lines there are.
    #[must_use]
    pub fn line_count(&self) -> usize {
        self.state.lines.len().max(1)
    }

    /// Line and column of the cursor, from 0.
    #[must_use]
    pub fn cursor(&self) -> (usize, usize) {
        (self.state.cursor.row, self.state.cursor.col)
    }

    /// The current key mode, in a word.
    #[must_use]
    pub fn mode(&self) -> &'static str {
        match (self.keys, self.state.mode) {
            (Keys::Vim, EditorMode::Normal) => "normal",
            (Keys::Vim, EditorMode::Visual) => "visual",
            (Keys::Vim, _) => "insert",
            _ if self.selection().is_some() => "select",
            _ => "insert",
        }
    }

    /// Whether keys are commands and do not write.
    #[must_use]
    pub fn commands(&self) -> bool {
        self.state.mode == EditorMode::Normal
    }

    /// The selection, without the place of its end.
    #[must_use]
    pub fn selection(&self) -> Option<(Index2, Index2)> {
        if let Some(selection) = &self.state.selection {
            let (start, mut end) = (selection.start(), selection.end());
            if selection.line_mode {
                let last = self.state.lines.len_col(end.row).unwrap_or(0);
                return Some((Index2::new(start.row, 0), Index2::new(end.row, last)));
            }
            end.col += 1;
            return Some((start, end));
        }
        let (a, b) = (self.anchor?, self.state.cursor);
        let ordered = if a < b { (a, b) } else { (b, a) };
        (a != b).then_some(ordered)
    }

    /// The selected text.
    #[must_use]
    pub fn selected(&self) -> Option<&str> {
        let (start, end) = self.selection()?;
        self.text.get(self.byte(start)..self.byte(end))
    }

    /// The byte of a place in the text.
    fn byte(&self, place: Index2) -> usize {
        let mut start = 0;
        for (row, line) in self.text.split('\n').enumerate() {
            if row == place.row {
                let inside = line.char_indices().nth(place.col);
                return start + inside.map_or(line.len(), |(at, _)| at);
            }
            start += line.len() + 1;
        }
        self.text.len()
    }

    /// The place of a byte of the text.
    fn place(text: &str, byte: usize) -> Index2 {
        let before = &text[..byte];
        let line = before.rfind('\n').map_or(0, |at| at + 1);
        let row = before.matches('\n').count();
        Index2::new(row, before[line..].chars().count())
    }

    pub(crate) fn clamp(&mut self) {
        if self.state.lines.is_empty() {
            self.state.lines = lines("");
        }
        let cursor = &mut self.state.cursor;
        cursor.row = cursor.row.min(self.state.lines.len().saturating_sub(1));
        let length = self.state.lines.len_col(cursor.row).unwrap_or(0);
        let last = match self.state.mode {
            EditorMode::Normal => length.saturating_sub(1),
            _ => length,
        };
        cursor.col = cursor.col.min(last);
    }

    /// Notes the time, for undo.
    pub fn at(&mut self, now: Duration) {
        self.now = now;
    }

    /// Gives a key to the crate, which makes this change if any; says whether the text changed.
    pub fn input(&mut self, input: KeyInput, change: Change) -> bool {
        let before = self.state.cursor;
        let rows = self.drawn.borrow().rows.len();
        self.state.set_viewport_height(rows.max(2));
        self.handler.on_key_event(input, &mut self.state);
        let changed = self.changed(before, change);
        if !changed && self.state.cursor != before {
            self.history.rest();
        }
        changed
    }

    /// Whether vim's next key is the object of a motion, and no command.
    #[must_use]
    pub fn awaits(&self) -> bool {
        self.awaiting
    }

    /// Notes a key of vim's normal mode: after some of them the next one is no command.
    pub fn await_after(&mut self, c: char) {
        self.awaiting = !self.awaiting && matches!(c, 'f' | 't');
    }

    /// Takes over what was changed in the lines; says whether anything was.
    fn changed(&mut self, before: Index2, change: Change) -> bool {
        self.clamp();
        let mut text = String::with_capacity(self.text.len() + 1);
        for (row, line) in self.state.lines.iter_row().enumerate() {
            if row > 0 {
                text.push('\n');
            }
            text.extend(line);
        }
        if text == self.text {
            return false;
        }
        let old = std::mem::replace(&mut self.text, text);
        let cursors = (before, self.state.cursor);
        self.history.record(old, cursors, change, self.now);
        if self.text.len() > HEAVY {
            // The crate keeps a hundred copies of the lines, which nothing uses here.
            let top = self.top.get();
            let text = std::mem::take(&mut self.text);
            self.put(text, self.state.cursor);
            self.top.set(top);
        }
        true
    }

    /// Writes a character at the cursor, over the selection.
    pub fn write(&mut self, c: char) -> bool {
        if self.text.len() + c.len_utf8() > LARGEST {
            return false;
        }
        self.erase();
        let before = self.state.cursor;
        if c == '\n' {
            LineBreak(1).execute(&mut self.state);
        } else {
            InsertChar(c).execute(&mut self.state);
        }
        self.changed(before, Change::Typed(c))
    }

    /// Writes a text at the cursor, over the selection, all at once: character by character, long ones would take
    /// seconds.
    ///
    /// # Errors
    /// The text would be too large.
    pub fn insert(&mut self, text: &str) -> Result<(), String> {
        let whole = self.text.len() + text.len() - self.selected().map_or(0, str::len);
        if whole > LARGEST {
            return Err(format!(
                "not pasted: with these {} characters the template would be larger than 1 MiB",
                text.chars().count()
            ));
        }
        let (start, end) = self
            .selection()
            .unwrap_or((self.state.cursor, self.state.cursor));
        self.splice(self.byte(start)..self.byte(end), text);
        Ok(())
    }

    fn splice(&mut self, range: std::ops::Range<usize>, with: &str) {
        let mut text = self.text.clone();
        text.replace_range(range.clone(), with);
        let cursor = Self::place(&text, range.start + with.len());
        self.replace(text, cursor);
    }

    /// Puts another text in place, which can be undone.
    pub fn replace_all(&mut self, text: &str) {
        let cursor = self.state.cursor;
        self.replace(text.to_string(), cursor);
    }

    fn replace(&mut self, text: String, cursor: Index2) {
        if text == self.text {
            return;
        }
        let before = self.state.cursor;
        let old = std::mem::take(&mut self.text);
        self.put(text, cursor);
        let cursors = (before, self.state.cursor);
        self.history.record(old, cursors, Change::Whole, self.now);
    }

    /// Takes the selected text away; says whether there was any.
    pub fn erase(&mut self) -> bool {
        let Some((start, end)) = self.selection() else {
            return false;
        };
        self.splice(self.byte(start)..self.byte(end), "");
        true
    }

    /// Remembers the selected text for pasting, and takes it away if it is `cut`.
    pub fn copy(&mut self, cut: bool) -> bool {
        let Some(text) = self.selected().map(str::to_string) else {
            return false;
        };
        Shared(self.clip.clone()).set_text(text);
        if cut {
            self.erase();
        } else {
            self.unselect();
        }
        true
    }

    /// The text last copied here.
    #[must_use]
    pub fn clipboard(&self) -> String {
        self.clip.borrow().text.clone()
    }

    /// Text copied since the last call.
    pub fn newly_copied(&mut self) -> Option<String> {
        let mut clip = self.clip.borrow_mut();
        std::mem::take(&mut clip.fresh).then(|| clip.text.clone())
    }

    /// Goes back by a step, or forward again; says whether there was one.
    pub fn undo(&mut self, back: bool) -> bool {
        let now = (self.text.clone(), self.state.cursor);
        let Some((text, cursor)) = self.history.step(back, now) else {
            return false;
        };
        self.put(text, cursor);
        true
    }
}

/// Texts from here on are handled with care for memory and time, bytes.
pub const HEAVY: usize = 100_000;

/// Position of the text on the screen.
#[derive(Debug, Default, Clone)]
pub struct EditorDrawn {
    /// Cells of the text, without line numbers: column, row, columns, rows.
    pub area: (u16, u16, u16, u16),
    /// For each row its line, and the range of its characters.
    pub rows: Vec<(usize, std::ops::Range<usize>)>,
}

/// Styles of characters, by line from one on, and for which text and colours they hold.
#[derive(Debug, Default)]
pub struct Styles {
    /// Stands for the text and the colours.
    pub of: u64,
    /// The first line.
    pub from: usize,
    /// A style for each character.
    pub lines: Vec<Vec<ratatui::style::Style>>,
}

/// The clipboard inside the program, and whether something was put into it since it was last asked.
#[derive(Default)]
struct Clip {
    /// Its text.
    pub text: String,
    /// Whether that is new.
    pub fresh: bool,
}

/// The clipboard as the crate takes it.
struct Shared(pub Rc<RefCell<Clip>>);

impl ClipboardTrait for Shared {
    fn set_text(&mut self, text: String) {
        let mut clip = self.0.borrow_mut();
        clip.text = text;
        clip.fresh = true;
    }

    fn get_text(&mut self) -> String {
        self.0.borrow().text.clone()
    }
}

/// Columns of a tab.
const TAB: usize = 4;

/// Columns that a character takes; what cannot be shown takes the one of its sign.
#[must_use]
pub fn width_of(c: char) -> usize {
    match c {
        '\t' => TAB,
        _ => c.width().unwrap_or(1),
    }
}

/// The characters of each row of the screen; at least one row, and none is empty but that of an empty line.
#[must_use]
pub fn rows(line: &[char], width: usize) -> Vec<Range<usize>> {
    let width = width.max(TAB);
    let mut rows = Vec::new();
    let (mut start, mut used, mut space) = (0, 0, None);
    for (i, &c) in line.iter().enumerate() {
        let wide = width_of(c);
        if used + wide > width {
            let end = space.filter(|&at| at > start).unwrap_or(i);
            rows.push(start..end);
            start = end;
            used = line[start..i].iter().map(|&c| width_of(c)).sum();
            space = None;
        }
        used += wide;
        if c == ' ' {
            space = Some(i + 1);
        }
    }
    rows.push(start..line.len());
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrapped(text: &str, width: usize) -> Vec<String> {
        let line: Vec<char> = text.chars().collect();
        let rows = rows(&line, width);
        rows.into_iter().map(|r| line[r].iter().collect()).collect()
    }

    #[test]
    fn between_words_and_inside_long_ones() {
        assert_eq!(wrapped("", 10), [""]);
        assert_eq!(wrapped("one two three", 8), ["one two ", "three"]);
        assert_eq!(wrapped("abcdefghij", 4), ["abcd", "efgh", "ij"]);
        assert_eq!(wrapped("漢字漢字", 5), ["漢字", "漢字"]);
        assert_eq!(wrapped("a\tb", 5), ["a\t", "b"]);
    }
}
