//! Edits templates: keys, and the round trip through the user's editor.

pub mod draw;
pub mod editor;
pub mod request;
pub mod saving;
pub mod state;

use crate::action::{Action, Scope};
use crate::features::Step;
use crate::features::prompt::request::KeepDraft;
use crate::keymap::{Code, Key, Keymap, editor_input, first_line};
use crate::layout;
use crate::message::{Effect, ExternalEdit, Mouse};
use crate::model::{Change, Editor, HEAVY, Model, Pane, PromptPane, PromptView};
use crate::update::keys;
use edtui::events::KeyInput;
use nearmiss_scene::description::visible;
use nearmiss_settings::Keys;
use ratatui::layout::Rect;

use editor::vim::NormalKey;
pub use saving::{reread, reset, saved};

/// Gives the keys to the editor.
pub fn begin(model: &mut Model) {
    if model.prompt.file().is_empty() {
        model.say("open a scenario with an ego first");
        return;
    }
    model.prompt.focus_before = Some(model.focus);
    model.focus = Pane::Prompt;
    model.prompt.view = PromptView::Template;
    model.prompt.beside = PromptView::Rendered;
    model.prompt.turned = false;
    model.prompt.scroll = 0;
    model.prompt.editing = true;
    // Where it last was, or where the words to the model begin.
    if model.prompt.editor.cursor() == (0, 0) {
        let line = first_line_of_system(model.prompt.editor.text());
        model.prompt.editor.go(line, 0, false);
    }
    model.compare();
}

/// The first line of the block of the system's message, behind the front matter.
fn first_line_of_system(text: &str) -> usize {
    let place = |sign: &str| text.lines().position(|line| line.contains(sign));
    place("block system").map_or_else(|| front_matter(text), |line| line + 1)
}

/// How many lines the front matter has, with those that enclose it.
pub fn front_matter(text: &str) -> usize {
    let mut lines = text.lines();
    if lines.next().map(str::trim) != Some("+++") {
        return 0;
    }
    lines
        .position(|line| line.trim() == "+++")
        .map_or(0, |at| at + 2)
}

/// Takes the keys back; the draft stays, also for the next start.
pub fn end(model: &mut Model) -> Vec<Effect> {
    model.prompt.editing = false;
    model.prompt.entry = None;
    let (line, _) = model.prompt.editor.cursor();
    model.prompt.scroll = line;
    model.prompt.editor.unselect();
    return_focus(model);
    if model.prompt.fill_in.is_some() {
        model.refill();
    }
    if model.prompt.error.is_some() {
        let edit = model.look.key(Action::Edit);
        model.say(format!(
            "the draft has an error: requests disabled until fixed; {edit} edits it"
        ));
    } else if model.prompt.is_draft() {
        let [edit, save, discard] = [Action::Edit, Action::SaveTemplate, Action::DiscardDraft]
            .map(|action| model.look.key(action));
        model.say(format!(
            "draft in use; {edit} then {save} saves it, {discard} discards it"
        ));
    }
    keep(model)
}

/// Gives the focus back to the pane that had it before editing.
fn return_focus(model: &mut Model) {
    if let Some(before) = model.prompt.focus_before.take()
        && model.focus == Pane::Prompt
    {
        model.focus = before;
    }
}

/// Keeps the drafts for the next start, or forgets those that were kept.
pub fn keep(model: &mut Model) -> Vec<Effect> {
    let mut drafts = model.prompt.unkept_drafts();
    let file = model.prompt.file().to_string();
    if !file.is_empty() && drafts.iter().all(|(kept, _)| *kept != file) {
        drafts.push((file, model.prompt.draft().map(|(_, text)| text)));
    }
    let keep = |(file, draft)| keep_draft(&model.prompt, file, draft);
    drafts.into_iter().map(keep).collect()
}

fn keep_draft(prompt: &PromptPane, file: String, draft: Option<String>) -> Effect {
    let found = prompt.found.get(&file).cloned();
    KeepDraft { file, draft, found }.into()
}

/// Time passes: drafts are kept, and heavy texts filled.
pub fn pass(model: &mut Model, seconds: f64) -> Vec<Effect> {
    if let Some(left) = &mut model.prompt.fill_in {
        *left -= seconds;
        if *left <= 0.0 {
            model.refill();
        }
    }
    let due = model.prompt.due(seconds);
    let keep = |(file, draft)| keep_draft(&model.prompt, file, draft);
    due.into_iter().map(keep).collect()
}

/// Heavy texts are rendered after this many seconds without a change.
const REST: f64 = 0.3;

/// The text in the editor changed.
fn edited(model: &mut Model) {
    model.prompt.note_change();
    if model.prompt.editor.text().len() > HEAVY {
        model.prompt.fill_in = Some(REST);
    } else {
        model.refill();
    }
}

