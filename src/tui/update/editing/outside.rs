//! Round trip of a template through the external editor.

use super::super::super::action::{Action, Scope};
use super::super::super::message::{Effect, ExternalEdit};
use super::super::super::model::{Model, Pane, PromptView};

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
    super::edited(model);
    let key = |action| model.look.keymap.key_in(action, Scope::Editor);
    let (undo, save) = (key(Action::Undo), key(Action::SaveTemplate));
    model.say(format!(
        "changes are a draft now; {undo} in the editor undoes them, {save} saves them"
    ));
}
