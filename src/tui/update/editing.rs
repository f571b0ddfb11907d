//! Editing the template: keys go to the editor, the prompt follows every change.

use edtui::actions::{Execute, SwitchMode};
use edtui::events::KeyEventHandler;
use edtui::{EditorEventHandler, EditorMode};

use super::super::keymap::{Code, Key, editor_input};
use super::super::message::Effect;
use super::super::model::{Model, Overlay, Pane, PromptView};
use super::history;
use crate::prompts::{Library, Template};

/// Gives the keys to the editor.
pub fn begin(model: &mut Model) {
    if model.prompt.file().is_empty() {
        model.say("open a scenario with an ego first");
        return;
    }
    model.focus = Pane::Prompt;
    model.prompt.view = PromptView::Template;
    model.prompt.editing = true;
    SwitchMode(EditorMode::Insert).execute(&mut model.prompt.editor.borrow_mut());
}

/// Takes the keys back; the draft stays, also for the next start.
pub fn end(model: &mut Model) -> Vec<Effect> {
    model.prompt.editing = false;
    if model.prompt.error.is_some() {
        model.say("the draft cannot be filled yet; the last version that could be is in use");
    } else if model.prompt.is_draft() {
        model.say(
            "the draft is in use; e and Ctrl-S save it, the palette's reset-template discards it",
        );
    }
    keep(model).into_iter().collect()
}

/// Keeps the draft for the next start, or forgets the one that was kept.
pub fn keep(model: &Model) -> Option<Effect> {
    let file = model.prompt.file();
    let draft = model.prompt.draft().map(|(_, text)| text);
    (!file.is_empty()).then(|| Effect::KeepDraft(file.to_string(), draft))
}

/// A key while editing.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match key {
        Key {
            code: Code::Esc, ..
        } => return end(model),
        Key {
            code: Code::Char('s'),
            ctrl: true,
            ..
        } => return save(model),
        _ => {}
    }
    if let Some(input) = editor_input(key) {
        let mut handler = EditorEventHandler::new(KeyEventHandler::emacs_mode());
        handler.on_key_event(input, &mut model.prompt.editor.borrow_mut());
        model.refresh();
    }
    Vec::new()
}

/// Text from the terminal's clipboard.
pub fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
    if model.overlays.last() == Some(&Overlay::History) {
        return history::paste(model, text);
    }
    if model.prompt.editing {
        // A whole text at once: every character through the editor would be slow.
        let plain = text.replace("\r\n", "\n").replace('\r', "\n");
        let handler = EditorEventHandler::new(KeyEventHandler::emacs_mode());
        handler.on_paste_event(plain, &mut model.prompt.editor.borrow_mut());
        model.refresh();
    } else if model.list.filtering {
        let filter = format!(
            "{}{}",
            model.list.filter,
            text.lines().next().unwrap_or_default()
        );
        model.list.set_filter(filter);
        return super::open_current(model);
    } else if let Some(picker) = super::overlays::picker_mut(model) {
        picker
            .text
            .push_str(text.lines().next().unwrap_or_default());
    }
    Vec::new()
}

fn save(model: &mut Model) -> Vec<Effect> {
    if !model.prompt.is_draft() {
        model.say("nothing to save");
        return Vec::new();
    }
    let text = model.prompt.text();
    if let Err(error) = Template::read(&text) {
        model.complain(format!("not saved: {error}"));
        return Vec::new();
    }
    if let Some(error) = model.prompt.error.clone() {
        model.complain(format!("not saved: {error}"));
        return Vec::new();
    }
    vec![Effect::SaveTemplate(model.prompt.file().to_string(), text)]
}

/// A template was written or removed.
pub fn saved(
    model: &mut Model,
    file: &str,
    result: Result<(Library, String), String>,
) -> Vec<Effect> {
    match result {
        Ok((library, words)) => {
            model.library = library.or_last_good(&model.library);
            if file == model.prompt.file() {
                if model.prompt.editing {
                    model.prompt.mark_saved();
                } else {
                    model.prompt.reload(&model.library);
                }
            }
            model.tell(words);
            model.refresh();
            return keep(model).into_iter().collect();
        }
        Err(error) => model.complain(error),
    }
    Vec::new()
}

/// All templates were read again: broken ones are said, and stay as they were when they were good.
pub fn reread(model: &mut Model, library: Library) {
    model.library = library.or_last_good(&model.library);
    for problem in model.library.problems.clone() {
        model.complain(problem.to_string());
    }
    if !model.prompt.is_draft() {
        model.prompt.reload(&model.library);
    }
    model.say("the templates are read again");
    model.refresh();
}

/// Discards the draft and the user's copy.
pub fn reset(model: &mut Model) -> Vec<Effect> {
    let file = model.prompt.file().to_string();
    if file.is_empty() {
        return Vec::new();
    }
    model.prompt.editing = false;
    model.prompt.reload(&model.library);
    model.refresh();
    vec![Effect::RemoveTemplate(file)]
}
