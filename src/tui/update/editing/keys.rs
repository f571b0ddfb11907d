//! Editor keys: actions of the table, everything else by key style.

use edtui::events::KeyInput;

use super::super::super::action::{Action, Scope};
use super::super::super::keymap::{Code, Key, Keymap, editor_input};
use super::super::super::model::{Change, Editor};
use nearmiss_settings::Keys;

/// Effect of a key on the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EditOutcome {
    /// It is another one.
    Changed,
    /// It is the same; perhaps the cursor moved.
    Same,
    /// The text is full.
    Full,
}

impl From<bool> for EditOutcome {
    fn from(changed: bool) -> Self {
        if changed { Self::Changed } else { Self::Same }
    }
}

/// The command that a key is, for the editor's kind of keys.
pub fn command(keymap: &Keymap, editor: &Editor, key: Key) -> Option<Action> {
    let letter = match key.code {
        Code::Char(c) => Some((c, key.ctrl, key.alt)),
        _ => None,
    };
    match (editor.keys(), letter) {
        (Keys::Vim, _) if key.code == Code::Esc => editor.commands().then_some(Action::EditDone),
        (Keys::Vim, Some((c, false, false))) if editor.commands() && !editor.awaits() => match c {
            'u' => Some(Action::Undo),
            '/' => Some(Action::Find),
            _ => None,
        },
        (Keys::Vim, Some(('r', true, false))) if editor.commands() => Some(Action::Redo),
        (Keys::Emacs, Some((c, true, false))) => match c {
            's' => Some(Action::SaveTemplate),
            'u' | '_' | '7' | 'z' => Some(Action::Undo),
            'r' => Some(Action::Redo),
            'w' => Some(Action::Cut),
            'y' => Some(Action::PasteCopied),
            _ => None,
        },
        // A word forward; F3 switches the frame.
        (Keys::Emacs, Some(('f', false, true))) => None,
        _ => keymap.action(key, Scope::Editor),
    }
}

/// A key that is no command.
pub fn typed(editor: &mut Editor, key: Key) -> EditOutcome {
    if editor.keys() == Keys::Vim {
        return vim(editor, key);
    }
    let page = editor.drawn.borrow().rows.len().saturating_sub(1).max(1);
    let page = isize::try_from(page).unwrap_or(1);
    let emacs = editor.keys() == Keys::Emacs;
    match key.code {
        _ if key.writes().is_some() => return written(editor, key.writes()),
        Code::Enter => return written(editor, Some('\n')),
        Code::Tab => return written(editor, Some('\t')),
        Code::Backspace | Code::Delete if editor.erase() => return EditOutcome::Changed,
        Code::Up => editor.go_rows(-1, key.shift),
        Code::Down => editor.go_rows(1, key.shift),
        Code::Char('p') if emacs && key.ctrl => editor.go_rows(-1, false),
        Code::Char('n') if emacs && key.ctrl => editor.go_rows(1, false),
        Code::Char(' ') if emacs && key.ctrl => editor.mark(),
        Code::PageUp => editor.go_rows(-page, key.shift),
        Code::PageDown => editor.go_rows(page, key.shift),
        Code::Home if key.ctrl => editor.go(0, 0, key.shift),
        Code::End if key.ctrl => editor.go(usize::MAX, usize::MAX, key.shift),
        Code::Left | Code::Right | Code::Home | Code::End => {
            editor.selecting(key.shift);
            return input(editor, key);
        }
        _ => {
            editor.selecting(false);
            return input(editor, key);
        }
    }
    EditOutcome::Same
}

fn written(editor: &mut Editor, c: Option<char>) -> EditOutcome {
    match c {
        Some(c) if editor.write(c) => EditOutcome::Changed,
        _ => EditOutcome::Full,
    }
}

fn input(editor: &mut Editor, key: Key) -> EditOutcome {
    let change = match key.code {
        Code::Char(c) if editor.mode() == "insert" && key.writes().is_some() => Change::Typed(c),
        Code::Enter if editor.mode() == "insert" => Change::Typed('\n'),
        Code::Backspace | Code::Delete if !key.ctrl && !key.alt => Change::Erased,
        _ => Change::Whole,
    };
    editor_input(key).map_or(EditOutcome::Same, |input: KeyInput| {
        editor.input(input, change).into()
    })
}

fn vim(editor: &mut Editor, key: Key) -> EditOutcome {
    if editor.mode() == "insert" {
        let c = match key.code {
            Code::Enter => Some('\n'),
            Code::Tab => Some('\t'),
            _ => None,
        };
        // The crate remembers what is typed, to repeat it.
        if c == Some('\t') {
            return written(editor, c);
        }
    }
    if let (Code::Char(c), true) = (key.code, editor.commands()) {
        editor.await_after(c);
    }
    input(editor, key)
}
