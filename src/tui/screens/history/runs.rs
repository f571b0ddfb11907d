//! Actions on the selected run: pin, delete, annotate, copy, reopen.

use super::follow;
use crate::action::Action;
use crate::message::Effect;
use crate::model::{InputPurpose, Model};
use crate::screens::Step;
use crate::tasks::history::HistoryCommand;
use nearmiss_store::RunId;

/// Does something with the selected run.
pub fn act(model: &mut Model, action: Action) -> Step {
    let history = &mut model.history;
    let Some(id) = history.current() else {
        model.say("no run is selected");
        return Step::stay();
    };
    let row = &mut history.rows[history.selected];
    match action {
        Action::PinRun => {
            row.pinned = !row.pinned;
            return Step::Stay(vec![HistoryCommand::Pin(id, row.pinned).into()]);
        }
        Action::DeleteRun if row.pinned => {
            let key = model.look.key(Action::PinRun);
            model.say(format!("run {id} is pinned; {key} unpins it"));
            return Step::stay();
        }
        Action::DeleteRun => {
            let deleted = !history.filter.deleted;
            history.undo.push((id, deleted));
            forget(model, id);
            let word = if deleted { "deleted" } else { "restored" };
            let key = model.look.key(Action::UndoDelete);
            model.say(format!("run {id} {word}; {key} takes that back"));
            let mut effects = vec![HistoryCommand::Delete(id, deleted).into()];
            effects.extend(follow(model));
            return Step::Stay(effects);
        }
        _ => {}
    }
    history.then = None;
    let Some(run) = history.shown().cloned() else {
        // Keys may be faster than the store.
        history.then = Some((id, action));
        return Step::stay();
    };
    match action {
        Action::NoteRun => model.history.typing = Some(InputPurpose::Note(id, run.notes)),
        Action::CopyRun => {
            let text = if run.reasoning.is_empty() {
                run.answer
            } else {
                format!("{}\n\n{}", run.reasoning, run.answer)
            };
            model.say(format!("{} characters copied", text.chars().count()));
            return Step::Stay(vec![Effect::Copy(text)]);
        }
        _ => return Step::Reopen(Box::new(run)),
    }
    Step::stay()
}

/// Takes a run off the list.
fn forget(model: &mut Model, id: RunId) {
    let history = &mut model.history;
    history.rows.retain(|run| run.run != id.0);
    history.selected = history.selected.min(history.rows.len().saturating_sub(1));
    history.total = history.total.map(|n| n.saturating_sub(1));
}

/// Takes the last deletion back.
pub fn undo(model: &mut Model) -> Vec<Effect> {
    let Some((id, deleted)) = model.history.undo.pop() else {
        model.say("nothing was deleted in this session");
        return Vec::new();
    };
    let word = if deleted {
        "is back"
    } else {
        "is deleted again"
    };
    model.say(format!("run {id} {word}"));
    vec![HistoryCommand::Delete(id, !deleted).into()]
}
