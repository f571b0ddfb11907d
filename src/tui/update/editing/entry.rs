//! The input line below the editor: search words, line numbers, names of new templates.

use super::super::super::keymap::{Code, Key, edit_line};
use super::super::super::message::Effect;
use super::super::super::model::{EntryLine, Find, Model, next};

/// Begins to search, from the word that was looked for last.
pub fn find(model: &mut Model) {
    let selected = model.prompt.editor.selected();
    let text = match selected.filter(|s| !s.contains('\n')) {
        Some(selected) => selected.to_string(),
        None => String::new(),
    };
    let from = model.prompt.editor.cursor();
    model.prompt.turned = false;
    model.prompt.entry = Some(EntryLine::Find(Find { text, from }));
}

/// Begins to go to a line.
pub fn go_to_line(model: &mut Model) {
    model.prompt.turned = false;
    model.prompt.entry = Some(EntryLine::Line(String::new()));
}

/// Begins to save under a new name.
pub fn save_as(model: &mut Model) {
    let stem = model.prompt.file().trim_end_matches(".md");
    model.prompt.entry = Some(EntryLine::SaveAs(format!("{stem}-")));
}

/// Text that is pasted into the line: up to its first line break, without control characters.
pub fn paste(entry: &mut EntryLine, text: &str) {
    let line = text.lines().next().unwrap_or_default();
    written(entry).extend(line.chars().filter(|c| !c.is_control()));
}

fn written(entry: &mut EntryLine) -> &mut String {
    match entry {
        EntryLine::Find(find) => &mut find.text,
        EntryLine::Line(text) | EntryLine::SaveAs(text) => text,
    }
}

/// A key while the line is typed into.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    let Some(entry) = &mut model.prompt.entry else {
        return Vec::new();
    };
    let finds = matches!(entry, EntryLine::Find(_));
    let again = matches!(key.code, Code::Char('f' | 's' | 'g' | 'n')) && key.ctrl;
    let back = matches!(key.code, Code::Char('p' | 'r')) && key.ctrl;
    match key.code {
        Code::Esc => close(model),
        Code::Enter if finds && key.shift => step(model, false),
        Code::Enter if finds => return found(model),
        Code::Enter => return entered(model),
        Code::Down if finds => step(model, true),
        Code::Up if finds => step(model, false),
        _ if finds && again => step(model, true),
        _ if finds && back => step(model, false),
        _ => {
            if edit_line(written(entry), key) {
                first(model);
            }
        }
    }
    Vec::new()
}

/// Goes to the first place at or after where the search began.
fn first(model: &mut Model) {
    let Some(EntryLine::Find(find)) = &model.prompt.entry else {
        return;
    };
    let places = find.places(&model.prompt.editor);
    let from = find.from;
    let at = places.iter().find(|&&at| at >= from).or(places.first());
    let (row, col) = at.copied().unwrap_or(from);
    model.prompt.editor.go(row, col, false);
}

/// Goes to the next place, or the one before.
fn step(model: &mut Model, forward: bool) {
    let Some(EntryLine::Find(find)) = &mut model.prompt.entry else {
        return;
    };
    if find.text.is_empty() {
        // Once more what was looked for last.
        find.text.clone_from(&model.prompt.sought.text);
    }
    let find = find.clone();
    go(model, &find, forward);
}

fn go(model: &mut Model, find: &Find, forward: bool) {
    let places = find.places(&model.prompt.editor);
    let cursor = model.prompt.editor.cursor();
    match next(&places, cursor, forward) {
        Some(place) => {
            let (row, col) = places[place];
            model.prompt.editor.go(row, col, false);
        }
        None => model.say(format!("`{}` is not in the template", find.text)),
    }
}

/// Stays at the match; on an empty line, jumps to the next match of the last search.
fn found(model: &mut Model) -> Vec<Effect> {
    let Some(EntryLine::Find(find)) = model.prompt.entry.take() else {
        return Vec::new();
    };
    if find.text.is_empty() {
        let last = model.prompt.sought.clone();
        if !last.text.is_empty() {
            go(model, &last, true);
        }
        return Vec::new();
    }
    if find.places(&model.prompt.editor).is_empty() {
        model.say(format!("`{}` is not in the template", find.text));
    }
    model.prompt.sought = find;
    Vec::new()
}

/// Goes back to where the search began.
fn close(model: &mut Model) {
    if let Some(EntryLine::Find(find)) = model.prompt.entry.take() {
        model.prompt.editor.go(find.from.0, find.from.1, false);
    }
}

fn entered(model: &mut Model) -> Vec<Effect> {
    match model.prompt.entry.take() {
        Some(EntryLine::Line(text)) => {
            let lines = model.prompt.editor.line_count();
            match text.trim().parse::<usize>() {
                Ok(line @ 1..) => model.prompt.editor.go(line.min(lines) - 1, 0, false),
                _ => model.say(format!(
                    "`{text}` is not a line number; the template has lines 1 to {lines}"
                )),
            }
            Vec::new()
        }
        Some(EntryLine::SaveAs(name)) => super::saving::save_as(model, &name),
        _ => Vec::new(),
    }
}
