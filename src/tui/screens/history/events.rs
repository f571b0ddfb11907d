//! Replies of the store to the run history.

use super::{HistoryScreen, details, read, runs};
use crate::message::Effect;
use crate::model::Model;
use crate::screens::Step;
use crate::tasks::history::{HistoryCommand, HistoryEvent};
use nearmiss_store::Edge;

/// Handles the store's answers.
pub fn on_event(model: &mut Model, event: HistoryEvent) -> Step {
    let open = model.screens.find::<HistoryScreen>().is_some();
    match event {
        HistoryEvent::Page(id, edge, result) if open && id == model.history.asked => {
            model.history.loading = None;
            match result {
                Ok(page) => {
                    model.history.error = None;
                    model.history.take(edge, page);
                }
                Err(error) => {
                    model.history.error = Some(error.clone());
                    model.complain(error);
                }
            }
            let mut effects = details(model, matches!(edge, Edge::Newest | Edge::From(_)));
            if std::mem::take(&mut model.history.stale) {
                effects.extend(changed(model));
            } else if let Some(edge) = model.history.missing() {
                effects.extend(read(model, edge));
            }
            let whole = matches!(edge, Edge::Newest | Edge::From(_));
            if whole || model.history.total.is_none() {
                let filter = model.history.filter.clone();
                let count = HistoryCommand::Count(filter);
                effects.push(count.into());
            }
            return Step::Stay(effects);
        }
        HistoryEvent::Counted(filter, count) if filter == model.history.filter => {
            model.history.total = Some(count);
        }
        HistoryEvent::Details(id, Ok(run)) if model.history.wanted == Some(id) => {
            model.history.details = run;
            let then = model.history.then.take_if(|(then, _)| *then == id);
            if let Some((_, action)) = then.filter(|_| open) {
                return runs::act(model, action);
            }
        }
        HistoryEvent::Details(id, Err(error)) if model.history.wanted == Some(id) => {
            model.complain(error);
        }
        HistoryEvent::Truth(id, truth) if model.history.wanted == Some(id) => {
            model.history.truth = Some((id, truth));
        }
        HistoryEvent::Changed if open => return Step::Stay(changed(model)),
        HistoryEvent::Done(id, Err(error)) => {
            model.history.undo.retain(|(undone, _)| *undone != id);
            model.complain(error);
            if open {
                return Step::Stay(changed(model));
            }
        }
        HistoryEvent::Done(_, Ok(())) if open => return Step::Stay(changed(model)),
        HistoryEvent::Exported(Ok(words)) => model.tell(words),
        HistoryEvent::Exported(Err(why)) => model.complain(why),
        _ => {}
    }
    Step::stay()
}

/// The store changed: what is at hand is read again, after what is on its way.
fn changed(model: &mut Model) -> Vec<Effect> {
    if model.history.loading.is_some() {
        model.history.stale = true;
        return Vec::new();
    }
    let (edge, _) = model.history.again();
    read(model, edge)
}
