//! Template editing: forwards keys to the editor, updates the prompt on every change, keeps drafts.

mod entry;
mod keys;
mod outside;
mod saving;
mod template_error;

use super::super::action::Action;
use super::super::keymap::{Code, Key, first_line};
use super::super::message::{Effect, Mouse};
use super::super::model::{HEAVY, Model, Pane, PromptView};
use super::{menus, screens};
use crate::tasks::templates::KeepDraft;
use nearmiss_scene::description::visible;

pub use outside::{edited_outside, open_outside};
pub use saving::{reread, reset, saved};
pub use template_error::show_error;

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
    model.compare();
}

/// Takes the keys back; the draft stays, also for the next start.
pub fn end(model: &mut Model) -> Vec<Effect> {
    model.prompt.editing = false;
    model.prompt.entry = None;
    model.prompt.scroll = 0;
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
    let keep = |(file, draft)| KeepDraft(file, draft).into();
    drafts.into_iter().map(keep).collect()
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
    let keep = |(file, draft)| KeepDraft(file, draft).into();
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
        return entry::on_key(model, key);
    }
    if let Some(effects) = menus::on_key(model, key) {
        return effects;
    }
    if let Some(action) = keys::command(&model.look.keymap, &model.prompt.editor, key) {
        return super::actions::perform(model, action);
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
            super::actions::scroll(model, Pane::Prompt, action);
            return Vec::new();
        }
        model.prompt.turned = false;
    }
    model.prompt.editor.at(model.uptime);
    match keys::typed(&mut model.prompt.editor, key) {
        keys::EditOutcome::Changed => edited(model),
        keys::EditOutcome::Full => {
            model.say("not typed: the template has reached its limit of 1 MiB")
        }
        keys::EditOutcome::Same => {}
    }
    copied(model)
}

/// Text copied in the editor goes to the terminal's clipboard too.
fn copied(model: &mut Model) -> Vec<Effect> {
    let text = model.prompt.editor.newly_copied();
    text.map(Effect::Copy).into_iter().collect()
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
        Action::SaveTemplateAs => entry::save_as(model),
        Action::Find => entry::find(model),
        Action::GoToLine => entry::go_to_line(model),
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
        _ => {
            prompt.turned = false;
            PromptView::Rendered
        }
    };
}

/// Text from the terminal's clipboard: it goes where keys go.
pub fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
    if !model.screens.is_empty() {
        return screens::paste(model, text);
    }
    if model.compare.open {
        if let Some(marking) = model.compare.marking.as_mut() {
            marking.text.push_str(&first_line(text));
        }
        return Vec::new();
    }
    if model.prompt.editing {
        if let Some(entry) = &mut model.prompt.entry {
            entry::paste(entry, text);
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
        return super::filter::paste(model, text);
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
