//! Saves, selects and reloads templates.

use super::super::super::action::Action;
use super::super::super::message::Effect;
use super::super::super::model::Model;
use super::super::super::tasks::templates::KeepDraft;
use super::super::super::tasks::templates::{ChangeTemplate, TemplateChange};
use nearmiss_ask::prompts::{Library, Template, renamed, template_file};

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
    let text = good_text(model);
    text.map(|text| ChangeTemplate(file, TemplateChange::Save(text)).into())
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
                effects.push(KeepDraft(old, None).into());
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