/// A key while editing.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    if model.prompt.entry.is_some() {
        return saving::on_key(model, key);
    }
    if let Some(action) = command(&model.look.keymap, &model.prompt.editor, key) {
        model.prompt.editor.forget_pending();
        return vec![Effect::Step(Step::Perform(action))];
    }
    if model.prompt.turned && !model.prompt.fits_beside(model.size.0) {
        // Moving keys scroll the view in the editor's place; typing switches back to the editor.
        let moves = match key.code {
            Code::Up => Some(Action::Up),
            Code::Down => Some(Action::Down),
            Code::PageUp => Some(Action::PageUp),
            Code::PageDown => Some(Action::PageDown),
            _ => None,
        };
        if let Some(action) = moves {
            keys::scroll(model, Pane::Prompt, action);
            return Vec::new();
        }
        model.prompt.turned = false;
    }
    model.prompt.editor.at(model.uptime);
    if let (Code::Char(c), Keys::Vim) = (key.code, model.prompt.editor.keys())
        && model.prompt.editor.commands()
        && !model.prompt.editor.awaits()
        && !model.prompt.editor.is_pending()
    {
        match c {
            ':' => {
                saving::command(model);
                return Vec::new();
            }
            '*' | 'n' | 'N' => {
                match c {
                    '*' => saving::find_word(model),
                    _ => saving::find_again(model, c == 'n'),
                }
                return Vec::new();
            }
            _ => {}
        }
    }
    match typed(&mut model.prompt.editor, key) {
        EditOutcome::Changed => edited(model),
        EditOutcome::Full => model.say("not typed: the template has reached its limit of 1 MiB"),
        EditOutcome::Same => {}
    }
    copied(model)
}

/// Text copied in the editor goes to the terminal's clipboard too.
fn copied(model: &mut Model) -> Vec<Effect> {
    let text = model.prompt.editor.newly_copied();
    text.map(Effect::Copy).into_iter().collect()
}

/// Whether the pane is not among those that the screen has room for.
pub fn is_hidden(model: &Model) -> bool {
    let (columns, rows) = model.size;
    let parts = layout::split(Rect::new(0, 0, columns, rows), model);
    parts.is_some_and(|parts| parts.panes.iter().all(|(pane, _)| *pane != Pane::Prompt))
}

/// Performs a command of the editor.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    if !model.prompt.editing {
        let edit = model.look.key(Action::Edit);
        model.say(format!("{edit} opens the editor first"));
        return Vec::new();
    }
    let editor = &mut model.prompt.editor;
    match action {
        Action::EditDone => return end(model),
        Action::SaveTemplate => return saving::save(model),
        Action::SaveTemplateAs => saving::ask_name(model),
        Action::Find => saving::find(model),
        Action::GoToLine => saving::go_to_line(model),
        Action::Turn => turn(model),
        Action::Undo | Action::Redo => {
            let back = action == Action::Undo;
            if editor.undo(back) {
                edited(model);
            } else {
                model.say(if back {
                    "nothing to undo"
                } else {
                    "nothing to redo"
                });
            }
        }
        Action::Cut | Action::CopySelection => {
            let cut = action == Action::Cut;
            if !editor.copy(cut) {
                model.say("nothing selected: Shift with a motion selects");
            } else if cut {
                edited(model);
            }
        }
        Action::PasteCopied => {
            let text = editor.clipboard();
            insert(model, &text);
        }
        Action::SelectAll => editor.select_all(),
        _ => {}
    }
    copied(model)
}

/// Cycles the view beside the editor; without room beside it, the editor is one of the views.
fn turn(model: &mut Model) {
    let prompt = &mut model.prompt;
    prompt.scroll = 0;
    let narrow = !prompt.fits_beside(model.size.0);
    if narrow && !prompt.turned {
        prompt.turned = true;
        return;
    }
    prompt.beside = match prompt.beside {
        PromptView::Rendered => PromptView::Description,
        PromptView::Description => PromptView::Diff,
        PromptView::Diff if !model.answers.columns.is_empty() => PromptView::Answer,
        _ => {
            prompt.turned = false;
            PromptView::Rendered
        }
    };
}

/// Text from the terminal's clipboard: it goes where keys go.
pub fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
    if model.compare.open {
        if let Some(marking) = model.compare.marking.as_mut() {
            marking.text.push_str(&first_line(text));
        }
        return Vec::new();
    }
    if model.prompt.editing {
        if let Some(entry) = &mut model.prompt.entry {
            saving::paste(entry, text);
            return Vec::new();
        }
        let plain = text.replace("\r\n", "\n").replace('\r', "\n");
        let shown = visible(&plain);
        let signs = shown
            .chars()
            .zip(plain.chars())
            .filter(|(a, b)| a != b)
            .count();
        insert(model, &shown);
        if signs > 0 {
            model.say(format!("{signs} control characters pasted as symbols"));
        }
    } else if model.list.filtering.is_some() {
        return super::scenarios::paste(model, text);
    }
    Vec::new()
}

