//! Saves, names, selects and reloads templates.

use nearmiss_ask::prompts::{Library, Origin, Template, renamed, template_file};
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::{Action, Scope};
use crate::features::Step;
use crate::features::picker::Choice;
use crate::features::prompt::request::{ChangeTemplate, TemplateChange};
use crate::keymap::{Code, Key, edit_line};
use crate::message::Effect;
use crate::model::{EntryLine, Find, Model, Picker, next, templates_shown};
use crate::widgets::{picker, window};

/// The text in the editor, if it is a template that can be filled.
fn good_text(model: &mut Model) -> Option<String> {
    if model.prompt.fill_in.is_some() {
        model.refill();
    }
    let text = model.prompt.text();
    let error = Template::read(&text).err().map(|e| e.to_string());
    match error.or_else(|| model.prompt.error.clone()) {
        Some(error) => {
            model.complain(format!("not saved: {error}"));
            None
        }
        None => Some(text),
    }
}

/// Saves the template in the editor as the user's.
pub fn save(model: &mut Model) -> Vec<Effect> {
    if !model.prompt.is_draft() {
        model.say("nothing to save");
        return Vec::new();
    }
    let file = model.prompt.file().to_string();
    let from = model.prompt.saved().to_string();
    let text = good_text(model);
    text.map(|text| ChangeTemplate(file, TemplateChange::Save { text, from }).into())
        .into_iter()
        .collect()
}

/// Saves it under a new name.
pub fn save_as(model: &mut Model, name: &str) -> Vec<Effect> {
    let file = match template_file(name) {
        Ok(file) => file,
        Err(why) => {
            model.complain(format!("not saved: {why}"));
            return Vec::new();
        }
    };
    if model.library.source(&file).is_some() || Library::shipped(&file).is_some() {
        let key = model.look.key(Action::SaveTemplate);
        model.complain(format!(
            "not saved: {file} exists already; choose another name, or press {key} to save {}",
            model.prompt.file()
        ));
        return Vec::new();
    }
    let Some(text) = good_text(model) else {
        return Vec::new();
    };
    let text = renamed(&text, &file);
    model.prompt.saving_as = Some((file.clone(), text.clone()));
    vec![ChangeTemplate(file, TemplateChange::SaveAs(text)).into()]
}

/// A template was written or removed, or another one chosen.
pub fn saved(
    model: &mut Model,
    file: &str,
    result: Result<(Library, String), String>,
) -> Vec<Effect> {
    let sent = model.prompt.saving_as.take_if(|(to, _)| to == file);
    match result {
        Ok((library, words)) => {
            model.library = library.or_last_good(&model.library);
            let mut effects = Vec::new();
            if let Some((file, text)) = sent {
                // The draft went into the new file.
                let old = model.prompt.file().to_string();
                effects.push(super::keep_draft(&model.prompt, old, None));
                model.prompt.become_file(file, text);
            } else if file == model.prompt.file() {
                if model.prompt.editing {
                    let saved = model.library.source(file).map(|(text, _)| text.to_string());
                    model.prompt.mark_saved(&saved.unwrap_or_default());
                } else {
                    model.prompt.reload(&model.library);
                }
            }
            model.tell(words);
            model.refresh();
            effects.extend(super::keep(model));
            return effects;
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
    model.say("templates reread");
    model.refresh();
}

/// Takes the draft and the user's copy out of use; both are kept beside it.
pub fn reset(model: &mut Model) -> Vec<Effect> {
    let file = model.prompt.file().to_string();
    if file.is_empty() {
        return Vec::new();
    }
    let draft = model.prompt.draft().map(|(_, text)| text);
    model.prompt.editing = false;
    super::return_focus(model);
    model.prompt.reload(&model.library);
    model.refresh();
    vec![ChangeTemplate(file, TemplateChange::Remove(draft)).into()]
}

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

/// Begins a command of vim's.
pub fn command(model: &mut Model) {
    model.prompt.turned = false;
    model.prompt.entry = Some(EntryLine::Command(String::new()));
}

/// What `:` and these characters do.
fn run_command(model: &mut Model, text: &str) -> Vec<Effect> {
    let leave = |model: &mut Model| super::end(model);
    match text {
        "" => Vec::new(),
        "w" | "write" => save(model),
        "q" | "quit" => leave(model),
        "q!" | "quit!" => {
            model.prompt.reload(&model.library);
            model.refresh();
            leave(model)
        }
        "x" | "wq" | "x!" | "wq!" => {
            let mut effects = save(model);
            effects.extend(leave(model));
            effects
        }
        _ if text.chars().all(|c| c.is_ascii_digit()) => {
            let line: usize = text.parse().unwrap_or(usize::MAX);
            model.prompt.editor.go(line.saturating_sub(1), 0, false);
            Vec::new()
        }
        _ => {
            model.complain(format!(
                "no command `:{text}`; :w saves, :q leaves with the draft in use, :q! without it, :x and :wq save and leave, :N goes to line N"
            ));
            Vec::new()
        }
    }
}

/// Goes to the next place, or the one before, of what was looked for last.
pub fn find_again(model: &mut Model, forward: bool) {
    let last = model.prompt.sought.clone();
    if last.text.is_empty() {
        return model.say("nothing was looked for yet");
    }
    go(model, &last, forward);
}

/// Looks for the word under the cursor.
pub fn find_word(model: &mut Model) {
    let from = model.prompt.editor.cursor();
    if let Some(text) = model.prompt.editor.word() {
        model.prompt.sought = Find { text, from };
        find_again(model, true);
    }
}

/// Begins to save under a new name.
pub fn ask_name(model: &mut Model) {
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
        EntryLine::Line(text) | EntryLine::SaveAs(text) | EntryLine::Command(text) => text,
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
        Some(EntryLine::Command(text)) => run_command(model, text.trim()),
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
        Some(EntryLine::SaveAs(name)) => save_as(model, &name),
        _ => Vec::new(),
    }
}

/// Templates by file.
#[derive(Debug)]
pub struct Templates;

impl Choice for Templates {
    fn count(&self, model: &Model, picker: &Picker) -> usize {
        templates_shown(model, picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = templates_shown(model, picker);
        let Some(file) = shown.into_iter().nth(picker.selected) else {
            return Step::close();
        };
        if model.library.in_use(&file) {
            model.say(format!("{file} is in use already"));
            return Step::close();
        }
        Step::Close(vec![ChangeTemplate(file, TemplateChange::Use).into()])
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let title = format!("templates · {} · {}", model.task.name(), model.frame.name());
        let inner = window::window(frame, screen, model, &title, (92, 18));
        let drafts = model.prompt.drafted();
        let rows = templates_shown(model, picker).into_iter().map(|file| {
            let sign = if model.library.in_use(&file) {
                "* "
            } else {
                "  "
            };
            let draft = if drafts.contains(&file) {
                ", with a draft"
            } else {
                ""
            };
            let from = match model.library.file(&file) {
                Some((_, Origin::Shipped)) => "shipped",
                _ if Library::shipped(&file).is_some() => "yours, overrides the shipped one",
                _ => "yours",
            };
            (format!("{sign}{file}"), format!("{from}{draft}"))
        });
        picker::draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
        let key = model
            .look
            .keymap
            .key_in(Action::SaveTemplateAs, Scope::Editor);
        let words = format!("* in use; {key} in the editor makes a new one");
        picker::hint(frame, inner, model, &words);
    }
}
