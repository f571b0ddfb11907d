//! An error of the template in use, shown at its place.

use super::super::super::action::Action;
use super::super::super::model::{Model, Pane, PromptView};

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
        prompt.scroll = line.saturating_sub(1 + ABOVE_ERROR);
    }
    let edit = model.look.key(Action::Edit);
    model.complain(format!(
        "requests disabled until fixed: {error}; {edit} edits the template there"
    ));
    true
}

/// Lines that are shown above the one with an error.
const ABOVE_ERROR: usize = 2;