fn insert(model: &mut Model, text: &str) {
    match model.prompt.editor.insert(text) {
        Ok(()) => edited(model),
        Err(why) => model.complain(why),
    }
}

/// The mouse in the editor; nothing where it is elsewhere.
pub fn on_mouse(model: &mut Model, mouse: Mouse) -> bool {
    let editor = &mut model.prompt.editor;
    match mouse {
        Mouse::Press(at) => {
            editor.unselect();
            editor.go_to_cell(at.x, at.y, false)
        }
        Mouse::Drag(at) => editor.go_to_cell(at.x, at.y, true),
        Mouse::WheelUp(at) | Mouse::WheelDown(at) => {
            let inside = editor.is_at(at.x, at.y);
            if inside {
                let up = matches!(mouse, Mouse::WheelUp(_));
                editor.go_rows(if up { -3 } else { 3 }, false);
            }
            inside
        }
        Mouse::Release(_) => false,
    }
}

/// Effect of a key on the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum EditOutcome {
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
fn command(keymap: &Keymap, editor: &Editor, key: Key) -> Option<Action> {
    let letter = match key.code {
        Code::Char(c) => Some((c, key.ctrl, key.alt)),
        _ => None,
    };
    match (editor.keys(), letter) {
        (Keys::Vim, _) if key.code == Code::Esc => {
            (editor.commands() && !editor.is_pending()).then_some(Action::EditDone)
        }
        (Keys::Vim, Some((_, false, false))) if editor.is_pending() => None,
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
fn typed(editor: &mut Editor, key: Key) -> EditOutcome {
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
    if editor.commands() && !editor.awaits() {
        match key.code {
            Code::Char(c) if !key.ctrl && !key.alt => match editor.normal_key(c) {
                NormalKey::Taken => return EditOutcome::Same,
                NormalKey::Changed => return EditOutcome::Changed,
                NormalKey::Left => {}
            },
            _ if editor.forget_pending() && key.code == Code::Esc => return EditOutcome::Same,
            _ => {}
        }
    }
    if let (Code::Char(c), true) = (key.code, editor.commands()) {
        editor.await_after(c);
    }
    input(editor, key)
}

/// Opens the template in the user's editor; a copy of the prompt, where that is what has the keys.
pub fn open_outside(model: &mut Model) -> Vec<Effect> {
    let prompt = &model.prompt;
    if prompt.file().is_empty() {
        model.say("open a scenario with an ego first");
        return Vec::new();
    }
    let file = prompt.file().to_string();
    let looks = !prompt.editing && model.focus == Pane::Prompt;
    let copy = match (&prompt.question, prompt.view) {
        (Some(question), PromptView::Rendered) if looks => Some((
            "prompt.md",
            format!("{}\n\n{}\n", question.prompt.system, question.prompt.user),
        )),
        (Some(question), PromptView::Description) if looks => {
            Some(("description.md", question.description.clone()))
        }
        _ => None,
    };
    vec![Effect::EditOutside(match copy {
        Some((name, text)) => ExternalEdit {
            file: name.into(),
            text,
            copy: true,
            place: None,
        },
        None => ExternalEdit {
            file,
            text: prompt.text(),
            copy: false,
            place: None,
        },
    })]
}

/// Takes over what came back as the template; what went wrong changes nothing.
pub fn edited_outside(model: &mut Model, sent: ExternalEdit, result: Result<String, String>) {
    let text = match result {
        Ok(text) => text.replace("\r\n", "\n"),
        Err(why) => return model.complain(why),
    };
    if sent.copy {
        if text != sent.text {
            model.say("changes discarded: $EDITOR had a read-only copy");
        }
        return;
    }
    if sent.file != model.prompt.file() {
        return model.complain(format!(
            "changes from $EDITOR discarded: {} is no longer open",
            sent.file
        ));
    }
    if text == sent.text {
        return model.say("no changes");
    }
    model.prompt.editor.replace_all(&text);
    edited(model);
    let key = |action| model.look.keymap.key_in(action, Scope::Editor);
    let (undo, save) = (key(Action::Undo), key(Action::SaveTemplate));
    model.say(format!(
        "changes are a draft now; {undo} in the editor undoes them, {save} saves them"
    ));
}

/// Shows why the template cannot be used, at its place: says it, and goes there in the prompt pane, where editing
/// begins at it. Whether there is such an error.
pub fn show_error(model: &mut Model) -> bool {
    let Some(error) = model.prompt.error.clone() else {
        return false;
    };
    let prompt = &mut model.prompt;
    if !prompt.editing {
        model.focus = Pane::Prompt;
        prompt.view = PromptView::Template;
        prompt.scroll = 0;
    }
    if let Some(line) = prompt.error_line {
        prompt.editor.go(line.saturating_sub(1), 0, false);
        prompt.scroll = line.saturating_sub(1);
    }
    let edit = model.look.key(Action::Edit);
    model.complain(format!(
        "requests disabled until fixed: {error}; {edit} edits the template there"
    ));
    true
}
